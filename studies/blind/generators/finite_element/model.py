"""Records of cases made by the program's own finite elements, every repeat a run of its own.

T0 has the mesh, increments and contact formulation of the nominal runs that a diagnosis makes; T1 has others of each,
and so have A1, of wires that cross at 15 to 75°, and B1, of balls on flats.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from typing import Any

import numpy as np

from studies.blind.generators.cases import Case
from studies.blind.generators.files import conditions_table, scar_lines_um
from studies.blind.generators.finite_element.changes import ANGLE, changes_of, outside_of
from studies.blind.generators.finite_element.readings import moments, read_test
from studies.blind.generators.generator import LIBRARY_EFFECTS, MadeRecord
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.nominal import BallNominal, Nominal, TurnedWires, drawn_nominals
from studies.blind.generators.nuisances import Nuisances, SpecimenDraw
from studies.blind.generators.sampling import LoggedTest, logged_channels, logged_scar, record_of
from wirewear.base.errors import RunError, WirewearError
from wirewear.records import MeasuredScar
from wirewear.results import RunResult
from wirewear.test import Study, study_from_tables

#: Loops are logged at these cycles too, so that the evolution can be read between them.
BETWEEN = (1, 10, *(factor * 10**decade for decade in range(2, 7) for factor in (1, 3)))
FIDELITY = "quick"

#: Share of records that keep their two or three specimens; the stream that chooses them is this one of the case's.
SEVERAL, _SPECIMENS = 0.25, 1
_FOLDER = "wirewear-blind-"


@dataclass(frozen=True)
class Numerics:
    """How a tier resolves space and time."""

    increments_per_cycle: int
    increments_per_wear_cycle: int | None = None
    mesh_refinement: float = 1.0
    formulation: str = "augmented-lagrangian"
    primary_wire: str = "fixed"


#: A rig logs the shelf of a free play sharply; few increments hold little of it. Wear, which is not read within a
#: cycle, does with fewer.
NUMERICS = {
    "T0": Numerics(increments_per_cycle=40),
    "T1": Numerics(
        increments_per_cycle=96,
        increments_per_wear_cycle=24,
        mesh_refinement=1.15,
        formulation="penalty",
        primary_wire="moving",
    ),
}
#: The tests of tiers that are not of wires at right angles; all are resolved as T1.
POINT_TESTS: Mapping[str, type[Nominal]] = {"A1": TurnedWires, "B1": BallNominal}


@dataclass(frozen=True)
class FiniteElementModel:
    """Contacts at a point of the program, as the tier resolves them.

    The drive imposes the true stroke without drift of its amplitude; a sample is taken at every increment. Most records
    have one specimen: a run for another one costs as much as another record, which shows more. A share of them,
    `several`, keeps the specimens that were drawn, mostly three. How large a gap is in scatters of one test is taken
    from the independent model, so that it means the same in all tiers.
    """

    tier: str
    several: float = SEVERAL
    outside: Sequence[str] = outside_of("first")

    @property
    def description(self) -> str:
        """What the manifest says of it."""
        own = self.numerics
        drawn = "" if tuple(self.outside) == outside_of("first") else ", causes of no library drawn from another set"
        return (
            f"finite elements of {self.contact.kind}, {own.increments_per_cycle} increments a cycle, mesh refined by "
            f"{own.mesh_refinement:g}, {own.formulation}, tractions on the {own.primary_wire} wire, up to three "
            f"specimens in {self.several:.0%} of the records{drawn}"
        )

    @property
    def contact(self) -> type[Nominal]:
        """Class of the tests that the tier draws."""
        return POINT_TESTS.get(self.tier, Nominal)

    @property
    def numerics(self) -> Numerics:
        """How the tier resolves it."""
        return NUMERICS.get(self.tier, NUMERICS["T1"])

    @property
    def library(self) -> tuple[str, ...]:
        """Effects of the contract that such a contact has: wires alone can cross at another angle."""
        return tuple(e for e in LIBRARY_EFFECTS if e != ANGLE or self.contact.kind == Nominal.kind)

    def nominals(self, number: int, random: np.random.Generator) -> tuple[Nominal, ...]:
        """Tests of that contact."""
        return drawn_nominals(number, random, self.contact)

    def make(self, case: Case) -> MadeRecord:
        """The record of a case; the same for the same case.
        Raises RunError if the contact does not slip, does not converge, or cannot be meshed.
        """
        kept = np.random.default_rng((case.seed, _SPECIMENS)).random() < self.several
        case = replace(case, nuisances=_affordable(case.nuisances, self.numerics, 3 if kept else 1))
        random = np.random.default_rng(case.seed)
        sizes = IndependentModel().sized(case)
        tests = [self._repeat(case, repeat, random) for repeat in range(1, case.nuisances.repeats + 1)]
        return MadeRecord(record_of(case, tests), case.nuisances, *sizes)

    def _repeat(self, case: Case, repeat: int, random: np.random.Generator) -> LoggedTest:
        draw = case.nuisances.specimen(random)
        changes = [one for one in changes_of(case.effects, draw) if one.name in self.library or one.name != ANGLE]
        result = run(nominal_study(case.nominal, case.nuisances, self.numerics).with_effects(*changes), case.name)
        return logged(result, case, repeat, draw, random)


def _affordable(nuisances: Nuisances, numerics: Numerics, most: int) -> Nuisances:
    """What these runs can have of the nuisances: a stroke that is imposed, few repeats, samples at the increments."""
    repeats = min(nuisances.repeats, most)
    return replace(
        nuisances,
        repeats=repeats,
        loop_cycles=nuisances.loop_cycles[:repeats],
        drive="stroke",
        amplitude_drift=0.0,
        samples=numerics.increments_per_cycle,
    )


def nominal_study(nominal: Nominal, nuisances: Nuisances, numerics: Numerics) -> Study:
    """The study of a test as its owner states it, without any gap: `nuisances` give only the logged cycles, `numerics`
    increments and refinement. Raises StudyError.
    """
    cycles = nominal.cycles
    logged_at = {cycle for cycle in (*BETWEEN, cycles) if cycle <= cycles}.union(*nuisances.loop_cycles)
    fidelity = {
        "increments_per_cycle": numerics.increments_per_cycle,
        "increments_per_wear_cycle": numerics.increments_per_wear_cycle,
        "mesh_refinement": numerics.mesh_refinement,
    }
    data: dict[str, Any] = {
        "format": 1,
        "name": "blind",
        "kind": nominal.kind,
        **nominal.tables,
        "conditions": conditions_table(nominal),
        "contact": {
            "friction": nominal.friction,
            "formulation": numerics.formulation,
            "primary_wire": numerics.primary_wire,
        },
        "wear": {"energy_wear_coefficient_mm3_per_J": nominal.wear_mm3_per_J},
        "holder": {
            "tangential_stiffness_N_per_mm": nominal.stiffness_N_per_mm or "rigid",
            "normal_spring_stiffness_N_per_mm": nominal.spring_N_per_mm,
        },
        "log": {"loop_cycles": sorted(logged_at)},
        "fidelity": {FIDELITY: {key: value for key, value in fidelity.items() if value is not None}},
    }
    study: Study = study_from_tables(data, "the test of a blind record")
    return study


def run(study: Study, name: str) -> RunResult:
    """A run whose files are not kept; those that a killed one left more than a day ago go too.
    Raises RunError if the study cannot be meshed, or the contact did not converge or does not slip.
    """
    from wirewear.base.cache import remove_abandoned
    from wirewear.simulation import run_study

    remove_abandoned(Path(gettempdir()), f"{_FOLDER}*")
    with TemporaryDirectory(prefix=_FOLDER) as folder:
        try:
            return run_study(study, fidelity=FIDELITY, output=Path(folder))[0]
        except WirewearError as error:
            raise RunError(f"{name} cannot be made: {error}") from error


def logged(result: RunResult, case: Case, repeat: int, draw: SpecimenDraw, random: np.random.Generator) -> LoggedTest:
    """A run as a rig would have logged it."""
    changes = changes_of(case.effects, draw)
    passed = moments(result.loops[0], case.nuisances.waveform.shape())
    time_s = passed / case.nominal.frequency_Hz
    readings = read_test(result.loops, changes, case.effects, case.nominal, case.nuisances, draw, time_s)
    loops, evolution = logged_channels(readings, case, repeat, random, time_s)
    scars: list[MeasuredScar] = []
    if case.nuisances.has_scars:
        last = max(scar.cycle for scar in result.scars)
        for scar in (scar for scar in result.scars if scar.cycle == last):
            lines = scar_lines_um(case.nominal, scar.body)
            scars.append(logged_scar(repeat, scar.body, lines, np.nan_to_num(scar.sampled(*lines)), random))
    return LoggedTest(loops, evolution, scars)
