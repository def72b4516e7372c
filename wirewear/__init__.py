"""Crossed-wire fretting tests in 3D finite elements: contact, friction, wear and the compliance of the rig.

This package is the only one to import: ``geometry`` and ``solvers`` beneath it are its parts, which lie beside it in a
checkout and within it once installed. What it offers is loaded when it is first asked for.
"""

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solvers import FrictionLaw, LocalState, WearLaw
    from wirewear import effects, reference
    from wirewear.app.api.run import Run, lives, read_result, read_results
    from wirewear.app.api.studies import Record, load, read_record, run, run_variants
    from wirewear.base.errors import RecordError, ResultError, RunError, SensorError, StudyError, WirewearError
    from wirewear.loops.held_stroke import sensor_held_stroke
    from wirewear.loops.sensor import LoopSignals, Sensor, SensorNoise
    from wirewear.records import ExperimentRecord, check_record, record_of_result, write_record
    from wirewear.results import Evolution, Loop, RunResult, Scar, largest_mean_pressure_MPa, write_result
    from wirewear.simulation import run_study
    from wirewear.strand import strand_contacts
    from wirewear.test import Study, load_study, parse_study

    __version__: str

__all__ = [
    "Evolution", "ExperimentRecord", "FrictionLaw", "LocalState", "Loop", "LoopSignals", "Record", "RecordError",
    "ResultError", "Run", "RunError", "RunResult", "Scar", "Sensor", "SensorError", "SensorNoise", "Study",
    "StudyError", "WearLaw", "WirewearError", "__version__", "check_record", "effects", "largest_mean_pressure_MPa",
    "lives", "load", "load_study", "parse_study", "read_record", "read_result", "read_results", "record_of_result",
    "reference", "run", "run_study", "run_variants", "sensor_held_stroke", "strand_contacts", "write_record",
    "write_result",
]  # fmt: skip

_SIBLINGS = ("geometry", "solvers")


def _require_own_siblings() -> None:
    """Raise ImportError with one clear sentence unless ``geometry`` and ``solvers`` are those beside this package.

    Where another module of such a name comes first on Python's path, the first symptom would be a puzzling
    AttributeError far away.
    """
    home = Path(__file__).resolve().parents[1]
    if (home / "wirewear" / "geometry").exists():
        return  # It is installed, and nobody else's module can stand for one within it.
    for name in _SIBLINGS:
        own = home / name
        found = _location(name)
        if found is None:
            raise ImportError(
                f"wirewear needs its own package '{name}' in {own}, but there is none: install wirewear again."
            )
        if found.resolve() not in (own, own / "__init__.py"):
            raise ImportError(
                f"wirewear needs its own package '{name}' in {own}, but {found} comes first on Python's path: "
                f"rename or remove that one, or start Python from another folder."
            )


def _location(name: str) -> Path | None:
    """File (or, for a package without ``__init__.py``, folder) that ``import name`` would give, or has given."""
    if name in sys.modules:
        module = sys.modules[name]
        file, folders = getattr(module, "__file__", None), list(getattr(module, "__path__", []))
    else:
        spec = find_spec(name)
        if spec is None:
            return None
        file, folders = spec.origin, list(spec.submodule_search_locations or [])
    if file is not None:
        return Path(file)
    return Path(folders[0]) if folders else Path(f"<built-in module {name}>")


_require_own_siblings()
from geometry.lazy import loaded_late  # noqa: E402 - only now is it known whose `geometry` that is

_loaded = loaded_late(__name__)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("wirewear")
    return _loaded(name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
