"""Causes of the reserved set: at all seams, the same again, without a trace, in both tiers alike, and how large."""

from pathlib import Path

import pytest

from studies.blind.generators.finite_element.changes import OUTSIDE_SETS as OF_RUNS
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.reserved import RESERVED
from studies.blind.generators.independent.unknown_causes import OUTSIDE_SETS
from studies.blind.generators.sizes import DRAWS
from studies.blind.generators.tiers import generator_of
from studies.blind.options import SETS_OF_CAUSES
from studies.blind.scoring.seams import OUTSIDE_SEAMS
from tests.reserved_causes import AT_SEAMS, NOTHING, READ
from tests.test_blind_unseen import require_read_alike
from tests.withheld_causes import (
    drawn,
    gaps_in_scatters,
    require_alike_at_seams,
    require_sizes_for_all_tests,
    require_traceless,
    require_untouched,
)
from wirewear.effects import Seam

#: What is worn or brought along at a place of its own: a finite element run has no seam for it.
OF_T2_ALONE = set(RESERVED) - {*READ, *AT_SEAMS}


def test_there_are_fourteen_kinds_and_more_at_all_seams_that_no_other_set_has() -> None:
    seams = [OUTSIDE_SEAMS[effect] for effect in RESERVED]
    assert len(RESERVED) >= 14
    assert all(seams.count(seam) >= 2 for seam in ("sensor", "contact", "holder", "loading"))
    assert set(seams) == set(Seam)
    assert set(NOTHING) == set(RESERVED) <= set(DRAWS)
    earlier = {effect for name, kinds in OUTSIDE_SETS.items() if name != "reserved" for effect in kinds}
    assert not set(RESERVED) & {*earlier, *LIBRARY_EFFECTS}


def test_a_batch_draws_from_the_set_and_ten_kinds_are_also_of_finite_elements() -> None:
    assert tuple(OUTSIDE_SETS) == SETS_OF_CAUSES
    assert generator_of("T2", outside="reserved").outside == tuple(RESERVED)
    for tier in ("T0", "T1"):
        assert len(generator_of(tier, outside="reserved").outside) >= 10
    assert set(OF_RUNS["reserved"]) == set(RESERVED) - OF_T2_ALONE
    assert {OUTSIDE_SEAMS[effect] for effect in OF_T2_ALONE} == {"wear", "specimens"}


@pytest.mark.parametrize("tier", ["T1", "T2"])
def test_manifests_name_the_set_no_more_than_any_other(tier: str) -> None:
    descriptions = {generator_of(tier, outside=one).description for one in ("withheld", "reserved")}
    assert len(descriptions) == 1
    assert not any(effect in one for effect in RESERVED for one in descriptions)


@pytest.mark.parametrize("effect", RESERVED)
def test_records_are_the_same_again_and_their_files_of_one_size_without_the_cause(effect: str, tmp_path: Path) -> None:
    require_traceless(effect, RESERVED, tmp_path)


@pytest.mark.parametrize("effect", RESERVED)
def test_a_cause_of_no_size_leaves_the_test_as_it_is(effect: str) -> None:
    require_untouched(effect, NOTHING[effect])


@pytest.mark.parametrize("effect", RESERVED)
def test_sizes_can_be_drawn_and_run_for_tests_of_every_kind(effect: str) -> None:
    require_sizes_for_all_tests(effect)


@pytest.mark.parametrize("effect", READ)
def test_both_tiers_read_the_same_of_the_same_loop(effect: str) -> None:
    require_read_alike(effect, drawn(effect))


@pytest.mark.parametrize("effect", AT_SEAMS)
def test_both_tiers_have_the_same_holder_friction_load_and_wear_at_every_cycle(effect: str) -> None:
    require_alike_at_seams(effect)


@pytest.mark.slow
@pytest.mark.parametrize("effect", RESERVED)
def test_sizes_of_gaps_lie_about_two_to_twenty_scatters(effect: str) -> None:
    size = gaps_in_scatters(effect, points=24)
    assert size["hard"] < size["easy"]
    assert 0.5 < size["hard"] < 8.0
    assert 3.5 < size["easy"] < 40.0
