"""Rigid and compliant rig side by side, as the article's Figures 8–10 show them, and its figures and findings checked.

    python studies/steel_wires/compare.py RESULT_DIR [--output DIR]

RESULT_DIR is the folder that `wirewear run` left of study.toml, with the variants "rigid" and "compliant". Every
verdict is computed from these results. Both runs are also set beside an experiment record, in the folders record_rigid
and record_compliant. It is no measurement: others simulated a rig of 167 N/mm, whose owner believes it rigid. The
article: Infante-García et al., On the Role of Contact and System Stiffness in the Measurement of Principal Variables in
Fretting Wear Testing, Sensors 2020, 20(15), 4152.
"""

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import click
from matplotlib.figure import Figure

from wirewear import ExperimentRecord, read_record
from wirewear.app.cli.consoles import wide_console
from wirewear.comparison.comparison import RecordComparison, compare
from wirewear.pictures import amplitude_evolution, loops_by_cycle, save, scar_sections
from wirewear.views.comparison_page import write_comparison

if not __package__:
    # Run by its path, as `make run` does: its neighbours are found from the root of the repository.
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
    __package__ = "studies.steel_wires"

from studies.study_script import StudyScript
from studies.verdicts import Finding, comparison_table, finding_table

from .closed_forms import first_loop_comparisons, volume_comparisons, worn_friction_comparison
from .findings import FINDINGS
from .pair import EARLY, LATE, Pair, read_pair

#: A record of a rig like the compliant one, made by an independent simulator; see the README beside it.
EXAMPLE_RECORD = Path(__file__).parent / "example_records" / "rigid_stated_compliant_rig"


def beside_record(pair: Pair, record: ExperimentRecord) -> dict[str, RecordComparison]:
    """Both runs compared with a record, by variant."""
    return {run.variant: compare(run, record) for run in pair.runs}


def compliant_run_is_nearer(comparisons: dict[str, RecordComparison]) -> Finding:
    """Finding whether the record of a compliant rig is nearer to the compliant run than to the rigid one at every
    recorded cycle, by the force at equal phase. comparisons: of the record, by the run's variant.
    """
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


def pictures(pair: Pair) -> dict[str, Callable[[], Figure]]:
    """The three figures by file name."""
    return {
        "loops": partial(loops_by_cycle, pair.runs, (EARLY, LATE)),
        "amplitudes": partial(amplitude_evolution, pair.runs),
        "scar_sections": partial(scar_sections, pair.runs, (EARLY, LATE)),
    }


@click.command(cls=StudyScript)
@click.argument("result_dir", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path), help="Picture folder.  [default: RESULT_DIR/comparison]")
def main(result_dir: Path, output: Path | None) -> None:
    """Set rigid and compliant rig side by side."""
    folder = output or result_dir / "comparison"
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
