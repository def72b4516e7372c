"""Both branches of a loop, freed from free play, with the micro-slip that was fitted to each.

Free play is a shelf about zero force on both branches, while the holder floats between its stops.
"""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.loops.branches import Branch, MicroSlip, fit_micro_slip, settled, slides_visibly, split_branches
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import Measured, StickSlip
from wirewear.loops.noise import noise_along
from wirewear.loops.opening import balance, mean_force
from wirewear.loops.robust import LinearFit, fit_linear

Course = tuple[Branch, MicroSlip]

MOST_TRIED = 4  #: Forces at which a shelf is tried.
#: Half of the band about the shelf's force that belongs to neither flank: this share of the rise, or so many noises.
BAND_SHARE, BAND_NOISES = 0.04, 4.0

#: Samples below a shelf, and above it, with which its flanks' common line can be told; with more of both, their bend.
FEWEST_BELOW, FEWEST_ABOVE, FEWEST_BENT = 2, 1, 2

#: Samples from the reversal to the plateau, below which no shelf can be told, and those with which flanks have a bend.
FEWEST_IN_RISE, FEWEST_IN_BENT_RISE = 5, 8

#: A shelf is one from so many of its standard deviations on, and from this share of what the flanks give way.
CERTAIN, LEAST_SHARE = 5.0, 0.03

#: Inside, the force rises by less than this share of the flanks' slope, and of what it rises by next. In a loop whose
#: hooks pass its plateau, a steep rise goes over into the scar's wall, along which it goes on by four fifths or more.
LEVEL, LEVELLER = 0.35, 0.75

#: Both branches' shelves lie at the same force within this share of the rise, and are alike within this share.
SAME_FORCE, SAME_WIDTH = 0.12, 0.4


#: A fall of the force is a slip from so many standard deviations of a step on, and from this share of the plateau.
CERTAIN_SLIP, LEAST_DROP = 7.0, 0.03
FEWEST_SLIPS = 4  #: So many slips of a cycle are no chance.
MOST_STEPS = 3  #: A slip takes no more steps between samples than this; a longer fall is a slope.

#: Slips are resolved where at least this share of those is seen that the stick branches' stiffness lets expect.
RESOLVED = 0.6
EARLY = 0.12  #: Where a static force is sought: from the onset on over this share of the plateau.


@dataclass(frozen=True)
class Shelf:
    """The shelf of one branch: its width with its standard deviation, where it begins, and its force.

    The force is that of the branch's coordinates, in which both branches rise.
    """

    width_um: float
    deviation_um: float
    begin_um: float
    force_N: float
    rise_N: float


def shelves_of(loop: CleanLoop, forward: Branch, backward: Branch) -> tuple[Shelf, Shelf] | None:
    """The shelves of both branches, or None where they do not agree on there being one."""
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
    """The play: the mean width of both shelves; how far they are apart is part of the doubt."""
    up, down = shelves
    own = 0.5 * float(np.hypot(up.deviation_um, down.deviation_um))
    apart = 0.5 * abs(up.width_um - down.width_um)
    return Measured.from_deviation(0.5 * (up.width_um + down.width_um), float(np.hypot(own, apart)))


def without_shelf(branch: Branch, shelf: Shelf, play_um: float) -> Branch:
    """The branch that a rig without play would give: displacements less half the play, with the force's sign.

    Samples on the shelf, which belong to neither side, are left out.
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
    """The shelf of one branch: travel over force is a smooth curve with one step in it.

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
    """Travels and forces from the reversal to just below the plateau, and the forces at both ends."""
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
    """The forces at which more travel is passed than just below and just above them, the clearest first."""
    edges = low + rise * np.linspace(0.02, 0.98, 33)
    # Noise makes the force waver: the first passage upwards and the last stand for one.
    first = np.interp(edges, np.maximum.accumulate(q), z)
    last = np.interp(edges, np.minimum.accumulate(q[::-1])[::-1], z)
    passed = np.diff(0.5 * (first + last))
    here = passed[4:-5] + passed[5:-4]
    usual = np.maximum(passed[2:-7] + passed[3:-6], passed[6:-3] + passed[7:-2]) + passed[:-9] + passed[9:]
    found = []
    for place in np.argsort(usual - 2.0 * here)[:MOST_TRIED]:
        low_edge, high_edge = first[place + 4], last[place + 6]
        inside = (z >= low_edge) & (z <= high_edge)
        if here[place] > 0.75 * usual[place]:
            found.append(float(np.median(q[inside])) if inside.any() else float(edges[place + 5]))
    return found


def _fits(z: Array, q: Array, below: BoolArray, above: BoolArray, *, order: int) -> tuple[LinearFit, LinearFit]:
    """Travel over force by a line, or a bent one of order 2, with a step between the flanks, and without."""
    flanks = below | above
    smooth = np.vander(q[flanks], order + 1, increasing=True)
    step = above[flanks].astype(float)
    # Of a flank of a few samples, weights would make outliers.
    rounds = 4 if min(np.count_nonzero(below), np.count_nonzero(above)) >= FEWEST_IN_RISE else 1
    return fit_linear(np.column_stack([smooth, step]), z[flanks], rounds), fit_linear(smooth, z[flanks], rounds)


def _rises_behind(branch: Branch, shelf: Shelf) -> bool:
    """Whether the force rises by more over as much travel behind the shelf."""
    middles = shelf.width_um * np.array([0.15, 0.85, 1.15, 1.85])
    force = np.interp(shelf.begin_um + middles, branch.travel_um, branch.force_N)
    return bool(force[1] - force[0] < LEVELLER * (force[3] - force[2]))


def _level_inside(z: Array, q: Array, shelf: Shelf, slope: float) -> bool:
    """Whether the force hardly rises between the shelf's ends; `slope` is the flanks' travel per force."""
    margin = 0.15 * shelf.width_um
    inside = (z > shelf.begin_um + margin) & (z < shelf.begin_um + shelf.width_um - margin)
    if np.count_nonzero(inside) < 3:
        return shelf.width_um > slope * shelf.rise_N * LEAST_SHARE
    line = np.polyfit(z[inside], q[inside], 1)
    return float(line[0]) * slope < LEVEL


@dataclass(frozen=True)
class Courses:
    """Forward and backward branch with their micro-slip, and what was found of free play.

    Where there is a shelf, the branches are those that a rig without play would give.
    """

    forward: Course
    backward: Course
    length_um: float
    shelves: tuple[Shelf, Shelf] | None

    @property
    def both(self) -> tuple[Course, Course]:
        return self.forward, self.backward

    @property
    def slide(self) -> bool:
        """Whether both branches slide visibly."""
        return slides_visibly(self.forward) and slides_visibly(self.backward)

    @property
    def misfit(self) -> float:
        """Sum of squared residuals of both fits."""
        return sum(slip.misfit for _, slip in self.both)

    @property
    def free_play(self) -> Measured | None:
        """Width of the shelf."""
        return None if self.shelves is None else play_of(self.shelves)

    @property
    def force_zero(self) -> Measured | None:
        """Force of the shelf: where the force's zero lies."""
        if self.shelves is None:
            return None
        up, down = self.shelves
        return Measured.from_deviation(0.5 * (up.force_N - down.force_N), 0.5 * abs(up.force_N + down.force_N))


def courses_of(loop: CleanLoop) -> Courses:
    """Split a loop into its branches, find free play, and fit the micro-slip."""
    forward, backward = split_branches(loop)
    length = forward.length_um
    shelves = shelves_of(loop, forward, backward)
    if shelves is not None:
        play = play_of(shelves).value
        forward, backward = (
            without_shelf(branch, shelf, play) for branch, shelf in zip((forward, backward), shelves, strict=True)
        )
    middle = mean_force(loop).value
    return Courses(_course(forward, middle), _course(backward, middle), length, shelves)


def _course(branch: Branch, middle_N: float) -> Course:
    crossing = balance(branch.travel_um, branch.force_N - branch.direction * middle_N)
    return branch, settled(branch, fit_micro_slip(branch), crossing)


def stick_slip(loop: CleanLoop, courses: tuple[Course, Course]) -> StickSlip | None:
    """Slips of both plateaus of a sliding loop, or None where the forces fall no more often than chance lets them."""
    found = [_slips(loop, *course) for course in courses]
    slips = np.concatenate([drops for drops, _, _ in found])
    if slips.size < FEWEST_SLIPS or min(drops.size for drops, _, _ in found) == 0:
        return None
    sliding = sum(count for _, count, _ in found)
    chattering = sum(share * count for _, count, share in found)
    per_cycle = float(slips.size)
    frequency = None
    if loop.times_known:
        duration = abs(float(loop.time[-1] - loop.time[0])) * len(loop.time) / (len(loop.time) - 1)
        frequency = per_cycle / duration * len(loop.time) / max(sliding, 1)
    spread = 1.4826 * float(np.median(np.abs(slips - np.median(slips)))) / float(np.sqrt(slips.size))
    return StickSlip(
        share=chattering / max(sliding, 1),
        slips_per_cycle=int(slips.size),
        frequency_Hz=frequency,
        force_drop_share=Measured.from_deviation(float(np.median(slips)), 1.25 * spread),
        resolved=slips.size >= RESOLVED * _expected(courses, float(np.median(slips))),
    )


def _expected(courses: tuple[Course, Course], drop_share: float) -> float:
    """Slips of a cycle whose stretches of sticking, each as long as the spring takes for the fall, fill the sliding."""
    count = 0.0
    for branch, slip in courses:
        stretched = drop_share * abs(slip.onset_force_N) * slip.travel_um / max(slip.height_N, 1e-300)
        count += (branch.length_um - slip.travel_um) / max(stretched, 1e-300)
    return count


def _slips(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> tuple[Array, int, float]:
    """Falls of the force over the sliding force, samples of the plateau, and the share of them between slips."""
    force = branch.force_N[branch.travel_um > slip.travel_um]
    if force.size < 6:
        return np.empty(0), force.size, 0.0
    level = float(np.percentile(np.abs(force), 75))
    if not level:
        return np.empty(0), force.size, 0.0
    least = max(CERTAIN_SLIP * np.sqrt(2.0) * _stick_noise(loop, branch, slip), LEAST_DROP * level)
    falling = np.diff(force) < 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], falling, [False]]).astype(int)))
    falls = [(int(a), int(b)) for a, b in edges.reshape(-1, 2) if force[a] - force[b] > least and b - a <= MOST_STEPS]
    sizes = np.array([force[start] - force[stop] for start, stop in falls])
    if not falls:
        return sizes, force.size, 0.0
    usual = (falls[-1][1] - falls[0][0]) / max(len(falls) - 1, 1)
    first, last = max(falls[0][0] - usual, 0.0), min(falls[-1][1] + usual, force.size - 1)
    return sizes / level, force.size, float(last - first) / (force.size - 1)


def _stick_noise(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> float:
    """Noise of one force, from the stick branch where that has samples enough: there nothing slips."""
    stick = branch.force_N[branch.travel_um < 0.8 * slip.travel_um]
    return loop.force_noise_N if stick.size < 10 else noise_along(stick)


def static_overshoot(loop: CleanLoop, courses: tuple[Course, Course]) -> Measured | None:
    """By which share the force first passes the plateau's later peaks, mean of both directions; None if it does not."""
    found = [_overshoot(loop, *course) for course in courses]
    if None in found:
        return None
    shares, deviations = zip(*[item for item in found if item is not None], strict=True)
    return Measured.from_deviation(float(np.mean(shares)), 0.5 * float(np.hypot(*deviations)))


def _overshoot(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> tuple[float, float] | None:
    span = branch.length_um - slip.travel_um
    begin, end = slip.travel_um - 0.1 * span, slip.travel_um + EARLY * span
    early = (branch.travel_um > begin) & (branch.travel_um < end)
    later = (branch.travel_um >= end) & (branch.travel_um < end + 0.4 * span)
    if np.count_nonzero(early) < 2 or np.count_nonzero(later) < 6:
        return None
    noise = _stick_noise(loop, branch, slip)
    top = int(np.flatnonzero(early)[np.argmax(branch.force_N[early])])
    # The peak lies between its highest sample and the next, up to where the rise would have led.
    step = max(float(branch.force_N[top] - branch.force_N[top - 1]), 0.0) if top else 0.0
    peak, plateau = float(branch.force_N[top]) + 0.5 * step, float(branch.force_N[later].max())
    if not plateau:
        # Nothing resists the motion there, which a peak could be set against.
        return None
    share = peak / plateau - 1.0
    deviation = float(np.hypot(np.sqrt(2.0) * noise, step / np.sqrt(12.0))) / abs(plateau)
    return (share, deviation) if plateau > 0.0 and share > max(2.5 * deviation, LEAST_DROP) else None
