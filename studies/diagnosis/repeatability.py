"""How well observables are read: what repeats of records differ by, less their scatter, over the noise expected.

    python -m studies.diagnosis.repeatability FOLDER...

FOLDERS hold records without a gap, or with one: repeats of one record share it. For each observable the table gives the
factor on the variance of the noise that repeats ask for, and how far single records depart from it beside chance.
"""

from collections import defaultdict
from pathlib import Path

import click
import numpy as np
from rich import box
from rich.table import Table

from studies.study_script import StudyScript
from wirewear import RecordError, WirewearError, read_record
from wirewear.app.cli.consoles import wide_console
from wirewear.diagnosis import prepared
from wirewear.diagnosis.infer.covariance import NoiseEvidence, estimate, noise_evidence


def evidence_of(path: Path) -> dict[str, NoiseEvidence]:
    """What the repeats of one record show of each observable.
    Raises WirewearError if the record cannot be read or its nominal model not be run.
    """
    read = prepared(read_record(path))[0].reduced()
    return noise_evidence(read.observed, estimate(read.states, read.setup, read.observed).between)


@click.command(cls=StudyScript)
@click.argument("folders", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
def main(folders: tuple[Path, ...]) -> None:
    """Factors on the noise of each observable by the repeats of the records in FOLDERS."""
    found: dict[str, list[NoiseEvidence]] = defaultdict(list)
    for path in sorted(path.parent for folder in folders for path in folder.glob("*/experiment.toml")):
        try:
            for name, evidence in evidence_of(path).items():
                found[name].append(evidence)
        except WirewearError as problem:
            click.echo(f"{path.name}: {problem}")
    if not any(evidence.weight for own in found.values() for evidence in own):
        raise RecordError("these folders hold no record with several repeats that can be read.")
    table = Table("observable", "records", "numbers each", "factor", "spread", "by chance", box=box.SIMPLE_HEAD)
    for name, own in found.items():
        seen = [evidence for evidence in own if evidence.weight > 0.0]
        if not seen:
            continue
        weights = np.array([evidence.weight for evidence in seen])
        factor = float(1.0 + sum(evidence.more for evidence in seen) / weights.sum())
        spread = float(np.std([1.0 + evidence.more / evidence.weight for evidence in seen]))
        chance = float(np.sqrt(np.mean(2.0 * factor**2 / weights)))
        table.add_row(name, *(f"{v:.2f}" if i else f"{v:.0f}" for i, v in enumerate((len(seen), np.mean(weights)))),
                      *(f"{v:.2f}" for v in (factor, spread, chance)))  # fmt: skip
    wide_console(100).print(table)


if __name__ == "__main__":
    main()
