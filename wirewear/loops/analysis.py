"""Analysis of one force–displacement loop, measured or simulated: its figures, such as slip amplitude and friction."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from wirewear.loops.branch_fits import BranchFits
from wirewear.loops.cleaning import NORMAL_CLIPPED, OPENS, CleanLoop
from wirewear.loops.energy import (
    MICROJOULE_IN_MILLIJOULE,
    MOST_IN_PARTIAL_SLIP,
    by_energy,
    dissipated_energy,
    energy_ratio,
    force_amplitude,
    mean_force,
    narrow,
    slip_amplitude,
)
from wirewear.loops.figures import LoopFigures, Measured, MicroSlipBranch, Regime
from wirewear.loops.friction import MIDDLE_SHARE, SlidingFigures, height_at, largest_ratio, peaks, sliding_figures
from wirewear.loops.lag import branch_earlier, goes_with_velocity
from wirewear.loops.reading import read_loop
from wirewear.loops.stick_slip import static_overshoot, stick_slip
from wirewear.loops.sticking import looks_worn, may_be_worn, notes_on, slip_of, stiffens
from wirewear.loops.stiffness import RESOLVED, bent, corner_of, mean_stiffness, micro_slip_branch, sliding_stiffness

UNDETERMINED = "the loop's width at its mid force cannot be determined: slip_amplitude is any that its area allows"

RUNS_ON = (
    "the displacement runs on while the force already falls, as a reading does that leans against the force or is "
    "late: branches were parted where the drive turns, and the measured stiffness is left out"
)

BY_ENERGY = (
    "the force passes its middle while the contact slides, or more than once: slip_amplitude is the energy over four "
    "times the mean force of both directions at mid-slip"
)

HIDDEN = (
    "the loop shows no plateau, but its energy ratio of {:.2g} is more than any unworn contact's in partial slip: it "
    "may slide all along a scar whose walls hide the plateau, and the interval of slip_amplitude holds that, too"
)

WALLED = (
    "the loop shows no plateau, but stiffens towards its ends, as no contact in partial slip does: it may slide all "
    "along between a scar's walls, and the interval of slip_amplitude holds that, too"
)

STUCK = 1e-3  #: A loop narrower than this share of its stroke is a line.

MAY_DRIFT = (
    "the displacement ends {:.3g} µm from where it began, {:.1%} of its stroke: it drifts, or the cycle is another one "
    "than that of the samples; dissipated_energy is {:.4g} mJ without a drift, which its interval holds"
)

ELLIPSE = (
    "the loop is an ellipse without a plateau: its force goes with the velocity, as viscous friction or a lag of an "
    "elastic force makes it. That it slides is not shown, and the figures of sliding are left out"
)

#: What the arithmetic of a closed loop may pass a bound by: corners that coarse samples cut off are put in.
ROUND_OFF = 5e-3


def allowed_slip(slip_um: Measured, amplitude_um: Measured, energy_mJ: Measured, force_N: Measured) -> Measured:
    """δ0 limited to 0 … δa (`amplitude_um`); if its interval lies wholly outside of that, the range of slips that the
    loop's area allows, with its middle as value.

    force_N: mean of the largest |Q| of both directions.
    """
    slip = bounded(slip_um, amplitude_um.value)
    if slip is not None:
        return slip
    energy_uJ = max(energy_mJ.value, 0.0) / MICROJOULE_IN_MILLIJOULE
    least = min(energy_uJ / max(4.0 * force_N.value, 1e-300), amplitude_um.value)
    return Measured(0.5 * (least + amplitude_um.value), (least, amplitude_um.value))


def within_bounds(found: LoopFigures) -> LoopFigures:
    """The figures, limited to 0 ≤ A ≤ 1, 0 ≤ B ≤ 1 and 0 ≤ E_d/(4Pδ0) ≤ max|Q|/P.

    A figure beyond a bound is set to the bound if its interval reaches it, else left out (None), with a note.
    """
    notes = list(found.notes)
    held: dict[str, Any] = {}
    for name in ("energy_ratio", "system_free_ratio", "friction_energy"):
        figure: Measured | None = getattr(found, name)
        high = found.friction_max.value if name == "friction_energy" and found.friction_max is not None else 1.0
        held[name] = None if figure is None else bounded(figure, high)
        if figure is not None and held[name] is None:
            notes.append(f"{name} as read, {figure.value:.3g}, lies beyond its bound {high:.3g} and is left out")
    return replace(found, notes=tuple(notes), **held)


def bounded(figure: Measured, high: float) -> Measured | None:
    """The figure limited to 0 … `high`, with its interval; None where the whole interval lies outside.

    The upper end of the interval may exceed `high` by ROUND_OFF, as coarse samples cut corners off.
    """
    begin, end = figure.interval95
    if begin > high * (1.0 + ROUND_OFF) or end < -ROUND_OFF * high:
        return None
    value = min(max(figure.value, 0.0), high)
    return Measured(value, (max(min(begin, value), 0.0), max(min(end, high * (1.0 + ROUND_OFF)), value)))


def analyse_loop(
    displacement_um: ArrayLike,
    tangential_force_N: ArrayLike,
    normal_force_N: ArrayLike | None = None,
    *,
    time_s: ArrayLike | None = None,
    cycle: int | None = None,
) -> LoopFigures:
    """Analyse one cycle of a force–displacement loop.

    displacement_um: (n,), n ≥ 16, starting anywhere in the cycle and in either direction. tangential_force_N: (n,),
    positive when it resists motion towards +x (the sign is found out if not). normal_force_N: a number or (n,),
    positive when pressing; without it, and where it falls to zero within the cycle, friction figures are left out.
    time_s: (n,) times of the samples; without them the samples count as evenly spread where that makes sense. cycle:
    its number in the test; surfaces count as unworn in the first ten, beyond them, and without it, friction in partial
    slip is only bounded.

    Definitions follow Infante-García et al., Sensors 20 (2020) 4152, sections 1 and 3: δ0 is half the loop's width at
    zero force (here at the mean force, which a sensor's offset does not shift), K_t,m the mean slope of both micro-slip
    branches, each fitted over half of its micro-slip region. Friction: E_d/(4Pδ0) (Fouvry et al. 1996) and the
    geometry-independent coefficient (Jahangiri et al. 2012). Raises LoopError, which says in one sentence what is wrong
    with the samples.
    """
    given = read_loop(displacement_um, tangential_force_N, normal_force_N, time_s=time_s)
    loop, fits, other, lag, _ = given
    forward, backward = fits.both
    force = mean_force(loop)
    loop, energy, slip, of_slip = _energy_and_slip(loop, fits, force.value, other)
    micro = micro_slip_branch(loop, *forward), micro_slip_branch(loop, *backward)
    no_line = any(bent(loop, *fitted) for fitted in fits.both)
    stiffness = None if no_line or loop.lean_um_per_N else _stiffness(loop, fits, micro, lag)
    viscous = goes_with_velocity(loop)
    slides = fits.slide and not viscous
    corner = corner_of(forward, backward) if slides and stiffness is not None else None
    tops = peaks(loop, forward, backward)
    largest = largest_ratio(loop, tops, slides=slides)
    positions = sliding_stiffness(stiffness, corner)
    sliding = sliding_figures(loop, fits.both, tops, positions) if slides else SlidingFigures()
    zero = fits.force_zero
    deviation = loop.amplitude_noise_um if loop.smoothed else loop.raw_noise_um
    amplitude, largest_force = Measured.from_deviation(0.5 * given.length_um, deviation), force_amplitude(loop, tops)
    read, reread = _slip_by_energy(loop, slip, energy, sliding, amplitude)
    ratio = energy_ratio(energy, amplitude, largest_force)
    hidden = None if fits.slide or viscous or ratio is None else _hidden(fits, ratio)
    if hidden is not None:
        read, loop = _all_along(read, fits, energy, amplitude), loop if OPENS in loop.notes else loop.noted(hidden)
    seen: Regime = "gross slip" if fits.slide else "contact opened" if OPENS in loop.notes else "partial slip"
    steep = (worn := may_be_worn(cycle)) and slides and looks_worn(fits.both, sliding.slope, ratio)
    if steep:
        slides, sliding, corner, seen = False, SlidingFigures(), None, "partial slip"
    doubts = {"hides": hidden is not None, "viscous": viscous, "worn": worn, "steep": steep}
    regime, regimes, sticking = slip_of(loop, fits.both, seen, **doubts)
    slip = allowed_slip(read, amplitude, energy, largest_force)
    found = LoopFigures(
        displacement_amplitude_um=amplitude,
        slip_amplitude_um=slip,
        dissipated_energy_mJ=energy,
        measured_stiffness_N_per_um=stiffness,
        branches=micro,
        friction_max=largest,
        friction_energy=_energy_friction(loop, energy, slip) if slides else None,
        friction_geometry_independent=sliding.friction,
        plateau_slope_N_per_um=sliding.slope,
        end_hook_ratio=sliding.hook,
        corner_curvature=None if corner is None else corner.curvature,
        energy_ratio=ratio,
        system_free_ratio=energy_ratio(energy, slip, largest_force),
        mean_force_N=force,
        asymmetry=sliding.asymmetry,
        free_play_um=fits.free_play,
        force_zero_N=zero,
        friction_forward=_from_zero(loop, sliding.forward, zero, -1.0),
        friction_backward=_from_zero(loop, sliding.backward, zero, 1.0),
        static_overshoot=static_overshoot(loop, fits.both) if slides else None,
        stick_slip=stick_slip(loop, fits.both) if slides else None,
        regime=regime,
        regimes=regimes,
        outlier_samples=loop.outliers,
        notes=(),
        used={
            "energy": tuple(sorted(loop.index.tolist())),
            "stiffness": () if stiffness is None else tuple(i for branch in micro for i in branch.samples),
            "slip": () if reread or hidden is not None else of_slip,
            "friction": sliding.samples,
        },
        sticking=sticking,
    )
    loop = loop.noted(ELLIPSE) if viscous else loop
    notes = [*_notes(loop, fits, found, no_line=no_line), *([BY_ENERGY] if reread else [])]
    notes += (
        [UNDETERMINED] if slip.interval95[1] < read.interval95[0] or slip.interval95[0] > read.interval95[1] else []
    )
    return within_bounds(replace(found, notes=tuple(notes)))


def _energy_and_slip(
    loop: CleanLoop, fits: BranchFits, mean_force_N: float, other_mJ: float
) -> tuple[CleanLoop, Measured, Measured, tuple[int, ...]]:
    """The loop, noted if drift matters, its energy, its slip, and the samples that gave the slip; intervals reach to
    what another lag or no drift makes.

    other_mJ: the energy with the other lag.
    """
    energy, (slip, used) = dissipated_energy(loop), slip_amplitude(loop, *fits.both, mean_force_N)
    still = dissipated_energy(loop.without_drift).value
    if not energy.interval95[0] <= still <= energy.interval95[1]:
        moved = abs(loop.may_drift_by) * float(np.ptp(loop.time))
        loop = loop.noted(MAY_DRIFT.format(moved, moved / float(np.ptp(loop.displacement_um)), still))
    for value in (other_mJ, still):
        if energy.value > 0.0:
            slip = slip.reaching(slip.value * value / energy.value)
        energy = energy.reaching(value)
    return loop, energy, slip, used


def _stiffness(
    loop: CleanLoop, fits: BranchFits, micro: tuple[MicroSlipBranch, MicroSlipBranch], lag: float
) -> Measured | None:
    """Mean stiffness of both branches; its interval reaches to that with the other lag."""
    stiffness = mean_stiffness(*micro)
    if stiffness is None or not lag:
        return stiffness
    sooner = mean_stiffness(*(micro_slip_branch(loop, branch_earlier(branch, lag), own) for branch, own in fits.both))
    return stiffness if sooner is None else stiffness.reaching(sooner.value)


def _slip_by_energy(
    loop: CleanLoop, slip: Measured, energy: Measured, sliding: SlidingFigures, amplitude: Measured
) -> tuple[Measured, bool]:
    """The slip amplitude as energy and height of the loop allow, and whether the energy gives it, not the width."""
    high = sliding.height_N
    widest = None if high is None or min(energy.value, high.value) <= 0.0 else by_energy(energy, high)
    reread = widest is not None and narrow(slip, widest, amplitude.value)
    read = widest if widest is not None and reread else slip
    if widest is not None:
        read = read.reaching(widest.value)
    if sliding.friction is not None and sliding.friction.value > 0.0 and loop.normal_force_N is not None:
        read = read.reaching(250.0 * energy.value / (sliding.friction.value * float(np.mean(loop.normal_force_N))))
    return read, reread


def _hidden(fits: BranchFits, ratio: Measured) -> str | None:
    """Note on why a loop without a plateau may yet slide all along; None if nothing suggests that."""
    if ratio.interval95[0] > MOST_IN_PARTIAL_SLIP:
        return HIDDEN.format(ratio.value)
    return WALLED if all(stiffens(branch) for branch, _ in fits.both) else None


def _all_along(read: Measured, fits: BranchFits, energy: Measured, amplitude: Measured) -> Measured:
    """δ0 of a contact that slides all along at the height seen at mid-slip; its interval also holds the width
    as read.
    """
    (forward, _), (backward, _) = fits.both
    centre, half = forward.origin_um + amplitude.value, MIDDLE_SHARE * amplitude.value
    height = height_at((forward, backward), (np.inf,), centre, half)
    found = by_energy(energy, height).reaching(read.value) if height.interval95[0] > 0.0 else read
    return found.reaching(amplitude.value)


def _from_zero(loop: CleanLoop, friction: Measured | None, zero: Measured | None, sign: float) -> Measured | None:
    """Friction of one direction, corrected for the zero error of the force sensor where free play shows it.

    sign: +1 or −1, by which the zero error over the load is added.
    """
    if friction is None or zero is None or loop.normal_force_N is None:
        return friction
    load = float(np.mean(loop.normal_force_N))
    return Measured.from_deviation(
        friction.value + sign * zero.value / load, float(np.hypot(friction.deviation, zero.deviation / load))
    )


def _energy_friction(loop: CleanLoop, energy: Measured, slip: Measured) -> Measured | None:
    """E_d/(4Pδ0); None without a normal force, or where nothing is dissipated."""
    if loop.normal_force_N is None or not energy.value or not slip.value:
        return None
    load = Measured.from_deviation(float(np.mean(loop.normal_force_N)), loop.normal_noise_N)
    return energy.over(slip, load, times=0.25 / MICROJOULE_IN_MILLIJOULE)


def _notes(loop: CleanLoop, fits: BranchFits, found: LoopFigures, *, no_line: bool) -> tuple[str, ...]:
    notes = list(loop.notes)
    if loop.normal_force_N is None and not {OPENS, NORMAL_CLIPPED} & set(notes):
        notes.append("no normal force was given, so coefficients of friction are left out")
    if loop.past:
        notes.append(f"the samples run on past one cycle: the last {loop.past} of them were left out")
    if count := len(loop.outliers) - loop.past:
        notes.append(f"{count} outlying or repeated {'sample was' if count == 1 else 'samples were'} left out")
    notes += _stiffness_notes(loop, fits, found, no_line=no_line)
    stiffness = found.measured_stiffness_N_per_um
    if found.regime == "partial slip" and stiffness is not None and _sticks(found) and WALLED not in loop.notes:
        stretch, force = found.displacement_amplitude_um.value, 0.5 * float(np.ptp(loop.force_N))
        notes.append(
            f"the contact sticks: a force of ±{force:.4g} N follows the displacement of ±{stretch:.4g} µm along a line "
            f"of {1e3 * stiffness.value:.4g} N/mm, which is what it is held by"
        )
    notes += notes_on(found.regime, found.sticking)
    return (*notes, *_signal_notes(found))


def _sticks(found: LoopFigures) -> bool:
    """True if the slip amplitude is smaller than its uncertainty or than 0.1 % of the displacement amplitude."""
    slip = found.slip_amplitude_um
    return slip.value < max(slip.interval95[1] - slip.value, STUCK * found.displacement_amplitude_um.value)


def _stiffness_notes(loop: CleanLoop, fits: BranchFits, found: LoopFigures, *, no_line: bool) -> list[str]:
    if loop.lean_um_per_N:
        return [RUNS_ON]
    if no_line:
        return ["the force does not rise along a line in the micro-slip regions, so the measured stiffness is left out"]
    if found.measured_stiffness_N_per_um is None:
        return ["no sample lies on the micro-slip branches, so the measured stiffness is left out"]
    notes = []
    for branch, slip in fits.both:
        resolved = int(np.count_nonzero(branch.travel_um <= 0.5 * slip.travel_um))
        if resolved < RESOLVED:
            name = "forward" if branch.direction > 0 else "backward"
            notes.append(
                f"only {resolved} samples resolve half of the {name} branch's micro-slip: its stiffness is coarse"
            )
    return notes


def _signal_notes(found: LoopFigures) -> list[str]:
    """Notes on free play, stick-slip and a static peak in a loop; none of these has samples left out."""
    notes = []
    if found.free_play_um is not None and found.force_zero_N is not None:
        notes.append(
            "free play: both branches have a shelf; slip amplitude and stiffness are those of a rig without it, "
            "and friction by direction counts from the shelf's force"
        )
    if (chatter := found.stick_slip) is not None:
        notes.append(
            "stick-slip: the force falls again and again while sliding; all samples are kept"
            + ("" if chatter.resolved else ", and there may be more slips than the samples resolve")
        )
    if found.static_overshoot is not None:
        notes.append("static friction: the force passes its later peaks before sliding sets in; all samples are kept")
    return notes
