"""Is an effect's cause recognised where its law is another one than the library's?

    python -m studies.diagnosis.other_laws OUTPUT [--tests N] [--seed S] [--jobs J]

Rough layers, third bodies, friction and wear that run in: each by five laws of other form (laws_of_other_form.py), in
every test of a Latin hypercube, as rigs of blind batches would record it. Sizes are fair ones: standard deviations
from what no effect would give. OUTPUT keeps records and diagnoses.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import click
import numpy as np
from rich import box
from rich.table import Table

from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.independent.fair_size import fair_size
from studies.blind.generators.sizes import drawn_parameters
from studies.blind.scoring.answers import read_answers
from wirewear import write_record
from wirewear.base.engine import engine_of
from wirewear.base.writing import prepared_folder
from wirewear.faces.study_script import StudyScript, wide_console

from .gap_free import drawn_tests, of_a_rig, wires_of
from .laws_of_other_form import LAWS, ModelOfOtherForm
from .odd_rigs import answered, judgement_of, result_of

FRICTION_LAW = "dahl"  #: Friction law of the independent model.
LARGE = 5.0  #: Gaps above so many standard deviations are counted apart.


def planned(tests: int, seed: int) -> Iterator[tuple[ModelOfOtherForm, Case]]:
    """Every law in every test, at a size that is easy to see."""
    for place, test in enumerate(drawn_tests(tests, seed)):
        for effect, laws in LAWS.items():
            for turn, law in enumerate(laws):
                name = f"test_{place + 1:02d}_{effect}_{law.replace(' ', '_')}"
                random = np.random.default_rng((seed, place, turn, len(effect)))
                case = of_a_rig(test, name, (seed, place, turn, len(effect)))
                true = TrueEffect(effect, drawn_parameters(effect, "easy", test, random))
                yield (
                    ModelOfOtherForm(FRICTION_LAW, form=(effect, law)),
                    replace(case, kind="single", ease="easy", effects=(true,)),
                )


def diagnosed(output: Path, model: ModelOfOtherForm, case: Case) -> tuple[float, str | None]:
    """Make a record and diagnose it, unless that was done; its fair size, and the sentence of a refusal."""
    return fair_size(case, model), answered(
        output, case, lambda folder: write_record(folder, wires_of(model.make(case).record))
    )


@click.command(cls=StudyScript)
@click.argument("output", type=click.Path(path_type=Path))
@click.option("--tests", type=click.IntRange(1), default=4, show_default=True, help="Tests, each with twenty records.")
@click.option("--seed", type=click.IntRange(0), default=23, show_default=True)
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Records side by side.")
def main(output: Path, tests: int, seed: int, jobs: int) -> None:
    """Make records by other laws in OUTPUT, diagnose them, and say how many are named rightly."""
    prepared_folder(output)
    plan = list(planned(tests, seed))
    tasks = [partial(diagnosed, output.resolve(), *one) for one in plan]
    sizes: dict[int, float] = {}
    for done in engine_of(jobs).done(tasks):
        sizes[done.place], refused = done.value()
        if refused:
            click.echo(refused)
    answers = read_answers(output / "diagnoses", [case.name for _, case in plan])
    table = Table("effect", "law", "test", "size", "answer", "judged", box=box.SIMPLE_HEAD)
    large = Counter[str]()
    for place, (model, case) in enumerate(plan):
        judgement = judgement_of(answers, case)
        result = result_of(judgement)
        if sizes[place] > LARGE:
            large[result] += 1
        table.add_row(*model.form, case.name[5:7], f"{sizes[place]:.1f}", judgement.said, result)
    console = wide_console(150)
    console.print(table)
    told = ", ".join(f"{count} {result}" for result, count in large.most_common())
    console.print(f"above {LARGE:g}: {told} of {large.total()}", highlight=False)


if __name__ == "__main__":
    main()
