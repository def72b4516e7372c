"""Figures of one force–displacement loop, measured or simulated."""

import numpy as np
from numpy.typing import ArrayLike

from wirewear.loops.branches import Branch, MicroSlip, fit_micro_slip, slides_visibly, split_branches
from wirewear.loops.cleaning import CleanLoop, clean_loop
from wirewear.loops.corners import corner_of
from wirewear.loops.figures import LoopFigures, Measured
from wirewear.loops.friction import SlidingFigures, peaks, sliding_figures
from wirewear.loops.opening import dissipated_energy, mean_force, slip_amplitude
from wirewear.loops.stiffness import RESOLVED, mean_stiffness, micro_slip_branch, sliding_stiffness

Course = tuple[Branch, MicroSlip]


def analyse_loop(
    displacement_um: ArrayLike,
    tangential_force_N: ArrayLike,
    normal_force_N: ArrayLike | None = None,
    *,
    time_s: ArrayLike | None = None,
) -> LoopFigures:
    """Analyse one cycle of a force–displacement loop.

    Definitions follow Infante-García et al., Sensors 20 (2020) 4152, sections 1 and 3: δ0 is half the loop's width
    at zero force (here at the mean force, which a sensor's offset does not shift), K_t,m the mean slope of both
    micro-slip branches, each fitted over half of its micro-slip region. Friction: E_d/(4Pδ0) (Fouvry et al. 1996)
    and the geometry-independent coefficient (Jahangiri et al. 2012).

    Args:
        displacement_um: displacement (n,), n ≥ 16, starting anywhere in the cycle and in either direction.
        tangential_force_N: force (n,), positive when it resists motion towards +x (the sign is found out if not).
        normal_force_N: number or (n,), positive when pressing; without it friction figures are left out.
        time_s: sample times (n,); without them the samples count as evenly spread where that makes sense.

    Raises:
        LoopError: what is wrong with the samples, in one sentence.
    """
    loop = clean_loop(displacement_um, tangential_force_N, normal_force_N, time_s=time_s)
    loop, forward, backward = _followed(loop, times_known=time_s is not None)
    force = mean_force(loop)
    energy = dissipated_energy(loop)
    slip = slip_amplitude(loop, forward, backward, force.value)
    micro = micro_slip_branch(loop, *forward), micro_slip_branch(loop, *backward)
    stiffness = mean_stiffness(*micro)
    slides = slides_visibly(forward) and slides_visibly(backward)
    corner = corner_of(forward, backward) if slides and stiffness is not None else None
    tops = peaks(loop, forward, backward)
    largest = None if loop.normal_force_N is None else max(tops, key=lambda figure: figure.value)
    position_stiffness = sliding_stiffness(stiffness, corner)
    sliding = sliding_figures(loop, (forward, backward), tops, position_stiffness) if slides else SlidingFigures()
    return LoopFigures(
        displacement_amplitude_um=_displacement_amplitude(loop, forward[0]),
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
        mean_force_N=force,
        asymmetry=sliding.asymmetry,
        regime="gross slip" if slides else "partial slip",
        outlier_samples=loop.outliers,
        notes=_notes(loop, (forward, backward), slides=slides, stiff=stiffness is None),
    )


def _followed(loop: CleanLoop, *, times_known: bool) -> tuple[CleanLoop, Course, Course]:
    """Branches and their micro-slip; samples without times may be unevenly spread, then the raw drive fits better."""
    courses = _courses(loop)
    if not loop.smoothed or times_known:
        return loop, *courses
    raw = loop.without_smooth_drive()
    raw_courses = _courses(raw)
    if _misfit(raw_courses) < 0.8 * _misfit(courses):
        return raw, *raw_courses
    return loop, *courses


def _courses(loop: CleanLoop) -> tuple[Course, Course]:
    forward, backward = split_branches(loop)
    return (forward, fit_micro_slip(forward)), (backward, fit_micro_slip(backward))


def _misfit(courses: tuple[Course, Course]) -> float:
    return sum(slip.misfit for _, slip in courses)


def _displacement_amplitude(loop: CleanLoop, branch: Branch) -> Measured:
    deviation = loop.amplitude_noise_um if loop.smoothed else loop.raw_noise_um
    return Measured.from_deviation(0.5 * branch.length_um, deviation)


def _energy_friction(loop: CleanLoop, energy: Measured, slip: Measured) -> Measured | None:
    """E_d/(4Pδ0)."""
    if loop.normal_force_N is None:
        return None
    load = float(np.mean(loop.normal_force_N))
    value = 1e3 * energy.value / (4.0 * load * slip.value)
    shares = energy.deviation / energy.value, slip.deviation / slip.value, loop.normal_noise_N / load
    deviation = abs(value) * float(np.linalg.norm(shares))
    return Measured.from_deviation(value, deviation)


def _notes(loop: CleanLoop, courses: tuple[Course, Course], *, slides: bool, stiff: bool) -> tuple[str, ...]:
    notes = list(loop.notes)
    if loop.normal_force_N is None:
        notes.append("no normal force was given, so coefficients of friction are left out")
    if loop.outliers:
        notes.append(f"{len(loop.outliers)} outlying or repeated samples were left out")
    if stiff:
        notes.append("no sample lies on the micro-slip branches, so the measured stiffness is left out")
    if not slides:
        notes.append(
            "partial slip: no plateau follows the micro-slip branches, so friction_max is a lower bound, "
            "slip_amplitude is the loop's half width without global sliding, and the figures of sliding are left out"
        )
    for branch, slip in courses:
        resolved = int(np.count_nonzero(branch.travel_um <= 0.5 * slip.travel_um))
        if resolved < RESOLVED and not stiff:
            name = "forward" if branch.direction > 0 else "backward"
            notes.append(
                f"only {resolved} samples resolve half of the {name} branch's micro-slip: its stiffness is coarse"
            )
    return tuple(notes)
