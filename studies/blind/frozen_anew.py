"""The frozen records of T0 and T1, made again from their batches' seeds by the program as it is.

    python -m studies.blind.frozen_anew FOLDER --tier T1 [--article] [--pack]

A batch's seed gives its cases again: specimens, noise, channels, sizes. So a frozen record can be made anew when the
solver that made it has changed; its truth stays. `--pack` puts FOLDER's records into frozen_records/TIER.tar.xz, those
that were not made anew as they are there.
"""

import tarfile
from collections.abc import Iterator
from pathlib import Path

import click

from studies.blind.errors import BlindError
from studies.blind.generators.cases import Case, planned_cases
from studies.blind.generators.files import write_traceless
from studies.blind.generators.finite_element.model import FiniteElementModel
from studies.blind.generators.generator import Generator
from wirewear.base.writing import prepared_folder
from wirewear.faces.study_script import StudyScript

from .frozen import FOLDER, FrozenRecord, frozen_records, unpack

#: Number of cases, seed and number of nominal tests of the batches that frozen records come from.
BATCHES = {
    "T0_third": (40, 118823, 2),
    "T1_third": (100, 651908, 2),
    "T1_fourth": (40, 905112, 2),
    "T2_third": (60, 733201, 3),
}

REFERENCE_SHARE = 0.4  #: The article's share of the cases at least, of all of them.


def cases_of(records: tuple[FrozenRecord, ...], model: Generator) -> Iterator[tuple[FrozenRecord, Case]]:
    """Each record with the case that it was made from.
    Raises BlindError if the generator draws other cases than it did.
    """
    planned = {
        batch: {
            case.name: case
            for case in planned_cases(
                count, seed, model.library, model.outside, tests, model.nominals, reference_share=REFERENCE_SHARE
            )
        }
        for batch, (count, seed, tests) in BATCHES.items()
        if batch.startswith(model.tier)
    }
    for one in records:
        batch, _, name = one.name.partition("-")
        case = planned[batch][name]
        if {effect.effect: dict(effect.parameters) for effect in case.effects} != dict(one.truth.parameters):
            raise BlindError(f"the seed of {one.name} gives other effects than its truth.")
        yield one, case


def pack(tier: str, folder: Path) -> None:
    """Put all records of a tier in `folder` into its archive."""
    with tarfile.open(FOLDER / f"{tier}.tar.xz", "w:xz") as archive:
        for path in sorted(folder.iterdir()):
            archive.add(path, arcname=path.name, filter=_nobodys)


def _nobodys(member: tarfile.TarInfo) -> tarfile.TarInfo:
    member.uid = member.gid = 0
    member.uname = member.gname = ""
    return member


@click.command(cls=StudyScript)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--tier", type=click.Choice(("T0", "T1")), required=True)
@click.option("--article", is_flag=True, help="Only records of the article's nominal test.")
@click.option("--pack", "is_packed", is_flag=True, help="Put FOLDER's records into the archive.")
def main(folder: Path, tier: str, article: bool, is_packed: bool) -> None:
    """Make the frozen records of a tier again in FOLDER; those that are there already stay."""
    prepared_folder(folder)
    model = FiniteElementModel(tier, several=0.0)
    for one, case in cases_of(frozen_records((tier,), article_only=article), model):
        if not (folder / one.name).exists():
            write_traceless(folder / one.name, model.make(case).record)
            click.echo(one.name)
    if is_packed:
        unpack([one for one in frozen_records((tier,)) if not (folder / one.name).exists()], folder)
        pack(tier, folder)


if __name__ == "__main__":
    main()
