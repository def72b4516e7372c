"""What the fast forward model is told: the nominal model, every effect's place in it, and its numerical freedoms."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, radians
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from wirewear.study import Study

Array = NDArray[np.float64]

#: Energy wear coefficients: 1 mm³/J in µm³/mJ.
UM3_PER_MJ = 1e6


@dataclass(frozen=True)
class Evolving:
    """A quantity that goes exponentially from one value to another: f + (i − f) exp(−n/n_c)."""

    initial: float
    final: float
    cycles: float = 1.0

    def at(self, cycles: Array) -> Array:
        """Values after `cycles` (n,)."""
        if self.initial == self.final:
            return np.full_like(cycles, self.final)
        values: Array = self.final + (self.initial - self.final) * np.exp(-cycles / self.cycles)
        return values


@dataclass(frozen=True)
class Setup:
    """One set of circumstances under which loops are computed; what has a default is ideal by default.

    Attributes:
        amplitude_um, load_N, cycles, frequency_Hz: conditions of the test.
        drive: where the amplitude is held, on the "sensor"'s reading or on the true "stroke".
        friction: coefficient over the cycles.
        wear_um3_per_mJ: worn volume of both wires per friction energy, over the cycles.
        compliance_um_per_N: of the holder along the motion, rotation about a pivot included.
        normal_spring_N_per_um: of the loading train.
        free_play_um: of the holder.
        layer_compliance_um_per_N: of a rough or filled contact along the motion, over the cycles.
        retained_fraction: of the worn volume that stays in the scars as debris.
        bed_compliance_um_per_N: of that debris along the motion, once the scar is large against Hertz's contact.
        load_drift_per_cycle: relative change of the load.
        misalignment_rad: rise of the line of motion out of the plane of contact.
        flattening_um: approach of the wires by flattening before any wear.
        crossing_error_rad: of the wires' axes from the right angle.
        gain, linear_um_per_N, quadratic_um_per_N2, crosstalk, lag_s: of the sensors.
        displacement_offset_um, force_offset_N: zeros of the sensors.
        slope_factor, slope_trend, tip_factor, tip_trend, stretch, stick_factor, angle_tilt, angle_trend, scar_factor:
            numerical freedoms of the fast model: the scar's slopes, their relative change per decade of wear, those of
            its ends and their change per decade, its length, the contact's stiffness, friction at its ends once worn
            and its change per decade of wear [rad], depths of the scars against the volume.
    """

    amplitude_um: float
    load_N: float
    cycles: float
    frequency_Hz: float
    drive: Literal["sensor", "stroke"]
    friction: Evolving
    wear_um3_per_mJ: Evolving
    compliance_um_per_N: float = 0.0
    normal_spring_N_per_um: float = 0.0
    free_play_um: float = 0.0
    layer_compliance_um_per_N: Evolving = Evolving(0.0, 0.0)
    retained_fraction: float = 0.0
    bed_compliance_um_per_N: float = 0.0
    load_drift_per_cycle: float = 0.0
    misalignment_rad: float = 0.0
    flattening_um: float = 0.0
    crossing_error_rad: float = 0.0
    gain: float = 1.0
    linear_um_per_N: float = 0.0
    quadratic_um_per_N2: float = 0.0
    crosstalk: float = 0.0
    lag_s: float = 0.0
    displacement_offset_um: float = 0.0
    force_offset_N: float = 0.0
    slope_factor: float = 1.0
    slope_trend: float = 0.0
    tip_factor: float = 0.0
    tip_trend: float = 0.0
    stretch: float = 1.0
    stick_factor: float = 1.0
    angle_tilt: float = 0.0
    angle_trend: float = 0.0
    scar_factor: float = 1.0

    @classmethod
    def nominal(cls, study: Study, drive: Literal["sensor", "stroke"]) -> Setup:
        """The circumstances that a study states."""
        conditions, holder, wear = study.conditions, study.holder, study.wear
        friction = study.contact.friction
        coefficient = 0.0 if wear is None else wear.volume_per_sliding_mm3_per_N_m(friction) / max(friction, 1e-9)
        arm = holder.pivot_height_mm or 0.0
        compliance = 1e3 / _stiffness(holder.tangential_stiffness_N_per_mm)
        compliance += 1e3 * arm**2 / _stiffness(holder.rotational_stiffness_N_mm_per_rad)
        return cls(
            amplitude_um=conditions.displacement_amplitude_um,
            load_N=conditions.normal_load_N,
            cycles=float(conditions.cycles),
            frequency_Hz=conditions.frequency_Hz,
            drive=drive,
            friction=Evolving(friction, friction),
            wear_um3_per_mJ=Evolving(coefficient * UM3_PER_MJ, coefficient * UM3_PER_MJ),
            compliance_um_per_N=compliance,
            crossing_error_rad=radians(study.wires.crossing_angle_deg - 90.0),
            normal_spring_N_per_um=1e-3 * holder.normal_spring_stiffness_N_per_mm,
        )


def _stiffness(value: float | str) -> float:
    return inf if isinstance(value, str) else value
