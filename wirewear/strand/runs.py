"""Runs of a strand's contacts, all together by the engine of sweeps."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wirewear.base.cache import Identity, identity_of
from wirewear.base.engine import Engine
from wirewear.sweeps.running import SweepObserver, run_sweep
from wirewear.sweeps.sweep import CODE, LIFE, Design, Sweep, SweepRow
from wirewear.test import LineStudy, Study

#: Figures of a run that stand in the table, by their names there.
OF_RUN = {
    "dissipated_energy_mJ": "run_friction_energy_mJ",
    "slip_amplitude_um": "run_slip_amplitude_um",
    "max_mean_pressure_MPa": "run_mean_pressure_MPa",
    "worn_volume_mm3": "run_worn_volume_mm3",
    LIFE: "run_life_cycles",
}


@dataclass(frozen=True, eq=False)
class ContactRuns(Sweep):
    """A sweep over the studies of different contacts, the worst first, of which the first `worst` are run."""

    studies: tuple[Study | LineStudy, ...] = ()
    worst: int = 0

    def __len__(self) -> int:
        return self.worst

    @property
    def identity(self) -> Identity:
        asked = {"studies": [own.resolved() for own in self.studies], "fidelity": self.fidelity}
        return identity_of(asked, CODE, {"added": {}})

    def case(self, place: int) -> tuple[Study | LineStudy, dict[str, float]]:
        return self.studies[place], {}


def run_contacts(
    name: str,
    studies: Mapping[str, Study | LineStudy],
    fidelity: str,
    output: Path,
    engine: Engine,
    observer: SweepObserver | None = None,
    *,
    worst: int | None = None,
) -> dict[str, SweepRow]:
    """Run the studies of the first `worst` contacts (all for None) and return their rows by the contacts' names.

    Each result is kept in a folder of `output`. Rows that it already holds are reused. Raises what `run_sweep` raises.
    """
    if not studies:
        return {}
    all_studies, count = tuple(studies.values()), min(worst or len(studies), len(studies))
    none = np.zeros((count, 0))
    asked = ContactRuns(name, all_studies[0], Design("grid", (), none, none), fidelity, True, all_studies, count)
    rows = run_sweep(asked, output, engine, observer).rows
    return {contact: rows[number] for number, contact in enumerate(studies, 1) if number in rows}


def with_figures_of_runs(table: list[dict[str, object]], runs: Mapping[str, SweepRow]) -> list[dict[str, object]]:
    """Rows of the table of contacts with the figures of each one's run, None where missing; as given without runs."""
    return [row | _of_run(runs.get(str(row["contact"]))) for row in table] if runs else table


def _of_run(row: SweepRow | None) -> dict[str, Any]:
    figures = {} if row is None or row.figures is None else row.figures
    failure = "" if row is None else row.failure
    return {own: figures.get(key) for key, own in OF_RUN.items()} | {"run_failure": failure}
