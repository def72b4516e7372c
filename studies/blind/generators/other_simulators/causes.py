"""How large effects are drawn for tests by others, and what a cause of no library may change of such a test.

Sizes are relative to the test: from one that hardly shows to one that nobody overlooks, evenly in their logarithm.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from studies.blind.causes import other_causes
from studies.blind.generators.other_simulators.pair import Array
from studies.blind.generators.other_simulators.tests_drawn import Test

if TYPE_CHECKING:
    from studies.blind.generators.other_simulators.world import World

Sizes = dict[str, float]

#: Part of the range, between 0 (small) and 1 (large), of hard and of easy cases.
PART = {"hard": (0.0, 0.5), "easy": (0.5, 1.0)}


class Size:
    """What a size is drawn from."""

    def __init__(self, ease: str, test: Test, random: np.random.Generator) -> None:
        self.part, self.test, self.random = random.uniform(*PART[ease]) + test.hides, test, random
        self.force_N = test.friction * test.load_N

    def between(self, low: float, high: float) -> float:
        return float(low * (high / low) ** self.part)

    def either(self, low: float, high: float) -> float:
        """A size of either sign."""
        return self.between(low, high) * float(self.random.choice([-1.0, 1.0]))

    def any(self, low: float, high: float) -> float:
        """A value that does not follow the size."""
        return float(np.exp(self.random.uniform(np.log(low), np.log(high))))

    def way_um(self, low: float, high: float) -> float:
        """A share of the stroke [µm]."""
        return self.between(low, high) * self.test.amplitude_um

    @property
    def cycles(self) -> float:
        """Within which something settles."""
        return self.any(0.01, 0.4) * self.test.cycles


class OtherCause(ABC):
    """Something that goes wrong in a test by others; whatever it does not change it leaves as it is."""

    #: Where it enters.
    seam: ClassVar[str]
    #: The sets that it belongs to, each with its place in their order.
    sets: ClassVar[tuple[tuple[str, int], ...]]

    @staticmethod
    @abstractmethod
    def size(d: Size) -> Sizes:
        """Parameters of the cause by name, drawn for a test."""

    def in_test(self, world: "World") -> "World":
        """A copy of the test in which this cause acts."""
        return replace(world, causes=(*world.causes, self))

    def friction_along(self, _place: Array, _direction: int) -> Array | float:
        """Factor on friction at places over the half stroke (n,), on the way in a direction."""
        return 1.0

    def load_along(self, _place: Array, _direction: int) -> Array | float:
        """Factor on the load there."""
        return 1.0

    def load(self, _cycle: float) -> float:
        """Factor on the mean load at a cycle."""
        return 1.0

    def wear(self, _cycle: float) -> float:
        """Factor on wear at a cycle."""
        return 1.0

    def gain(self, _cycle: float, _cycles: int) -> float:
        """Factor on what the displacement sensor reads at a cycle of a test of so many."""
        return 1.0

    def given_mm(self, _force_N: Array, _limit_N: float, _direction: int) -> Array | float:
        """What the holder gives way by besides, along a stroke (n,); `limit_N` is the stated friction."""
        return 0.0

    def read_N(self, force_N: Array, _limit_N: float, _cycle: float) -> Array:
        """What the force cell reads (n,)."""
        return force_N


def _rotational(d: Size) -> Sizes:
    arm = d.any(5.0, 80.0)
    return {"stiffness_N_mm_per_rad": 1e3 * arm**2 * d.force_N / d.way_um(0.01, 0.15), "arm_mm": arm}


def _coupling(d: Size) -> Sizes:
    linear = d.way_um(0.01, 0.12) / d.force_N * float(d.random.choice([-1.0, 1.0]))
    return {"linear_um_per_N": linear, "quadratic_um_per_N2": d.random.uniform(-0.4, 0.4) * linear / d.force_N}


SIZES: Mapping[str, Callable[[Size], Sizes]] = {
    "tangential_compliance": lambda d: {"stiffness_N_per_mm": 1e3 * d.force_N / d.way_um(0.01, 0.15)},
    "rotational_compliance": _rotational,
    "free_play": lambda d: {"gap_um": d.way_um(0.01, 0.15)},
    "friction_offset": lambda d: {"friction": d.test.friction * (1.0 + d.either(0.02, 0.25))},
    "friction_evolution": lambda d: {
        "initial": d.test.friction * (1.0 + d.either(0.03, 0.35)),
        "final": d.test.friction,
        "cycles": d.cycles,
    },
    "roughness_compliance": lambda d: {"layer_um": d.between(0.5, 6.0), "cycles": d.cycles},
    "third_body": lambda d: {"retained_fraction": d.between(0.08, 0.6), "modulus_MPa": d.any(300.0, 5000.0)},
    "plasticity": lambda d: {"flattening_um": d.between(0.3, 4.0)},
    "crossing_angle_error": lambda d: {"angle_deg": d.either(1.0, 8.0)},
    "misalignment": lambda d: {"angle_deg": d.either(0.15, 3.0)},
    "normal_load_drift": lambda d: {"fraction_per_100k_cycles": 1e5 * d.either(0.02, 0.25) / d.test.cycles},
    "wear_rate_offset": lambda d: {"factor": float(d.between(1.1, 2.5) ** d.random.choice([-1.0, 1.0]))},
    "wear_rate_evolution": lambda d: {
        "initial_factor": 1.0 + d.between(0.3, 5.0),
        "final_factor": 1.0,
        "cycles": d.cycles,
    },
    "displacement_gain": lambda d: {"gain": 1.0 + d.either(0.01, 0.15)},
    "displacement_load_coupling": _coupling,
    "force_crosstalk": lambda d: {"coefficient": d.either(0.003, 0.05)},
    "sensor_lag": lambda d: {"time_s": d.between(0.004, 0.08) / (2.0 * np.pi * d.test.frequency_Hz)},
}


def sizes(effect: str, ease: str, test: Test, random: np.random.Generator) -> Sizes:
    """Parameters of an effect or a cause, five digits each."""
    size = SIZES[effect] if effect in SIZES else other_causes()[effect].size
    return {name: float(f"{value:.5g}") for name, value in size(Size(ease, test, random)).items()}
