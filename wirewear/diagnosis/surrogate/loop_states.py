"""The contact as one logged loop of a nominal run shows it, and the motion of a drive over time.

θ, φ, s and δ are those of `wear_states`. A branch is the part of a loop from one reversal of the motion to the next.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TypedDict

import numpy as np
from scipy.special import erfc

from geometry.arrays import Array, BoolArray, ComplexArray
from wirewear.base.errors import ResultError
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.surrogate.springs import yielding_of
from wirewear.results import Loop, RunResult
from wirewear.results.scar import SCAR_FIGURES, scar_figures
from wirewear.test import study_from_tables

#: For a skew, depths below this share of the deepest are left out: the ground counts by its distance squared.
_SKEW_EDGE = constants("surrogate.loop_states.scar_figures").number("skew_edge")

_KNOWN = constants("surrogate.loop_states")

#: Powers of the position s/δ in θ and in φ. A scar's ends are steeper than its middle, so high odd powers matter.
ODD_POWERS, EVEN_POWERS = (1, 3, 5, 7, 9), (0, 2)

#: Powers of s/δ in what springs add to the load where walls lift the bodies.
LIFT_POWERS = (2, 4)

#: Full slip comes at this multiple of Q/K_c (Mindlin): the elastic displacement of a sliding contact.
FULL_SLIP = 1.5

#: A drive that moves by less than this share of its stroke rests; loads below this share of the test's do not press.
_STILL, _PRESSED = _KNOWN.each("still", "pressed")

#: Weights that keep high powers small where the few increments of a loop do not show them.
_RIDGE = (*_KNOWN.numbers("odd_ridge"), *_KNOWN.numbers("even_ridge"))

#: Travels of full slip that a loop has at least, and past which a branch slides for certain; shares of the rise between
#: which it sticks for certain.
_LEAST_TRAVEL, _SLIDES_PAST = _KNOWN.each("least_travel", "slides_past")
_MICRO_SLIP = _KNOWN.pair("micro_slip")

#: States are smoothed over this difference of the volume's logarithm.
_SMOOTHING = _KNOWN.number("smoothing")

_MOTION = constants("surrogate.loop_states.motion")

#: Even phases at which a motion is tabulated.
_PHASES = _MOTION.count("phases")

#: Corners are looked for in motions of so many harmonics at least, in all but the first of so many parts of them; there
#: are so many at most, none below this share of the largest.
_FEWEST, _PARTS, _MOST_CORNERS = _MOTION.count("fewest"), _MOTION.count("parts"), _MOTION.count("most_corners")
_LEAST_CORNER = _MOTION.number("least_corner")


def scar_skew(x_um: Array, y_um: Array, depth_um: Array) -> float:
    """Skew ∫d x y / ∫d y² in rad of depths d (n_x, n_y) about their centre, x along the motion; NaN of a map without a
    scar.

    A cylinder whose axis is turned by ε from the normal to the motion leaves d = h − y²/2R − (x + ε y − s)²/2R on one
    along the motion, whatever its position s: every scar that is swept by it is sheared by x → x − ε y, and the skew is
    −tan ε on both wires (geometry).
    """
    return skew_and_noise(x_um, y_um, depth_um, 0.0)[0]


def skew_and_noise(x_um: Array, y_um: Array, depth_um: Array, noise_um: float) -> tuple[float, float]:
    """(`scar_skew`, its standard deviation by noise of each depth); NaN of a map without a scar."""
    edge = _SKEW_EDGE * float(np.max(depth_um))
    depth = np.where(depth_um > edge, depth_um, 0.0)
    volume = float(depth.sum())
    if not volume > 0.0:
        return float("nan"), float("nan")
    x = x_um - float(depth.sum(axis=1) @ x_um) / volume
    y = y_um - float(depth.sum(axis=0) @ y_um) / volume
    across = float(depth.sum(axis=0) @ y**2)
    if not across > 0.0:
        return float("nan"), float("nan")
    skew = float(x @ depth @ y) / across
    # Beside the scar noise counts where it exceeds the edge.
    over = edge / max(noise_um, 1e-9)
    beside = over * np.exp(-0.5 * over**2) / np.sqrt(2.0 * np.pi) + 0.5 * erfc(over / np.sqrt(2.0))
    shares = np.where(depth > 0.0, 1.0, beside) * ((x[:, None] - skew * y) * y / across) ** 2
    return skew, noise_um * float(np.sqrt(shares.sum()))


def state_of(result: RunResult, loop: Loop, friction: float, fresh_stiffness: float) -> tuple[object, ...] | None:
    """A loop's row of `WearStates`: worn volume in µm³, slip in µm, slope, angle, stiffness in N/µm, load in mid-stroke
    in N and coefficients of its rise elsewhere (see `fitted_load`), scars and their skews; None if it does not travel
    far beyond the onset of gross slip. friction: coefficient of the run. fresh_stiffness: of the unworn contact in
    N/µm.
    """
    row = result.evolution.at(loop.cycle)
    volume = 1e9 * sum(row[f"worn_volume_{body}_mm3"] for body in result.bodies)
    x, q, p = loop.relative_displacement_um, loop.tangential_force_N, loop.normal_force_N
    of_load = load_shares(result, loop)
    steady_N, mean_N = p / of_load, float(p.sum() / of_load.sum())
    full = 2.0 * FULL_SLIP * friction * mean_N * float(of_load.max()) / fresh_stiffness
    if np.ptp(x) < _LEAST_TRAVEL * full:
        return None
    stiffness, steady = fresh_stiffness, bool((of_load == 1.0).all())
    if not steady:
        stiffness, _ = yielding_of(x, q, of_load, friction * mean_N, np.array([FULL_SLIP]), fresh_stiffness)
    for _ in range(3):
        s = x - FULL_SLIP * q / stiffness
        slip = float(0.5 * np.ptp(s))
        travel, forward = travelled(x)
        # A sliding contact has left its reversal by the micro-slip's travel; mirrored, both branches are one.
        slides = (travel > _SLIDES_PAST * full) & moves(x, of_load)
        sign = np.where(forward, 1.0, -1.0)
        slope, angle = fitted_angles(sign[slides] * s[slides] / slip, sign[slides] * np.arctan2(q, p)[slides], friction)
        if steady:
            rise = sum(mean_N * np.tan(np.arctan(friction) + angle.sum() + side * slope.sum()) for side in (1.0, -1.0))
            stiffness = _stick_stiffness(x, q, travel, forward, float(rise), stiffness)
    scars, skews = zip(*(scar_figures_of(result, loop.cycle, body) for body in result.bodies), strict=True)
    return volume, slip, slope, angle, stiffness, *fitted_load(s[slides] / slip, steady_N[slides]), scars, skews


def sliding(result: RunResult, row_of: Callable[[Loop], tuple[object, ...] | None]) -> list[Array]:
    """Columns of the rows that `row_of` gives for a run's loops; of several loops before any wear only the last counts,
    but all if nothing wears; none if no loop slides far enough to show how. row_of: the row of a loop, None if it does
    not slide.
    """
    known = [(loop.cycle, row) for loop in result.loops if (row := row_of(loop)) is not None]
    if not known:
        return []
    worn = np.interp([cycle for cycle, _ in known], result.evolution["cycle"], result.worn_volume_mm3)
    rows = [row for (_, row), later in zip(known, [*worn[1:], np.inf], strict=True) if later > 0.0 or not worn[-1]]
    return [np.array(column) for column in zip(*rows, strict=True)]


class StatesOfLoops(TypedDict):
    """Fields of `WearStates` that all contacts have; each array has one row for each wear state."""

    volume_um3: Array
    similarity: Array
    slip_um: Array
    slope: Array
    angle: Array
    stiffness_N_per_um: Array
    load_drop_N: Array
    lift_N: Array
    scars: Array
    stroke_um: float


def states_of(
    result: RunResult, load_N: float, volume: Array, similarity: Array, scars: Array, *columns: Array
) -> StatesOfLoops:
    """Fields of `WearStates` of a sliding contact, smoothed over the worn volume.

    load_N: load before any wear. volume, similarity, scars: (n,), (n,) and (n, 2, 4). columns: slip, slope, angle,
    stiffness, load in mid-stroke and coefficients of its rise elsewhere, each (n, …) as in `state_of`.
    """
    slip, slope, angle, stiffness, normal, lift = columns
    return StatesOfLoops(
        volume_um3=volume,
        similarity=np.maximum.accumulate(similarity * (1.0 + 1e-9 * np.arange(volume.size))),
        slip_um=slip,
        slope=smoothed(volume, slope),
        angle=smoothed(volume, angle),
        stiffness_N_per_um=smoothed(volume, stiffness[:, None])[:, 0],
        load_drop_N=np.maximum(load_N - normal, 0.0),
        lift_N=smoothed(volume, lift),
        scars=scars,
        stroke_um=max(0.5 * float(np.ptp(loop.displacement_um)) for loop in result.loops),
    )


def fitted_load(u: Array, load_N: Array) -> tuple[float, Array]:
    """Load in N in mid-stroke, and coefficients (2,) over `LIFT_POWERS` of what it is more elsewhere, by least squares.

    u, load_N: positions s/δ and loads, both (n,). Walls lift the bodies against the spring that presses them by less
    than their slopes say, as the contact gives way.
    """
    design = np.stack([u**power for power in (0, *LIFT_POWERS)], axis=1)
    found = np.linalg.lstsq(design, load_N, rcond=None)[0]
    return float(found[0]), np.asarray(found[1:], dtype=np.float64)


def moves(x: Array, of_load: Array) -> BoolArray:
    """(n,) True for samples of a loop at which the drive moves while the bodies are pressed together."""
    return np.asarray((np.abs(x - np.roll(x, 1)) > _STILL * np.ptp(x)) & (of_load > _PRESSED))


def turns_of(x: Array) -> tuple[int, int]:
    """Samples at which a loop leaves its ends at −x and at +x."""
    ends = x < x.min() + _STILL * np.ptp(x), x > x.max() - _STILL * np.ptp(x)
    low, top = (int(np.flatnonzero(end & ~np.roll(end, -1))[0]) for end in ends)
    return low, top


def travelled(x: Array) -> tuple[Array, BoolArray]:
    """Distance in µm (n,) of each sample from the reversal before it, and marks (n,) of the branch towards +x. x: (n,)
    displacements of one closed loop in µm.
    """
    n, (low, top) = x.size, turns_of(x)
    forward = (np.arange(n) - low) % n <= (top - low) % n
    return np.where(forward, x - x[low], x[top] - x), forward


def fitted_angles(u: Array, psi: Array, friction: float) -> tuple[Array, Array]:
    """Coefficients of θ over `ODD_POWERS` (5,) and of φ − atan µ over `EVEN_POWERS` (2,), by least squares. u: (n,)
    positions s/δ. psi: (n,) angles of the force in rad, both with the branch towards −x mirrored. friction: µ.
    """
    powers = (*ODD_POWERS, *EVEN_POWERS)
    design = np.stack([u**power for power in powers], axis=1)
    ridge = np.diag(_RIDGE) * np.sqrt(u.size)
    values = np.concatenate([psi - np.arctan(friction), np.zeros(len(powers))])
    coefficients = np.linalg.lstsq(np.vstack([design, ridge]), values, rcond=None)[0]
    return coefficients[: len(ODD_POWERS)], coefficients[len(ODD_POWERS) :]


def _stick_stiffness(x: Array, q: Array, travel: Array, forward: BoolArray, rise: float, before: float) -> float:
    """K_c that puts Mindlin's micro-slip, by Masing's rule, through the samples just after a reversal.

    rise: of the force from a reversal to where the branch slides.
    """
    top, low = float(q[np.argmax(x)]), float(q[np.argmin(x)])
    done = np.where(forward, q - low, top - q) / rise
    near = (done > _MICRO_SLIP[0]) & (done < _MICRO_SLIP[1]) & (travel > 0.0)
    if not near.any():
        return before
    curve = FULL_SLIP * rise * (1.0 - (1.0 - done[near]) ** (2.0 / 3.0))
    return float(np.median(curve / travel[near]))


def load_shares(result: RunResult, loop: Loop) -> Array:
    """Normal load that a run asked for at a loop's samples (n,), over the test's load; 1 under a steady load."""
    stated = result.study["conditions"].get("load_cycle")
    if stated is None:
        return np.ones(loop.time_s.size)
    load = study_from_tables(result.study, result.label).conditions.load_cycle
    x = loop.displacement_um
    rest_s = float(loop.time_s[x > x.max() - 1e-6 * np.ptp(x)].mean())
    share = load.shares(((loop.time_s - rest_s) * float(result.study["conditions"]["frequency_Hz"])) % 1.0)
    return np.asarray(np.maximum(share, 1e-3))


def scar_figures_of(result: RunResult, cycle: int, body: str) -> tuple[list[float], float]:
    """`SCAR_FIGURES` in µm³ and µm of a body after a cycle, and the skew of its scar; zeros and NaN if no scar was
    logged.
    """
    try:
        scar = result.scar(cycle, body)
    except ResultError:
        # No scars were logged near this cycle.
        return [0.0] * len(SCAR_FIGURES), float("nan")
    line = np.linspace(-4.0, 4.0, 161) * float(max(np.abs(scar.axial_um).max(), np.abs(scar.transverse_um).max())) / 4.0
    depth = scar.sampled(line, line)
    return scar_figures(line, line, depth), scar_skew(line, line, depth)


def later_scars(result: RunResult) -> tuple[Array, Array, Array]:
    """Of scars logged after a run's last loop: worn volume in µm³ (k,), `SCAR_FIGURES` (k, 2, 4) in µm³ and µm, skews
    (k, 2) in rad.
    """
    cycles = [cycle for cycle in result.scar_cycles() if cycle > result.loops[-1].cycle]
    volume = 1e9 * np.interp(cycles, result.evolution["cycle"], result.worn_volume_mm3)
    each = [[scar_figures_of(result, cycle, body) for body in result.bodies] for cycle in cycles]
    figures, skews = ([[body[part] for body in one] for one in each] for part in (0, 1))
    return volume, np.reshape(figures, (-1, 2, len(SCAR_FIGURES))), np.reshape(skews, (-1, 2))


def smoothed(volume: Array, rows: Array) -> Array:
    """A copy of `rows` (n, k) without scatter: at each, the value of a straight line fitted with Gaussian weights.
    volume: (n,) in µm³, increasing; lines are fitted over ln(V + V_last/25000 + 1), so that V may be 0.
    """
    at = np.log(volume + 1e-3 * volume[-1] / 25.0 + 1.0)
    weight = np.exp(-0.5 * ((at[:, None] - at) / _SMOOTHING) ** 2)
    smooth = np.empty_like(rows)
    for i, w in enumerate(weight):
        design = np.stack([np.ones_like(at), at - at[i]], axis=1) * np.sqrt(w)[:, None]
        smooth[i] = np.linalg.lstsq(design, rows * np.sqrt(w)[:, None], rcond=None)[0][0]
    return smooth


Harmonics = ComplexArray


@dataclass(frozen=True, eq=False)
class FastMotion:
    """A periodic motion, displacement Re Σ c_k exp(ikφ) at the phase φ of a cycle, with harmonics c_k, k = 1, 2, …"""

    harmonics: Harmonics  #: (k,) complex, over the drive's amplitude.

    def before(self, lag: float) -> FastMotion:
        """The motion that becomes this one in a first-order filter; lag: the filter's time constant times angular
        frequency, in rad. Source: Bendat & Piersol, Random Data, 4th ed., section 2.3.
        """
        undone = self.harmonics * (1.0 + 1j * lag * np.arange(1, self.harmonics.size + 1))
        return FastMotion(np.concatenate([undone, _beyond(undone)]))

    def behind(self, lag: float) -> FastMotion:
        """This motion after a first-order filter; lag: the filter's time constant times angular frequency, in rad."""
        return FastMotion(np.asarray(self.harmonics / (1.0 + 1j * lag * np.arange(1, self.harmonics.size + 1))))

    def phases(self, place: Array) -> Array:
        """Phases (..., 2, m) in rad at which the motion passes places (..., 2, m): first on the way to +x, then on the
        way back. place: displacement over amplitude in the order of travel, −1 and 1 being the ends of the stroke.
        Phases increase along each branch. If the drive rests at an end, the next branch begins when it leaves it.
        """
        bent = np.arcsin(np.clip(place, -1.0, 1.0))
        there, back = (
            np.interp(sign * bent[..., side, :], *table)
            for side, (sign, table) in enumerate(zip((1.0, -1.0), self.tables, strict=True))
        )
        return np.stack([there, back], axis=-2)

    def at(self, phase: Array) -> Array:
        """Displacement at phases (...) in rad, in the unit of the harmonics."""
        return np.interp(phase, _even_phases(), self._even, period=2.0 * np.pi)

    @cached_property
    def half_range(self) -> float:
        return 0.5 * float(np.ptp(self._even))

    @cached_property
    def _even(self) -> Array:
        """The motion (PHASES,) at even phases."""
        return _at_even_phases(self.harmonics)

    @cached_property
    def tables(self) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Arcsines of places in the direction of travel, and their phases, one way and back."""
        even = self._even
        # An eccentric's sine is a straight line in these.
        bent = np.arcsin(np.clip((even - 0.5 * (even.max() + even.min())) / self.half_range, -1.0, 1.0))
        bottom, top = int(np.argmin(even)), int(np.argmax(even))
        top += _PHASES if top < bottom else 0
        return _table(bent, bottom, top), _table(-bent, top, bottom + _PHASES)


@cache
def _even_phases() -> Array:
    return np.asarray(2.0 * np.pi * np.arange(_PHASES) / _PHASES)


def _table(values: Array, first: int, last: int) -> tuple[Array, Array]:
    """Values that rise from one even phase to another, and these phases."""
    places = np.arange(first, last + 1)
    return np.asarray(np.maximum.accumulate(values[places % _PHASES])), np.asarray(2.0 * np.pi / _PHASES * places)


def _at_even_phases(harmonics: Harmonics, first: int = 1) -> Array:
    """Re Σ c_k exp(ikφ) of harmonics (k,), from that order on, at even phases (PHASES,)."""
    spectrum = np.zeros(_PHASES // 2 + 1, dtype=np.complex128)
    spectrum[first : first + harmonics.size] = harmonics
    return np.asarray(np.fft.irfft(0.5 * _PHASES * spectrum, _PHASES))


def _beyond(harmonics: Harmonics) -> Harmonics:
    """Harmonics that follow the known ones (k,) where the motion has corners.

    A speed that jumps by J at φ has the harmonics −J exp(−ikφ)/(π k²), which fall off slower than those of any smooth
    motion: the last ones that are known show J and φ.
    """
    if harmonics.size < _FEWEST:
        return np.zeros(0, dtype=np.complex128)
    order = np.arange(harmonics.size // _PARTS, harmonics.size + 1)
    given = -np.pi * order**2 * harmonics[order - 1]
    places: list[float] = []
    jumps, left = np.zeros(0), given
    for _ in range(_MOST_CORNERS):
        best = int(np.argmax(np.abs(_at_even_phases(left, int(order[0])))))
        turns = np.exp(-1j * np.outer(order, [*places, _even_phases()[best]]))
        design = np.concatenate([turns.real, turns.imag])
        found = np.linalg.lstsq(design, np.concatenate([given.real, given.imag]), rcond=None)[0]
        if np.abs(found).min() < _LEAST_CORNER * np.abs(found).max():
            break
        places.append(float(_even_phases()[best]))
        jumps, left = found, given - turns @ found
    beyond = np.arange(harmonics.size + 1, _PHASES // 2)
    turns = np.exp(-1j * np.outer(beyond, places))
    return np.asarray(-(turns @ jumps) / (np.pi * beyond**2), dtype=np.complex128)


#: That of an eccentric.
SINE = FastMotion(np.array([-1j]))
