"""Marks on wires that rubbing does not leave: grooves from before a test, and what befalls a wire at once during it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Protocol

import numpy as np

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


@dataclass(frozen=True)
class Groove:
    """A scratch that a worn die left along the fixed wire: a parabola across it, its middle so far aside."""

    deepest_mm: float
    half_width_mm: float
    aside_mm: float

    def depth_mm(self, grid: Grid) -> Array:
        """Its depth on the fixed wire's grid (n_y, n_x)."""
        across = (grid.x_mm - self.aside_mm) / self.half_width_mm
        depth = self.deepest_mm * np.maximum(1.0 - across**2, 0.0)
        return np.asarray(np.broadcast_to(depth, (grid.y_mm.size, depth.size)))


@dataclass(frozen=True)
class Remounted:
    """The fixed wire is taken out and put back turned about its axis: its scar lies aside along the motion."""

    cycle: float
    aside_mm: float

    def befallen(self, grid: Grid, shapes: Shapes) -> Shapes:
        """The fixed wire's scar at its new place."""
        places = grid.x_mm - self.aside_mm
        turned = [np.interp(places, grid.x_mm, row, left=0.0, right=0.0) for row in shapes.fixed]
        return replace(shapes, fixed=np.stack(turned))


@dataclass(frozen=True)
class Spalled:
    """A flake breaks out of the fixed wire's scar and leaves a pit, a paraboloid with its middle so far off."""

    cycle: float
    deepest_mm: float
    radius_mm: float
    x_mm: float
    y_mm: float

    def befallen(self, grid: Grid, shapes: Shapes) -> Shapes:
        """The fixed wire with its pit."""
        off = np.hypot(grid.x_mm[None, :] - self.x_mm, grid.y_mm[:, None] - self.y_mm) / self.radius_mm
        return replace(shapes, fixed=shapes.fixed + self.deepest_mm * np.maximum(1.0 - off**2, 0.0))
