"""The plan of a blind batch: kinds and effects in their shares, nominal tests that slip, and seeds."""

from collections import Counter

import numpy as np

from studies.blind.generators.cases import exact_class, planned_cases
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.nominal import MOST_LOST, WIDEST_SCAR, drawn_nominals
from tests.blind_batches import PlainModel

OUTSIDE = PlainModel().outside


def test_a_plan_holds_every_kind_in_its_share_and_every_effect_about_as_often() -> None:
    cases = planned_cases(400, 1, LIBRARY_EFFECTS, OUTSIDE)
    kinds = Counter(case.kind for case in cases)
    assert kinds["none"] == 80
    assert set(kinds) == {"none", "single", "pair", "outside", "left_out"}
    singles = Counter(case.effects[0].effect for case in cases if case.kind == "single")
    assert set(singles) == set(LIBRARY_EFFECTS)
    assert max(singles.values()) - min(singles.values()) <= 1
    assert all(len(case.effects) == (2 if case.kind == "pair" else case.kind != "none") for case in cases)


def test_a_plan_depends_on_its_seed_alone() -> None:
    first, again = (planned_cases(30, 7, LIBRARY_EFFECTS, OUTSIDE) for _ in range(2))
    assert first == again
    assert planned_cases(30, 8, LIBRARY_EFFECTS, OUTSIDE) != first


def test_cases_that_leave_their_effect_out_hide_among_others_that_leave_out_one_that_is_not_there() -> None:
    cases = planned_cases(400, 1, LIBRARY_EFFECTS, OUTSIDE)
    told = [case for case in cases if case.left_out]
    true = [case for case in told if case.kind == "left_out"]
    assert all(set(case.left_out) == exact_class(case.effects[0].effect) for case in true)
    assert 0.2 < len(true) / len(told) < 0.5
    for case in told:
        if case.kind != "left_out":
            assert not {effect.effect for effect in case.effects} & set(case.left_out)


def test_nominal_tests_slip_and_keep_their_scars_inside_the_wire() -> None:
    for nominal in drawn_nominals(50, np.random.default_rng(0)):
        assert nominal.expected_scar_mm < WIDEST_SCAR * nominal.diameter_mm / 2
        if nominal.stiffness_N_per_mm is not None:
            lost_um = 1e3 * nominal.friction * nominal.load_N / nominal.stiffness_N_per_mm
            assert lost_um < MOST_LOST * nominal.amplitude_um


def test_what_a_record_looks_like_depends_on_seed_and_place_not_on_its_effect() -> None:
    planned = planned_cases(60, 4, LIBRARY_EFFECTS, OUTSIDE)
    others = planned_cases(60, 4, LIBRARY_EFFECTS[:9], ())
    assert [case.effects for case in planned] != [case.effects for case in others]
    for case, other in zip(planned, others, strict=True):
        assert (case.name, case.nominal, case.nuisances, case.seed) == (
            other.name,
            other.nominal,
            other.nuisances,
            other.seed,
        )
