"""Loops of a real rig whose cause is known: what the diagnosis says of a banded damper with backlash.

    python -m studies.real_rigs.diagnose [--output DIR]

Each record of cases.toml states the fit of another setting, or an ideal slider: what is then not as stated is what was
set, or what its builders wrote of it. DIR gets the records, their diagnoses and answers.csv.
"""

import tomllib
from pathlib import Path
from shutil import copyfile

import click
import numpy as np

from studies.study_script import StudyScript
from wirewear import Record, read_record
from wirewear.base.writing import prepared_folder, write_csv
from wirewear.diagnosis import Diagnosed
from wirewear.diagnosis.wording import explanations, in_words, parameters_in_words
from wirewear.test import AnyStudy
from wirewear.views.diagnosis_page import write_diagnosis

HERE = Path(__file__).parent

#: Effects by which the known causes go, in the words of the library.
CLASSES = {
    "friction": {"friction_offset", "friction_evolution", "normal_load_drift"},
    "play": {"free_play"},
    "none": set[str](),
}

#: What the 30 lb loops of 2023 yield behind an ideal slider, by their diagnosis.
STIFFNESS_N_per_mm = 3400.0

TABLES = """format = 1
name = "{name}"
[contact]
kind = "joint"
[conditions]
displacement_amplitude_um = 25400.0
frequency_Hz = {frequency}
cycles = 7
[stated]
friction_force_N = {force:.0f}.0
tangential_stiffness_N_per_mm = {stiffness}
[files]
loops = "loops.csv"
"""


def plateau_N(file: str) -> float:
    """Friction force in N of the loops of a file: half the distance of their quartiles of force."""
    rows = np.genfromtxt(HERE / "damper" / f"{file}.csv", delimiter=",", skip_header=1)
    return float(np.subtract(*np.percentile(rows[:, 5], [75, 25]))) / 2.0


def record_of(file: str, folder: Path, force_N: float, stiffness: float | str) -> Record:
    """The record of a file whose owner states a friction force and the stiffness of the rig."""
    folder.mkdir(parents=True, exist_ok=True)
    copyfile(HERE / "damper" / f"{file}.csv", folder / "loops.csv")
    frequency = float(file.rsplit("_", maxsplit=1)[-1].removesuffix("Hz"))
    tables = TABLES.format(name=folder.name, frequency=frequency, force=force_N, stiffness=stiffness)
    (folder / "experiment.toml").write_text(tables, encoding="utf-8")
    return read_record(folder)


def diagnosed(file: str, stated: str, folder: Path) -> Diagnosed:
    """The diagnosis of a file; its model is an ideal slider, or the fit of the file `stated`."""
    if stated == "slider":
        return record_of(file, folder, plateau_N(file), '"rigid"').diagnose(progress=False)
    force_N, stiffness = plateau_N(stated), STIFFNESS_N_per_mm
    model: AnyStudy = record_of(stated, folder / "stated", force_N, stiffness).fit(progress=False).study
    return record_of(file, folder, force_N, stiffness).diagnose(model=model, progress=False)


def answer(found: Diagnosed, cause: str) -> dict[str, object]:
    """One row of the table: what the answer names, its value, and whether the known cause is among it."""
    own = found.diagnosis
    named = own.partial.causes if own.partial else ()
    if own.verdict in ("explained", "ambiguous"):
        named = explanations(own.causes, own.equivalent)[0].causes
    alike = {name for one in named for group in own.equivalent if one.effect in group for name in group}
    effects = {one.effect for one in named} | alike
    return {
        "verdict": own.verdict,
        "named": " + ".join(f"{in_words(one)} {parameters_in_words(one)}" for one in named),
        "removed": f"{own.shrink.shrink:.2f}",
        "cause_named": bool(effects & CLASSES[cause]) if CLASSES[cause] else own.verdict == "no_gap",
    }


@click.command(cls=StudyScript)
@click.option("--output", default="runs/real_rigs", type=click.Path(path_type=Path), show_default=True)
def main(output: Path) -> None:
    """Diagnose every case and write the answers beside the known causes."""
    cases = tomllib.loads((HERE / "cases.toml").read_text(encoding="utf-8"))["case"]
    rows = []
    for number, case in enumerate(cases, 1):
        folder = prepared_folder(output / f"case_{number:02d}")
        found = diagnosed(case["file"], case["stated"], folder)
        write_diagnosis(found, folder)
        rows.append(case | answer(found, case["cause"]))
        click.echo("  ".join(str(value) for value in rows[-1].values()))
    write_csv(output / "answers.csv", rows)


if __name__ == "__main__":
    main()
