"""What a rig stiffness run leaves: closed loops and contact fields of each case and scenario, in HDF5 and CSV.

Everything is per mm of thickness. Files: result.h5 (all of it), cases.csv, differences.csv, loops.csv, contact.csv.
In result.h5 a group `runs/<contact>_<case>_<scenario>` holds LOOP_COLUMNS and CONTACT_COLUMNS as data sets and
everything else as attributes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from wirewear.planar.storage import arrays_in, long_table, opened_result, put_arrays, table_of_rows, write_files

Array = NDArray[np.float64]

KIND = "wirewear rig stiffness result"
LOOP_COLUMNS = ("displacement_um", "tangential_force_N_per_mm", "tilt_deg")
CONTACT_COLUMNS = ("x_um", "pressure_MPa", "shear_MPa", "slip_amplitude_um")


@dataclass(frozen=True, eq=False)
class RigStiffnessRun:
    """The last cycle of a case in a scenario.

    contact: "cylinder" or "flat".  case: counted from 1.  scenario: 1, the pad translates on a spring of `stiffness`
    N/mm², or 2, it rotates on one of `stiffness` N/rad.
    Loop, arrays (m,), from one end of the stroke and back: LOOP_COLUMNS.
    Contact, arrays (n,) over x in the pad's frame: pressure and shear (on the pad) at the largest displacement, and the
    slip amplitude, a quarter of the path that a point of the pad slides while it is in contact, in a cycle.
    regime: "gross slip" if at some time nothing sticks, else "partial slip".
    cycles: simulated.  shakedown_change: largest change of shear over the last cycle,
    at its end, over friction times the peak pressure.
    force_balance, penetration, complementarity: worst residuals of all increments, as `IncrementReport` has them.
    """

    contact: str
    case: int
    scenario: int
    stiffness: float
    regime: str
    measured_stiffness_N_per_mm2: float
    largest_tilt_deg: float
    largest_force_N_per_mm: float
    slip_amplitude_of_loop_um: float
    dissipated_energy_mJ_per_mm: float
    pressure_centre_um: float
    pressed_width_um: float
    max_pressure_MPa: float
    cycles: int
    shakedown_change: float
    force_balance: float
    penetration: float
    complementarity: float
    displacement_um: Array
    tangential_force_N_per_mm: Array
    tilt_deg: Array
    x_um: Array
    pressure_MPa: Array
    shear_MPa: Array
    slip_amplitude_um: Array

    @property
    def scalars(self) -> dict[str, Any]:
        """Everything that is no array, by name."""
        arrays = {*LOOP_COLUMNS, *CONTACT_COLUMNS}
        return {field.name: getattr(self, field.name) for field in fields(self) if field.name not in arrays}


@dataclass(frozen=True, eq=False)
class RigStiffnessResult:
    """All that a run leaves; `settings` holds the meshes, by contact."""

    name: str
    fidelity: str
    study: Mapping[str, Any]
    settings: Mapping[str, Any]
    runs: tuple[RigStiffnessRun, ...]

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts, in the order of the study."""
        return tuple(dict.fromkeys(run.contact for run in self.runs))

    def pairs(self, contact: str) -> tuple[tuple[RigStiffnessRun, RigStiffnessRun], ...]:
        """Both scenarios of each case of a contact."""
        chosen = {(run.case, run.scenario): run for run in self.runs if run.contact == contact}
        return tuple((chosen[case, 1], chosen[case, 2]) for case, scenario in chosen if scenario == 1)


@dataclass(frozen=True)
class ScenarioDifference:
    """Scenario 2 against scenario 1 of a case.

    stiffness_ratio: of K_t,m.  loop: largest difference of the forces at equal displacement over the largest force.
    Of the pressure at the largest displacement: pressure_centre_um, how far its centre moves on the pad;
    pressure_reshaped, the share of the load that presses elsewhere relative to that centre, ∫|p2 - p1| dx / (2 P);
    peak_pressure_ratio, width_ratio, of the peak and of the width under pressure.
    mean_slip_um: of the slip amplitude, weighted with the pressure.
    """

    contact: str
    case: int
    stiffness_ratio: float
    loop: float
    pressure_centre_um: float
    pressure_reshaped: float
    peak_pressure_ratio: float
    width_ratio: float
    mean_slip_um: float


def scenario_difference(one: RigStiffnessRun, two: RigStiffnessRun) -> ScenarioDifference:
    """What rotation instead of translation changes; both runs on the same mesh and steps."""
    force = two.tangential_force_N_per_mm - one.tangential_force_N_per_mm
    shift = two.pressure_centre_um - one.pressure_centre_um
    aligned = np.interp(one.x_um + shift, two.x_um, two.pressure_MPa)
    apart = np.trapezoid(np.abs(aligned - one.pressure_MPa), one.x_um)
    return ScenarioDifference(
        contact=one.contact,
        case=one.case,
        stiffness_ratio=two.measured_stiffness_N_per_mm2 / one.measured_stiffness_N_per_mm2,
        loop=float(np.abs(force).max()) / one.largest_force_N_per_mm,
        pressure_centre_um=shift,
        pressure_reshaped=float(0.5 * apart / np.trapezoid(one.pressure_MPa, one.x_um)),
        peak_pressure_ratio=two.max_pressure_MPa / one.max_pressure_MPa,
        width_ratio=two.pressed_width_um / one.pressed_width_um,
        mean_slip_um=_mean_slip(two) - _mean_slip(one),
    )


def _mean_slip(run: RigStiffnessRun) -> float:
    return float(np.average(run.slip_amplitude_um, weights=run.pressure_MPa * np.gradient(run.x_um)))


def differences(result: RigStiffnessResult) -> tuple[ScenarioDifference, ...]:
    """Of all cases of all contacts."""
    return tuple(scenario_difference(*pair) for contact in result.contacts for pair in result.pairs(contact))


def write_rig_stiffness_result(folder: Path, result: RigStiffnessResult) -> list[Path]:
    """Write result.h5 and the CSV tables, each in one step; ResultError when that fails."""
    keys = ("contact", "case", "scenario")
    tables = {
        "cases.csv": table_of_rows([run.scalars for run in result.runs]),
        "differences.csv": table_of_rows([vars(difference) for difference in differences(result)]),
        "loops.csv": long_table(result.runs, keys, LOOP_COLUMNS),
        "contact.csv": long_table(result.runs, keys, CONTACT_COLUMNS),
    }

    def fill(file: h5py.File) -> None:
        runs = file.create_group("runs", track_order=True)
        for run in result.runs:
            group = runs.create_group(f"{run.contact}_{run.case}_{run.scenario}")
            group.attrs.update(run.scalars)
            put_arrays(group, run, (*LOOP_COLUMNS, *CONTACT_COLUMNS))

    return write_files(folder, KIND, result, tables, fill)


def read_rig_stiffness_result(path: Path) -> RigStiffnessResult:
    """Read a result.h5, or that of a run's folder.

    Raises:
        ResultError: there is none, or it is no result of a rig stiffness run.
    """
    with opened_result(path, KIND, "rig stiffness") as (file, common):
        return RigStiffnessResult(**common, runs=tuple(_read_run(group) for group in file["runs"].values()))


def _read_run(group: h5py.Group) -> RigStiffnessRun:
    values: dict[str, Any] = {
        name: value.item() if isinstance(value, np.generic) else value for name, value in group.attrs.items()
    }
    return RigStiffnessRun(**values | arrays_in(group))
