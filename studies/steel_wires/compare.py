"""Rigid and compliant rig side by side, as the article's Figures 8–10 show them, and its figures and findings checked.

    python studies/steel_wires/compare.py RESULT_DIR [--output DIR]

RESULT_DIR is the folder that `wirewear run` left of study.toml, with the variants "rigid" and "compliant". Every
verdict is computed from these results. Both runs are also set beside an experiment record, in the folders record_rigid
and record_compliant. It is no measurement: others simulated a rig of 167 N/mm, whose owner believes it rigid. The
article: Infante-García et al., On the Role of Contact and System Stiffness in the Measurement of Principal Variables in
Fretting Wear Testing, Sensors 2020, 20(15), 4152.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from wirewear import ExperimentRecord, ResultError, read_record
from wirewear.comparison import Comparison as RecordComparison
from wirewear.comparison import compare, write_comparison
from wirewear.loops import LoopFigures, Measured, analyse_loop
from wirewear.pictures import amplitude_evolution, loops_by_cycle, save, scar_sections
from wirewear.quantity import counted
from wirewear.reference import (
    Elastic,
    closed_loop,
    contact_modulus,
    dissipated_energy,
    hertz_point,
    partial_slip_point,
    slip_amplitude,
    tangential_contact_modulus,
)
from wirewear.results import Loop, RunResult, Scar, read_results
from wirewear.study_script import comparison_command, wide_console
from wirewear.verdicts import Comparison, Finding, comparison_table, finding_table

#: Cycles whose loops and sections the article shows; from the middle one on it calls the loops plainly distorted.
EARLY, DISTORTED, LATE = 100, 10_000, 100_000

#: A plateau that rises by less towards the stroke's end is flat; one that rises by more is plainly distorted.
FLAT_RISE, PLAIN_RISE = 0.05, 0.10

#: Share of the late depth up to which the early depth is negligible.
NEGLIGIBLE_DEPTH = 0.10

#: The article: "worst wear depth < 40 µm".
WORST_DEPTH_um = 40.0

#: Relative change of δa that still counts as constant.
CONSTANT = 1e-3

WIRES = ("moving", "fixed")

#: A record of a rig like the compliant one, made by an independent simulator; see the README beside it.
EXAMPLE_RECORD = Path(__file__).parent / "example_records" / "rigid_stated_compliant_rig"


@dataclass(frozen=True)
class Pair:
    """The same test on both rigs."""

    rigid: RunResult
    compliant: RunResult

    @property
    def runs(self) -> tuple[RunResult, RunResult]:
        """Both runs, the real rig first."""
        return self.compliant, self.rigid


def read_pair(folder: Path) -> Pair:
    """The runs "rigid" and "compliant" in `folder`.

    Raises:
        ResultError: one of them is missing or cannot be read.
    """
    runs = {result.variant: result for result in read_results(folder)}
    if missing := {"rigid", "compliant"} - runs.keys():
        raise ResultError(f"{folder} lacks the variant(s) {', '.join(sorted(missing))}, which the comparison needs")
    for name in ("rigid", "compliant"):
        if not runs[name].loops or not {"wires", "conditions", "contact", "wear", "holder"} <= runs[name].study.keys():
            raise ResultError(f"the variant {name} in {folder} has logged no loop or is no run of this study with wear")
    return Pair(runs["rigid"], runs["compliant"])


def first_loop_comparisons(pair: Pair) -> list[Comparison]:
    """First simulated cycle against Hertz and the loop of a Cattaneo–Mindlin contact behind a spring, without wear."""
    study = pair.compliant.study
    wire = Elastic(study["wires"]["youngs_modulus_MPa"], study["wires"]["poissons_ratio"])
    load, friction = study["conditions"]["normal_load_N"], study["contact"]["friction"]
    amplitude_mm = 1e-3 * study["conditions"]["displacement_amplitude_um"]
    rig = study["holder"]["tangential_stiffness_N_per_mm"]
    hertz = hertz_point(load, 0.5 * study["wires"]["diameter_mm"], contact_modulus(wire, wire))
    contact = partial_slip_point(load, friction, hertz.contact_radius_mm, tangential_contact_modulus(wire, wire))
    first = {run.variant: {name: float(column[0]) for name, column in run.evolution.items()} for run in pair.runs}
    comparisons = []
    for run, stiffness in ((pair.compliant, rig), (pair.rigid, np.inf)):
        slip, energy = (first[run.variant][name] for name in ("slip_amplitude_um", "dissipated_energy_mJ"))
        slip_expected = 1e3 * slip_amplitude(contact, amplitude_mm, stiffness)
        energy_expected = dissipated_energy(contact, amplitude_mm, stiffness)
        comparisons += [
            Comparison(f"{run.variant}: δ0 [µm]", slip, slip_expected, 0.01, "closed form"),
            Comparison(f"{run.variant}: energy per cycle [mJ]", energy, energy_expected, 0.02, "closed form"),
        ]
    taken = first["rigid"]["slip_amplitude_um"] - first["compliant"]["slip_amplitude_um"]
    loop = pair.compliant.loops[0]
    ideal = closed_loop(contact, amplitude_mm, rig, samples=loop.time_s.size)
    # The analysis fits a line to a curved branch: the same is done to the closed form, on as many samples.
    expected = analyse_loop(1e3 * ideal.displacement_mm, ideal.tangential_force_N).measured_stiffness_N_per_um
    stiffness = _analysed(loop).measured_stiffness_N_per_um
    if stiffness is None or expected is None:
        raise ResultError("the first loop on the compliant rig shows no micro-slip branch to measure its stiffness on")
    return [
        *comparisons,
        Comparison("displacement taken by rig [µm]", taken, 1e3 * friction * load / rig, 0.05, "µP/K"),
        Comparison(
            "compliant: stiffness K_t,m [N/mm]", 1e3 * stiffness.value, 1e3 * expected.value, 0.05, "closed form"
        ),
        Comparison(
            "compliant: largest pressure [MPa]",
            first["compliant"]["max_pressure_MPa"],
            hertz.peak_pressure_MPa,
            0.02,
            "Hertz",
        ),
    ]


def volume_comparisons(pair: Pair) -> list[Comparison]:
    """Worn volume of each wire against its share of the wear coefficient times the friction energy."""
    comparisons = []
    for run in pair.runs:
        wear, evolution = run.study["wear"], run.evolution
        for wire, share in zip(WIRES, (wear["moving_share"], 1.0 - wear["moving_share"]), strict=True):
            volume = float(evolution[f"worn_volume_{wire}_mm3"][-1])
            expected = share * wear["energy_wear_coefficient_mm3_per_J"] * float(evolution["accumulated_energy_J"][-1])
            name = f"{run.variant}: worn off {wire} wire [10⁻³ mm³]"
            comparisons.append(Comparison(name, 1e3 * volume, 1e3 * expected, 1e-6, "energy law"))
    return comparisons


def worn_friction_comparison(pair: Pair) -> Comparison:
    """Geometry-independent friction of the late loop against the friction that the article measured in this way."""
    friction = _analysed(pair.compliant.loop(LATE)).friction_geometry_independent
    expected = pair.compliant.study["contact"]["friction"]
    return Comparison("compliant: friction in the last loop", _value(friction), expected, 0.02, "the article")


def extent_along_motion_um(scar: Scar) -> float:
    """Length of the section y = 0 on which at least a twentieth of its worst depth is worn."""
    x, depth = scar.section_along_motion()
    fine = np.linspace(x[0], x[-1], 4001)
    worn = fine[np.interp(fine, x, depth) > 0.05 * depth.max()]
    return float(np.ptp(worn)) if worn.size else 0.0


def loops_distort(pair: Pair) -> Finding:
    """Finding 1: flat at 100 cycles, plainly distorted from 10 000 on, ever more so."""
    rises = [
        [_value(_analysed(run.loop(cycle)).end_hook_ratio) - 1.0 for cycle in (EARLY, DISTORTED, LATE)]
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


def beside_record(pair: Pair, record: ExperimentRecord) -> dict[str, RecordComparison]:
    """Both runs compared with a record, by variant."""
    return {run.variant: compare(run, record) for run in pair.runs}


def compliant_run_is_nearer(comparisons: dict[str, RecordComparison]) -> Finding:
    """The record of a compliant rig is closer to the compliant run, at every cycle, by the force at equal phase."""
    distances = {variant: _force_distances(comparison) for variant, comparison in comparisons.items()}
    evidence = [f"{variant} {min(d):.3f} to {max(d):.3f} N" for variant, d in distances.items()]
    nearer = all(a < b for a, b in zip(distances["compliant"], distances["rigid"], strict=True))
    return Finding(
        "   The example record, simulated by others, is nearer to the compliant rig's loops",
        "\n".join(evidence),
        nearer,
    )


def _force_distances(comparison: RecordComparison) -> list[float]:
    return [row.difference for row in comparison.differences if row.quantity == "force at equal phase (rms)"]


FINDINGS: tuple[Callable[[Pair], Finding], ...] = (
    loops_distort,
    slip_falls,
    rigid_rig_over_predicts_slip,
    energy_rises,
    scars_grow,
    worst_depth_is_bounded,
    fixed_scar_is_shorter_and_deeper,
)


def pictures(pair: Pair) -> dict[str, Callable[[], Figure]]:
    """The three figures by file name."""
    return {
        "loops": partial(loops_by_cycle, pair.runs, (EARLY, LATE)),
        "amplitudes": partial(amplitude_evolution, pair.runs),
        "scar_sections": partial(scar_sections, pair.runs, (EARLY, LATE)),
    }


def _analysed(loop: Loop) -> LoopFigures:
    return analyse_loop(loop.displacement_um, loop.tangential_force_N, loop.normal_force_N, time_s=loop.time_s)


def _value(measured: Measured | None) -> float:
    """NaN, of which no statement holds, where the figure has no meaning."""
    return np.nan if measured is None else measured.value


@comparison_command
def main(result_dir: Path, folder: Path) -> None:
    """Set rigid and compliant rig side by side."""
    console = wide_console()
    pair = read_pair(result_dir)
    comparisons = [*first_loop_comparisons(pair), worn_friction_comparison(pair), *volume_comparisons(pair)]
    beside = beside_record(pair, read_record(EXAMPLE_RECORD))
    findings = [*(judge(pair) for judge in FINDINGS), compliant_run_is_nearer(beside)]
    folder.mkdir(parents=True, exist_ok=True)
    drawn = [save(draw, folder / f"{name}.png") for name, draw in pictures(pair).items()]
    pages = [write_comparison(one, folder / f"record_{variant}")[0] for variant, one in beside.items()]
    console.print(
        f"Rigid and compliant rig, {pair.compliant.fidelity} fidelity; figures of the first loop and of all wear"
    )
    console.print(comparison_table(comparisons), finding_table(findings))
    verdicts = [item.holds for item in comparisons] + [finding.holds for finding in findings]
    console.print(
        f"{sum(verdicts)} of {len(verdicts)} hold. Pictures, and both runs beside the simulated example record:"
    )
    for path in [*drawn, *pages]:
        console.print(str(path), soft_wrap=True, highlight=False)


if __name__ == "__main__":
    main()
