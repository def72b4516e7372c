"""Effects as the fast model knows them: parameters with what one expects of them, and how they change a setup."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import exp, log, pi, radians

import numpy as np

from wirewear.diagnosis.setup import Array, Evolving, Setup
from wirewear.diagnosis.wear_states import WearStates

#: Standard deviations from the middle to either end of a range that holds 95 %.
_ENDS = 1.96

#: Mindlin: tangential over normal compliance of a rough interface, (2 − ν)/(2(1 − ν)) at ν = 0.3.
_TANGENTIAL_TO_NORMAL = 1.21


@dataclass(frozen=True)
class Parameter:
    """One number of an effect: `interest` is the range that holds 95 % of what one expects before looking."""

    name: str
    interest: tuple[float, float]
    logarithmic: bool = True

    def value(self, coordinate: float) -> float:
        """The value at a coordinate that is a standard normal deviate under the expectation."""
        low, high = (log(end) for end in self.interest) if self.logarithmic else self.interest
        value = 0.5 * (low + high) + coordinate * (high - low) / (2.0 * _ENDS)
        return exp(value) if self.logarithmic else value

    def coordinate(self, value: float) -> float:
        """The inverse of `value`."""
        low, high = (log(end) for end in self.interest) if self.logarithmic else self.interest
        at = log(value) if self.logarithmic else value
        return (at - 0.5 * (low + high)) / (high - low) * 2.0 * _ENDS


Change = Callable[[Setup, WearStates, Mapping[str, float]], Setup]


@dataclass(frozen=True)
class Candidate:
    """An effect: `held` parameters stay at their middle, as nothing in a record tells them from the others."""

    name: str
    parameters: tuple[Parameter, ...]
    change: Change
    held: tuple[Parameter, ...] = ()

    def values(self, coordinates: Array) -> dict[str, float]:
        """Parameters by name."""
        free = {p.name: p.value(float(z)) for p, z in zip(self.parameters, coordinates, strict=True)}
        return {**free, **{p.name: p.value(0.0) for p in self.held}}

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
    # An exponential bearing curve of that height compresses by layer/P per newton (Greenwood & Williamson 1966).
    compliance = _TANGENTIAL_TO_NORMAL * p["layer_um"] / setup.load_N
    return replace(setup, layer_compliance_um_per_N=Evolving(compliance, 0.0, p["cycles"]))


def _third_body(setup: Setup, states: WearStates, p: Mapping[str, float]) -> Setup:
    # Debris of thickness f·h over the worn area A: h/A = V/A² and A² = πRV keep the compliance constant once it is there.
    radius_mm = 1e-3 * states.radius_um
    shear = p["modulus_MPa"] / 2.6
    compliance = 1e3 * p["retained_fraction"] / (pi * radius_mm * shear)
    return replace(setup, layer_compliance_um_per_N=Evolving(0.0, compliance, 0.05 * setup.cycles))


def _plasticity(setup: Setup, states: WearStates, p: Mapping[str, float]) -> Setup:
    # Overlap of crossed cylinders at that approach: V = πR h².
    return replace(setup, early_volume_um3=setup.early_volume_um3 + pi * states.radius_um * p["flattening_um"] ** 2)


def _angle(setup: Setup, _: WearStates, __: Mapping[str, float]) -> Setup:
    # To first order the loops, volumes and extents along the axes do not change.
    return setup


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


def library(setup: Setup) -> tuple[Candidate, ...]:
    """All effects, with ranges that follow the test's load, stroke, length and frequency where they must."""
    micrometre = setup.amplitude_um / 60.0
    per_newton = micrometre * 2.0 / setup.load_N
    friction = setup.friction.final
    fixed, early = (0.75 * friction, 1.3 * friction), (0.4 * friction, 1.5 * friction)
    period = 1.0 / setup.frequency_Hz
    duration = (max(3e-4 * setup.cycles, 1.0), setup.cycles)
    stiffness = (30.0 / per_newton, 1e4 / per_newton)
    arm = Parameter("arm_mm", (10.0, 100.0))
    rotation = (stiffness[0] * arm.value(0.0) ** 2, stiffness[1] * arm.value(0.0) ** 2)
    return (
        Candidate("tangential_compliance", (Parameter("stiffness_N_per_mm", stiffness),), _tangential),
        Candidate("rotational_compliance", (Parameter("stiffness_N_mm_per_rad", rotation),), _rotational, (arm,)),
        Candidate("free_play", (Parameter("gap_um", (0.2 * micrometre, 12.0 * micrometre)),), _play),
        Candidate("friction_offset", (Parameter("friction", fixed),), _friction),
        Candidate(
            "friction_evolution",
            (Parameter("initial", early), Parameter("final", fixed), Parameter("cycles", duration)),
            _friction_evolution,
        ),
        Candidate(
            "roughness_compliance",
            (Parameter("layer_um", (0.1 * micrometre, 6.0 * micrometre)), Parameter("cycles", duration)),
            _roughness,
        ),
        Candidate(
            "third_body", (Parameter("modulus_MPa", (20.0, 2e4)),), _third_body,
            (Parameter("retained_fraction", (0.02, 0.5)),),
        ),
        Candidate("plasticity", (Parameter("flattening_um", (0.1, 4.0)),), _plasticity),
        Candidate("crossing_angle_error", (Parameter("angle_deg", (-6.0, 6.0), logarithmic=False),), _angle),
        Candidate("misalignment", (Parameter("angle_deg", (-4.0, 4.0), logarithmic=False),), _misalignment),
        Candidate(
            "normal_load_drift",
            (Parameter("fraction_per_100k_cycles", (-3e4 / setup.cycles, 3e4 / setup.cycles), logarithmic=False),),
            _load_drift,
        ),
        Candidate("wear_rate_offset", (Parameter("factor", (0.4, 2.5)),), _wear_offset),
        Candidate(
            "wear_rate_evolution",
            (
                Parameter("initial_factor", (0.2, 5.0)),
                Parameter("final_factor", (0.4, 2.5)),
                Parameter("cycles", duration),
            ),
            _wear_evolution,
        ),
        Candidate("displacement_gain", (Parameter("gain", (0.85, 1.15), logarithmic=False),), _gain),
        Candidate(
            "displacement_load_coupling",
            (
                Parameter("linear_um_per_N", (-8.0 * per_newton, 8.0 * per_newton), logarithmic=False),
                Parameter(
                    "quadratic_um_per_N2", (-2.0 * per_newton / setup.load_N, 2.0 * per_newton / setup.load_N),
                    logarithmic=False,
                ),
            ),
            _coupling,
        ),
        Candidate("force_crosstalk", (Parameter("coefficient", (-0.08, 0.08), logarithmic=False),), _crosstalk),
        Candidate("sensor_lag", (Parameter("time_s", (-0.02 * period, 0.02 * period), logarithmic=False),), _lag),
    )
