"""Free play of the holder, seen in a loop as a shelf on both branches.

A shelf is a stretch of a branch along which the displacement grows while the force stays near zero, because the holder
floats between its stops. The rises before and after it are its flanks.
"""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.loops.branches import Branch
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import Measured
from wirewear.loops.noise import noise_along
from wirewear.loops.robust import LinearFit, fit_linear

#: Half of the band about the shelf's force that belongs to neither flank: this share of the rise, or so many noises.
BAND_SHARE, BAND_NOISES = 0.04, 4.0


#: Samples below a shelf, and above it, with which its flanks' common line is known; with more of both, their bend.
FEWEST_BELOW, FEWEST_ABOVE, FEWEST_BENT = 2, 1, 2


#: Samples from the reversal to the plateau, below which no shelf is known, and those with which flanks have a bend.
FEWEST_IN_RISE, FEWEST_IN_BENT_RISE = 5, 8


#: A shelf is one from so many of its standard deviations on, and from this share of what the flanks give way.
CERTAIN, LEAST_SHARE = 5.0, 0.03


#: Inside, the force rises by less than this share of the flanks' slope, and of what it rises by next. In a loop whose
#: hooks pass its plateau, a steep rise goes over into the scar's wall, along which it goes on by four fifths or more.
LEVEL, LEVELLER = 0.35, 0.75


#: Both branches' shelves lie at the same force within this share of the rise, and are alike within this share.
SAME_FORCE, SAME_WIDTH = 0.12, 0.4


@dataclass(frozen=True)
class Shelf:
    """Shelf of one branch: its width with its standard deviation, the travel at which it begins, its force, and the
    rise of the force from reversal to plateau.

    Forces are those of the branch: multiplied by the direction of motion, so that they rise along the travel.
    """

    width_um: float
    deviation_um: float
    begin_um: float
    force_N: float
    rise_N: float


def shelves_of(loop: CleanLoop, forward: Branch, backward: Branch) -> tuple[Shelf, Shelf] | None:
    """Shelves of the forward and the backward branch; None unless both have one, at the same force within 12 % of the
    rise and of the same width within 40 % (and three standard deviations).
    """
    up, down = shelf_of(loop, forward), shelf_of(loop, backward)
    if up is None or down is None:
        return None
    rise = 0.5 * (up.rise_N + down.rise_N)
    if abs(up.force_N + down.force_N) > SAME_FORCE * rise:
        return None
    mean, apart = 0.5 * (up.width_um + down.width_um), abs(up.width_um - down.width_um)
    doubt = float(np.hypot(up.deviation_um, down.deviation_um))
    return (up, down) if apart <= SAME_WIDTH * mean + 3.0 * doubt else None


def play_of(shelves: tuple[Shelf, Shelf]) -> Measured:
    """Free play in µm: mean width of both shelves, whose difference adds to its deviation."""
    up, down = shelves
    own = 0.5 * float(np.hypot(up.deviation_um, down.deviation_um))
    apart = 0.5 * abs(up.width_um - down.width_um)
    return Measured.from_deviation(0.5 * (up.width_um + down.width_um), float(np.hypot(own, apart)))


def without_shelf(branch: Branch, shelf: Shelf, play_um: float) -> Branch:
    """Branch that a rig without play would give: the travel behind the shelf is shortened by the play `play_um`.

    The origin moves by half the play along the direction of motion. Samples on the shelf are left out.
    """
    above = branch.travel_um >= shelf.begin_um + 0.5 * shelf.width_um
    on_it = (branch.travel_um > shelf.begin_um) & (branch.travel_um < shelf.begin_um + shelf.width_um)
    keep = ~on_it
    travel = np.where(above, branch.travel_um - play_um, branch.travel_um)[keep]
    return replace(
        branch,
        travel_um=travel,
        force_N=branch.force_N[keep],
        normal_force_N=None if branch.normal_force_N is None else branch.normal_force_N[keep],
        origin_um=branch.origin_um + 0.5 * branch.direction * play_um,
        length_um=branch.length_um - play_um,
        samples=branch.samples[keep],
        play_um=play_um,
    )


def shelf_of(loop: CleanLoop, branch: Branch) -> Shelf | None:
    """Shelf of one branch; None if it has none. Travel over force is fitted by a smooth curve with one step in it, the
    shelf.

    The curve is a line with a bend, as a contact softens on its way to sliding; both flanks share it.
    """
    rising = _rising(branch)
    if rising is None:
        return None
    z, q, low, top = rising
    found = [_shelf_at(loop, z, q, force, top - low) for force in _candidates(z, q, low, top - low)]
    found = [shelf for shelf in found if shelf is not None and _rises_behind(branch, shelf)]
    return max((shelf for shelf in found if shelf), key=lambda shelf: shelf.width_um / shelf.deviation_um, default=None)


def _shelf_at(loop: CleanLoop, z: Array, q: Array, force: float, rise: float) -> Shelf | None:
    # That of the rise: the plateau's chatter is none.
    noise = noise_along(q)
    band = max(BAND_SHARE * rise, BAND_NOISES * noise)
    below, above = q < force - band, q > force + band
    flanks = np.count_nonzero(below), np.count_nonzero(above)
    if band > 0.3 * rise or flanks[0] < FEWEST_BELOW or flanks[1] < FEWEST_ABOVE:
        return None
    bend = min(flanks) >= FEWEST_BENT and z.size >= FEWEST_IN_BENT_RISE
    fit, plain = _fits(z, (q - force) / rise, below, above, order=2 if bend else 1)
    width, deviation = float(fit.coefficients[-1]), float(np.sqrt(fit.covariance[-1, -1]))
    slope = float(fit.coefficients[1]) / rise
    if slope <= 0.0:
        return None
    deviation = max(deviation, loop.displacement_noise_um, slope * noise, 1e-9 * float(z[-1]))
    if not bend:
        # What a bend hides, or makes up.
        deviation = max(deviation, LEAST_SHARE * slope * rise)
    # A step worth its name makes the misfit far smaller, too.
    misfits = [max(float(np.linalg.norm(each.residuals)), 1e-300) for each in (plain, fit)]
    better = np.count_nonzero(below | above) * np.log(misfits[0] / misfits[1])
    shelf = Shelf(width, deviation, float(fit.coefficients[0]), force, rise)
    if width < max(CERTAIN * deviation, LEAST_SHARE * slope * rise) or better < 2.0 * np.log(z.size):
        return None
    return shelf if _level_inside(z, q, shelf, slope) else None


def _rising(branch: Branch) -> tuple[Array, Array, float, float] | None:
    """Travels and forces from the reversal to just below the plateau, then the forces at both ends; None if too few
    samples.
    """
    z, q = branch.travel_um, branch.force_N
    late = q[z > 0.5 * branch.length_um]
    if late.size < 4 or q.size < 12:
        return None
    low = float(np.median(q[:3]))
    # Where the course leaves the rise it stands farthest above the line from reversal to reversal.
    corner = float(q[np.argmax(q - (q[-1] - q[0]) * z / branch.length_um)])
    top = min(corner, float(np.percentile(late, 25)))
    # A plateau that chatters begins at its lower edge, after the first rise.
    reached = np.flatnonzero(q >= low + 0.92 * (top - low))
    if top <= low or not reached.size or reached[0] < FEWEST_IN_RISE:
        return None
    end = int(reached[0])
    return z[:end], q[:end], low, top


def _candidates(z: Array, q: Array, low: float, rise: float) -> list[float]:
    """Up to four forces at which more travel is passed than just below and just above them, the clearest first."""
    edges = low + rise * np.linspace(0.02, 0.98, 33)
    # Noise makes the force waver: the first passage upwards and the last stand for one.
    first = np.interp(edges, np.maximum.accumulate(q), z)
    last = np.interp(edges, np.minimum.accumulate(q[::-1])[::-1], z)
    passed = np.diff(0.5 * (first + last))
    here = passed[4:-5] + passed[5:-4]
    usual = np.maximum(passed[2:-7] + passed[3:-6], passed[6:-3] + passed[7:-2]) + passed[:-9] + passed[9:]
    found = []
    # A shelf is tried at four forces.
    for place in np.argsort(usual - 2.0 * here)[:4]:
        low_edge, high_edge = first[place + 4], last[place + 6]
        inside = (z >= low_edge) & (z <= high_edge)
        if here[place] > 0.75 * usual[place]:
            found.append(float(np.median(q[inside])) if inside.any() else float(edges[place + 5]))
    return found


def _fits(z: Array, q: Array, below: BoolArray, above: BoolArray, *, order: int) -> tuple[LinearFit, LinearFit]:
    """Two fits of travel over force by a polynomial of this order: with a step between the flanks, and without."""
    flanks = below | above
    smooth = np.vander(q[flanks], order + 1, increasing=True)
    step = above[flanks].astype(float)
    # Of a flank of a few samples, weights would make outliers.
    rounds = 4 if min(np.count_nonzero(below), np.count_nonzero(above)) >= FEWEST_IN_RISE else 1
    return fit_linear(np.column_stack([smooth, step]), z[flanks], rounds), fit_linear(smooth, z[flanks], rounds)


def _rises_behind(branch: Branch, shelf: Shelf) -> bool:
    """True if the force rises clearly more behind the shelf than along it, over the same travel."""
    middles = shelf.width_um * np.array([0.15, 0.85, 1.15, 1.85])
    force = np.interp(shelf.begin_um + middles, branch.travel_um, branch.force_N)
    return bool(force[1] - force[0] < LEVELLER * (force[3] - force[2]))


def _level_inside(z: Array, q: Array, shelf: Shelf, slope: float) -> bool:
    """True if the force hardly rises between the shelf's ends; `slope` is the flanks' travel per force in µm/N."""
    margin = 0.15 * shelf.width_um
    inside = (z > shelf.begin_um + margin) & (z < shelf.begin_um + shelf.width_um - margin)
    if np.count_nonzero(inside) < 3:
        return shelf.width_um > slope * shelf.rise_N * LEAST_SHARE
    line = np.polyfit(z[inside], q[inside], 1)
    return float(line[0]) * slope < LEVEL
