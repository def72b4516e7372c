"""The nominal model of a record, and its one finite element run, kept for all records that state the same."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from importlib.metadata import version
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Any

from wirewear.diagnosis.calibration import constants
from wirewear.errors import RecordError, RunError, StudyError, WirewearError

if TYPE_CHECKING:
    from wirewear.records import ExperimentRecord
    from wirewear.results import RunResult
    from wirewear.simulation import RunObserver
    from wirewear.study import Study

ObserverOf = Callable[[str], "AbstractContextManager[RunObserver]"]

_KNOWN = constants("model.nominal")

#: Relative difference up to which model and record describe the same test.
SAME = _KNOWN.number("same_test")

# Raise when what is kept of a run changes.
_GENERATION = 1

#: Wear beyond the stated coefficient only re-labels cycles, so the run wears on; less where the wires are too thin.
_WEAR_MARGINS = _KNOWN.numbers("wear_margins")

#: Increments of a logged loop: enough that a few fall on the micro-slip after a reversal.
INCREMENTS_PER_CYCLE = _KNOWN.count("increments_per_cycle")

#: Late loops change most: shares of the cycles at which one more is logged; and how many a run that fails must have.
_LATE_LOOPS, _FEWEST_LOOPS = _KNOWN.numbers("late_loops"), _KNOWN.count("fewest_loops")


def nominal_study(record: ExperimentRecord) -> Study:
    """What the record's owner believes, as a study; what is not stated is ideal.

    Raises:
        RecordError: friction or wear coefficient is not stated.
    """
    from wirewear.study import study_from_tables

    tables = record.tables
    stated = tables.stated
    for key in ("friction", "energy_wear_coefficient_mm3_per_J"):
        if getattr(stated, key) is None:
            raise RecordError(
                f"[stated] of the record {record.name!r} does not give {key}, without which there is no model to "
                "diagnose: add it, or give a study with --model."
            )
    holder: dict[str, Any] = {
        "tangential_stiffness_N_per_mm": stated.tangential_stiffness_N_per_mm,
        "rotational_stiffness_N_mm_per_rad": stated.rotational_stiffness_N_mm_per_rad,
        "normal_spring_stiffness_N_per_mm": stated.normal_spring_stiffness_N_per_mm,
    }
    if stated.pivot_height_mm is not None:
        holder["pivot_height_mm"] = stated.pivot_height_mm
    conditions = tables.conditions.model_dump(exclude={"drive"})
    data = {
        "format": 1,
        "name": record.name,
        "kind": "crossed-wires",
        "wires": tables.wires.model_dump(),
        "conditions": conditions,
        "contact": {"friction": stated.friction},
        "wear": {
            "energy_wear_coefficient_mm3_per_J": stated.energy_wear_coefficient_mm3_per_J,
            "moving_share": stated.moving_share,
        },
        "holder": holder,
    }
    return study_from_tables(data, f"the nominal model of the record {record.name!r}")


def checked_model(record: ExperimentRecord, study: Study) -> Study:
    """A study that is to be diagnosed against a record.

    Raises:
        RecordError: it is of other wires, load or amplitude than the record's test.
    """
    believed, asked = study.conditions, record.tables.conditions
    pairs = {
        "diameter_mm": (study.wires.diameter_mm, record.tables.wires.diameter_mm),
        "normal_load_N": (believed.normal_load_N, asked.normal_load_N),
        "displacement_amplitude_um": (believed.displacement_amplitude_um, asked.displacement_amplitude_um),
    }
    for key, (own, recorded) in pairs.items():
        if abs(own / recorded - 1.0) > SAME:
            raise RecordError(
                f"{key} is {own:g} in the model {study.name!r} but {recorded:g} in the record {record.name!r}: they "
                "must describe the same test."
            )
    return study


def nominal_run(study: Study, observer_of: ObserverOf | None = None) -> RunResult:
    """The quick run of a study, from the cache or made now; its wear coefficient is the stated one times a margin.

    Raises:
        StudyError: the study cannot be meshed.
        SolverError: the contact did not converge before enough loops were logged.
    """
    from wirewear.files.cache import cache_directory, remove_abandoned
    from wirewear.results import RESULT_FILE_NAME, read_result

    # Effects of the model enter the fast model; the wear states are those without.
    study = study.with_effects()
    folder = cache_directory() / f"nominal-{_key(study)}"
    try:
        return read_result(folder / RESULT_FILE_NAME)
    except (WirewearError, OSError):
        pass
    folder.parent.mkdir(parents=True, exist_ok=True)
    remove_abandoned(folder.parent, ".nominal-*")
    temporary = Path(mkdtemp(prefix=".nominal-", dir=folder.parent))
    try:
        result = _run(study, temporary, observer_of)
        if not (folder / RESULT_FILE_NAME).exists():
            shutil.rmtree(folder, ignore_errors=True)
            temporary.replace(folder)
    except OSError:
        # Another process may have been faster.
        result = read_result(folder / RESULT_FILE_NAME)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return result


def _run(study: Study, folder: Path, observer_of: ObserverOf | None) -> RunResult:
    from solvers import SolverError
    from wirewear.results import RESULT_FILE_NAME, read_result
    from wirewear.simulation import run_study

    problem: Exception | None = None
    for margin in _WEAR_MARGINS if study.wear is not None else (1.0,):
        try:
            return run_study(
                _faster_wearing(study, margin),
                fidelity="quick",
                output=folder,
                observer_of=observer_of or (lambda _: nullcontext(_silent())),
            )[0]
        except StudyError as error:
            problem = error
        except SolverError as error:
            result = read_result(folder / RESULT_FILE_NAME)
            if len(result.loops) >= _FEWEST_LOOPS:
                return result
            problem = error
    raise problem or RunError(f"the nominal model of {study.name!r} cannot be run.")


def _silent() -> RunObserver:
    from wirewear.simulation import NoObserver

    return NoObserver()


def _faster_wearing(study: Study, margin: float) -> Study:
    from wirewear.study import study_from_tables

    data = study.resolved()
    data.pop("variants", None)
    if study.wear is not None:
        for key in ("energy_wear_coefficient_mm3_per_J", "archard_wear_coefficient_mm3_per_N_m"):
            if data["wear"].get(key) is not None:
                data["wear"][key] *= margin
    cycles = study.conditions.cycles
    data["log"] = {"loop_cycles": sorted({*_half_decades(cycles), cycles})}
    own = data.get("fidelity", {}).get("quick", {})
    data["fidelity"] = {"quick": {"increments_per_cycle": INCREMENTS_PER_CYCLE, **own}}
    return study_from_tables(data, f"the nominal model {study.name!r}")


def _half_decades(cycles: int) -> list[int]:
    series = [factor * 10**decade for decade in range(len(str(cycles))) for factor in (1, 3)]
    late = [int(share * cycles) for share in _LATE_LOOPS]
    return [cycle for cycle in [*series, *late] if 1 <= cycle < cycles]


def _key(study: Study) -> str:
    stated = {key: value for key, value in study.resolved().items() if key not in ("name", "log", "variants")}
    parts = {
        "generation": _GENERATION,
        # Loops without inertia or damping are the same at any frequency.
        "study": {**stated, "conditions": {**stated["conditions"], "frequency_Hz": 1.0}},
        "version": version("wirewear"),
        "increments": INCREMENTS_PER_CYCLE,
        "margins": _WEAR_MARGINS,
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()[:24]
