"""Causes of the withheld set for tests: each at no size; causes of any set as drawn, as read of a loop and as worn."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from solvers import Holder, WearRates
from studies.blind.generators.cases import Case, TrueEffect, planned_cases
from studies.blind.generators.files import write_traceless
from studies.blind.generators.finite_element.changes import OUTSIDE_SETS as OF_RUNS
from studies.blind.generators.finite_element.changes import changes_of, instruments_of
from studies.blind.generators.finite_element.model import NUMERICS, believed_study
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.independent.sensing import Reading, read
from studies.blind.generators.independent.wear_test import Snapshot, snapshots
from studies.blind.generators.independent.withheld import WITHHELD
from studies.blind.generators.instruments import Signals, read_by
from studies.blind.generators.nominal import Nominal, drawn_nominals
from studies.blind.generators.sizes import drawn_parameters
from tests.test_blind_finite_element import plain_nuisances
from tests.test_blind_unseen import LOOP, QUIET, STEEL, Named
from wirewear.effects import Age, ContactLaw, Loading, Seam, applied

#: Each cause at a size that changes nothing.
NOTHING: dict[str, Named] = {
    "overloaded_cell": {"loss": 0.0, "zero_N": 0.0, "cycle": 100.0},
    "loose_plug": {"zero_N": 0.0, "cycle_1": 10.0, "cycle_2": 100.0, "cycle_3": 1e3, "cycle_4": 1e4},
    "slew_limited_amplifier": {"N_per_s": 1e9},
    "crossover_distortion": {"band_N": 0.0},
    "averaging_logger": {"time_s": 0.0},
    "hard_spot": {"rise": 0.0, "place": 0.2, "width": 0.1},
    "debris_ridge": {"force_N": 0.0, "begins": 0.5, "cycles": 1e3},
    "thinning_grease": {"force_N": 0.0, "cycles": 1e3},
    "rattling_weight": {"share": 0.0, "frequency_Hz": 20.0, "time_s": 0.03},
    "cracking_flexure": {"um_per_N": 0.0, "cycles": 1e3, "power": 3.0},
    "wearing_pivot": {"gap_um": 0.0, "cycles": 1e3},
    "opening_joint": {"preload_N": 0.5, "um_per_N": 0.0},
    "microslipping_joint": {"um_per_N2": 0.0},
    "shedding_film": {"share": 0.0, "cycles": 1e3},
    "changing_air": {**{f"factor_{i}": 1.0 for i in (1, 2, 3)}, **{f"cycle_{i}": 10.0**i for i in (1, 2, 3)}},
    "swinging_load": {"share": 0.0, "cycles": 1e3, "phase_rad": 1.0},
    "incubated_wear": {"share": 0.0, "cycle": 1e3, "abruptness": 5.0},
    "hard_skin": {"factor": 1.0, "depth_um": 2.0},
    "used_wire": {"depth_um": 0.0, "aside_um": 0.0},
    "rolled_wire": {"crown_factor": 1.0},
}

#: Those that are read of a loop and leave it as it is, and those at the seams of a run.
READ = [effect for effect in WITHHELD if instruments_of([TrueEffect(effect, NOTHING[effect])], Nominal())]
AT_SEAMS = [effect for effect in OF_RUNS["withheld"] if effect not in READ]

#: What tells the ends of a stroke, or the directions, apart.
ONE_WAY = {"overloaded_cell", "loose_plug", "hard_spot", "debris_ridge"}


def seen(effect: str, signals: Signals = LOOP, at: float = 100.0, /, **parameters: float) -> Signals:
    return read_by(instruments_of([TrueEffect(effect, parameters)], Nominal()), signals, at)


def drawn(effect: str, seed: int = 1) -> Named:
    return drawn_parameters(effect, "easy", Nominal(), np.random.default_rng(seed))


@cache
def worn(effect: str = "", last: int = 2000, /, **parameters: float) -> tuple[Snapshot, Reading]:
    """Some thousand cycles on a coarse grid."""
    world = changed(STEEL, effect, parameters) if effect else STEEL
    *_, shot = snapshots(world, [last], 10)
    return shot, read(world, shot.loop, last)


def shown(effect: str, /, **parameters: float) -> Reading:
    return worn(effect, **parameters)[1]


def require_untouched(effect: str, nothing: Named) -> None:
    """See that a cause of no size leaves a test as it is."""
    (snapshot, found), (plain, expected) = worn(effect, **nothing), worn()
    assert found.displacement_mm == pytest.approx(expected.displacement_mm, abs=1e-9)
    assert found.tangential_force_N == pytest.approx(expected.tangential_force_N, abs=1e-6)
    assert found.normal_force_N == pytest.approx(expected.normal_force_N, abs=1e-9)
    assert snapshot.shapes.fixed == pytest.approx(plain.shapes.fixed, abs=1e-12)
    assert snapshot.shapes.moving == pytest.approx(plain.shapes.moving, abs=1e-12)


def require_traceless(effect: str, outside: Iterable[str], folder: Path) -> None:
    """See that a record is the same again, and that its files have one size without the cause."""
    model = IndependentModel(points=6, outside=tuple(outside))
    case = planned_cases(20, 2, LIBRARY_EFFECTS, model.outside)[0]
    true = TrueEffect(effect, drawn_parameters(effect, "easy", case.nominal, np.random.default_rng(1)))
    case = replace(case, effects=(true,))
    seen_ = {}
    for name, one in (("first", case), ("again", case), ("without", replace(case, effects=()))):
        written = write_traceless(folder / name, model.make(one).record)
        seen_[name] = written, {path.name: path.stat().st_size for path in (folder / name).iterdir()}
    assert seen_["first"] == seen_["again"]
    assert seen_["first"][0] != seen_["without"][0]
    assert seen_["first"][1] == seen_["without"][1]


def require_alike_at_seams(effect: str) -> None:
    """See that both tiers have the same holder, friction, load and wear at every cycle."""
    parameters = drawn(effect, 2)
    world = changed(STEEL, effect, parameters)
    changes = changes_of([TrueEffect(effect, parameters)], QUIET)
    believed_study(Nominal(), plain_nuisances(), NUMERICS["T1"]).with_effects(*changes)
    for cycle in (0.0, 10.0, 1000.0, 3e4, 1e5):
        age = Age(cycle, 0.0)
        holder = applied(changes, Seam.HOLDER, Holder(2.0, 1.0 / 167.0), age)
        assert holder.tangential_compliance_mm_per_N == pytest.approx(
            world.rig.series_mm_per_N + world.rig.loose_mm_per_N(cycle)
        )
        assert holder.play_mm == pytest.approx(world.rig.aged(cycle).play_mm)
        friction = applied(changes, Seam.CONTACT, ContactLaw(0.62), age).friction
        assert friction == pytest.approx(world.friction.at(cycle))
        load = applied(changes, Seam.LOADING, Loading(2.0), age).normal_load_N
        assert load == pytest.approx(world.loading.load_at(cycle))
        rates = applied(changes, Seam.WEAR, WearRates(0.5, 0.5), age)
        assert rates.lower_mm3_per_mJ == pytest.approx(0.5 * world.wear.factor_at(cycle))


def gaps_in_scatters(effect: str, points: int = 10) -> dict[str, float]:
    """Median size of a cause's gap over three tests, hard and easy."""
    model = IndependentModel("dahl", points=points)
    nuisances = replace(plain_nuisances(), drive="stroke", has_scars=True, has_normal_force=True)
    size: dict[str, list[float]] = {"hard": [], "easy": []}
    for ease, found in size.items():
        for place, test in enumerate(drawn_nominals(3, np.random.default_rng(77))):
            true = TrueEffect(effect, drawn_parameters(effect, ease, test, np.random.default_rng(place)))
            case = Case("a case", "outside", ease, (true,), (), test, nuisances, 1)
            found.append(max(model.differences(case).values()))
    return {ease: float(np.median(found)) for ease, found in size.items()}
