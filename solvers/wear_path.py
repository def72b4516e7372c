"""The ends of the increments of a cycle by which surfaces wear.

Wear is computed at these ends only, so they must lie closer together than the surfaces' elements. Both strokes wear the
same surface: if the places of one stroke are shifted by a quarter of their distance, those of the other, its mirror
image, lie halfway between them, and together they are twice as dense. The slip is the motion of the drive less that of
the holder. The holder's position along a stroke is taken from an earlier one; without one it is assumed to spring back
as far to the other side as it had been carried along, and then to stand still. Where load or bulk stress change within
the cycle, the contact slides and sticks by them as well, on a soft rig even against the drive. Such cycles have shorter
increments, and surfaces wear at the ends of some of them.

Places are displacements of the drive in mm, at which increments end; side is +1 or -1 for the end of the stroke where a
cycle starts; a guide holds first guesses from a similar cycle.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from solvers.contact_state import Guide, Stroke
from solvers.drive import Drive, Path

# Increments from a reversal to the first place, over which the holder springs back and the contact mostly sticks.
_STICK_INCREMENTS = 2
_SHIFT = 0.25
_FOLLOWS = 0.9  # A holder that moves by less than this share of what the drive moves slides.
# The increment that sticks ends where the bodies have moved against each other by this share of the places' distance,
# for they yield elastically while they stick, and no nearer than that share of its way to either side.
_STUCK_SHARE = 0.04
_LEAST_SLIP = 1e-4  # Of all slip: increments with less stick.


def cosine_places(amplitude_mm: float, increments: int) -> Array:
    """Places (increments,) in mm of half a cycle from +amplitude to -amplitude, evenly spaced in a cosine's phase.

    Both quarters are mirror images to the last bit. increments: an even number.
    """
    quarter = amplitude_mm * np.cos(0.5 * np.pi * np.arange(1, increments // 2 + 1) / (increments // 2))
    quarter[-1] = 0.0
    return np.concatenate([quarter, -quarter[-2::-1], [-amplitude_mm]])


def traced_path(
    drive: Drive, side: float, holder_x_mm: float, increments: int, guide: Guide | None, *, half: bool
) -> Path:
    """The path of a cycle by which surfaces wear, or of its first `half`, starting at `side` times the amplitude.

    holder_x_mm: position of the holder at the start. increments: number in a cycle, at whose ends surfaces wear; under
    a changing load there are more in between. guide: for the holder's positions; None if there is none yet.
    """
    count, strokes = increments // 2, list[Path]()
    worn = None if drive.steady or guide is None else _evenly_slid(drive, increments, guide)
    for own in (side,) if half else (side, -side):
        before = None if guide is None else guide.stroke(own)
        if drive.steady:
            places = own * wear_path(drive.amplitude_mm, own * holder_x_mm, count, before)
        else:
            places = own * cosine_places(drive.amplitude_mm, drive.followed_by(count))
            places = places if worn is None else _with_places(places, worn[own])
        strokes.append(drive.stroke(own, places))
        holder_x_mm = -holder_x_mm if before is None else own * float(before.holder_x[-1])
    return strokes[0] if half else strokes[0] + strokes[1]


@dataclass(frozen=True)
class WornPlaces:
    """The k increments of a traced cycle at whose ends surfaces wear; each stands for its neighbours as well."""

    increments: IntArray  #: (k,) their indices in the trace, increasing.
    load_slip: Array  #: (k,) integral of the load over the slip that each stands for, N mm.
    driven: Array  #: (k,) motion of the drive during the sliding that each stands for, mm.


def spread_over_slip(slip: Array, weight: Array, count: int) -> Array:
    """Ends of increments at which surfaces wear: evenly spaced over the slip, and one where each slip in a direction
    ends.

    slip: (m,) signed, of each increment, mm. weight: (m,) factors on these lengths. count: about how many ends. Returns
    them as numbers of increments from the start of the cycle, with fractions; empty if nothing slides.
    """
    length, places = np.abs(slip) * weight * slides(slip), list[float]()
    sliding = np.flatnonzero(length)
    for own in np.split(sliding, 1 + np.flatnonzero(np.diff(np.sign(slip[sliding])))) if len(sliding) else ():
        passed = np.cumsum(length[own])
        own_count = round(count * float(passed[-1] / length.sum()))
        wanted = float(passed[-1]) * (np.arange(own_count) + _SHIFT) / max(own_count, 1)
        at = np.searchsorted(passed, wanted)
        places += [*(own[at] + 1.0 - (passed[at] - wanted) / length[own[at]]), own[-1] + 1.0]
    return np.array(places)


def _onsets(slip: Array, durations: Array) -> Array:
    """Positions in a cycle where sticking bodies suddenly begin to slide, as numbers of increments, with fractions.

    slip, durations: (m,) of each increment.
    """
    # No phase passes while the drive rests.
    rate = np.divide(slip, durations, out=np.zeros(len(slip)), where=durations > 0.0)
    before, after = np.roll(rate, 1), np.roll(rate, -1)
    # Of the rate at which the bodies slide after an increment: with less before it, they stuck there.
    begins = (np.abs(before) < 0.1 * np.abs(after)) & slides(np.roll(slip, -1)) & (rate * after > 0.0)
    at = np.flatnonzero(begins)
    return np.asarray(at + 1.0 - np.minimum(rate[at] / after[at], 1.0))


def slides(slip: Array) -> BoolArray:
    """(m,) True for increments of a cycle with more than 1e-4 of its whole slip."""
    return np.asarray(np.abs(slip) > _LEAST_SLIP * float(np.abs(slip).sum()))


def sliding_increments(increments: int) -> int:
    """Number of those of a cycle's increments at whose ends surfaces wear: all but two of each stroke."""
    return increments - 2 * _STICK_INCREMENTS


def _evenly_slid(drive: Drive, increments: int, guide: Guide) -> dict[float, Array]:
    """Places in mm on the strokes from either side (+1, -1), evenly spaced over a guide's slip, and where sliding
    begins.

    The latter are needed, since an increment that first sticks would take its friction for all of its slip.
    """
    time, slip = _slid(drive, guide)
    even = spread_over_slip(slip, drive.mean_load + drive.load.shares(time), sliding_increments(increments))
    return _of_strokes(drive, guide, np.sort(np.append(even, _onsets(slip, np.diff(guide.phase, prepend=0.0)))))


def _slid(drive: Drive, guide: Guide) -> tuple[Array, Array]:
    """Times (m,) at which a guide's increments end, and slip (m,) in mm of the bodies over each of them."""
    stroke = _stroke(guide)
    along = drive.amplitude_mm * stroke
    slip = np.diff(along - guide.holder_x, prepend=along[-1] - guide.holder_x[-1])
    return drive.waveform.times(stroke, guide.phase), slip


def _stroke(guide: Guide) -> Array:
    """Displacements (m,) of a guide over its amplitude."""
    return np.asarray(guide.drive / float(np.abs(guide.drive).max()))


def _of_strokes(drive: Drive, guide: Guide, found: Array) -> dict[float, Array]:
    """Places in mm on the strokes from either side (+1, -1), from positions as numbers of a guide's increments."""
    along = drive.amplitude_mm * _stroke(guide)
    places = np.interp(found, np.arange(len(along) + 1), np.append(along[-1], along))
    falling = found <= np.count_nonzero(guide.phase <= 0.5)
    return {1.0: places[falling], -1.0: places[~falling]}


def loop_path(drive: Drive, side: float, increments: int, guide: Guide | None) -> Path:
    """The path of a cycle by which a loop is measured, starting at `side` times the amplitude: `increments` places of a
    cosine.

    Where load or bulk stress change, also the places where sticking bodies begin to slide, according to a guide of a
    whole cycle.
    """
    places = cosine_places(drive.amplitude_mm, increments // 2)
    along = {own: own * places for own in (side, -side)}
    if not drive.steady and guide is not None and guide.phase[0] < 0.5 < guide.phase[-1]:
        slip = _slid(drive, guide)[1]
        onsets = _of_strokes(drive, guide, _onsets(slip, np.diff(guide.phase, prepend=0.0)))
        along = {own: _with_places(along[own], onsets[own]) for own in along}
    return drive.stroke(side, along[side]) + drive.stroke(-side, along[-side])


def forced_path(drive: Drive, side: float, increments: int, drives_mm: Array, forces_N: Array) -> Path:
    """The path of a cycle whose contact has a core, starting at `side` times the amplitude, with equal changes of the
    force.

    Equal changes follow best a force whose curve bends all along the stroke. drives_mm, forces_N: (m,) along a similar
    stroke, its start included, between whose points the force is interpolated.
    """
    moved, forced = np.abs(drives_mm - drives_mm[0]), np.abs(forces_N - forces_N[0])
    order = np.maximum.accumulate(forced)
    wanted = np.linspace(0.0, order[-1], increments // 2 + 1)[1:]
    shares = np.interp(wanted, order, moved) / moved[-1]
    places = drive.amplitude_mm * (1.0 - 2.0 * shares)
    places[np.argmin(np.abs(places))], places[-1] = 0.0, -drive.amplitude_mm
    return drive.stroke(side, side * places) + drive.stroke(-side, -side * places)


def _with_places(places: Array, others: Array) -> Array:
    """Places along a stroke (m,) joined with others (k,); a place of the first that nearly coincides with one of these
    is left out.
    """
    # Of the distance of places that follow a cosine: none of them lies nearer to a place where surfaces wear.
    step, direction = 0.3 * np.abs(np.gradient(places)), float(np.sign(places[-1]))
    fixed = (places == 0.0) | (np.arange(len(places)) == len(places) - 1)
    inside = np.abs(np.subtract.outer(others, places[fixed])).min(axis=1) > float(step.min())
    others = others[inside & (np.abs(others) < np.abs(places[-1]))]
    near = np.abs(np.subtract.outer(places, others)).min(axis=1, initial=np.inf) < step
    return np.asarray(direction * np.unique(direction * np.concatenate([places[fixed | ~near], others])))


def wear_path(amplitude_mm: float, holder_x_mm: float, increments: int, before: Stroke | None = None) -> Array:
    """Places (increments,) in mm at which the increments of half a cycle from +amplitude to -amplitude end.

    holder_x_mm: position of the holder at +amplitude, to which the contact has carried it. before: holder's positions
    along a similar stroke; None: assumed. If the bodies slide over less than a quarter of the amplitude, places follow
    a cosine.
    """
    carried = min(max(holder_x_mm, 0.0), amplitude_mm)
    slides = amplitude_mm - carried
    # Share of the stroke over which the bodies must move against each other for places to be spread over that.
    if slides < 0.25 * amplitude_mm or increments < 2 * _STICK_INCREMENTS:
        steps = np.cos(np.pi * np.arange(1, increments + 1) / increments)
        steps[-1] = -1.0
        return amplitude_mm * np.asarray(steps)
    count = increments - _STICK_INCREMENTS
    places, stuck = _places(amplitude_mm, carried, count, before)
    between = amplitude_mm - places[0]
    stuck = min(max(stuck, places[0] + _STUCK_SHARE * between), amplitude_mm - _STUCK_SHARE * between)
    return np.concatenate([[stuck], places, [-amplitude_mm]])


def _places(amplitude: float, carried: float, count: int, before: Stroke | None) -> tuple[Array, float]:
    """Places (count,) in mm at which surfaces wear, and the place where the first increment ends, in which the contact
    sticks.
    """
    shares = (np.arange(count) + _SHIFT) / count
    if before is None:
        places = amplitude - 2.0 * carried - 2.0 * (amplitude - carried) * shares
        return places, 0.5 * (amplitude + float(places[0]))
    drive, holder = _with_knee(*_along(amplitude, carried, before))
    # Round-off and creep must not let the bodies seem to slide back.
    apart = np.minimum.accumulate(drive - holder)
    start, end = float(apart[0]), float(apart[-1])
    wanted = start - (start - end) * np.append(_STUCK_SHARE / count, shares)
    found = -np.interp(-wanted, -apart, -drive)
    return found[1:], float(found[0])


def _along(amplitude: float, carried: float, before: Stroke) -> tuple[Array, Array]:
    """Drive and holder positions of an earlier stroke fitted to one from +amplitude to -amplitude.

    A stroke of another amplitude is shifted to begin alike; a shorter one is extended with the holder at rest.
    """
    drive, holder = np.append(amplitude, before.drive), np.append(carried, before.holder_x)
    longer = amplitude + float(before.drive[-1])
    # Of the amplitude: strokes whose amplitudes differ by less are the same.
    if abs(longer) <= 1e-6 * amplitude:
        return drive, holder
    drive[1:] += longer
    holder[1:] += carried + float(before.holder_x[-1])
    ahead = drive > -amplitude
    return np.append(drive[ahead], -amplitude), np.append(holder[ahead], np.interp(amplitude, -drive, holder))


def _with_knee(drive: Array, holder: Array) -> tuple[Array, Array]:
    """The stroke with the place added at which sliding begins, since its increments may be long.

    There the line of a holder that follows the drive meets the line of one that stands while the bodies slide.
    """
    ahead = np.append(True, np.diff(drive) < 0.0)
    drive, holder = drive[ahead], holder[ahead]
    rates = np.diff(holder) / np.diff(drive)
    knee = int(np.argmax(rates < _FOLLOWS))
    if rates[knee] >= _FOLLOWS or knee + 1 == len(rates):
        return drive, holder
    slope = float(np.clip(rates[knee + 1], -0.5, 0.5))
    along = holder[knee + 1] - slope * drive[knee + 1] - holder[knee] + drive[knee]
    place = float(np.clip(along / (1.0 - slope), drive[knee + 1], drive[knee]))
    stands = holder[knee] + place - drive[knee]
    return np.insert(drive, knee + 1, place), np.insert(holder, knee + 1, stands)
