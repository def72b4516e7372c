"""A study and its refinements: what is refined, and what is said of the difference."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests import synthetic_results
from tests.studies import MINIMAL
from wirewear import StudyError, parse_study
from wirewear.results import Evolution
from wirewear.simulation import converge, discretise
from wirewear.simulation.convergence import BASE, compared, refined_study


def test_each_refinement_refines_one_resolution_and_leaves_the_others() -> None:
    study = refined_study(parse_study(MINIMAL, "s.toml"), "quick")
    plans = {name: discretise(study.variant(name), "quick") for name in study.variant_names}
    base = plans.pop(BASE)
    assert plans["mesh"].fixed.transverse.fine_mm == pytest.approx(base.fixed.transverse.fine_mm / 1.5)
    assert plans["mesh"].fixed.transverse.outer_mm == pytest.approx(base.fixed.transverse.outer_mm / 1.5)
    assert plans["increments"].increments_per_cycle == 1.5 * base.increments_per_cycle
    assert plans["jumps"].jump_tolerance == 0.5 * base.jump_tolerance
    for name, plan in plans.items():
        assert (plan.fixed == base.fixed) == (name != "mesh")
        assert (plan.jump_tolerance == base.jump_tolerance) == (name != "jumps")
        assert (plan.increments_per_cycle == base.increments_per_cycle) == (name != "increments")


def test_more_increments_are_more_of_those_that_only_wear_too() -> None:
    given = MINIMAL + "[fidelity.quick]\nincrements_per_cycle = 96\nincrements_per_wear_cycle = 24\n"
    study = refined_study(parse_study(given, "s.toml"), "quick")
    steps = {}
    for name in study.variant_names:
        plan = discretise(study.variant(name), "quick")
        steps[name] = plan.increments_per_cycle, plan.increments_per_wear_cycle
    assert steps.pop("increments") == (144, 36)
    assert set(steps.values()) == {(96, 24)}


def test_changes_are_relative_to_the_base_run() -> None:
    base = synthetic_results.result()
    deeper = {name: column * (1.1 if name == "max_depth_fixed_um" else 1.0) for name, column in base.evolution.items()}
    rows = compared({BASE: base, "mesh": replace(base, evolution=Evolution(deeper))})
    changes = {row.figure: row.changes["mesh"] for row in rows}
    assert changes.pop("depth of the fixed wire [µm]") == pytest.approx(0.1)
    assert set(changes.values()) == {0.0}


def test_a_study_with_variants_asks_which_of_them(tmp_path: Path) -> None:
    study = parse_study(MINIMAL + "[variants.slow.conditions]\nfrequency_Hz = 1\n", "s.toml")
    with pytest.raises(StudyError, match="--variant"):
        converge(study, fidelity="quick", output=tmp_path)
    assert not list(tmp_path.iterdir())
