"""A scored batch by fair sizes: how much of each gap no imitation takes (generators/independent/fair_size.py).

    python -m studies.blind.fair_sizes BATCH DIAGNOSES [--write SUMMARY]

Opens the key of a batch that was scored. A gap counts as large above 5 standard deviations that the best imitation
leaves, beside the usual count above 5 scatters of one figure.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from rich import box
from rich.table import Table

from studies.blind import Judgement, default_key_path, verified
from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.independent.fair_size import fair_size
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import Nuisances, Scatter
from studies.blind.generators.waveform import Waveform
from studies.blind.make import KEY
from studies.blind.scoring.answers import read_answers, require_any
from studies.blind.scoring.score import judge_all
from studies.blind.scoring.statistics import area_interval, area_under_curve, share
from studies.blind.scoring.table import share_text
from studies.blind.sealing import opened, read_key_file
from wirewear import WirewearError
from wirewear.faces.study_script import StudyScript, wide_console

from .answering import write_json

LARGE, SMALL = 5.0, 2.0  #: Above so many standard deviations a gap is large, above the other one it counts at all.


def case_of_key(truth: Mapping[str, Any]) -> Case:
    """The case that a line of a key describes."""
    known = dict(truth["nuisances"])
    known["scatter"] = Scatter(**known["scatter"])
    known["waveform"] = Waveform(**known["waveform"])
    known["loop_cycles"] = tuple(map(tuple, known["loop_cycles"]))
    known["evolution_cycles"] = tuple(known["evolution_cycles"])
    return Case(
        name=truth["case"],
        kind=truth["kind"],
        ease=truth["ease"],
        effects=tuple(TrueEffect(one["effect"], one["parameters"]) for one in truth["effects"]),
        left_out=tuple(truth["left_out"]),
        nominal=Nominal(**truth["nominal"]),
        nuisances=Nuisances(**known),
        seed=0,
    )


def sizes_of(batch: Path, law: str) -> dict[str, float]:
    """Fair sizes by case."""
    known = verified(batch, default_key_path(batch))
    key = opened((batch / KEY).read_bytes(), read_key_file(default_key_path(batch)), str(batch / KEY))
    model = IndependentModel(law)
    found = {}
    for truth in key["truths"]:
        try:
            found[truth["case"]] = round(fair_size(case_of_key(truth), model), 2)
        except WirewearError as problem:
            click.echo(f"{truth['case']}: {problem}")
    return {truth.case: found.get(truth.case, truth.gap_in_scatter) for truth in known.truths}


def figures(judgements: Sequence[Judgement]) -> dict[str, str]:
    """Figures of gaps by their sizes, as text; sizes are those of the truths."""

    def told(marks: Sequence[bool]) -> str:
        return share_text(share(marks).to_json())

    singles = [one for one in judgements if one.truth.kind == "single"]
    large = [one for one in singles if one.truth.gap_in_scatter > LARGE]
    middle = [one for one in singles if SMALL < one.truth.gap_in_scatter <= LARGE]
    opened_ = [one for one in judgements if one.truth.is_open and one.truth.gap_in_scatter > LARGE]
    known = [one for one in judgements if one.truth.kind in ("single", "pair") and one.truth.gap_in_scatter > LARGE]
    scores = [one.outside_score for one in opened_], [one.outside_score for one in known]
    area, ends = area_under_curve(*scores), area_interval(*scores)
    pairs = [one for one in judgements if one.truth.kind == "pair" and one.truth.gap_in_scatter > 3.0]
    return {
        "class right above 5": told([one.first_right for one in large]),
        "class right from 2 to 5": told([one.first_right for one in middle]),
        "right where named, above 5": told([one.first_right for one in large if one.effect_named]),
        "pairs both named, second above 3": told([one.pair_found == 2 for one in pairs]),
        "outside: unexplained above 5": told([one.rejected for one in opened_ if one.truth.kind == "outside"]),
        "outside: the right seam of those": told([one.right_seam for one in opened_ if one.right_seam is not None]),
        "left out: unexplained or equivalent above 5": told(
            [one.first_right for one in opened_ if one.truth.kind == "left_out"]
        ),
        "area under the ROC above 5": "–"
        if area is None or ends is None
        else f"{area:.3f} ({ends[0]:.2f} to {ends[1]:.2f})",
        "known effects unexplained": told([one.rejected for one in judgements if one.truth.kind in ("single", "pair")]),
    }


@click.command(cls=StudyScript)
@click.argument("batch", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("diagnoses", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--law", default="dahl", show_default=True, help="Friction law that sizes are computed with.")
@click.option("--write", type=click.Path(file_okay=False, path_type=Path), help="Folder for fair_sizes.json.")
def main(batch: Path, diagnoses: Path, law: str, write: Path | None) -> None:
    """The figures of BATCH, whose records were answered in DIAGNOSES, by fair sizes."""
    truths = verified(batch, default_key_path(batch)).truths
    answers = read_answers(diagnoses, [truth.case for truth in truths])
    require_any(answers, diagnoses, batch)
    sizes = sizes_of(batch, law)
    fair = judge_all([replace(truth, gap_in_scatter=sizes[truth.case]) for truth in truths], answers)
    rows = {"by one figure": figures(judge_all(truths, answers)), "by fair size": figures(fair)}
    table = Table("figure", *rows, box=box.SIMPLE_HEAD)
    for name in rows["by fair size"]:
        table.add_row(name, *(row[name] for row in rows.values()))
    wide_console(140).print(table)
    if write is not None:
        write_json(write / "fair_sizes.json", {"law": law, "figures": rows, "sizes": sizes})


if __name__ == "__main__":
    main()
