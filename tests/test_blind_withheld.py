"""Causes of the withheld set: at all seams, the same again, without a trace, in both tiers alike, and how large."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from solvers import Holder, WearRates
from tests.test_blind_finite_element import plain_nuisances
from tests.test_blind_unseen import QUIET, STEEL, require_read_alike
from tests.withheld_causes import AT_SEAMS, NOTHING, READ, drawn, worn
from wirewear.blind.cases import Case, TrueEffect, planned_cases
from wirewear.blind.files import write_traceless
from wirewear.blind.finite_element.changes import OUTSIDE_SETS as OF_RUNS
from wirewear.blind.finite_element.changes import changes_of
from wirewear.blind.finite_element.model import NUMERICS, believed_study
from wirewear.blind.generator import LIBRARY_EFFECTS
from wirewear.blind.independent.effects import changed
from wirewear.blind.independent.fair_size import fair_size
from wirewear.blind.independent.model import IndependentModel
from wirewear.blind.independent.unknown_causes import DEVELOPMENT, FIRST, SEALED, UNSEEN
from wirewear.blind.independent.withheld import WITHHELD
from wirewear.blind.nominal import Nominal, drawn_nominals
from wirewear.blind.scoring.seams import OUTSIDE_SEAMS
from wirewear.blind.sizes import drawn_parameters
from wirewear.blind.tiers import generator_of
from wirewear.effects import Age, ContactLaw, Loading, Seam, applied


def test_there_are_twelve_kinds_and_more_at_all_seams_that_no_other_set_has() -> None:
    seams = [OUTSIDE_SEAMS[effect] for effect in WITHHELD]
    assert len(WITHHELD) >= 12
    assert all(seams.count(seam) >= 2 for seam in ("sensor", "holder", "contact"))
    assert set(seams) == set(Seam)
    assert set(NOTHING) == set(WITHHELD)
    assert not set(WITHHELD) & {*FIRST, *DEVELOPMENT, *SEALED, *UNSEEN, *LIBRARY_EFFECTS}


def test_a_batch_draws_from_the_set_and_eight_kinds_are_also_of_finite_elements() -> None:
    assert generator_of("T2", outside="withheld").outside == tuple(WITHHELD)
    for tier in ("T0", "T1"):
        assert len(generator_of(tier, outside="withheld").outside) >= 8
    assert set(OF_RUNS["withheld"]) == {*READ, *AT_SEAMS} < set(WITHHELD)
    assert {OUTSIDE_SEAMS[effect] for effect in OF_RUNS["withheld"]} == set(Seam) - {"specimens"}


@pytest.mark.parametrize("tier", ["T1", "T2"])
def test_manifests_name_the_set_no_more_than_any_other(tier: str) -> None:
    descriptions = {generator_of(tier, outside=one).description for one in ("sealed", "unseen", "withheld")}
    assert len(descriptions) == 1
    assert not any(effect in one for effect in WITHHELD for one in descriptions)


def test_planned_cases_are_the_same_again_and_look_alike_whatever_set_they_draw_from() -> None:
    plans = [planned_cases(40, 6, LIBRARY_EFFECTS, tuple(outside)) for outside in (WITHHELD, WITHHELD, UNSEEN)]
    assert plans[0] == plans[1]
    looks = [[(case.nominal, case.nuisances, case.seed) for case in plan] for plan in plans]
    assert looks[0] == looks[2]


@pytest.mark.parametrize("effect", ["crossover_distortion", "loose_plug", "opening_joint", "used_wire"])
def test_records_are_the_same_again_and_their_files_of_one_size_without_the_cause(effect: str, tmp_path: Path) -> None:
    model = IndependentModel(points=6, outside=tuple(WITHHELD))
    case = planned_cases(20, 2, LIBRARY_EFFECTS, model.outside)[0]
    case = replace(
        case, effects=(TrueEffect(effect, drawn_parameters(effect, "easy", case.nominal, np.random.default_rng(1))),)
    )
    seen = {}
    for name, one in (("first", case), ("again", case), ("without", replace(case, effects=()))):
        written = write_traceless(tmp_path / name, model.make(one).record)
        seen[name] = written, {path.name: path.stat().st_size for path in (tmp_path / name).iterdir()}
    assert seen["first"] == seen["again"]
    assert seen["first"][0] != seen["without"][0]
    assert seen["first"][1] == seen["without"][1]


@pytest.mark.parametrize("effect", WITHHELD)
def test_a_cause_of_no_size_leaves_the_test_as_it_is(effect: str) -> None:
    (snapshot, found), (plain, expected) = worn(effect, **NOTHING[effect]), worn()
    assert found.displacement_mm == pytest.approx(expected.displacement_mm, abs=1e-9)
    assert found.tangential_force_N == pytest.approx(expected.tangential_force_N, abs=1e-6)
    assert found.normal_force_N == pytest.approx(expected.normal_force_N, abs=1e-9)
    assert snapshot.shapes.fixed == pytest.approx(plain.shapes.fixed, abs=1e-12)
    assert snapshot.shapes.moving == pytest.approx(plain.shapes.moving, abs=1e-12)


@pytest.mark.parametrize("effect", WITHHELD)
def test_sizes_can_be_drawn_and_run_for_tests_of_every_kind(effect: str) -> None:
    random = np.random.default_rng(3)
    for nominal in drawn_nominals(8, random):
        for ease in ("hard", "easy"):
            parameters = drawn_parameters(effect, ease, nominal, random)
            assert all(np.isfinite(value) for value in parameters.values())
            assert changed(STEEL, effect, parameters) != STEEL


@pytest.mark.parametrize("effect", READ)
def test_both_tiers_read_the_same_of_the_same_loop(effect: str) -> None:
    require_read_alike(effect, drawn(effect))


@pytest.mark.parametrize("effect", AT_SEAMS)
def test_both_tiers_have_the_same_holder_friction_load_and_wear_at_every_cycle(effect: str) -> None:
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


@pytest.mark.slow
def test_sizes_of_gaps_lie_about_two_to_twenty_scatters() -> None:
    model = IndependentModel("dahl", points=10)
    nuisances = replace(plain_nuisances(), drive="stroke", has_scars=True, has_normal_force=True)
    tests = drawn_nominals(3, np.random.default_rng(77))
    for effect in WITHHELD:
        size: dict[str, list[float]] = {"hard": [], "easy": []}
        for ease, found in size.items():
            for place, test in enumerate(tests):
                true = TrueEffect(effect, drawn_parameters(effect, ease, test, np.random.default_rng(place)))
                case = Case("a case", "outside", ease, (true,), (), test, nuisances, 1)
                found.append(max(model.differences(case).values()))
        assert np.median(size["hard"]) < np.median(size["easy"]), effect
        assert 0.5 < np.median(size["hard"]) < 15.0, effect
        assert 4.0 < np.median(size["easy"]) < 50.0, effect


@pytest.mark.slow
def test_fair_sizes_are_found_for_withheld_causes() -> None:
    model = IndependentModel("dahl", points=24, library=("tangential_compliance", "friction_offset"))
    nuisances = replace(plain_nuisances(), drive="stroke", has_scars=True, has_normal_force=True)
    test = Nominal(cycles=20_000)
    for effect in ("hard_spot", "wearing_pivot", "used_wire"):
        true = TrueEffect(effect, drawn_parameters(effect, "easy", test, np.random.default_rng(1)))
        assert fair_size(Case("a case", "outside", "easy", (true,), (), test, nuisances, 1), model) > 1.0, effect
