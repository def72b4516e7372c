"""`python -m studies.challenge`: make, pack, answer and score the challenge."""

from math import inf
from pathlib import Path

import click

from studies import challenge
from studies.blind.batch import diagnosing_tasks, run_tasks
from studies.blind.errors import BlindError
from studies.blind.scoring.answers import NONE
from studies.blind.scoring.table import share_text
from studies.json_files import read_json
from wirewear.app.cli import prepare_streams
from wirewear.app.cli.group import Commands
from wirewear.base.engine import engine_of
from wirewear.base.writing import json_text, write_text

folder = click.argument("folder", type=click.Path(path_type=Path))
keys_option = click.option("--keys", type=click.Path(path_type=Path), required=True, help="Folder of the keys.")


@click.group(cls=Commands)
def main() -> None:
    """A public challenge of sealed records."""


@main.command()
@folder
@keys_option
@click.option("--seed", type=click.IntRange(0), required=True, help="Of all that is drawn; keep it secret.")
@click.option("--part", "chosen", type=click.Choice([*challenge.PARTS]), multiple=True, help="Only this part.")
def make(folder: Path, keys: Path, seed: int, chosen: tuple[str, ...]) -> None:
    """Make the records in FOLDER; the same command continues one that was interrupted."""
    challenge.make(folder, keys, seed, chosen or tuple(challenge.PARTS), click.echo)


@main.command()
@folder
@click.argument("archive", type=click.Path(path_type=Path))
@click.option("--seal", is_flag=True, help="Note the hashes of a new challenge as those that are published.")
def pack(folder: Path, archive: Path, seal: bool) -> None:
    """Write FOLDER as an archive that is ready for upload, without keys."""
    if seal:
        write_text(challenge.SEALED, json_text(challenge.seals_of(folder), indent=1) + "\n")
    challenge.require_sealed(folder)
    click.echo(f"{archive}: SHA-256 {challenge.pack(folder, archive)}")


@main.command()
@folder
@click.argument("answers", type=click.Path(path_type=Path))
@click.option("--diagnoses", type=click.Path(path_type=Path), help="wirewear's answers, made or continued there.")
@click.option("--nearest", type=click.Path(path_type=Path), help="Nearest neighbours in this opened challenge.")
@click.option("--keys", type=click.Path(path_type=Path), help="Keys of the opened challenge.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Records side by side.")
def answer(
    folder: Path, answers: Path, diagnoses: Path | None, nearest: Path | None, keys: Path | None, jobs: int
) -> None:
    """Write the file ANSWERS of wirewear or a baseline; without an option that of one that never sees a gap."""
    rows = [(name, NONE, 1.0) for name in challenge.records_of(folder)]
    if nearest is not None and keys is not None:
        rows = challenge.nearest(folder, nearest, keys)
    if diagnoses is not None:
        rows = []
        for part in challenge.seals_of(folder):
            own = (diagnoses / part).resolve()
            run_tasks(diagnosing_tasks((folder / part).resolve(), own), engine_of(jobs, None), part, inf)
        for name in challenge.records_of(folder):
            if (path := diagnoses / name / "diagnosis.json").exists():
                rows += challenge.rows_of(name, read_json(path, BlindError, "diagnosis"))
    challenge.write_answers(answers, rows)


@main.command()
@folder
@click.argument("answers", type=click.Path(path_type=Path))
@keys_option
def score(folder: Path, answers: Path, keys: Path) -> None:
    """Print the score of the file ANSWERS."""
    for name, found in challenge.score(folder, keys, challenge.read_answers(answers)).items():
        click.echo(f"{name:24} {share_text(found) if isinstance(found, dict) else f'{found or 0.0:.3f}'}")


if __name__ == "__main__":
    prepare_streams()
    main(prog_name="python -m studies.challenge")
