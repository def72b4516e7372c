"""The article's findings, each judged by both runs."""

from collections.abc import Callable

import numpy as np

from studies.verdicts import Finding
from wirewear.base.words import counted
from wirewear.results import RunResult, Scar

from .pair import DISTORTED, EARLY, LATE, WIRES, Pair, analysed, value_of

#: A plateau that rises by less towards the stroke's end is flat; one that rises by more is plainly distorted.
FLAT_RISE, PLAIN_RISE = 0.05, 0.10

NEGLIGIBLE_DEPTH = 0.10  #: Share of the late depth up to which the early depth is negligible.
WORST_DEPTH_um = 40.0  #: The article: "worst wear depth < 40 µm".
CONSTANT = 1e-3  #: Relative change of δa that still counts as constant.


def extent_along_motion_um(scar: Scar) -> float:
    """Length of the section y = 0 on which at least a twentieth of its worst depth is worn."""
    x, depth = scar.section_along_motion()
    fine = np.linspace(x[0], x[-1], 4001)
    worn = fine[np.interp(fine, x, depth) > 0.05 * depth.max()]
    return float(np.ptp(worn)) if worn.size else 0.0


def loops_distort(pair: Pair) -> Finding:
    """Finding 1: flat at 100 cycles, plainly distorted from 10 000 on, ever more so."""
    rises = [
        [value_of(analysed(run.loop(cycle)).end_hook_ratio) - 1.0 for cycle in (EARLY, DISTORTED, LATE)]
        for run in pair.runs
    ]
    return Finding(
        f"1  Loops are flat at {EARLY} cycles; |Q| rises towards the stroke ends, plainly from {DISTORTED} on",
        "\n".join(
            f"{run.variant} +{100 * a:.1f} %, +{100 * b:.1f} %, +{100 * c:.1f} %"
            for run, (a, b, c) in zip(pair.runs, rises, strict=True)
        ),
        all(early < FLAT_RISE and PLAIN_RISE < middle < late for early, middle, late in rises),
    )


def slip_falls(pair: Pair) -> Finding:
    """Finding 2: δa constant; δ0 below it throughout, and lower at the end than at 100 cycles."""
    holds, evidence = True, []
    for run in pair.runs:
        amplitude, slip = run.evolution["displacement_amplitude_um"], run.evolution["slip_amplitude_um"]
        early, late = (run.evolution.at(cycle)["slip_amplitude_um"] for cycle in (EARLY, LATE))
        constant = bool(np.ptp(amplitude) <= CONSTANT * amplitude.mean())
        holds = holds and constant and bool((slip < amplitude).all()) and late < early
        evidence.append(f"{run.variant} δa {amplitude.min():.2f}–{amplitude.max():.2f}, δ0 {early:.2f} → {late:.2f} µm")
    return Finding("2  δa stays constant; δ0 is always below it and falls", "\n".join(evidence), holds)


def rigid_rig_over_predicts_slip(pair: Pair) -> Finding:
    """Finding 3: at every cycle that both runs reached, δ0 is larger on the rigid rig."""
    rigid, compliant = pair.rigid.evolution, pair.compliant.evolution
    cycles = compliant["cycle"][compliant["cycle"] <= rigid["cycle"][-1]]
    slip = np.interp(np.log(cycles), np.log(rigid["cycle"]), rigid["slip_amplitude_um"])
    excess = slip - compliant["slip_amplitude_um"][: cycles.size]
    return Finding(
        "3  A rigid rig over-predicts slip throughout",
        f"by {excess.min():.2f} to {excess.max():.2f} µm",
        bool((excess > 0.0).all()),
    )


def energy_rises(pair: Pair) -> Finding:
    """The article's section 3.1.1: the measured test dissipates gradually more over the cycles."""
    holds, evidence = True, []
    for run in pair.runs:
        cycles, energy = run.evolution["cycle"], run.evolution["dissipated_energy_mJ"]
        holds = holds and bool((np.diff(energy) > 0.0).all())
        top = int(energy.argmax())
        evidence.append(
            f"{run.variant} {energy[0]:.4f} → {energy[top]:.4f} at {counted(cycles[top])} → {energy[-1]:.4f} mJ; µ of "
            f"{friction_for_rising_energy(run):.3f} in the end would only undo the fall"
        )
    return Finding("   The dissipated energy rises gradually (the measured test)", "\n".join(evidence), holds)


def friction_for_rising_energy(run: RunResult) -> float:
    """Friction to which the coefficient must rise for the last loop to dissipate no less than any before.

    A loop in gross slip dissipates about 4 µP (δa − µP/K): a little more friction raises its energy by the share
    2 − δa/δ0 of itself.
    """
    last = {name: float(column[-1]) for name, column in run.evolution.items()}
    share = 2.0 - last["displacement_amplitude_um"] / last["slip_amplitude_um"]
    lacking = float(run.evolution["dissipated_energy_mJ"].max()) / last["dissipated_energy_mJ"] - 1.0
    return float(run.study["contact"]["friction"]) * (1.0 + lacking / share)


def scars_grow(pair: Pair) -> Finding:
    """Finding 4: wear negligible at 100 cycles, a wider and deeper bowl at 100 000."""
    holds, evidence = True, []
    for run in pair.runs:
        for wire in WIRES:
            early, late = run.scar(EARLY, wire), run.scar(LATE, wire)
            holds = (
                holds
                and early.max_depth_um < NEGLIGIBLE_DEPTH * late.max_depth_um
                and extent_along_motion_um(early) < extent_along_motion_um(late)
            )
            evidence.append(f"{run.variant} {wire} {early.max_depth_um:.2f} → {late.max_depth_um:.2f} µm")
    statement = f"4  Wear is negligible at {EARLY} cycles; at {LATE} the bowls are wider and deeper"
    return Finding(statement, "\n".join(evidence), holds)


def worst_depth_is_bounded(pair: Pair) -> Finding:
    """The article's bound on the worst depth."""
    worst = max(run.scar(LATE, wire).max_depth_um for run in pair.runs for wire in WIRES)
    return Finding(f"   The worst depth is below {WORST_DEPTH_um:g} µm", f"{worst:.2f} µm", worst < WORST_DEPTH_um)


def fixed_scar_is_shorter_and_deeper(pair: Pair) -> Finding:
    """The contact wanders along the moving wire, while the same spot of the fixed wire bears the load all the time."""
    holds, evidence = True, []
    for run in pair.runs:
        moving, fixed = (run.scar(LATE, wire) for wire in WIRES)
        lengths = extent_along_motion_um(moving), extent_along_motion_um(fixed)
        holds = holds and lengths[1] < lengths[0] and fixed.max_depth_um > moving.max_depth_um
        evidence.append(
            f"{run.variant} {lengths[1]:.0f} × {fixed.max_depth_um:.1f} "
            f"against {lengths[0]:.0f} × {moving.max_depth_um:.1f} µm"
        )
    return Finding("   The fixed wire's scar is shorter and deeper than the moving wire's", "\n".join(evidence), holds)


FINDINGS: tuple[Callable[[Pair], Finding], ...] = (
    loops_distort, slip_falls, rigid_rig_over_predicts_slip, energy_rises, scars_grow, worst_depth_is_bounded,
    fixed_scar_is_shorter_and_deeper,
)  # fmt: skip
