"""Does the full simulation with the named effects shrink the gap as the diagnosis predicts?

    python -m studies.diagnosis.confirmed_shrinks OUTPUT RECORD... [--most 30]

Diagnoses records until so many name effects whose gap shows on cycles left out of the fit, and confirms each. OUTPUT
keeps an answer a record, so that an interrupted run goes on with the same command.
"""

import json
from pathlib import Path
from typing import Any

import click
from rich import box
from rich.table import Table

from studies.json_files import read_json
from studies.study_script import StudyScript, understanding
from wirewear import RecordError, ResultError, WirewearError, read_record
from wirewear.app.cli.consoles import wide_console
from wirewear.base.writing import prepared_folder, write_text
from wirewear.diagnosis import confirmed, diagnose

WITHIN = 0.05  #: A shrink predicted within so much of the one achieved counts as predicted.


def answered(kept: Path, record: Path) -> dict[str, Any]:
    """What was predicted of a record and what was achieved, by figure; neither where nothing is to be confirmed."""
    if kept.exists():
        known: dict[str, Any] = read_json(kept, ResultError, "file of shrinks")
        return known
    found = diagnose(read_record(record))
    diagnosis, shrink = found.diagnosis, found.diagnosis.shrink
    answer: dict[str, Any] = {"verdict": diagnosis.verdict, "effects": list(found.search.best.names)}
    if diagnosis.verdict in ("explained", "ambiguous") and shrink.shows_gap:
        achieved = confirmed(found).diagnosis.confirmed
        if achieved is not None:
            answer |= {"before": shrink.before, "floor": shrink.floor, "predicted": shrink.predicted}
            answer |= {"achieved": achieved.shrink, "after": achieved.after}
    kept.parent.mkdir(parents=True, exist_ok=True)
    write_text(kept, json.dumps(answer, indent=1) + "\n")
    return answer


@click.command(cls=StudyScript)
@click.argument("output", type=click.Path(path_type=Path))
@click.argument("records", nargs=-1, required=True, type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--most", type=click.IntRange(1), default=30, show_default=True, help="Then stop.")
def main(output: Path, records: tuple[Path, ...], most: int) -> None:
    """Confirm what RECORDS are named for, and print predicted and achieved shrinks."""
    table = Table("record", "named", "gap before → after (floor)", "predicted", "achieved", box=box.SIMPLE_HEAD)
    off: list[float] = []
    for record in records:
        kept = prepared_folder(output) / f"{record.parent.parent.name}_{record.name}.json"
        try:
            one = answered(kept, record)
        except WirewearError as problem:
            click.echo(f"{record}: {problem}")
            continue
        with understanding(kept, "file of this script's shrinks"):
            if "achieved" not in one:
                continue
            off.append(abs(one["achieved"] - one["predicted"]))
            gap = f"{one['before']:.2f} → {one['after']:.2f} ({one['floor']:.2f})"
            shrinks = f"{one['predicted']:.2f}", f"{one['achieved']:.2f}"
            table.add_row(record.name, " + ".join(one["effects"]), gap, *shrinks)
        click.echo(f"{record.name}: predicted {one['predicted']:.2f}, achieved {one['achieved']:.2f}")
        if len(off) == most:
            break
    if not off:
        raise RecordError("none of these records shows a gap that an effect is named for.")
    console = wide_console(120)
    console.print(table)
    within = sum(one <= WITHIN for one in off)
    console.print(f"{within} of {len(off)} within {100 * WITHIN:.0f} points.", highlight=False)


if __name__ == "__main__":
    main()
