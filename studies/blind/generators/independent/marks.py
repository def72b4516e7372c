"""Marks on wires that rubbing does not leave: grooves from before a test, and what befalls a wire at once during it."""

from collections.abc import Sequence
from math import inf
from typing import Protocol

from studies.blind.generators.independent.foundation import Array, Grid, Shapes


class Incident(Protocol):
    """What changes the worn wires at once."""

    @property
    def cycle(self) -> float:
        """When it happens, after the start."""
        ...

    def befallen(self, grid: Grid, shapes: Shapes) -> Shapes:
        """Both wires after it."""
        ...


def next_cycle(incidents: Sequence[Incident], cycle: float) -> float:
    """When the next incident after a cycle happens; infinite if none does."""
    return min((incident.cycle for incident in incidents if incident.cycle > cycle), default=inf)


def befallen(incidents: Sequence[Incident], cycle: float, grid: Grid, shapes: Shapes) -> Shapes:
    """Both wires after all that happens to them at a cycle, one after the other."""
    for incident in incidents:
        if incident.cycle == cycle:
            shapes = incident.befallen(grid, shapes)
    return shapes


class Groove(Protocol):
    """A mark along the fixed wire."""

    def depth_mm(self, grid: Grid) -> Array:
        """Its depth on the fixed wire's grid (n_y, n_x)."""
        ...
