"""Effects as the fast model knows them: the library's parameters, and how they change a setup."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import log, pi, radians
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from wirewear.diagnosis.model.numerical import EXPECTED
from wirewear.diagnosis.model.setup import Array, Evolving, Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.effects import Effect, Parameter, Stated, all_effects

if TYPE_CHECKING:
    from wirewear.study import Study

#: Mindlin: tangential over normal compliance of a rough interface, (2 − ν)/(2(1 − ν)) at ν = 0.3.
_TANGENTIAL_TO_NORMAL = 1.21

#: Part of that bed's compliance that the full simulation shows (40 % retained, 500 MPa): it spreads the contact.
BED_SHARE = 0.5

#: Shear modulus over the modulus of a laterally confined bed, (1 − 2ν)/(2(1 − ν)) at ν = 0.3.
_SHEAR_TO_CONFINED = 0.286


Change = Callable[[Setup, WearStates, Mapping[str, float]], Setup]


@dataclass(frozen=True)
class Candidate:
    """An effect of the library with the numbers that are to be found.

    `held` parameters stay at their middle, as nothing in a record tells them from the others.
    """

    kind: type[Effect[Any]]
    parameters: Mapping[str, Parameter]
    change: Change
    held: Mapping[str, Parameter]

    @classmethod
    def of(cls, kind: type[Effect[Any]], change: Change, stated: Stated) -> Candidate:
        """The effect in a test that states these numbers."""
        known = {name: described.beside(stated) for name, described in kind.parameters().items()}
        free, held = (
            {name: item for name, item in known.items() if (item.held_by is not None) is wanted}
            for wanted in (False, True)
        )
        return cls(kind, free, change, held)

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.kind.name

    def unknown_spread(self, name: str) -> float:
        """Standard deviation that a held parameter lends to the coordinate of the one that it goes with."""
        spreads = [0.0]
        for held in self.held.values():
            if held.held_by is not None and held.held_by[0] == name:
                own = self.parameters[name].interest
                ratios = log(held.interest[1] / held.interest[0]), log(own[1] / own[0])
                spreads.append(held.held_by[1] * ratios[0] / ratios[1])
        return max(spreads)

    def values(self, coordinates: Array) -> dict[str, float]:
        """Parameters by name."""
        free = {name: p.value(float(z)) for (name, p), z in zip(self.parameters.items(), coordinates, strict=True)}
        return {**free, **{name: p.value(0.0) for name, p in self.held.items()}}

    def applied(self, setup: Setup, states: WearStates, coordinates: Array) -> Setup:
        """The setup with the effect in it."""
        return self.change(setup, states, self.values(coordinates))

    def starts(self) -> list[Array]:
        """Coordinates from which a search begins."""
        if len(self.parameters) == 1:
            return [np.array([z]) for z in (-1.6, -0.8, 0.0, 0.8, 1.6)]
        # The last parameter of several is how many cycles a change takes, or a second term.
        places = [(a, b) for a in (-1.2, -0.4, 0.4, 1.2) for b in (-0.8, 0.8)]
        starts = [np.zeros(len(self.parameters)) for _ in places]
        for start, (a, b) in zip(starts, places, strict=True):
            start[0], start[-1] = a, b
        return starts


def _tangential(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, compliance_um_per_N=setup.compliance_um_per_N + 1e3 / p["stiffness_N_per_mm"])


def _rotational(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    added = 1e3 * p["arm_mm"] ** 2 / p["stiffness_N_mm_per_rad"]
    return replace(setup, compliance_um_per_N=setup.compliance_um_per_N + added)


def _play(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, free_play_um=setup.free_play_um + p["gap_um"])


def _friction(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, friction=Evolving(p["friction"], p["friction"]))


def _friction_evolution(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, friction=Evolving(p["initial"], p["final"], p["cycles"]))


def _roughness(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    # Asperities that close by s ln p under a pressure p give way by s/P per newton of the load P.
    compliance = _TANGENTIAL_TO_NORMAL * p["layer_um"] / setup.load_N
    return replace(setup, layer_compliance_um_per_N=Evolving(compliance, 0.0, p["cycles"]))


def _third_body(setup: Setup, states: WearStates, p: Mapping[str, float]) -> Setup:
    retained, shear = p["retained_fraction"], 1e-6 * _SHEAR_TO_CONFINED * p["modulus_MPa"]
    # A bed of f·V/A on the area A shears by f V/(A² G) per newton, and A² = πRV once the scar is larger than Hertz's.
    compliance = BED_SHARE * retained / (pi * states.radius_um * shear)
    return replace(setup, retained_fraction=retained, bed_compliance_um_per_N=compliance)


def _plasticity(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, flattening_um=setup.flattening_um + p["flattening_um"])


def _angle(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    # To first order the loops, volumes and extents along the axes do not change: scars are skewed.
    return replace(setup, crossing_error_rad=setup.crossing_error_rad + radians(p["angle_deg"]))


def _misalignment(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, misalignment_rad=setup.misalignment_rad + radians(p["angle_deg"]))


def _load_drift(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, load_drift_per_cycle=setup.load_drift_per_cycle + 1e-5 * p["fraction_per_100k_cycles"])


def _wear_offset(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    rate = setup.wear_um3_per_mJ
    return replace(setup, wear_um3_per_mJ=Evolving(rate.initial * p["factor"], rate.final * p["factor"], rate.cycles))


def _wear_evolution(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    rate = setup.wear_um3_per_mJ.final
    ends = rate * p["initial_factor"], rate * p["final_factor"]
    return replace(setup, wear_um3_per_mJ=Evolving(*ends, p["cycles"]))


def _gain(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, gain=setup.gain * p["gain"])


def _coupling(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(
        setup,
        linear_um_per_N=setup.linear_um_per_N + p["linear_um_per_N"],
        quadratic_um_per_N2=setup.quadratic_um_per_N2 + p["quadratic_um_per_N2"],
    )


def _crosstalk(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, crosstalk=setup.crosstalk + p["coefficient"])


def _lag(setup: Setup, _: WearStates, p: Mapping[str, float]) -> Setup:
    return replace(setup, lag_s=setup.lag_s + p["time_s"])


#: How each effect of the library enters the fast model.
CHANGES: dict[str, Change] = {
    "tangential_compliance": _tangential,
    "rotational_compliance": _rotational,
    "free_play": _play,
    "friction_offset": _friction,
    "friction_evolution": _friction_evolution,
    "roughness_compliance": _roughness,
    "third_body": _third_body,
    "plasticity": _plasticity,
    "crossing_angle_error": _angle,
    "misalignment": _misalignment,
    "normal_load_drift": _load_drift,
    "wear_rate_offset": _wear_offset,
    "wear_rate_evolution": _wear_evolution,
    "displacement_gain": _gain,
    "displacement_load_coupling": _coupling,
    "force_crosstalk": _crosstalk,
    "sensor_lag": _lag,
}


def nominal_setup(study: Study, states: WearStates, drive: Literal["sensor", "stroke"]) -> Setup:
    """The circumstances that a study states, its own effects among them, with the numerical freedoms as expected."""
    setup = replace(Setup.nominal(study, drive), **EXPECTED)
    for effect in study.effects:
        if effect.name in CHANGES:
            setup = CHANGES[effect.name](setup, states, effect.values)
    return setup


def library(setup: Setup) -> tuple[Candidate, ...]:
    """The library's effects, as far as the fast model knows them."""
    stated = {"contact.friction": setup.friction.final}
    return tuple(Candidate.of(kind, CHANGES[name], stated) for name, kind in all_effects().items() if name in CHANGES)
