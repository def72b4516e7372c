"""The seams of the model, at which effects enter, and the descriptions of the model there that effects change."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import inf
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from solvers import ContactLayer, DebrisFlow

if TYPE_CHECKING:
    from solvers import ContactProblem

T = TypeVar("T")


class Seam(StrEnum):
    """The seams, each with the class that describes the model there: holder (solvers.Holder), contact (ContactLaw),
    wear (solvers.WearRates), specimens (Specimens), drive (Control), loading (Loading), sensor
    (wirewear.loops.sensor.Sensor).
    """

    HOLDER = "holder"  #: solvers.Holder
    CONTACT = "contact"  #: ContactLaw
    WEAR = "wear"  #: solvers.WearRates
    SPECIMENS = "specimens"  #: Specimens
    DRIVE = "drive"  #: Control
    LOADING = "loading"  #: Loading
    SENSOR = "sensor"  #: wirewear.loops.sensor.Sensor


@dataclass(frozen=True)
class Age:
    """Age of a test: number of cycles done, and friction energy dissipated in J."""

    cycles: float
    energy_J: float

    @classmethod
    def new(cls) -> Age:
        """The age before the first cycle."""
        return cls(0.0, 0.0)


class Ageing(StrEnum):
    """On what an effect's strength may depend during a test: nothing, the cycles alone, or cycles, energy and wear."""

    NEVER = "nothing: it is the same throughout"
    BY_CYCLES = "the cycles alone"
    BY_WEAR = "the cycles, the dissipated energy or the worn volume"


@dataclass(frozen=True)
class ContactLaw:
    """The coefficient of friction between the surfaces, and compliant layers there, in series; how debris leaves, None
    if it stays.
    """

    friction: float
    layers: tuple[ContactLayer, ...] = ()
    debris: DebrisFlow | None = None


@dataclass(frozen=True)
class Specimens:
    """The bodies as mounted: the angle between the wires' axes, the approach in mm by which both were flattened
    together before any wear, and the yield stress of the body that yields first, infinite for elastic bodies.
    """

    crossing_angle_deg: float
    flattening_mm: float = 0.0
    yield_stress_MPa: float = inf


@dataclass(frozen=True)
class Control:
    """Displacement amplitude in µm that the drive holds; None if it holds another figure, which the study states."""

    displacement_amplitude_um: float | None


@dataclass(frozen=True)
class Loading:
    """The load on the holder when the bodies have just been pressed together, and the motion's direction."""

    normal_load_N: float  #: Along the loading axis.
    misalignment_rad: float = 0.0  #: Angle by which the motion rises out of the contact plane.


class ChangesASeam(Protocol):
    """Anything that changes the description at one seam."""

    @property
    def seam(self) -> Seam | None:
        """The seam at which the change acts; None if it acts at several."""
        ...

    def changed(self, described: Any, age: Age) -> Any:
        """The description with the change made, at an age of the test."""
        ...


def applied(effects: Iterable[ChangesASeam], seam: Seam, described: T, age: Age) -> T:
    """The description `described` of a seam after all those of `effects` that change this seam, one after the other, at
    an age of the test.
    """
    for effect in effects:
        if effect.seam is seam:
            described = effect.changed(described, age)
    return described


def problem_with(problem: ContactProblem, effects: Sequence[ChangesASeam], age: Age) -> ContactProblem:
    """The nominal contact problem with the effects on holder, loading, contact law and wear law in it, at an age of the
    test; other effects do not count here.
    """
    if problem.friction_law.ages or problem.wear.law.ages:
        problem = replace(problem, cycle=age.cycles)
    if not effects:
        return problem
    holder = applied(effects, Seam.HOLDER, problem.holder, age)
    loading = applied(effects, Seam.LOADING, Loading(holder.normal_load_N), age)
    law = applied(effects, Seam.CONTACT, ContactLaw(problem.friction, problem.layers, problem.debris), age)
    if loading.misalignment_rad != 0.0:
        from solvers import misaligned

        problem = misaligned(problem, loading.misalignment_rad)
    return replace(
        problem,
        holder=replace(holder, normal_load_N=loading.normal_load_N),
        friction=law.friction,
        layers=law.layers,
        debris=law.debris,
        wear=applied(effects, Seam.WEAR, problem.wear, age),
    )
