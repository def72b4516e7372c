"""The article's result, reached from a record alone: what a rigid model lacks, calibrated at 100 cycles, at 100 000.

    python -m studies.steel_wires.diagnose [RECORD] [--output DIR]

RECORD is that of a rig of 167 N/mm whose owner believes it rigid (example_records/rigid_stated_compliant_rig). The
model built from it is diagnosed on the whole record; then its leading class is calibrated on the loops of the first
cycle alone and predicts those of the last. It leaves the diagnosis and a picture in DIR. The article: Infante-García et
al., On the Role of Contact and System Stiffness in the Measurement of Principal Variables in Fretting Wear Testing,
Sensors 2020, 20(15), 4152.
"""

from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from matplotlib.figure import Figure
from matplotlib.typing import LineStyleType

from studies.study_script import StudyScript
from studies.verdicts import Finding, finding_table
from wirewear import read_record
from wirewear.app.cli.consoles import wide_console
from wirewear.base.words import counted
from wirewear.base.writing import prepared_folder
from wirewear.diagnosis import Diagnosed, Estimate, calibrated, diagnose
from wirewear.diagnosis.infer.where import physical_gap
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.pictures import save
from wirewear.pictures.panels import draw_loop, name_axes
from wirewear.pictures.style import VARIANT_COLOURS, new_figure
from wirewear.simulation import ProgressBar
from wirewear.views.diagnosis_page import write_diagnosis

EXAMPLE_RECORD = Path(__file__).parent / "example_records" / "rigid_stated_compliant_rig"

STIFFNESS_N_per_mm, TOLERANCE = 167.0, 0.06  #: The article's spring, and how near to it the one found must be.

EFFECT, PARAMETER = "tangential_compliance", "stiffness_N_per_mm"

#: A prediction that leaves less than this share of the difference stands for the article's "good agreement".
LEFT_OVER = 0.25


@dataclass(frozen=True)
class Chapter:
    """The record diagnosed, and its compliance calibrated on the first logged cycle alone."""

    whole: Diagnosed
    stiffness: Estimate
    early_stiffness: Estimate
    calibrated: SurrogateInputs
    cycles: tuple[int, int]

    def differences(self, cycle: int) -> dict[str, tuple[float, float]]:
        """Distances of measured loops from the rigid model, and from the one calibrated on the first cycle."""
        whole = self.whole
        return dict(physical_gap(whole.states, whole.observed, whole.setup, self.calibrated, (cycle,)))


def chapter_of(whole: Diagnosed) -> Chapter:
    """The spring calibrated on all of a diagnosed record, and on its first cycle."""
    cycles = whole.record.cycles
    first, last = cycles[0], cycles[-1]
    early = calibrated(whole, EFFECT, (first,))
    return Chapter(whole, calibrated(whole, EFFECT, cycles)[0][PARAMETER], early[0][PARAMETER], early[1],
                   (first, last))  # fmt: skip


def findings(chapter: Chapter) -> list[Finding]:
    """What the article says of the spring, judged by what was found in the record."""
    diagnosis = chapter.whole.diagnosis
    members = next((group for group in diagnosis.equivalent if EFFECT in group), ())
    low, high = chapter.stiffness.interval95
    first, last = chapter.cycles
    late = chapter.differences(last)
    slip, energy = late["slip_amplitude_um"], late["dissipated_energy_percent"]
    shrink = diagnosis.shrink
    return [
        Finding(
            "A compliance explains the gap",
            f"{diagnosis.verdict}: {', '.join(members) or diagnosis.causes[0].effect}",
            diagnosis.verdict == "explained" and EFFECT in members,
        ),
        Finding(
            "The record does not distinguish a spring from a rotation",
            f"rotational_compliance {'is' if 'rotational_compliance' in members else 'is not'} in its class",
            "rotational_compliance" in members,
        ),
        Finding(
            f"The spring is that of {STIFFNESS_N_per_mm:g} N/mm",
            f"{chapter.stiffness.value:.4g} N/mm ({low:.4g} to {high:.4g}) from the whole record",
            abs(chapter.stiffness.value / STIFFNESS_N_per_mm - 1.0) < TOLERANCE and low < STIFFNESS_N_per_mm < high,
        ),
        Finding(
            f"The loops of cycle {counted(first)} suffice to calibrate it",
            f"{chapter.early_stiffness.value:.4g} N/mm from them alone",
            abs(chapter.early_stiffness.value / STIFFNESS_N_per_mm - 1.0) < TOLERANCE,
        ),
        Finding(
            f"So calibrated, the model predicts cycle {counted(last)}",
            f"slip off by {slip[0]:.2g} → {slip[1]:.2g} µm, energy by {energy[0]:.2g} → {energy[1]:.2g} %",
            slip[1] < LEFT_OVER * slip[0] and energy[1] < LEFT_OVER * energy[0],
        ),
        Finding(
            "The gap on cycles left out of the fit shrinks to its floor",
            f"{shrink.before:.2f} → {shrink.after:.2f} scatters, floor {shrink.floor:.2f}",
            shrink.after <= 1.2 * shrink.floor,
        ),
    ]


def picture(chapter: Chapter) -> Figure:
    """Measured loops, the rigid model, and the one calibrated on the first cycle."""
    figure = new_figure(3.2)
    panels = figure.subplots(1, 2, sharey=True)
    at = np.array(chapter.cycles, dtype=float)
    first = f"calibrated on cycle {counted(chapter.cycles[0])}"
    curves = [("rigid model", chapter.whole.setup), (first, chapter.calibrated)]
    dashes: tuple[LineStyleType, ...] = ("-", "--")
    for row, (axes, cycle) in enumerate(zip(panels, chapter.cycles, strict=True)):
        for loop in (one for one in chapter.whole.record.loops if one.cycle == cycle):
            axes.plot(
                loop.displacement_um,
                loop.tangential_force_N,
                ".",
                ms=2,
                color="#b5b5b5",
                label=chapter.whole.record.name,
            )
        for colour, dash, (label, setup) in zip(VARIANT_COLOURS, dashes, curves, strict=False):
            course = simulate(chapter.whole.states, setup, at)
            x, q = course.displacement_um[row].ravel(), course.tangential_force_N[row].ravel()
            draw_loop(axes, x, q, linestyle=dash, color=colour, linewidth=1.4, label=label)
        name_axes(axes)
        axes.label_outer()
        axes.set_title(f"cycle {counted(cycle)}")
    handles, labels = panels[0].get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside lower center", ncols=3)
    return figure


@click.command(cls=StudyScript)
@click.argument("record_path", metavar="[RECORD]", type=click.Path(path_type=Path), default=EXAMPLE_RECORD)
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/steel_wires_diagnosis"))
def main(record_path: Path, output: Path) -> None:
    """Diagnose the record of a compliant rig against a rigid model."""
    console = wide_console(116)
    prepared_folder(output)
    chapter = chapter_of(diagnose(read_record(record_path), observer_of=ProgressBar))
    written = [*write_diagnosis(chapter.whole, output), save(lambda: picture(chapter), output / "prediction.png")]
    console.print(chapter.whole.diagnosis.sentence)
    judged = findings(chapter)
    console.print(finding_table(judged))
    console.print(f"{sum(finding.holds for finding in judged)} of {len(judged)} hold. Report and picture:")
    for path in written:
        console.print(str(path), soft_wrap=True, highlight=False)


if __name__ == "__main__":
    main()
