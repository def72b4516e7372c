"""A wire as a beam on several contacts, which press one way only: what each of them carries (N, mm).

The beam bends, shears (Timoshenko) and is pulled along its axis. Places are along it, deflections towards the contacts.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.optimize import root

from geometry.arrays import Array
from wirewear.base.errors import StudyError

_PARTS = 8  #: Elements between neighbouring places; with twice as many, loads of the tests change by less than 1e-6.


class HeldWire(Protocol):
    """A wire under load_N on contacts, a beam or of elements."""

    @property
    def load_N(self) -> float: ...

    def at(self, places_mm: Array, /) -> tuple[Array, Array]:
        """(K (n, n) in N/mm, p (n,) in N) at places_mm (n,): forces p − K u hold the deflections u (n,) there."""
        ...


@dataclass(frozen=True)
class Beam:
    """A straight beam. bending_N_mm2, shear_N: stiffnesses EI and κGA; tension_N: pull along it. clamped_at_mm: places
    at which deflection and slope are zero; free without any. load_N acts in equal parts at loads_at_mm.
    """

    bending_N_mm2: float
    shear_N: float
    load_N: float
    loads_at_mm: tuple[float, ...]
    tension_N: float = 0.0
    clamped_at_mm: tuple[float, ...] = ()

    def at(self, places_mm: Array, /) -> tuple[Array, Array]:
        marks = np.unique([*places_mm, *self.loads_at_mm, *self.clamped_at_mm])
        steps = np.linspace(0.0, 1.0, _PARTS, endpoint=False)
        nodes = np.append(marks[:-1, None] + np.diff(marks)[:, None] * steps, marks[-1])
        matrix, force = np.zeros((2 * nodes.size, 2 * nodes.size)), np.zeros(2 * nodes.size)
        for k, length in enumerate(np.diff(nodes)):
            matrix[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += self._element(length)
        at, pressed, held = (
            2 * np.searchsorted(nodes, each) for each in (places_mm, self.loads_at_mm, self.clamped_at_mm)
        )
        force[pressed] = self.load_N / len(self.loads_at_mm)
        rest = np.setdiff1d(np.arange(force.size), [*at, *held, *(held + 1)])
        found = np.linalg.solve(matrix[np.ix_(rest, rest)], np.column_stack([matrix[np.ix_(rest, at)], force[rest]]))
        across = matrix[np.ix_(at, rest)]
        return matrix[np.ix_(at, at)] - across @ found[:, :-1], force[at] - across @ found[:, -1]

    def _element(self, length_mm: float) -> Array:
        """Stiffness (4, 4) against deflection and slope at both ends (Przemieniecki, Theory of Matrix Structural
        Analysis, 1968), tension included.
        """
        shear = 12.0 * self.bending_N_mm2 / (self.shear_N * length_mm**2)
        a, b = 6.0 * length_mm, length_mm**2
        same, other = (4.0 + shear) * b, (2.0 - shear) * b
        bent = np.array([[12.0, a, -12.0, a], [a, same, -a, other], [-12.0, -a, 12.0, -a], [a, other, -a, same]])
        c, d = 3.0 * length_mm, 4.0 * b
        pulled = np.array([[36.0, c, -36.0, c], [c, d, -c, -b], [-36.0, -c, 36.0, -c], [c, -b, -c, d]])
        own = self.bending_N_mm2 / (length_mm**3 * (1.0 + shear))
        return np.asarray(own * bent + self.tension_N / (30.0 * length_mm) * pulled)


@dataclass(frozen=True, eq=False)
class Yielding:
    """Depths by which n contacts let a beam down under forces f (n,): gap_mm + softness f^⅔ + wear √(work + cycles f).

    gap_mm: of the unworn contact, negative if the straight beam would press on it; softness: in mm/N^⅔, of Hertz'
    contacts. wear: in mm/√N; a scar's depth grows as the root of its volume. work: sum in N of past loads over cycles.
    """

    gap_mm: Array
    softness: Array
    wear: Array
    work: Array
    cycles: float

    def depth_mm(self, force_N: Array) -> Array:
        """Worn depths (n,) after the cycles under forces (n,)."""
        return np.asarray(self.wear * np.sqrt(self.work + self.cycles * force_N))


def contact_forces(beam: HeldWire, places_mm: Array, contacts: Yielding) -> Array:
    """Forces (n,) in N, 0 where open, with which contacts at places_mm (n,) hold the beam. Raises StudyError if it
    rests on none of them, or tips over.
    """
    stiffness, load = beam.at(places_mm)
    size = beam.load_N / len(places_mm)
    sunk = contacts.softness * size ** (2.0 / 3.0)

    def force(sinking: Array) -> Array:
        return np.asarray(size * np.maximum(sinking, 0.0) ** 1.5)

    def missed(sinking: Array) -> Array:
        # Elastic approach over that under an equal share; below 0, the contact is open by as much.
        own = force(sinking)
        down = contacts.gap_mm + contacts.depth_mm(own) + sunk * sinking
        return np.asarray((stiffness @ down + own - load) / beam.load_N)

    for start in (0.5, 1.0, 0.1, 2.0):
        found = root(missed, np.full(len(places_mm), start), method="hybr", options={"xtol": 1e-13})
        own = force(found.x)
        if np.abs(missed(found.x)).max() < 1e-10 and own.any():
            return own
    raise StudyError("no loads were found under which the wire rests on its contacts: it tips over, or touches none")
