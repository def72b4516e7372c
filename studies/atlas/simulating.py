"""From a test of an entry to its figures: a study with the test's keys is run once, and kept."""

import re
from collections.abc import Mapping
from dataclasses import fields
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from studies.atlas.entry import Entry, Simulated
from wirewear import RunResult, StudyError, read_record
from wirewear.base.writing import json_text
from wirewear.kinds import any_study
from wirewear.loops import LoopError, Measured, analyse_loop
from wirewear.simulation import ProgressBar, run_study
from wirewear.test.keys import merged
from wirewear.test.study import read_study


def simulator(entry: Entry, fidelity: str, output: Path) -> Simulated:
    """What gives the figures of a test of that entry; runs are kept in `output` and gone on with."""
    if entry.table.figures is not None:
        module, _, name = entry.table.figures.partition(":")
        given: Simulated = getattr(import_module(module), name)
        return given
    if entry.table.study is None:
        return lambda _: {}
    return lambda row: _figures(entry, row, _run(_tables(entry, row), fidelity, output / entry.name))


def _tables(entry: Entry, row: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a test's study: its variant's, and columns with dots in their names put in their places.

    A number between dots counts the tables of a list: effects.0.supply_W.
    """
    path = entry.folder / str(entry.table.study)
    tables = read_study(path)
    variants = tables.pop("variants", {})
    if (variant := row.get("variant")) is not None:
        if variant not in variants:
            raise StudyError(f"{path} has no variant {variant!r}, which test {row['test']} of {entry.name} asks for.")
        tables = merged(tables, variants[variant])
    for name, value in row.items():
        *above, key = name.split(".")
        if not above or value is None:
            continue
        here: Any = tables
        for part in above:
            here = here[int(part)] if isinstance(here, list) else here.setdefault(part, {})
        here[key] = int(value) if isinstance(value, float) and value.is_integer() else value
    return tables


def _run(tables: dict[str, Any], fidelity: str, output: Path) -> RunResult:
    study = any_study(tables, str(output))
    # Tests that differ in what is compared alone share a run.
    own = sha256(json_text([tables, fidelity]).encode()).hexdigest()[:12]
    run: RunResult
    (run,) = run_study(study, fidelity=fidelity, output=output / own, resume=True, observer_of=ProgressBar, jobs=1)
    return run


def _figures(entry: Entry, row: Mapping[str, Any], run: RunResult) -> dict[str, float]:
    """Figures of a run at its end or at the row's `at_cycle`, with those of its first loop and of the row's `record`.

    The evolution's, `first_` ones of its first cycle, `loop_` and `first_loop_` ones of the analysis of loops,
    settings, depths and mid-stroke pressures of scars, and of each difference from the record `NAME_simulated`,
    `NAME_measured` and `NAME_difference`.
    """
    cycles = run.evolution["cycle"]
    at = row.get("at_cycle") or cycles[-1]
    found = {name: float(value) for name, value in run.settings.items() if isinstance(value, float | int)}
    for name, values in run.evolution.items():
        found |= {name: float(np.interp(at, cycles, values)), f"first_{name}": float(values[0])}
    for body in run.bodies:
        scar = run.scar(max(cycle for cycle in run.scar_cycles() if cycle <= at), body)
        x_um, depth_um = scar.section_along_motion()
        found[f"middle_depth_{body}_um"] = float(np.interp(0.0, x_um, depth_um))
        found[f"deepest_at_{body}_um"] = float(abs(x_um[np.argmax(depth_um)]))
        middle = np.hypot(scar.axial_um[:, None], scar.transverse_um[None, :]).argmin()
        found[f"middle_pressure_{body}_MPa"] = float(scar.pressure_MPa.flat[middle])
        found[f"peak_pressure_{body}_MPa"] = float(scar.pressure_MPa.max())
    for start, loop in (("first_loop_", run.loops[0]), ("loop_", [one for one in run.loops if one.cycle <= at][-1])):
        try:
            loop_figures = analyse_loop(loop.displacement_um, loop.tangential_force_N, loop.normal_force_N)
        except LoopError:
            continue
        for field in fields(loop_figures):
            value = getattr(loop_figures, field.name)
            found |= {start + field.name: value.value} if isinstance(value, Measured) else {}
    if (record := row.get("record")) is not None:
        for one in read_record(entry.folder / record).compare(run).differences:
            name = re.sub(r"\W+", "_", f"{one.source} {one.quantity}").strip("_")
            for side in ("simulated", "measured", "difference"):
                value = getattr(one, side)
                found[f"{name}_{side}"] = float("nan") if value is None else value
    return found
