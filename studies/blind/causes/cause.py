"""What a cause says of itself, and the parts of a model that causes change: readings, friction, load, wear, holder.

A model takes each part where it has it: the independent model (T2) by `in_world`, which every cause has; finite element
runs (T0, T1, A1, B1, L1) know readings, factors on friction, load and wear, and holders that age.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

from studies.blind.generators.draw import Draw
from studies.blind.generators.independent.world import World
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.signals import Instrument, Signals

Sizes = dict[str, float]


@dataclass(frozen=True)
class Cause(ABC):
    """Something that goes wrong on a rig, of some size."""

    #: Where it enters: sensor, contact, holder, loading, wear or specimens. What a force cell bears beside the contact
    #: is the sensor's.
    seam: ClassVar[str]
    #: The sets that it belongs to, each with its place in their order.
    sets: ClassVar[tuple[tuple[str, int], ...]]

    @staticmethod
    @abstractmethod
    def size(d: Draw) -> Sizes:
        """Parameters by name, of the severity that is drawn, relative to the nominal test."""

    @abstractmethod
    def in_world(self, world: World) -> World:
        """A test of the independent model with the cause in it."""


class ReadingOfTest(Cause):
    """Changes the channels of a loop that was computed without it, by what the test states.

    What acts on true forces is of first order: it leaves out what further force bends the holder, and wear, whose work
    over a whole cycle it does not change.
    """

    @abstractmethod
    def instrument(self, nominal: Nominal) -> Instrument:
        """What reads a finite element run of a test."""


class Reading(ReadingOfTest):
    """Changes the channels whatever the test."""

    @abstractmethod
    def read(self, signals: Signals, cycle: float) -> Signals:
        """The channels as changed at a cycle."""

    def instrument(self, _nominal: Nominal) -> Instrument:
        return self

    def in_world(self, world: World) -> World:
        """A test whose loops are read with it."""
        return replace(world, instruments=(*world.instruments, self))


class FrictionFactor(Cause):
    """A factor on friction over the cycles."""

    @abstractmethod
    def at(self, cycle: float) -> float:
        """The factor at a cycle."""

    def in_world(self, world: World) -> World:
        """A test with such friction."""
        return replace(world, friction=replace(world.friction, events=(*world.friction.events, self)))


class LoadFactor(Cause):
    """A factor on the load over the cycles."""

    @abstractmethod
    def at(self, cycle: float) -> float:
        """The factor at a cycle."""

    def in_world(self, world: World) -> World:
        """A test under such a load."""
        return replace(world, loading=replace(world.loading, events=(*world.loading.events, self)))


class WearChange(Cause):
    """Other wear coefficients of both bodies over the cycles."""

    @abstractmethod
    def rates(self, upper: float, lower: float, cycle: float) -> tuple[float, float]:
        """Coefficients of the upper and the lower body at a cycle, from those without it; the lower one moves."""


class WearFactor(WearChange):
    """A factor on both coefficients."""

    @abstractmethod
    def at(self, cycle: float) -> float:
        """The factor at a cycle."""

    def rates(self, upper: float, lower: float, cycle: float) -> tuple[float, float]:
        """Both coefficients times the factor."""
        factor = self.at(cycle)
        return factor * upper, factor * lower

    def in_world(self, world: World) -> World:
        """A test that wears so."""
        return replace(world, wear=replace(world.wear, events=(*world.wear.events, self)))


class AgeingHolder(Cause):
    """A holder that gives way more, or comes to have more play, over the cycles."""

    def mm_per_N(self, _cycle: float) -> float:
        """What it has come to give way by, in series with the contact."""
        return 0.0

    def play_mm(self, _cycle: float) -> float:
        """How much play it has come to have."""
        return 0.0

    def in_world(self, world: World) -> World:
        """A test on that holder."""
        return replace(world, rig=replace(world.rig, ageing=(*world.rig.ageing, self)))
