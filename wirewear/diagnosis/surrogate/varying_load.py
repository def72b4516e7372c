"""A contact behind its rig in a cycle whose load varies: it slides, sticks in its middle, opens, or rests."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray, IntArray
from solvers import LoadCycle
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.surrogate.loop_states import FastMotion
from wirewear.diagnosis.surrogate.sensed_loops import POSITIONS, STICK, SlidingContact
from wirewear.diagnosis.surrogate.springs import Curves, Rig, Rows, through

if TYPE_CHECKING:
    from wirewear.effects import Chain

_KNOWN = constants("surrogate.varying_load")

#: Instants of a stroke and of a rest, and the share of the stroke by which the first ones of a stroke are apart.
_INSTANTS, _AT_REST, _CLOSE = _KNOWN.count("instants"), _KNOWN.count("instants_at_rest"), _KNOWN.number("close")

#: Instants of a stroke by which a holder's swinging is followed, some twenty times as fast as the drive.
_SWINGS = _KNOWN.count("instants_of_swinging")

#: A drive rests where the arcsine of its place is so near to its end.
_RESTS = _KNOWN.number("rests")

#: Share of the friction from which on a contact slides as a whole.
_WHOLE = _KNOWN.number("whole")


@dataclass(frozen=True, eq=False)
class CyclePath:
    """A cycle's path at k instants: drive over its amplitude, load over the test's, phase, which of them are kinks of
    the load, and where the stroke to −x ends.

    It begins and ends at +x, in the middle of the drive's rest there, and turns in the middle of that at −x.
    """

    drive: Array
    load: Array
    phase: Array
    bends: BoolArray
    turn: int

    @classmethod
    def of(cls, motion: FastMotion, load: LoadCycle, *, swings: bool = False) -> CyclePath:
        """The path of a drive and a load; swings: with instants so near that a holder's swinging is followed."""
        return _path(motion, load, swings)


@lru_cache(maxsize=64)
def _path(motion: FastMotion, load: LoadCycle, swings: bool) -> CyclePath:
    # Corners that few harmonics round off are the ends of a rest; what is left of their ripple counts as one.
    sharp = motion.before(0.0)
    rest = _RESTS if sharp.harmonics.size > motion.harmonics.size else _RESTS / 10.0
    (there, come), (back, left) = sharp.tables
    whole = 2.0 * np.pi
    top, bottom = (
        0.5 * (phase[bent > bent[-1] - rest][0] + later[other < other[0] + rest][-1])
        for bent, phase, other, later in ((there, come, back, left), (back, left, there, come + whole))
    )
    bends, strokes = top + whole * load.bends(0.0, 1.0), []
    travel = _CLOSE * ((1.0 + 1.0 / _CLOSE) ** np.linspace(0.0, 1.0, _INSTANTS) - 1.0)
    if swings:
        travel = np.union1d(travel, 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, _SWINGS)))
    for bent, phase, start, end in ((back, left, top, bottom), (there, come + whole, bottom, top + whole)):
        moves = np.flatnonzero((bent > bent[0] + rest) & (bent < bent[-1] - rest))
        rising, kept = np.unique(bent[moves], return_index=True)
        at = 2.0 * (np.sin(rising) - np.sin(rising[0])) / (np.sin(rising[-1]) - np.sin(rising[0])) - 1.0
        passed = np.interp(2.0 * travel - 1.0, at, phase[moves[kept]])
        rests = [np.linspace(a, b, _AT_REST) for a, b in ((start, passed[0]), (passed[-1], end))]
        kinks = bends[(bends > start) & (bends < end)]
        times = np.unique(np.concatenate([rests[0][:-1], passed, rests[1][1:], kinks]))
        strokes.append((times, np.interp(times, passed, 2.0 * travel - 1.0)))
    (falls, down), (rises, up) = strokes
    times = np.concatenate([falls, rises[1:]])
    shares = load.shares(((times - top) / whole) % 1.0)
    return CyclePath(np.concatenate([-down, up[1:]]), np.asarray(shares), times, np.isin(times, bends), falls.size - 1)


@dataclass(frozen=True, eq=False)
class Followed:
    """Figures of n contacts over a cycle: drive, tangential and normal force (n, 2, m) along both branches, as of a
    contact that slides; slip amplitude in µm, friction energy in mJ and largest share of the friction (n,).
    """

    displacement_um: Array
    force_N: Array
    load_N: Array
    slip_um: Array
    energy_mJ: Array
    share: Array

    def taken(self, moments: NDArray[np.intp]) -> Followed:
        """The contacts of these indices only."""
        return Followed(*(column[moments] for column in vars(self).values()))


def followed(
    contact: SlidingContact, chain: Chain, path: CyclePath, slip_um: Array, stroke_um: Array, frequency_Hz: float
) -> Followed:
    """Contacts under the test's load, behind springs, play and inertia, whose drive moves by `stroke_um` (n,) to either
    side. slip_um: (n,) slip amplitudes over which the contact's curves reach.
    """
    # Where nothing wears, most moments are alike, and so are those that only differ in what sensors read.
    known = (
        contact.force_N, contact.load_N, contact.yielding_um_per_N, contact.order, contact.springs_um_per_N,
        chain.free_play_um, chain.mass_kg, slip_um, stroke_um,
    )  # fmt: skip
    table = np.concatenate([one.reshape(stroke_um.size, -1) for one in known], axis=1)
    places: dict[bytes, int] = {}
    alike = np.array([places.setdefault(row.tobytes(), len(places)) for row in table])
    first = np.unique(alike, return_index=True)[1]
    if first.size < alike.size:
        own = followed(contact.taken(first), chain.taken(first), path, slip_um[first], stroke_um[first], frequency_Hz)
        return own.taken(alike)
    up = contact.force_N[:, 0]
    wall, friction = 0.5 * (up - up[:, ::-1]), 0.5 * (up + up[:, ::-1])
    load = np.broadcast_to(contact.load_N[:, 0], up.shape)
    full_um = contact.yielding_um_per_N * friction[:, POSITIONS.size // 2]
    curves = Curves(slip_um[:, None] * POSITIONS, contact.yielding_um_per_N[:, None] * wall, wall, friction, load)
    inertia = 1e-6 * chain.mass_kg * (2.0 * np.pi * frequency_Hz) ** 2
    q, p, slid, mobile, energy = through(
        path.phase, path.drive, path.load, stroke_um, Rows(full_um, contact.order), curves,
        Rig(contact.springs_um_per_N, chain.free_play_um, inertia),
    )  # fmt: skip
    x = stroke_um[:, None] * path.drive
    # The branch towards +x is the second stroke.
    strokes = slice(path.turn, None), slice(0, path.turn + 1)
    branches = [
        _branch(
            path.phase[own], np.flatnonzero(path.bends[own]), sign * mobile[:, own], x[:, own], q[:, own], p[:, own]
        )
        for sign, own in zip((1.0, -1.0), strokes, strict=True)
    ]
    x, q, p = (np.stack(both, axis=1) for both in zip(*branches, strict=True))
    share = np.minimum(mobile.max(axis=1), -mobile.min(axis=1))
    slides = share > _WHOLE
    return Followed(x, q, p, np.where(slides, 0.5 * np.ptp(slid, axis=1), 0.0), energy, np.where(slides, 1.0, share))


def _branch(phase: Array, bends: IntArray, mobile: Array, *columns: Array) -> tuple[Array, ...]:
    """Columns (n, k) of a stroke at places of branches (n, m): those until it slides as a whole, or to its middle, then
    even times.
    """
    count = mobile.shape[1]
    slides: BoolArray = mobile > _WHOLE
    middle = np.interp(0.5 * (phase[0] + phase[-1]), phase, np.arange(count))
    knee = np.where(slides.any(axis=1), np.maximum(slides.argmax(axis=1), 1), middle)[:, None]
    begins = np.interp(knee, np.arange(count), phase)
    after = np.interp(
        begins + (phase[-1] - begins) * np.linspace(0.0, 1.0, POSITIONS.size)[1:], phase, np.arange(count)
    )
    at = np.concatenate([knee * STICK, after], axis=1)
    rows = np.arange(len(mobile))
    for kink in bends.tolist():
        # A place next to a kink stands for it: none is cut off.
        at[rows, 1 + np.abs(at[:, 1:-1] - kink).argmin(axis=1)] = kink
    left = np.minimum(at.astype(int), count - 2)
    share = at - left
    here, there = (rows[:, None], left), (rows[:, None], left + 1)
    return tuple(column[here] + share * (column[there] - column[here]) for column in columns)
