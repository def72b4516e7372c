"""How much a record speaks for each family of distortions, beside no effect and beside the effects that explain it
best.

A family's unknowns are normal deviates times one of a few sizes, so that its evidence has a closed form once the
explanation beside it is taken as linear: residuals r ~ N(0, 1 + J Jᵀ + s² C Cᵀ), J of the effect's parameters, C of the
family. Many directed tests, each sharp, see what one blunt test of all residuals does not (Anau Montel, Alvey and
Weniger, Phys. Rev. D 111 (2025) 083013).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import LASTING, LASTING_REACH
from wirewear.diagnosis.infer.families import FAMILIES, PROFILE_FAMILIES, Branches, Family, Shape
from wirewear.diagnosis.infer.inference import Fit, Problem, jacobian_of
from wirewear.diagnosis.observe.reduction import Layout
from wirewear.diagnosis.observe.scars import ProfileDepths
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.effects import Age, Ageing, Chain, Seam

_KNOWN = constants("infer.distortions")

#: Shares of the plateau force or of the amplitude by which a distortion is tried; none is more likely than another.
SIZES = _KNOWN.numbers("sizes")

#: Step of the derivatives, as such a share.
_STEP = _KNOWN.number("step")

#: What changes over the cycles does so as Matérn's process of order 1/2, between so many of them.
KNOTS = _KNOWN.count("knots")


@dataclass(frozen=True, eq=False)
class Distortion:
    """Fit of a family of distortions added to one explanation, `beside`."""

    family: Family
    beside: Fit
    log_evidence: float  #: Of family and explanation together, on the scale of `Fit.log_evidence`.
    gain: float  #: Log evidence that the family adds to the explanation's own.
    size: float  #: The size of `SIZES` with the largest evidence.
    unknowns: Array  #: (k,) best values of the family's unknowns, which are multiplied by its columns.
    observed: Array  #: (n,) change of the observables by these.
    #: Logarithms of cycles (j,) and changes of the family's column at them (j,); both empty for shapes.
    over_time: tuple[Array, Array]
    deviations: float  #: Square root of the χ² that the family removes beside the explanation.


def distortions(problem: Problem, fits: Sequence[Fit]) -> tuple[Distortion, ...]:
    """Every family of distortions added to each of the fits in turn, largest log evidence first."""
    found = [one for fit in fits for one in _beside(problem, fit)]
    # Explanations that are one to the model keep their order.
    return tuple(sorted(found, key=lambda one: -round(one.log_evidence, 6)))


def _beside(problem: Problem, fit: Fit) -> list[Distortion]:
    jacobian = jacobian_of(problem, fit)
    residual = problem.whitened(fit.setup) - jacobian @ fit.places
    alone = _log_evidence(residual, jacobian)
    found = []
    for sets in columns_of(problem, fit.setup):
        family = sets[0].family
        tried = [(one, problem.whitening @ one.observed, size) for one in sets for size in SIZES]
        # The model moves by the columns, the residual against them.
        logs = [_log_evidence(residual, np.column_stack([jacobian, size * white])) for _, white, size in tried]
        beliefs = [np.log(one.weight / len(SIZES)) for one, _, _ in tried]
        total = float(np.logaddexp.reduce(np.add(logs, beliefs))) - family.allowed
        columns, white, size = tried[int(np.argmax(np.add(logs, beliefs)))]
        both = np.column_stack([-jacobian, size * white])
        best = np.linalg.solve(both.T @ both + np.eye(both.shape[1]), both.T @ residual)
        unknowns: Array = np.asarray(size * best[jacobian.shape[1] :], dtype=np.float64)
        found.append(
            Distortion(
                family=family,
                beside=fit,
                # The fit's own evidence is not linear: only what the family adds is taken from here.
                log_evidence=fit.log_evidence + total - alone,
                gain=total - alone,
                size=size,
                unknowns=unknowns,
                observed=columns.observed @ unknowns,
                over_time=(columns.knots, columns.of_unknowns @ unknowns if columns.knots.size else np.zeros(0)),
                deviations=float(np.sqrt(max(_explained(residual, both)[0] - _explained(residual, jacobian)[0], 0.0))),
            )
        )
    return found


def _log_evidence(residual: Array, columns: Array) -> float:
    """Log evidence, but for a constant, of residuals (m,) that are columns (m, k) times normal deviates plus others."""
    squares, logarithm = _explained(residual, columns)
    return -0.5 * (float(residual @ residual) - squares) - 0.5 * logarithm


def _explained(residual: Array, columns: Array) -> tuple[float, float]:
    """By how much such columns lower the residuals' sum of squares, and the logarithm of the volume that they span."""
    inner = columns.T @ columns + np.eye(columns.shape[1])
    along = columns.T @ residual
    return float(along @ np.linalg.solve(inner, along)), float(np.linalg.slogdet(inner)[1])


@dataclass(frozen=True, eq=False)
class FreeInTime:
    """A change of one column of a chain over the cycles, used in a setup in place of an effect."""

    column: str  #: Name of the chain's column.
    knots: Array  #: Logarithms (k,) of cycles.
    values: Array  #: (k,) changes at these, linear between and constant beyond them.
    scale: float  #: Added to the column per unit of change; 0 if the change is relative.
    name: str = "free in time"
    ages: Ageing = Ageing.BY_CYCLES

    @property
    def seam(self) -> Seam | None:
        """None, as the chain itself is changed."""
        return None

    def changed(self, described: object, _age: Age) -> object:
        """The description as it was, as no seam is changed."""
        return described

    def predicted(self, chain: Chain) -> Chain:
        """A copy of the chain with `column` changed."""
        share = np.interp(np.log(np.maximum(chain.cycles, 1.0)), self.knots, self.values)
        was = getattr(chain, self.column)
        return replace(chain, **{self.column: was * (1.0 + share) if self.scale == 0.0 else was + self.scale * share})


@dataclass(frozen=True, eq=False)
class Columns:
    """Derivatives of the observables by a family's k unknowns at one explanation."""

    family: Family  #: The family.
    weight: float  #: Prior probability of this set of columns among all sets of the family.
    observed: Array  #: (n, k) change of the observables by one standard deviation of each unknown, at size 1.
    knots: Array  #: (j,) logarithms of cycles between which changes over the test are linear; empty for shapes.
    of_unknowns: Array  #: (j, k) change of the column there by each unknown.


def families_of(layout: Layout) -> tuple[Family, ...]:
    """Families that a layout can show: shapes of loops if it has loops, changes over the test if it has several cycles,
    profiles if it has profiles.
    """
    loops = any(not part.observable.of_scars for part in layout)
    several = np.unique(layout.cycle).size > 1
    found = tuple(one for one in FAMILIES if loops and (several or not one.column))
    return (*found, *PROFILE_FAMILIES) if layout.of_kind(ProfileDepths).any() else found


def columns_of(problem: Problem, setup: SurrogateInputs) -> tuple[tuple[Columns, ...], ...]:
    """For each family that the problem's layout can show, sets of columns at a setup, one for each of its shapes."""
    layout, states = problem.layout, problem.states
    loops = simulate(states, setup, layout.cycles)
    base = layout.observed(loops)
    branches = Branches.of(loops, setup.amplitude_um, setup.plateau_force_N, setup.motion)
    logged = np.log(np.unique(np.maximum(layout.cycle, 1)).astype(float))
    knots = np.linspace(logged[0], logged[-1], min(KNOTS, logged.size))
    found = []
    for family in families_of(layout):
        if family.shapes:
            each = (family.shapes, *family.instead)
            sets = [
                np.nan_to_num(np.column_stack([*_of_shapes(family, one, problem, branches, base, logged)]))
                for one in each
            ]
            nowhere = np.zeros(0), np.zeros((0, 0))
            found.append(tuple(Columns(family, 1.0 / len(sets), one, *nowhere) for one in sets))
        else:
            found.append(_changing_in_time(family, problem, setup, base, knots))
    return tuple(found)


def _changing_in_time(
    family: Family, problem: Problem, setup: SurrogateInputs, base: Array, knots: Array
) -> tuple[Columns, ...]:
    """Columns of what changes in time: freely, or, as likely as that, towards a final value as creep and warmth do."""
    free: Array = np.asarray(np.linalg.cholesky(_kernel(knots, 0.0)), dtype=np.float64)
    observed = np.nan_to_num(_in_time(family, problem, setup, base, knots, free))
    found = [Columns(family, 0.5, observed, knots, free)]
    # Linear in the values at knots, as what changes freely is.
    by_values = observed @ np.linalg.inv(free)
    for late in knots[1:]:
        settling = (1.0 - np.exp(-np.exp(knots - late)))[:, None]
        found.append(Columns(family, 0.5 / (knots.size - 1), by_values @ settling, knots, settling))
    return tuple(found)


def _of_shapes(
    family: Family, shapes: Sequence[Shape], problem: Problem, branches: Branches, base: Array, logged: Array
) -> Iterator[Array]:
    row = np.searchsorted(logged, np.log(np.maximum(problem.layout.cycle, 1)) - 1e-9)
    for shape in shapes:
        change = (problem.layout.observed(shape(branches, _STEP)) - base) / _STEP
        if not family.develops:
            yield change
            continue
        for weights in np.linalg.cholesky(_kernel(logged, LASTING)).T:
            yield change * weights[row]


def _in_time(
    family: Family, problem: Problem, setup: SurrogateInputs, base: Array, knots: Array, values: Array
) -> Array:
    """Changes (n, k) of the observables by a column that changes over the cycles through values (j, k) at knots."""
    force = setup.plateau_force_N
    scale = {"": 0.0, "force": force, "compliance": setup.amplitude_um / force}[family.scale]
    moved = (FreeInTime(family.column, knots, _STEP * weights, scale) for weights in values.T)
    return (problem.layout.computed(problem.states, *map(setup.with_effect, moved)) - base).T / _STEP


def _kernel(time: Array, lasting: float) -> Array:
    """Covariance (k, k) of a size over logarithms of cycles (k,), of which a share stays the same throughout."""
    apart = np.abs(time[:, None] - time)
    kernel: Array = lasting + (1.0 - lasting) * np.exp(-apart / LASTING_REACH) + 1e-9 * np.eye(time.size)
    return kernel
