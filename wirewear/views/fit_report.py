"""A fit as tables, as JSON, as a study file and as the table `[stated]` of a record."""

from pathlib import Path

import numpy as np
from rich import box
from rich.table import Table

from wirewear.base.errors import RecordError
from wirewear.base.files import TABLE_FILE_NAME, parsed_toml, read_text, table_of, toml_text
from wirewear.base.units import UNIT_SYMBOLS
from wirewear.base.words import counted
from wirewear.base.writing import prepared_folder, require_absent, write_text
from wirewear.diagnosis.fit.fit import stated_by
from wirewear.diagnosis.fit.values import CheckedRun, FittedParameter, FittedTest
from wirewear.records.writing import with_checksums
from wirewear.results.scar import called
from wirewear.test.kinds import kind_of
from wirewear.test.template import study_text

#: What parameters and figures are called.
NAMES = {
    "friction": "coefficient of friction µ",
    "friction_initial": "µ at the start",
    "friction_final": "µ run in",
    "friction_cycles": "cycles of running-in",
    "tangential_stiffness_N_per_mm": "rig stiffness K_rig, all cycles",
    "normal_spring_stiffness_N_per_mm": "spring of the loading train",
    "free_play_um": "free play",
    "energy_wear_coefficient_mm3_per_J": "wear coefficient V/ΣE_d",
    "moving_share": "driven body's share of the wear",
    "pad_energy_wear_coefficient_mm3_per_J": "wear coefficient of the pad V/ΣE_d",
    "specimen_energy_wear_coefficient_mm3_per_J": "wear coefficient of the specimen V/ΣE_d",
    "measured_stiffness_N_per_mm": "stiffness of the first loops K_t,m",
    "contact_stiffness_N_per_mm": "stiffness of the contact K_c",
    "rig_stiffness_of_first_loops_N_per_mm": "K_rig by 1/K_t,m − 1/K_c, first loops",
    "accumulated_energy_J": "friction energy of a test ΣE_d",
}

#: What the fitted figures of loops are called, and their unit.
FIGURE_NAMES = {
    "friction_geometry_independent": "µ, geometry-independent",
    "slip_amplitude_um": "slip amplitude δ0",
    "dissipated_energy_mJ": "energy of a loop E_d",
    "measured_stiffness_N_per_um": "stiffness K_t,m",
}

#: What begins a line of experiment.toml that holds a checksum.
CHECKSUM = "# sha256 "

STIFF = 0.9  #: A rig of this share of what is rigid is shown as one whose stiffness the loops leave open.

_UNITS = {"slip_amplitude_um": " µm", "dissipated_energy_mJ": " mJ"}
_HEAD = "Fitted to the record "  #: How the remark above a fitted study begins.


def fit_table(fitted: FittedTest) -> Table:
    """Table of the fitted parameters and of the further figures found, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, title=f"Fit of {fitted.record.name}", title_justify="left", pad_edge=False)
    for heading in ("", "value", "95 % interval", "tests"):
        table.add_column(heading, justify="left" if not heading else "right")
    stiff = STIFF * fitted.rigid_N_per_mm
    bodies = fitted.record.tables.body_names
    names = NAMES | {f"worn_volume_{body}_mm3": f"worn volume, {called(body)}" for body in bodies}
    for name, found in {**fitted.parameters, **fitted.found}.items():
        value, interval = _shown(found, stiff)
        table.add_row(names[name], value, interval, str(found.repeats) if found.repeats else "–")
    return table


def _shown(found: FittedParameter, stiff_N_per_mm: float) -> tuple[str, str]:
    """Value and interval as text; a stiffness above `stiff_N_per_mm`, which loops cannot resolve, is shown as rigid."""
    low, high = found.interval95
    unit = UNIT_SYMBOLS[found.unit]
    stiff = stiff_N_per_mm if found.unit == "N_per_mm" else np.inf
    value = "rigid" if found.value > stiff else f"{_number(found.value)}{unit}"
    if high > stiff:
        return value, f"above {_number(min(low, stiff))}{unit}"
    return value, f"{_number(low)} … {_number(high)}{unit}" if _number(low) != _number(high) else "–"


def _number(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.4g}"


def check_table(checked: CheckedRun) -> Table:
    """Table of the figures of record and checking run, at the first and the last cycle that has both, to be printed
    with rich.
    """
    table = Table(box=box.SIMPLE_HEAD, title="Checked by a run", title_justify="left", pad_edge=False)
    for heading in ("", "cycle", "record", "run", "difference", "one test scatters"):
        table.add_column(heading, justify="left" if not heading else "right")
    for place, (name, title) in enumerate(FIGURE_NAMES.items()):
        both = np.flatnonzero(np.isfinite(checked.measured[:, place] * checked.simulated[:, place]))
        for row in sorted({int(both[0]), int(both[-1])}) if both.size else ():
            measured, simulated = checked.measured[row, place], checked.simulated[row, place]
            factor, unit = (1e3, " N/mm") if name.endswith("N_per_um") else (1.0, _UNITS.get(name, ""))
            table.add_row(
                title,
                counted(checked.cycles[row]),
                f"{factor * measured:.4g}{unit}",
                f"{factor * simulated:.4g}{unit}",
                f"{100.0 * (simulated / measured - 1.0):+.1f} %",
                f"{100.0 * checked.deviations[row, place] / abs(measured):.1f} %",
            )
    return table


def fit_json(fitted: FittedTest, checked: CheckedRun | None) -> dict[str, object]:
    """Plain values for JSON: record, parameters and further figures (value, 95 % interval, unit, repeats), check and
    notes. checked: None if no run checked the fit.
    """
    check = None
    if checked is not None:
        check = {"relative_differences": checked.differences, "in_scatters": checked.scatters}
    return {
        "record": fitted.record.name,
        "parameters": {name: _json(found) for name, found in fitted.parameters.items()},
        "found": {name: _json(found) for name, found in fitted.found.items()},
        "check": check,
        "notes": list(fitted.notes),
    }


def _json(found: FittedParameter) -> dict[str, object]:
    return {
        "value": found.value,
        "interval95": list(found.interval95),
        "unit": UNIT_SYMBOLS[found.unit].strip(),
        "repeats": found.repeats,
    }


def require_no_other_study(folder: Path) -> None:
    """Raise RecordError if the folder holds a study.toml that no fit has written, or a stated.toml without a
    study.toml.
    """
    path = folder / "study.toml"
    if not path.exists():
        require_absent([folder / "stated.toml"], RecordError, "")
    elif _HEAD not in read_text(path, RecordError, "study file"):
        raise RecordError(f"{path} is a study that was not fitted, and is not overwritten: choose another folder.")


def write_fit(fitted: FittedTest, folder: Path) -> list[Path]:
    """Write study.toml with the fitted study, and stated.toml with the table `[stated]`; return both paths.

    Raises RunError if the folder cannot be created or written to.
    """
    prepared_folder(folder)
    study, stated = folder / "study.toml", folder / "stated.toml"
    stiff = STIFF * fitted.rigid_N_per_mm
    lines = [f"{_HEAD}{fitted.record.name}; value and 95 % interval:"]
    for name, found in fitted.parameters.items():
        value, interval = _shown(found, stiff)
        lines.append(f"  {NAMES[name]}: {value} ({interval})")
    write_text(study, study_text(str(study), kind_of(fitted.study).template, fitted.study.given(), "\n".join(lines)))
    write_text(stated, toml_text({"stated": stated_by(fitted.parameters, fitted.rigid_N_per_mm)}).lstrip())
    return [study, stated]


def write_stated(fitted: FittedTest) -> Path:
    """Write the fitted values into `[stated]` of the record's table file, keep its other tables, and return its path.
    Raises RecordError if the record was not read from a folder, or its table cannot be written.
    """
    if fitted.record.path is None:
        raise RecordError("the record was not read from a folder, so that nothing can be written into it.")
    path = fitted.record.path / TABLE_FILE_NAME
    before = read_text(path, RecordError)
    tables = parsed_toml(before, str(path), RecordError)
    known = stated_by(fitted.parameters, fitted.rigid_N_per_mm)
    if "friction_force_N" in table_of(tables, "stated") and "friction" in known:
        # A friction force that was stated stands for the load as well.
        known["friction_force_N"] = known.pop("friction") * fitted.record.tables.conditions.normal_load_N
    # A body wears by one law: what was fitted takes the place of what was stated otherwise.
    replaced = {key.replace("energy", "archard").replace("_per_J", "_per_N_m") for key in known}
    before_it = {key: value for key, value in table_of(tables, "stated").items() if key not in replaced}
    tables["stated"] = {**before_it, **known}
    text = toml_text(tables)
    write_text(
        path, with_checksums(text, path.parent, table_of(tables, "files").values()) if CHECKSUM in before else text
    )
    return path
