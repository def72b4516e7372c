"""A scored batch by the diagnosis's own deviations: how much of each gap stands out of all that it takes for no gap.

    python -m studies.blind.own_sizes BATCH DIAGNOSES [--write SUMMARY]

Opens the key of a batch that was scored. Fair sizes (fair_sizes.py) count what no diagnosis can know. These count what
this one does not: how far solvers differ, and a scatter that one specimen cannot tell. True effects act in the fast
model. The distance is whitened by the record's own covariance. A pair is imitated by each of its effects alone, what
was left out of the library by each effect that was not. The fast model does not know what is in no library: its size is
that of the record itself, the squared distance that the best effect leaves less that of chance.
"""

from dataclasses import replace
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from rich import box
from rich.table import Table

from studies.blind import default_key_path, verified
from studies.blind.generators.cases import Case, exact_class
from studies.blind.make import KEY
from studies.blind.scoring.answers import read_answers, require_any
from studies.blind.scoring.score import judge_all
from studies.blind.sealing import opened, read_key_file
from wirewear import WirewearError, read_record
from wirewear.diagnosis.diagnose import reduced_record
from wirewear.diagnosis.infer.covariance import Covariance, estimate
from wirewear.diagnosis.infer.inference import Problem, fit
from wirewear.diagnosis.model.candidates import Candidate, effect_of, library
from wirewear.effects import effect_named
from wirewear.faces.study_script import StudyScript, wide_console

from .answering import write_json
from .fair_sizes import case_of_key, figures


def own_size(case: Case, problem: Problem, covariance: Covariance) -> dict[str, float]:
    """Distances, in standard deviations, that are left of a case's gap: `all`, and with specimens and noise alone.

    Without solver differences nothing is imitated: that figure only tells how much they take.
    """
    if case.kind == "outside":
        left = min(fit(problem, [one]).distance2 for one in _allowed(case, problem))
        return {"all": round(max(left - len(problem.layout), 0.0) ** 0.5, 2)}
    changed = problem.setup
    for one in case.effects:
        changed = changed.with_effect(effect_named(one.effect)(**one.parameters))
    truth = problem.predicted(changed)
    told = replace(problem, mean=truth)
    sure = Problem.of(
        problem.states,
        problem.setup,
        problem.layout,
        replace(covariance, mean=truth, total=covariance.total - covariance.numerical - covariance.tolerated),
    )
    imitations = [fit(told, [one]).distance2 for one in _allowed(case, problem)]
    least = min([_squared(told.whitened(told.setup)), *imitations])
    return {"all": round(least**0.5, 2), "without_solvers": round(_squared(sure.whitened(sure.setup)) ** 0.5, 2)}


def _squared(residual: NDArray[np.float64]) -> float:
    return float(residual @ residual)


def _allowed(case: Case, problem: Problem) -> list[Candidate]:
    """Effects that may imitate a case's."""
    if case.kind == "single":
        return []
    if case.kind == "pair":
        own = {one.effect for one in case.effects}
        return [one for one in library(problem.setup) if effect_of(one.name) in own]
    barred = {name for one in case.left_out for name in exact_class(one)}
    return [one for one in library(problem.setup) if effect_of(one.name) not in barred]


def sizes_of(batch: Path) -> dict[str, dict[str, float]]:
    """Own sizes by case."""
    key = opened((batch / KEY).read_bytes(), read_key_file(default_key_path(batch)), str(batch / KEY))
    found = {}
    for truth in key["truths"]:
        case = case_of_key(truth)
        if not case.effects:
            continue
        try:
            nominal, observed = reduced_record(read_record(batch / case.name))
            covariance = estimate(nominal.states, nominal.setup, observed)
            problem = Problem.of(nominal.states, nominal.setup, observed.layout, covariance)
            found[case.name] = own_size(case, problem, covariance)
        except (WirewearError, np.linalg.LinAlgError) as error:
            click.echo(f"{case.name}: {error}", err=True)
    return found


@click.command(cls=StudyScript)
@click.argument("batch", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("diagnoses", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--write", type=click.Path(file_okay=False, path_type=Path), help="Folder for own_sizes.json.")
def main(batch: Path, diagnoses: Path, write: Path | None) -> None:
    """The figures of BATCH, whose records were answered in DIAGNOSES, by the diagnosis's own deviations."""
    truths = verified(batch, default_key_path(batch)).truths
    answers = read_answers(diagnoses, [truth.case for truth in truths])
    require_any(answers, diagnoses, batch)
    sizes = sizes_of(batch)
    sized = [
        replace(truth, gap_in_scatter=sizes.get(truth.case, {}).get("all", truth.gap_in_scatter)) for truth in truths
    ]
    judged = judge_all(sized, answers)
    own = figures(judged)
    table = Table("figure", "by own deviations", box=box.SIMPLE_HEAD)
    for name, text in own.items():
        table.add_row(name, text)
    wide_console(140).print(table)
    missed = [one.truth for one in judged if one.truth.kind in ("single", "outside") and not one.first_right]
    table = Table("missed", "effect", "own size", "with solvers alike", box=box.SIMPLE_HEAD)
    for truth in missed:
        if truth.case in sizes:
            table.add_row(truth.case, truth.effects[0], *(f"{size:.1f}" for size in sizes[truth.case].values()))
    wide_console(140).print(table)
    if write is not None:
        write_json(write / "own_sizes.json", {"figures": own, "sizes": sizes})


if __name__ == "__main__":
    main()
