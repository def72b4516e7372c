"""Metals that flow: von Mises' criterion with isotropic and kinematic hardening, and what a step of strain does.

    f = sigma_eq(s - X) - sigma_y - H_i p,    d eps = 3/2 (s - X) / sigma_eq dp,    dX = 2/3 C d eps - gamma X dp

(Armstrong & Frederick, CEGB report RD/B/N 731 (1966); without recall gamma Prager's rule), by backward Euler: the
return is along one direction, and the plastic strain of the step the root of one equation.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from solvers.jit_cache import compiled

_STEPS = 30  #: Of Newton's method for one point.


@dataclass(frozen=True)
class Metal:
    """Yield stress in tension and hardening of a metal, MPa.

    hardening_MPa: stress per plastic strain, of which `kinematic_share` (0 to 1) shifts the yield surface and the rest
    widens it. recall: γ of the shift's dynamic recovery, which limits the shift to its hardening over γ; 0: none.
    """

    yield_stress_MPa: float
    hardening_MPa: float = 0.0
    kinematic_share: float = 1.0
    recall: float = 0.0

    @property
    def moduli(self) -> tuple[float, float, float, float]:
        """Yield stress, isotropic hardening H_i, kinematic hardening C (all MPa) and recall γ."""
        shift = self.kinematic_share * self.hardening_MPa
        return self.yield_stress_MPa, self.hardening_MPa - shift, shift, self.recall


@dataclass(frozen=True)
class Flow:
    """State of k points of a metal.

    strain: (k, 6) plastic strain; shift: (k, 6) of the yield surface, MPa; tensor components in the order of
    `TENSOR_PLACES`. accumulated: (k,) accumulated plastic strain.
    """

    strain: Array
    shift: Array
    accumulated: Array

    @classmethod
    def none(cls, points: int) -> "Flow":
        """The state of points that have never yielded."""
        return cls(np.zeros((points, 6)), np.zeros((points, 6)), np.zeros(points))


def flown(metal: Metal, shear_MPa: float, trial_MPa: Array, before: Flow) -> Flow:
    """The state of k points after a step in which purely elastic stresses of the first n would become `trial_MPa` (n,
    6), and the others do not flow.

    shear_MPa: shear modulus. before: the state at the step's start. Where the yield surface is exceeded, plastic strain
    returns the stress to it.
    """
    after = Flow(before.strain.copy(), before.shift.copy(), before.accumulated.copy())
    upper = slice(len(trial_MPa))
    _return(
        trial_MPa, after.strain[upper], after.shift[upper], after.accumulated[upper], shear_MPa, *metal.moduli
    )  # fmt: skip
    return after


@compiled
def _return(
    trial: Array,
    strain: Array,
    shift: Array,
    accumulated: Array,
    shear: float,
    yields: float,
    isotropic: float,
    kinematic: float,
    recall: float,
) -> None:
    """Change strain, shift and accumulated strain of the points to those after the step."""
    own = np.empty(6)
    for k in range(len(trial)):
        mean = (trial[k, 0] + trial[k, 1] + trial[k, 2]) / 3.0
        for c in range(6):
            own[c] = trial[k, c] - mean if c < 3 else trial[k, c]
        step, flows = 0.0, False
        for _ in range(_STEPS):
            kept = 1.0 / (1.0 + recall * step)
            square, across = 0.0, 0.0
            for c in range(6):
                twice = 1.5 if c < 3 else 3.0
                apart = own[c] - kept * shift[k, c]
                square += twice * apart * apart
                across += twice * apart * shift[k, c]
            equivalent = np.sqrt(square)
            excess = equivalent - step * (3.0 * shear + kept * kinematic) - yields - isotropic * (accumulated[k] + step)
            if not flows and excess <= 0.0:
                break
            flows = True
            if abs(excess) <= 1e-12 * equivalent:
                break
            turning = recall * kept * kept * (across / equivalent + step * kinematic)
            step = max(step - excess / (turning - 3.0 * shear - kept * kinematic - isotropic), 0.0)
        if flows:
            kept = 1.0 / (1.0 + recall * step)
            for c in range(6):
                normal = 1.5 * (own[c] - kept * shift[k, c]) / equivalent
                strain[k, c] += step * normal
                shift[k, c] = kept * (shift[k, c] + kinematic * step * normal / 1.5)
            accumulated[k] += step
