"""Sensitivities of the first loop beside those of its closed form, run by run and index by index.

    wirewear sweep studies/rig_sensitivity/sweep.toml --output DIR
    python -m studies.rig_sensitivity.compare DIR

The closed form is a spring in series with Cattaneo and Mindlin's contact of circular area, without wear.
"""

from pathlib import Path

import click
import numpy as np
import polars as pl
from numpy.typing import NDArray
from rich import box
from rich.table import Table

from studies.study_script import StudyScript
from wirewear.app.cli.consoles import wide_console
from wirewear.base.errors import ResultError
from wirewear.reference import hertz_crossed_cylinders, tangential_contact_modulus
from wirewear.reference.cattaneo_mindlin import dissipated_energy, force_amplitude, partial_slip_point, slip_amplitude
from wirewear.sweeps import Sweep, load_sweep
from wirewear.sweeps.indices import Index, indices
from wirewear.sweeps.sweep import FIRST, SweepRow
from wirewear.test import LineStudy, Study

SWEEP = Path(__file__).with_name("sweep.toml")

#: Figures of the first loop, with their units' factors from N, mm and mJ.
FIGURES = {
    "slip_amplitude_um": (slip_amplitude, 1e3),
    "max_tangential_force_N": (force_amplitude, 1.0),
    "dissipated_energy_mJ": (dissipated_energy, 1.0),
}

Array = NDArray[np.float64]


def closed_form(study: Study | LineStudy) -> dict[str, float]:
    """Figures of the loop of a fresh contact of crossed wires."""
    if isinstance(study, LineStudy):
        raise TypeError("the closed form is that of crossed wires")
    moving, fixed = study.bodies
    load, angle = study.conditions.normal_load_N, study.wires.crossing_angle_deg
    radii = moving.diameters_mm[1] / 2.0, fixed.diameters_mm[1] / 2.0
    hertz = hertz_crossed_cylinders(load, *radii, angle, first=moving.material, second=fixed.material)
    modulus = tangential_contact_modulus(moving.material, fixed.material)
    contact = partial_slip_point(load, study.contact.friction, hertz.contact_radius_mm, modulus)
    stroke, rig = study.conditions.displacement_amplitude_um * 1e-3, study.holder.tangential_stiffness_N_per_mm
    stiffness = float("inf") if rig == "rigid" else float(rig)
    return {name: factor * formula(contact, stroke, stiffness) for name, (formula, factor) in FIGURES.items()}


def compared(sweep: Sweep, table: pl.DataFrame) -> dict[str, tuple[Array, Array]]:
    """Simulated and exact figures of every complete run."""
    complete = table.filter(pl.col("ended") == "complete")
    exact = [closed_form(sweep.study_of(number - 1)) for number in complete["run"].to_list()]
    return {name: (complete[f"{FIRST}{name}"].to_numpy(), np.array([one[name] for one in exact])) for name in FIGURES}


def both_indices(sweep: Sweep, table: pl.DataFrame, name: str) -> list[tuple[Index, Index]]:
    """Indices of the simulation and of the closed form, on one design."""
    simulated = {
        row["run"]: SweepRow(row["run"], {name: row[f"{FIRST}{name}"]} if row["ended"] == "complete" else None)
        for row in table.to_dicts()
    }
    exact = {
        number: row if row.failed else SweepRow(number, {name: closed_form(sweep.study_of(number - 1))[name]})
        for number, row in simulated.items()
    }
    return list(zip(indices(sweep.design, simulated, name), indices(sweep.design, exact, name), strict=True))


def read_table(folder: Path) -> pl.DataFrame:
    """The table of the sweep. Raises ResultError if the folder has none, or another sweep's."""
    path, needed = folder / "table.parquet", ["run", "ended", *(f"{FIRST}{name}" for name in FIGURES)]
    made_by = f"wirewear sweep {SWEEP} --output {folder}"
    if not path.is_file():
        raise ResultError(f"there is no {path}: make it by {made_by}.")
    try:
        return pl.read_parquet(path).select(needed)
    except pl.exceptions.PolarsError:
        raise ResultError(f"{path} is no table of this sweep: {made_by} makes it.") from None


@click.command(cls=StudyScript, help=__doc__)
@click.argument("folder", type=click.Path(path_type=Path))
def main(folder: Path) -> None:
    """Print both tables."""
    sweep, table = load_sweep(SWEEP), read_table(folder)
    console = wide_console(110)
    shown = Table("figure of the first loop", "runs", "median off", "largest off", box=box.SIMPLE_HEAD)
    for name, (simulated, exact) in compared(sweep, table).items():
        off = np.abs(simulated / exact - 1.0)
        shown.add_row(name, str(off.size), f"{100.0 * np.median(off):.2f} %", f"{100.0 * off.max():.2f} %")
    console.print(shown)
    shown = Table("figure", "key", "alone", "exact", "with others", "exact", box=box.SIMPLE_HEAD)
    for name in FIGURES:
        for own, ideal in both_indices(sweep, table, name):
            shown.add_row(
                name,
                own.key,
                f"{own.first:.3f} ± {own.first_error:.3f}",
                f"{ideal.first:.3f}",
                f"{own.total:.3f} ± {own.total_error:.3f}",
                f"{ideal.total:.3f}",
            )
    console.print(shown)


if __name__ == "__main__":
    main()
