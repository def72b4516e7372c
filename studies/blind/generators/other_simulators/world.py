"""What is true of one test by others: specimens, rig, instruments, and what an effect or a cause changes of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from math import ceil, exp, inf, prod, radians
from typing import Any

import numpy as np

from studies.blind.causes import other_causes
from studies.blind.generators.cases import TrueEffect
from studies.blind.generators.other_simulators.causes import OtherCause
from studies.blind.generators.other_simulators.pair import Array, Layer


@dataclass(frozen=True)
class World:
    """One test; mm, N, MPa, s, unless named otherwise.

    programme: cycles of each block, and its load and stroke over those of the test. held: key and value of what the
    drive holds by a stroke of `amplitude_mm` at most. swing: share of the load by which it swings, and how often in a
    cycle. `causes` are those of no library.
    """

    friction: float
    load_N: float
    wear_mm3_per_J: float
    amplitude_mm: float
    frequency_Hz: float
    cycles: int
    drive: str
    compliance_mm_per_N: float = 0.0
    spring_N_per_mm: float = 0.0
    moving_share: float = 0.5
    friction_course: tuple[float, float] = (0.0, 1.0)
    load_drift: float = 0.0
    wear_course: tuple[float, float, float] = (1.0, 1.0, 1.0)
    play_mm: float = 0.0
    lean_rad: float = 0.0
    rough: tuple[float, float] = (0.0, 1.0)
    bed: tuple[float, float] = (0.0, inf)
    flattening_mm: float = 0.0
    angle_error_deg: float = 0.0
    gain: float = 1.0
    coupling: tuple[float, float] = (0.0, 0.0)
    crosstalk: float = 0.0
    lag_s: float = 0.0
    speed_exponent: float = 0.0
    pressure_exponent: float = 0.0
    expected_MPa: float = 100.0
    stated_friction: float = 0.5
    stated_load_N: float = 1.0
    #: Share of the stroke that must slip.
    least_slip: float = 0.35
    causes: tuple[OtherCause, ...] = ()
    programme: tuple[tuple[int, float, float], ...] = ()
    held: tuple[str, float] | None = None
    swing: tuple[float, int] | None = None

    def during(self, cycle: float) -> "World":
        """The world under the load and the stroke of the block to which a cycle belongs."""
        if not self.programme:
            return self
        ends = np.cumsum([cycles for cycles, _, _ in self.programme])
        within = (max(ceil(cycle), 1) - 1) % ends[-1]
        _, load, stroke = self.programme[int(np.searchsorted(ends, within, side="right"))]
        return replace(self, load_N=self.load_N * load, amplitude_mm=self.amplitude_mm * stroke)

    def with_effect(self, effect: str, given: Mapping[str, float]) -> "World":
        """The world with an effect of the contract, by its parameters there, or with a cause of no library."""
        if effect in CHANGES:
            return replace(self, **CHANGES[effect](self, given))
        return other_causes()[effect](**given).in_test(self)

    def with_effects(self, effects: Sequence[TrueEffect]) -> "World":
        """The world with all of a case's effects."""
        return reduce(lambda world, one: world.with_effect(one.effect, one.parameters), effects, self)

    def friction_at(self, cycle: float) -> float:
        """Coefficient of friction at the middle of the stroke."""
        change, cycles = self.friction_course
        return self.friction + change * exp(-cycle / cycles)

    def varied(self, place: Array, direction: int) -> Array:
        """Friction over that of the middle, at places over the half stroke (n,)."""
        speed = np.sqrt(np.maximum(1.0 - place**2, 1e-3))
        rate = speed**self.speed_exponent
        return np.asarray(reduce(lambda rate, one: rate * one.friction_along(place, direction), self.causes, rate))

    def load_at(self, cycle: float, sunk_mm: float) -> float:
        """Mean load at a cycle; a spring relaxes as the bodies sink into one another."""
        load = self.load_N * (1.0 + self.load_drift * cycle) - self.spring_N_per_mm * sunk_mm
        return float(load * prod(cause.load(cycle) for cause in self.causes))

    def wear_at(self, first: float, last: float) -> float:
        """Mean worn volume per energy of both bodies over cycles [mm³/J]."""
        initial, final, cycles = self.wear_course
        middle = 0.5 * (first + last)
        factor = final + (initial - final) * exp(-middle / cycles)
        return self.wear_mm3_per_J * (factor * prod(cause.wear(middle) for cause in self.causes))

    def layer_at(self, cycle: float) -> Layer:
        """What lies between the bodies at a cycle."""
        filled, modulus = self.bed
        height, cycles = self.rough
        return Layer(filled, modulus, height * exp(-cycle / cycles))

    def gain_at(self, cycle: float) -> float:
        """Gain of the displacement channel at a cycle."""
        return self.gain * prod(cause.gain(cycle, self.cycles) for cause in self.causes)


def _softer(world: World, more_mm_per_N: float) -> dict[str, Any]:
    return {"compliance_mm_per_N": world.compliance_mm_per_N + more_mm_per_N}


def _friction(world: World, given: Mapping[str, float]) -> dict[str, Any]:
    """A specimen's scatter stays in proportion."""
    scatter = world.friction / world.stated_friction
    final = given.get("final", given.get("friction", 0.0)) * scatter
    return {
        "friction": final,
        "friction_course": (
            given.get("initial", 0.0) * scatter - final if "initial" in given else 0.0,
            given.get("cycles", 1.0),
        ),
    }


#: What effects of the contract change.
CHANGES: Mapping[str, Callable[[World, Mapping[str, float]], dict[str, Any]]] = {
    "tangential_compliance": lambda w, p: _softer(w, 1.0 / p["stiffness_N_per_mm"]),
    "rotational_compliance": lambda w, p: _softer(w, p["arm_mm"] ** 2 / p["stiffness_N_mm_per_rad"]),
    "free_play": lambda _, p: {"play_mm": 1e-3 * p["gap_um"]},
    "friction_offset": _friction,
    "friction_evolution": _friction,
    "roughness_compliance": lambda _, p: {"rough": (1e-3 * p["layer_um"], p["cycles"])},
    "third_body": lambda _, p: {"bed": (p["retained_fraction"], p["modulus_MPa"])},
    "plasticity": lambda _, p: {"flattening_mm": 1e-3 * p["flattening_um"]},
    "crossing_angle_error": lambda _, p: {"angle_error_deg": p["angle_deg"]},
    "misalignment": lambda _, p: {"lean_rad": radians(p["angle_deg"])},
    "normal_load_drift": lambda _, p: {"load_drift": 1e-5 * p["fraction_per_100k_cycles"]},
    "wear_rate_offset": lambda w, p: {"wear_mm3_per_J": w.wear_mm3_per_J * p["factor"]},
    "wear_rate_evolution": lambda _, p: {"wear_course": (p["initial_factor"], p["final_factor"], p["cycles"])},
    "displacement_gain": lambda _, p: {"gain": p["gain"]},
    "displacement_load_coupling": lambda _, p: {
        "coupling": (1e-3 * p["linear_um_per_N"], 1e-3 * p["quadratic_um_per_N2"])
    },
    "force_crosstalk": lambda _, p: {"crosstalk": p["coefficient"]},
    "sensor_lag": lambda _, p: {"lag_s": p["time_s"]},
}
