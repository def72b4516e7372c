"""How far 95 % intervals of parameters would have to reach, by effect, on spent batches.

    python -m studies.blind.intervals --answered BATCH DIAGNOSES [--answered BATCH DIAGNOSES]...

A distance of one is an interval's end. The table says how many of them hold the truth as they stand, and stretched by
the factors given: those in use stand in calibration.toml (`report.values`).
"""

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
from rich import box
from rich.table import Table

from studies.blind import default_key_path, verified
from studies.blind.errors import BlindError
from studies.json_files import read_json
from studies.study_script import StudyScript, understanding
from wirewear.app.cli.consoles import wide_console
from wirewear.effects import Parameter, all_effects

KINDS = ("single", "pair")  #: Kinds of records whose parameters are estimated.


def distance(parameter: Parameter, value: float, interval95: tuple[float, float], true: float) -> float:
    """How far the truth lies from an estimate, in units of the interval's reach to that side."""
    end = interval95[1] if true > value else interval95[0]
    if end == value:
        return 0.0 if true == value else np.inf
    at, own, reach = (parameter.coordinate(one) for one in (true, value, end))
    return abs((at - own) / (reach - own))


def distances(batch: Path, diagnoses: Path) -> Iterator[tuple[str, float]]:
    """Effects of a batch's records with the distance of each parameter of theirs, as their likeliest listing says."""
    known = all_effects()
    for truth in verified(batch, default_key_path(batch)).truths:
        path = diagnoses / truth.case / "diagnosis.json"
        if truth.kind not in KINDS or not path.exists():
            continue
        said = read_json(path, BlindError, "diagnosis")
        for effect, values in truth.parameters.items():
            own = known[effect].parameters()
            with understanding(path, "diagnosis"):
                named = [cause["parameters"] for cause in said["causes"] if cause["effect"] == effect]
                found = [
                    distance(own[name], one["value"], tuple(one["interval95"]), true)
                    for name, true in values.items()
                    if named and (one := named[0].get(name)) is not None
                ]
            yield from ((effect, far) for far in found)


@click.command(cls=StudyScript)
@click.option("--answered", "batches", type=(Path, Path), multiple=True, required=True, metavar="BATCH DIAGNOSES")
@click.option("--stretch", type=float, default=1.0, show_default=True, help="Of every effect's intervals.")
@click.option("--of", "own", type=(str, float), multiple=True, metavar="EFFECT FACTOR", help="Of one effect's instead.")
def main(batches: tuple[tuple[Path, Path], ...], stretch: float, own: tuple[tuple[str, float], ...]) -> None:
    """Print how many intervals hold, by effect."""
    factors = dict(own)
    found: defaultdict[str, list[float]] = defaultdict(list)
    for batch, diagnoses in batches:
        for effect, far in distances(batch, diagnoses):
            found[effect].append(far)
    if not found:
        raise BlindError("no diagnosis of these batches estimates a parameter of an effect that is there.")
    table = Table("effect", "intervals", "hold", "stretched", "farthest", box=box.SIMPLE_HEAD)
    held = np.zeros(2, dtype=int)
    for effect, own_distances in sorted(found.items()):
        ordered = np.sort(own_distances)
        within = np.array([np.sum(ordered <= factor) for factor in (1.0, factors.get(effect, stretch))])
        held += within
        farthest = ", ".join(f"{one:.2f}" for one in ordered[-3:])
        table.add_row(effect, str(ordered.size), *map(str, within), farthest)
    count = sum(map(len, found.values()))
    table.add_row("all", str(count), *(f"{one} ({one / count:.0%})" for one in held), "")
    wide_console(100).print(table)


if __name__ == "__main__":
    main()
