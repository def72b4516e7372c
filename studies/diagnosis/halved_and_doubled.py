"""What answers do when each tuned number of the diagnosis is halved, and when it is doubled.

    python -m studies.diagnosis.halved_and_doubled OUTPUT RECORD... [--jobs 2]

Every number is changed alone, in a process of its own, and all records are diagnosed with it. OUTPUT keeps the answers,
so that an interrupted run goes on with the same command, and a table: in how many records the verdict or the likeliest
cause is another one, and by how much the probability of any cause changes at most.
"""

import csv
from collections.abc import Mapping, Sequence
from functools import partial
from io import StringIO
from pathlib import Path

import click

from studies.study_script import StudyScript
from wirewear import RecordError
from wirewear.base.engine import LocalProcesses
from wirewear.base.writing import prepared_folder, write_text
from wirewear.diagnosis.calibration import Constant, all_constants, scale

FACTORS = {"as it is": 1.0, "halved": 0.5, "doubled": 2.0}
TABLE = "halved_and_doubled.csv"

Probabilities = Mapping[str, float]


def diagnosed_with(name: str, factor: float, records: Sequence[Path], diagnoses: Path) -> None:
    """Diagnose records with one constant scaled, in a process that has imported no module which uses it."""
    scale(name, factor)
    from studies.blind.answering import answer, answered

    for record in records:
        if not answered(diagnoses / record.name):
            answer(record, (), diagnoses)


def answers_in(diagnoses: Path, records: Sequence[Path]) -> list[tuple[str, Probabilities]]:
    """Of each record the verdict with the likeliest cause, and all probabilities; a refusal is a verdict, too."""
    from studies.blind.scoring.answers import read_answers

    found = read_answers(diagnoses, [record.name for record in records])
    listed = [
        {} if one is None else {cause.effect: cause.probability for cause in one.causes} for one in found.values()
    ]
    verdicts = ["refused" if one is None else one.verdict for one in found.values()]
    return [
        (f"{verdict}, {max(own, key=own.__getitem__, default='nothing')}", own)
        for verdict, own in zip(verdicts, listed, strict=True)
    ]


def row_of(constant: Constant, output: Path, records: Sequence[Path]) -> dict[str, object]:
    """One line of the table."""
    own = {words: answers_in(_folder(output, constant, words), records) for words in FACTORS}
    row: dict[str, object] = {"constant": constant.name, "value": constant.value, "unit": constant.unit}
    for words in list(FACTORS)[1:]:
        pairs = list(zip(own["as it is"], own[words], strict=True))
        moved = [abs(a.get(name, 0.0) - b.get(name, 0.0)) for (_, a), (_, b) in pairs for name in {*a, *b}]
        row[f"{words}_other_answers"] = sum(before[0] != after[0] for before, after in pairs)
        row[f"{words}_largest_change_of_probability"] = round(max(moved, default=0.0), 3)
    return row


def _folder(output: Path, constant: Constant, words: str) -> Path:
    return output / (words if FACTORS[words] == 1.0 else f"{constant.name} {words}").replace(" ", "_")


@click.command(cls=StudyScript)
@click.argument("output", type=click.Path(path_type=Path))
@click.argument("records", nargs=-1, required=True, type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--jobs", type=click.IntRange(1), default=2, show_default=True, help="Processes.")
def main(output: Path, records: tuple[Path, ...], jobs: int) -> None:
    """Diagnose RECORDS with each tuned number halved and doubled; answers and a table go to OUTPUT."""
    from studies.blind.batch import run_tasks

    if len({record.name for record in records}) < len(records):
        raise RecordError("two of the records have folders of one name: answers are kept by it.")
    prepared_folder(output)
    tuned = [one for one in all_constants() if one.tuned]
    folders = {_folder(output, one, words): (one.name, factor) for one in tuned for words, factor in FACTORS.items()}
    tasks = [partial(diagnosed_with, *changed, records, folder) for folder, changed in folders.items()]
    run_tasks(tasks, LocalProcesses(jobs, tasks_per_process=1), "numbers halved and doubled", float("inf"))
    text = StringIO()
    rows = [row_of(one, output, records) for one in tuned]
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(output / TABLE, text.getvalue())
    click.echo(f"{output / TABLE}: {len(rows)} numbers, {len(records)} records.")


if __name__ == "__main__":
    main()
