"""A test as a chain in series, as fast models take it: drive, play and springs, contact, sensors.

An effect enters a fast model by what it makes of this chain. Without further words that is what it does to its seam,
read moment by moment.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from math import degrees, pi, radians
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from solvers import Holder, WearRates
from wirewear.base.errors import StudyError
from wirewear.effects.seams import Age, Ageing, ChangesASeam, ContactLaw, Loading, Seam, Specimens
from wirewear.loops.sensor import Sensor

Array = NDArray[np.float64]


class UnforeseenError(StudyError):
    """An effect changes something of its seam that a chain does not hold."""


@dataclass(frozen=True, eq=False)
class Chain:
    """A test of crossed wires, or of a cylinder on a flat, at n moments; arrays are (n,).

    Attributes:
        radius_um, fresh_area_um2: of the wires or the cylinder, and of their contact before any wear.
        cycles, energy_J: how far the test has come.
        worn_um3: volume that both wires have lost.
        load_N, misalignment_rad: the load when nothing is worn, and by which the motion rises out of the contact plane.
        friction: coefficient.
        wear_um3_per_mJ: worn volume of both wires per friction energy.
        retained_fraction, bed_MPa: share of the worn volume that stays in the scars as debris, and the bed's modulus,
            zero of one that does not give way.
        oxygen_W, starved_factor: supply of oxygen, zero for enough everywhere, and the factor on wear where it lacks.
        compliance_um_per_N, free_play_um: of all that lies in series with the contact along the motion.
        flattening_um: approach of the wires by flattening before any wear.
        rough_um, bed_um: heights of rough layers that spread the contact's pressures: of asperities, and of one that
            gives way like a bed of debris.
        crossing_error_rad: of the wires' axes from the right angle.
        gain, linear_um_per_N, quadratic_um_per_N2, crosstalk, lag_s, force_lag_s, force_zero_N: of the sensors.
        length_um: of a line contact; zero for crossed wires.
    """

    radius_um: float
    fresh_area_um2: float
    cycles: Array
    energy_J: Array
    worn_um3: Array
    load_N: Array
    misalignment_rad: Array
    friction: Array
    wear_um3_per_mJ: Array
    retained_fraction: Array
    bed_MPa: Array
    oxygen_W: Array
    starved_factor: Array
    compliance_um_per_N: Array
    free_play_um: Array
    flattening_um: Array
    rough_um: Array
    bed_um: Array
    crossing_error_rad: Array
    gain: Array
    linear_um_per_N: Array
    quadratic_um_per_N2: Array
    crosstalk: Array
    lag_s: Array
    force_lag_s: Array
    force_zero_N: Array
    length_um: float = 0.0

    @property
    def worn_area2_um4(self) -> Array:
        """Square of the contact's area (n,) as wear leaves it: π R V of wires, (2 L w)² of lines, w³ = 3 R V/(2 L)."""
        if self.length_um == 0.0:
            return pi * self.radius_um * self.worn_um3
        half_width = np.cbrt(1.5 * self.radius_um * self.worn_um3 / self.length_um)
        return np.asarray((2.0 * self.length_um * half_width) ** 2)

    @property
    def ages(self) -> list[Age]:
        """How far the test has come at each moment."""
        return [Age(n, energy) for n, energy in zip(self.cycles.tolist(), self.energy_J.tolist(), strict=True)]

    def taken(self, moments: NDArray[np.intp]) -> Chain:
        """Some moments only."""
        return replace(self, **{name: getattr(self, name)[moments] for name in _COLUMNS})


_COLUMNS = tuple(
    field.name for field in fields(Chain) if field.name not in ("radius_um", "fresh_area_um2", "length_um")
)


@dataclass(frozen=True)
class _SeamView:
    """How columns of a chain and a seam's description say the same: one row of columns to a description and back.

    `unread` names the description's fields that the columns do not hold.
    """

    columns: tuple[str, ...]
    unread: tuple[str, ...]
    described: Callable[..., Any]
    row: Callable[[Any], tuple[float, ...]]


def _other(description: type[Any], *read: str) -> tuple[str, ...]:
    """Names of a description's fields but for those that are read."""
    return tuple(field.name for field in fields(description) if field.name not in read)


_VIEWS: dict[Seam, _SeamView] = {
    Seam.HOLDER: _SeamView(
        ("load_N", "compliance_um_per_N", "free_play_um"),
        _other(
            Holder,
            "normal_load_N",
            "tangential_compliance_mm_per_N",
            "rotational_compliance_rad_per_N_mm",
            "pivot_height_mm",
            "play_mm",
        ),
        lambda load, compliance, play: Holder(
            load, tangential_compliance_mm_per_N=1e-3 * compliance, play_mm=1e-3 * play
        ),
        lambda holder: (holder.normal_load_N, 1e3 * holder.compliance_at_contact_mm_per_N, 1e3 * holder.play_mm),
    ),
    Seam.CONTACT: _SeamView(("friction",), _other(ContactLaw, "friction"), ContactLaw, lambda law: (law.friction,)),
    Seam.WEAR: _SeamView(
        ("wear_um3_per_mJ",),
        _other(WearRates, "upper_mm3_per_mJ", "lower_mm3_per_mJ"),
        lambda both: WearRates(0.5e-9 * both, 0.5e-9 * both),
        lambda rates: (1e9 * (rates.upper_mm3_per_mJ + rates.lower_mm3_per_mJ),),
    ),
    Seam.SPECIMENS: _SeamView(
        ("crossing_error_rad", "flattening_um"),
        _other(Specimens, "crossing_angle_deg", "flattening_mm"),
        lambda error, flattening: Specimens(90.0 + degrees(error), 1e-3 * flattening),
        lambda wires: (radians(wires.crossing_angle_deg - 90.0), 1e3 * wires.flattening_mm),
    ),
    Seam.LOADING: _SeamView(
        ("load_N", "misalignment_rad"),
        _other(Loading, "normal_load_N", "misalignment_rad"),
        Loading,
        lambda loading: (loading.normal_load_N, loading.misalignment_rad),
    ),
    Seam.SENSOR: _SeamView(
        ("gain", "linear_um_per_N", "quadratic_um_per_N2", "crosstalk", "lag_s", "force_lag_s"),
        _other(
            Sensor,
            "displacement_gain",
            "linear_um_per_N",
            "quadratic_um_per_N2",
            "force_crosstalk",
            "lag_s",
            "force_lag_s",
        ),
        lambda gain, linear, quadratic, crosstalk, lag, force_lag: Sensor(
            displacement_gain=gain,
            linear_um_per_N=linear,
            quadratic_um_per_N2=quadratic,
            force_crosstalk=crosstalk,
            lag_s=lag,
            force_lag_s=force_lag,
        ),
        lambda sensor: (
            sensor.displacement_gain,
            sensor.linear_um_per_N,
            sensor.quadratic_um_per_N2,
            sensor.force_crosstalk,
            sensor.lag_s,
            sensor.force_lag_s,
        ),
    ),
}


class Foreseeable(ChangesASeam, Protocol):
    """What changes a seam, and says what it follows over a test."""

    @property
    def seam(self) -> Seam:
        """The seam that it changes."""
        ...

    @property
    def name(self) -> str:
        """Its name."""
        ...

    @property
    def ages(self) -> Ageing:
        """What it follows over a test."""
        ...


def through_its_seam(effect: Foreseeable, chain: Chain) -> Chain:
    """The chain with what an effect changes at its seam.

    Raises:
        UnforeseenError: it changes something there that the chain does not hold.
    """
    view = _VIEWS[effect.seam]
    columns = np.stack([getattr(chain, name) for name in view.columns], axis=1)
    once = effect.ages is Ageing.NEVER and bool((columns == columns[0]).all())
    rows, ages = (columns[:1], chain.ages[:1]) if once else (columns, chain.ages)
    changed = [_changed(effect, view, row, age) for row, age in zip(rows.tolist(), ages, strict=True)]
    values = np.broadcast_to(np.array(changed), columns.shape)
    return replace(chain, **dict(zip(view.columns, values.T, strict=True)))


def _changed(effect: Foreseeable, view: _SeamView, row: Iterable[float], age: Age) -> tuple[float, ...]:
    before = view.described(*row)
    after = effect.changed(before, age)
    if any(getattr(after, name) != getattr(before, name) for name in view.unread):
        raise UnforeseenError(
            f"{effect.name} changes something of the {effect.seam} that fast models do not know: let its method "
            "`foreseen` say what it does to a chain."
        )
    return view.row(after)
