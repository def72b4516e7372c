"""Does the diagnosis blame the specimens for what is odd about a sound rig?

    python -m studies.diagnosis.odd_rigs OUTPUT [--effects N] [--seed S] [--jobs J]

Ten tests are drawn, then three more, and one rig for each, odd in its own way (oddities.py). The independent model of
the blind check makes a gap-free record of each, and records with so many effects of the library, easy to see. An answer
is a wrong name where it names an effect that is not in the record. OUTPUT keeps records and diagnoses.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import click
import numpy as np
from rich import box
from rich.table import Table

from studies.blind import LIBRARY_EFFECTS, Judgement, Truth
from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.nuisances import Nuisances
from studies.blind.generators.sizes import drawn_parameters
from studies.blind.generators.tiers import generator_of
from studies.blind.scoring.answers import FILE_NAME, Answer, read_answers
from studies.blind.scoring.judging import judged
from wirewear import WirewearError, read_record, write_record
from wirewear.base.engine import engine_of
from wirewear.base.writing import prepared_folder
from wirewear.diagnosis import diagnose, write_diagnosis
from wirewear.faces.study_script import StudyScript, wide_console

from .gap_free import drawn_tests, of_a_rig, wires_of
from .oddities import FURTHER, ODDITIES, RIGS

LAW = "dahl"  #: Friction law of the independent model.


def planned(effects: int, seed: int) -> Iterator[tuple[str, Case]]:
    """Oddities with the cases that are made odd."""
    random = np.random.default_rng(seed)
    order = random.permutation(LIBRARY_EFFECTS).tolist()
    tests = (*drawn_tests(len(ODDITIES), seed), *drawn_tests(len(FURTHER), seed))
    for place, (test, oddity) in enumerate(zip(tests, (*ODDITIES, *FURTHER), strict=True)):
        names = [None, *(order[(effects * place + turn) % len(order)] for turn in range(effects))]
        for name in names:
            case = of_a_rig(test, f"rig_{place + 1:02d}_{name or 'none'}", (seed, place))
            if name is not None:
                effect = TrueEffect(name, drawn_parameters(name, "easy", test, random))
                case = replace(case, kind="single", ease="easy", effects=(effect,))
            yield oddity, replace(case, nuisances=RIGS.get(oddity, _as_drawn)(case.nuisances))


def _as_drawn(nuisances: Nuisances) -> Nuisances:
    return nuisances


def made(folder: Path, oddity: str, case: Case, seed: int) -> None:
    """Write the odd record of a case into the folder."""
    record = wires_of(generator_of("T2", law=LAW).make(case).record)
    write_record(folder, {**ODDITIES, **FURTHER}[oddity](record, np.random.default_rng((seed, case.seed))))


def diagnosed(output: Path, oddity: str, case: Case, seed: int) -> str | None:
    """Make a record and diagnose it, unless that was done; the sentence of a refusal."""
    return answered(output, case, partial(made, oddity=oddity, case=case, seed=seed))


def answered(output: Path, case: Case, make: Callable[[Path], object]) -> str | None:
    """Have a case's record made in its folder and diagnose it, unless that was done; the sentence of a refusal."""
    record, answer = output / "records" / case.name, output / "diagnoses" / case.name
    try:
        if not (record / "experiment.toml").exists():
            make(record)
        if not (answer / FILE_NAME).exists():
            write_diagnosis(diagnose(read_record(record)), answer)
    except WirewearError as problem:
        return f"{case.name}: {problem}"
    return None


def judgement_of(answers: Mapping[str, Answer | None], case: Case) -> Judgement:
    """The answer on a case, judged; how large its gap is plays no part."""
    effects = tuple(one.effect for one in case.effects)
    parameters = {one.effect: one.parameters for one in case.effects}
    return judged(Truth(case.name, case.kind, case.ease, effects, parameters, math.nan), answers[case.name])


def result_of(judgement: Judgement) -> str:
    """Right, a wrong name, or what else an answer is."""
    if judgement.answer is None:
        return "refused"
    if judgement.first_right:
        return "right"
    if judgement.effect_named:
        return "WRONG NAME"
    return judgement.answer.verdict.replace("_", " ")


@click.command(cls=StudyScript)
@click.argument("output", type=click.Path(path_type=Path))
@click.option("--effects", type=click.IntRange(0), default=2, show_default=True, help="Records with an effect a rig.")
@click.option("--seed", type=click.IntRange(0), default=9, show_default=True)
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Records side by side.")
def main(output: Path, effects: int, seed: int, jobs: int) -> None:
    """Make odd records in OUTPUT, diagnose them, and say how many names are wrong."""
    prepared_folder(output)
    cases = list(planned(effects, seed))
    for done in engine_of(jobs).done([partial(diagnosed, output.resolve(), *one, seed) for one in cases]):
        if refused := done.value():
            click.echo(refused)
    answers = read_answers(output / "diagnoses", [case.name for _, case in cases])
    table = Table("rig", "what is odd", "effect in it", "answer", "judged", box=box.SIMPLE_HEAD)
    results = Counter[str]()
    for oddity, case in cases:
        judgement = judgement_of(answers, case)
        result = result_of(judgement)
        results[result] += 1
        truth = ", ".join(one.effect for one in case.effects) or "none"
        table.add_row(case.name[4:6], oddity, truth, judgement.said, result)
    console = wide_console(150)
    console.print(table)
    console.print(", ".join(f"{count} {result}" for result, count in results.most_common()), highlight=False)


if __name__ == "__main__":
    main()
