"""The run of a line contact's blind test: another mesh and other jumps than a diagnosis' nominal run."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from studies.blind.generators.line_nominal import LineNominal
from studies.blind.generators.lines.tables import tables_of
from wirewear.base.errors import RunError, WirewearError
from wirewear.effects import Effect
from wirewear.planar.tables import PlanarStudy
from wirewear.planar.whole_contact import per_mm
from wirewear.records.line_believed import believed_study
from wirewear.results import RunResult

#: Loops are logged at these shares of decades too; scars of other wear rates are read beyond the test's end.
BETWEEN = (1, 10, 100, 300, 1000, 3000, 10000, 30000)
LATE = (0.6, 0.85, 1.0, 1.2)

#: Contact elements and width of the patch against those of the level "quick", and jumps: other than a diagnosis takes.
REFINED, WIDER, JUMP_TOLERANCE = 1.2, 1.1, 0.07


@lru_cache(maxsize=24)
def run_of(nominal: LineNominal, effects: tuple[Effect[Any], ...]) -> RunResult:
    """The run of a test with effects of the whole contact in it.

    Raises:
        RunError: it cannot be meshed, or the contact did not converge.
    """
    from wirewear.planar.run import run_planar_study

    try:
        return run_planar_study(_study(nominal, effects), fidelity="quick")
    except WirewearError as error:
        raise RunError(f"a line contact cannot be made: {error}") from error


def _study(nominal: LineNominal, effects: tuple[Effect[Any], ...]) -> PlanarStudy:
    from wirewear.planar.model import plan

    tables = tables_of(nominal, "blind", {})
    tables = tables.model_copy(update={"conditions": tables.conditions.model_copy(update={"cycles": _length(nominal)})})
    logged = {cycle for cycle in BETWEEN if cycle < nominal.cycles}
    logged |= {round(share * nominal.cycles) for share in LATE}
    study = believed_study(tables, {"log": {"loop_cycles": sorted(logged)}})
    study = study.model_copy(update={"effects": per_mm(effects, nominal.length_mm)})
    quick = plan(study, "quick").pad.along
    mesh = study.mesh.model_copy(
        update={
            "contact_mesh_um": 1e3 * quick.fine_mm / REFINED,
            "scar_half_width_um": 1e3 * WIDER * quick.half_extent_mm,
            "jump_tolerance": JUMP_TOLERANCE,
        }
    )
    return study.model_copy(update={"mesh": mesh})


def _length(nominal: LineNominal) -> int:
    return round(LATE[-1] * nominal.cycles)
