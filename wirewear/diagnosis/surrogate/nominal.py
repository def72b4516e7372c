"""The nominal run: one finite element run of a test as it is stated, kept in a cache for all records that state the
same.

Wear laws that depend on energy or sliding alone run faster than stated: other wear then only re-labels the cycles. The
factor on the wear coefficients is called the margin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass, replace
from functools import partial
from math import log
from pathlib import Path
from typing import Any, TypeVar

from solvers import Archard, EnergyLaw, SolverError
from wirewear.base.cache import RUN_CODE, Identity, added_code, identity_of
from wirewear.base.errors import RecordError, ResultError, RunError, StudyError
from wirewear.base.files import table_of
from wirewear.base.words import counted
from wirewear.base.writing import temporary_folder, write_bytes
from wirewear.diagnosis.calibration import constants
from wirewear.records import AnyRecord
from wirewear.records.values import stated_study
from wirewear.results import RESULT_FILE_NAME, RunResult, read_result
from wirewear.test import AnyStudy, LineStudy, Study
from wirewear.test.conditions import Wear
from wirewear.test.gaps import Gap

Result = TypeVar("Result")

_WITHOUT_BULK = "loops are predicted without the bulk stresses of the bodies, whose strain hardly changes sliding ones"

_FOLDER = "wirewear-nominal-"

ObserverOf = Callable[[str], "AbstractContextManager[Any]"]
Stage = Callable[[str], "AbstractContextManager[object]"]  #: Entered for each step of the work, with its name.

_KNOWN = constants("surrogate.nominal")

#: Relative difference up to which model and record describe the same test.
SAME = _KNOWN.number("same_test")

#: What a study may state at most.
MOST_WEAR_mm3_per_J = _KNOWN.number("most_wear_mm3_per_J")

#: Wear beyond the stated coefficient only re-labels cycles, so the run wears on; less where the bodies are too thin.
_WEAR_MARGINS = _KNOWN.numbers("wear_margins")

#: Increments of a logged loop: enough that a few fall on the micro-slip after a reversal.
INCREMENTS_PER_CYCLE = _KNOWN.count("increments_per_cycle")

#: Late loops change most: shares of the cycles at which one more is logged; and how many a run that fails must have.
_LATE_LOOPS, _FEWEST_LOOPS = _KNOWN.numbers("late_loops"), _KNOWN.count("fewest_loops")

_OF_LINE_NOMINAL = constants("surrogate.nominal.line_nominal")

#: The run wears so many times as fast as stated, so that other wear only re-labels its cycles; and how coarsely it
#: jumps, which moves depths by a thousandth.
WEAR_MARGIN, JUMP_TOLERANCE = _OF_LINE_NOMINAL.each("wear_margin", "jump_tolerance")


def kept_or_made(
    name: str, read: Callable[[Path], Result], make: Callable[[Path], tuple[Result, Path]]
) -> tuple[Result, Path | None]:
    """A result and its file in the cache; read from there if kept, else made and kept. The file is None if nothing can
    be kept. name: of the file. read: reads that file; if it raises ResultError the result is made again. make: makes
    the result in a given folder, and returns it with its file there.
    """
    from wirewear.base.cache import allowed_bytes, keep_within, kept_file, mark_used, not_kept, remove_abandoned

    path = kept_file(name)
    if path is not None and path.exists():
        with suppress(ResultError):
            result = read(path)
            mark_used(path)
            return result, path
    with temporary_folder(_FOLDER) as folder:
        remove_abandoned(folder.parent, f"{_FOLDER}*")
        result, made = make(folder)
        if path is not None:
            try:
                write_bytes(path, made.read_bytes())
                keep_within(path.parent, allowed_bytes(), newest=path)
            except OSError as problem:
                not_kept(path, problem)
    return result, path


def nominal_study(record: AnyRecord) -> Any:
    """Study of the test as the record states it; a rig property that is not stated is taken to be ideal. Raises
    RecordError if friction or wear is not stated, or if friction is stated twice and differently.
    """
    return stated_study(record.tables)


def require_the_same(record: AnyRecord, study: AnyStudy, pairs: Mapping[str, tuple[float, float]]) -> None:
    """Raise RecordError unless each pair of numbers, the model's and the record's by key, agrees within the share
    `SAME`.
    """
    for key, (own, recorded) in pairs.items():
        if abs(own - recorded) > SAME * max(abs(own), abs(recorded)):
            raise RecordError(
                f"{key} is {own:g} in the model {study.name!r} but {recorded:g} in the record {record.name!r}: they "
                "must describe the same test."
            )


def wears_evenly(study: AnyStudy) -> bool:
    """True if the worn volume is proportional to friction energy or sliding: laws of Archard or of energy, without
    layers.
    """
    plain = all(isinstance(law, EnergyLaw | Archard) for law in study.laws[1:])
    return plain and not any(study.layers.values())


@dataclass(frozen=True)
class RunRecipe:
    """How the nominal run of a study is to be made. Creating it runs nothing.

    margins: factors on the wear coefficients, tried in turn until a run completes.
    """

    study: AnyStudy
    margins: Sequence[float]
    changes: Mapping[str, Any]  #: Changes of mesh and fidelity, as tables of a study.


def point_recipe(study: Study) -> RunRecipe:
    """How the nominal run of a contact at a point is to be made: with a wear that gives wear states, and enough
    increments in a loop. Runs nothing.
    """
    increments = study.fidelity("quick").increments_per_cycle or INCREMENTS_PER_CYCLE
    return RunRecipe(wearing(study), _WEAR_MARGINS, {"fidelity": {"quick": {"increments_per_cycle": increments}}})


def line_recipe(study: LineStudy) -> RunRecipe:
    """How the nominal run of a line contact is to be made: with the margin WEAR_MARGIN, and its jump tolerance. Runs
    nothing.
    """
    tolerance = study.mesh.jump_tolerance or JUMP_TOLERANCE
    return RunRecipe(study, (WEAR_MARGIN,), {"mesh": {"jump_tolerance": tolerance}})


def nominal_run(
    study: AnyStudy, observer_of: ObserverOf | None = None, recipe_of: Callable[[Any], RunRecipe] = point_recipe
) -> RunResult:
    """The nominal run of a study without its effects, in quick fidelity, from the cache or made now.

    It is the run with the first margin that completes or, if none does, the one with most logged loops, whose status
    and message say why it ended. Of a programme it has only the loops of the study's own block. observer_of: makes the
    observer of a run from its name; None for none. recipe_of: gives how the run is to be made. Raises StudyError if the
    study cannot be meshed; SolverError if the contact did not converge before enough loops were logged.
    """
    # Effects of the model enter the fast model; the wear states are those without.
    recipe = recipe_of(study.with_effects())

    def made(folder: Path) -> tuple[RunResult, Path]:
        result = _run(recipe, folder, observer_of)
        return result, result.path or folder / RESULT_FILE_NAME

    result, path = kept_or_made(f"nominal-{_identity(recipe).name}.h5", read_result, made)
    return of_own_block(replace(result, path=path), recipe.study)


def of_own_block(result: RunResult, study: AnyStudy) -> RunResult:
    """The run of a programme with only those loops whose block has the study's own conditions; unchanged without
    blocks.
    """
    if not study.schedule.blocks:
        return result
    own = _own_blocks(study)
    blocks = dict(zip(result.evolution["cycle"], result.evolution["block"], strict=True))
    return replace(result, loops=tuple(loop for loop in result.loops if blocks[loop.cycle] in own))


def _own_blocks(study: AnyStudy) -> set[int]:
    def under(one: AnyStudy) -> tuple[object, ...]:
        return one.conditions, one.contact, one.holder

    return {one.block for one in study.schedule.stretches if under(one.study) == under(study)}


def logged_by(study: AnyStudy) -> tuple[int, ...]:
    """Cycles at which a nominal run logs loops; of a programme, the nearest cycles in the study's own block."""
    cycles = study.conditions.cycles
    wanted = {*half_decades(cycles), cycles}
    if study.schedule.blocks:
        blocks = _own_blocks(study)
        own = [one for one in study.schedule.stretches if one.block in blocks]
        nearest = {cycle: [min(max(cycle, one.start + 1), one.end) for one in own] for cycle in wanted}
        wanted = {min(within, key=partial(_apart, cycle)) for cycle, within in nearest.items()}
    return tuple(sorted(wanted))


def _apart(cycle: int, other: int) -> float:
    return abs(log(other / cycle))


def wearing(study: Study) -> Study:
    """The study itself or, if it does not wear, a copy with a wear coefficient by which V = δ⁴/R is worn in the end.

    Scars begin to change loops at that volume, so that wear states can be made; the fast model still wears as the study
    does.
    """
    if study.wear is not None and any(study.wear.coefficients.values()):
        return study
    conditions = study.conditions
    amplitude_mm = 1e-3 * conditions.displacement_amplitude_um
    radius_mm = Gap.like(conditions.normal_load_N, *study.bodies).radius_mm
    energy_J = 4e-3 * study.contact.friction * conditions.normal_load_N * amplitude_mm * conditions.cycles
    coefficient = min(amplitude_mm**4 / radius_mm / energy_J, MOST_WEAR_mm3_per_J)
    return study.changed({"wear": Wear(energy_wear_coefficient_mm3_per_J=coefficient)})


def limits_of(result: RunResult, study: AnyStudy) -> tuple[str, ...]:
    """Sentences on what limits wear states taken from a run: bulk stress that is left out, or an end before the last
    cycle; empty if nothing does.
    """
    notes = (_WITHOUT_BULK,) if study.schedule.pulled else ()
    if result.status == "complete":
        return notes
    reached = f"cycle {counted(result.loops[-1].cycle)} of {counted(result.study['conditions']['cycles'])}"
    reason = result.message.rstrip(".")
    ended = f"the simulation of the nominal model ended at {reached} ({reason}): later wear is led on from there"
    return (*notes, ended)


def _run(recipe: RunRecipe, folder: Path, observer_of: ObserverOf | None) -> RunResult:
    from wirewear.simulation import Observer, run_study

    problem: Exception | None = None
    farthest: RunResult | None = None
    study = recipe.study
    wear = {} if study.wear is None else study.wear.coefficients
    changes = {**recipe.changes, "log": {"loop_cycles": logged_by(study)}}
    # The blocks of a programme come at their cycles, and layers and other laws wear by the energy so far.
    relabelled = wear and wears_evenly(study) and not study.schedule.blocks
    for place, margin in enumerate(recipe.margins if relabelled else (1.0,)):
        output = folder / str(place)
        faster = {"wear": {key: margin * value for key, value in wear.items()}} if wear else {}
        try:
            return run_study(
                study.changed({**changes, **faster}),
                fidelity="quick",
                output=output,
                observer_of=observer_of or (lambda _: nullcontext(Observer())),
            )[0]
        except StudyError as error:
            problem = error
        except SolverError as error:
            problem = error
            result = read_result(output / RESULT_FILE_NAME)
            if len(result.loops) >= max(_FEWEST_LOOPS, 1 + len(farthest.loops) if farthest else 0):
                farthest = result
    if farthest is not None:
        return farthest
    raise problem or RunError(f"the nominal model of {study.name!r} cannot be run.")


def half_decades(cycles: int) -> list[int]:
    """Cycles 1, 3, 10, 30, … and some late ones, all below `cycles`."""
    series = [factor * 10**decade for decade in range(len(str(cycles))) for factor in (1, 3)]
    late = [int(share * cycles) for share in _LATE_LOOPS]
    return [cycle for cycle in [*series, *late] if 1 <= cycle < cycles]


def _identity(recipe: RunRecipe) -> Identity:
    study = recipe.study
    stated = {key: value for key, value in study.resolved().items() if key not in ("name", "log", "variants")}
    # Loops without inertia or damping are the same at any frequency, unless a law follows the speed.
    timing = {} if any(law.timed for law in study.laws) else {"frequency_Hz": 1.0}
    how = {"margins": recipe.margins, "changes": recipe.changes}
    asked = {**stated, "conditions": {**table_of(stated, "conditions"), **timing}, **how}
    plan = {name: constant.value for name, constant in _KNOWN.known.items()} | {"added": added_code(study.laws)}
    return identity_of(asked, (*RUN_CODE, "wirewear/diagnosis/surrogate/nominal.py"), plan)
