"""Causes of the withheld set: at all seams, the same again, without a trace, in both tiers alike, and how large."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from studies.blind.generators.cases import Case, TrueEffect, planned_cases
from studies.blind.generators.finite_element.changes import OUTSIDE_SETS as OF_RUNS
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.fair_size import fair_size
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.independent.unknown_causes import DEVELOPMENT, FIRST, SEALED, UNSEEN
from studies.blind.generators.independent.withheld import WITHHELD
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.sizes import drawn_parameters
from studies.blind.generators.tiers import generator_of
from studies.blind.scoring.seams import OUTSIDE_SEAMS
from tests.test_blind_finite_element import plain_nuisances
from tests.test_blind_unseen import require_read_alike
from tests.withheld_causes import (
    AT_SEAMS,
    NOTHING,
    READ,
    drawn,
    gaps_in_scatters,
    require_alike_at_seams,
    require_sizes_for_all_tests,
    require_traceless,
    require_untouched,
)
from wirewear.effects import Seam


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
    require_traceless(effect, WITHHELD, tmp_path)


@pytest.mark.parametrize("effect", WITHHELD)
def test_a_cause_of_no_size_leaves_the_test_as_it_is(effect: str) -> None:
    require_untouched(effect, NOTHING[effect])


@pytest.mark.parametrize("effect", WITHHELD)
def test_sizes_can_be_drawn_and_run_for_tests_of_every_kind(effect: str) -> None:
    require_sizes_for_all_tests(effect)


@pytest.mark.parametrize("effect", READ)
def test_both_tiers_read_the_same_of_the_same_loop(effect: str) -> None:
    require_read_alike(effect, drawn(effect))


@pytest.mark.parametrize("effect", AT_SEAMS)
def test_both_tiers_have_the_same_holder_friction_load_and_wear_at_every_cycle(effect: str) -> None:
    require_alike_at_seams(effect)


@pytest.mark.slow
def test_sizes_of_gaps_lie_about_two_to_twenty_scatters() -> None:
    for effect in WITHHELD:
        size = gaps_in_scatters(effect)
        assert size["hard"] < size["easy"], effect
        assert 0.5 < size["hard"] < 15.0, effect
        assert 4.0 < size["easy"] < 50.0, effect


@pytest.mark.slow
def test_fair_sizes_are_found_for_withheld_causes() -> None:
    model = IndependentModel("dahl", points=24, library=("tangential_compliance", "friction_offset"))
    nuisances = replace(plain_nuisances(), drive="stroke", has_scars=True, has_normal_force=True)
    test = Nominal(cycles=20_000)
    for effect in ("hard_spot", "wearing_pivot", "used_wire"):
        true = TrueEffect(effect, drawn_parameters(effect, "easy", test, np.random.default_rng(1)))
        assert fair_size(Case("a case", "outside", "easy", (true,), (), test, nuisances, 1), model) > 1.0, effect
