"""Records of line contacts by finite elements of another mesh and other jumps than a diagnosis' nominal run.

A case is one run; its repeats are that run, read for specimens of other friction, load and wear: forces are
proportional to friction and load once the contact slides, and what wears follows the dissipated energy, so that
another wear rate is another cycle of the same run.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, cast

import numpy as np

from studies.blind.generators.cases import Case
from studies.blind.generators.files import line_record_tables
from studies.blind.generators.finite_element.changes import at_seams, outside_of
from studies.blind.generators.generator import MadeRecord
from studies.blind.generators.line_nominal import LineNominal, drawn_line_nominals
from studies.blind.generators.lines.differences import PROFILE_NOISE_um, differences
from studies.blind.generators.lines.readings import dose_of, nominal_of, profile_at, read_test, record_tables
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.sampling import logged_channels
from wirewear.base.errors import RunError, WirewearError
from wirewear.effects import Effect, Seam
from wirewear.records import LineRecord, MeasuredEvolution, MeasuredLoop, MeasuredProfile
from wirewear.records.values import stated_study
from wirewear.results import BODIES, RunResult
from wirewear.test import LineStudy

#: Loops are logged at these shares of decades too; scars of other wear rates are read beyond the test's end.
BETWEEN = (1, 10, 100, 300, 1000, 3000, 10000, 30000)
LATE = (0.6, 0.85, 1.0, 1.2)

#: Contact elements and width of the patch against those of the level "quick", and jumps: other than a diagnosis takes.
REFINED, WIDER, JUMP_TOLERANCE = 1.2, 1.1, 0.07

#: Effects of the contract that a line contact can have.
LINE_LIBRARY = (
    "tangential_compliance", "rotational_compliance", "free_play", "friction_offset", "friction_evolution",
    "roughness_compliance", "third_body", "misalignment", "normal_load_drift", "wear_rate_offset",
    "wear_rate_evolution", "contact_oxygenation", "displacement_gain", "displacement_load_coupling", "force_crosstalk",
    "sensor_lag",
)  # fmt: skip

POINTS, PROFILE_MARGIN = 181, 1.7  #: Points of a profile, and how far it reaches.


@lru_cache(maxsize=24)
def run_of(nominal: LineNominal, effects: tuple[Effect[Any], ...]) -> RunResult:
    """The run of a test with effects of the whole contact in it.
    Raises RunError if it cannot be meshed, or the contact did not converge.
    """
    from wirewear.simulation import simulate

    try:
        return simulate(_study(nominal, effects), fidelity="quick")
    except WirewearError as error:
        raise RunError(f"a line contact cannot be made: {error}") from error


def _study(nominal: LineNominal, effects: tuple[Effect[Any], ...]) -> LineStudy:
    from wirewear.simulation.line_model import line_plan

    tables = line_record_tables(nominal, "blind", {})
    conditions = tables.conditions.model_copy(update={"cycles": round(LATE[-1] * nominal.cycles)})
    tables = tables.model_copy(update={"conditions": conditions})
    logged = {cycle for cycle in BETWEEN if cycle < nominal.cycles}
    logged |= {round(share * nominal.cycles) for share in LATE}
    study: LineStudy = stated_study(tables, {"log": {"loop_cycles": sorted(logged)}})
    study = study.changed({"effects": effects})
    quick = line_plan(study, "quick").pad.along
    mesh = {
        "contact_mesh_um": 1e3 * quick.fine_mm / REFINED,
        "scar_half_width_um": 1e3 * WIDER * quick.half_extent_mm,
        "jump_tolerance": JUMP_TOLERANCE,
    }
    return study.changed({"mesh": mesh})


@dataclass(frozen=True)
class LineModel:
    """Cylinders on flats of the program, one run a case; the drive imposes the true stroke."""

    tier: str = "L1"
    library: Sequence[str] = LINE_LIBRARY
    outside: Sequence[str] = outside_of("first")

    @property
    def description(self) -> str:
        """What the manifest says of it."""
        return (
            f"line contacts, mesh refined by {REFINED:g} on a patch {WIDER:g} times as wide, jump tolerance "
            f"{JUMP_TOLERANCE:g}"
        )

    def nominals(self, number: int, random: np.random.Generator) -> tuple[Nominal, ...]:
        """Nominal tests of a batch."""
        return cast("tuple[Nominal, ...]", drawn_line_nominals(number, random))

    def make(self, case: Case) -> MadeRecord:
        """The record of a case; the same for the same case.
        Raises RunError if the contact does not slip, does not converge, or cannot be meshed.
        """
        case = replace(case, nuisances=replace(case.nuisances, drive="stroke", amplitude_drift=0.0))
        random = np.random.default_rng(case.seed)
        nominal = run_of(nominal_of(case), ())
        changes = at_seams(case.effects)
        inside = tuple(effect for effect in changes if effect.seam is not Seam.SENSOR)
        true = run_of(nominal_of(case), inside) if inside else nominal
        repeats = [_repeat(true, changes, case, repeat, random) for repeat in range(1, case.nuisances.repeats + 1)]
        record = LineRecord(
            record_tables(case),
            tuple(loop for loops, _, _ in repeats for loop in loops),
            tuple(rows for _, evolution, _ in repeats for rows in evolution),
            tuple(profile for _, _, profiles in repeats for profile in profiles),
        )
        return MadeRecord(record, case.nuisances, differences(nominal, true, changes, case))


def _repeat(
    run: RunResult, changes: Sequence[Effect[Any]], case: Case, repeat: int, random: np.random.Generator
) -> tuple[list[MeasuredLoop], list[MeasuredEvolution], list[MeasuredProfile]]:
    draw = case.nuisances.specimen(random)
    readings = read_test(run, changes, case, draw, case.nuisances.all_cycles)
    loops, evolution = logged_channels(readings, case, repeat, random)
    profiles = []
    if case.nuisances.has_scars:
        nominal = nominal_of(case)
        half = PROFILE_MARGIN * 1e3 * nominal.expected_scar_mm + nominal.amplitude_um
        x = np.linspace(-half, half, POINTS)
        for body in BODIES:
            depth = np.interp(x, *profile_at(run, body, dose_of(draw) * nominal.cycles), left=0.0, right=0.0)
            profiles.append(MeasuredProfile(repeat, body, x, depth + PROFILE_NOISE_um * random.standard_normal(POINTS)))
    return loops, evolution, profiles
