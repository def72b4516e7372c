"""Rig stiffness studies: what their files may hold, what a run leaves, and what rotation changes."""

import tomllib
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from studies.rig_stiffness_2d.compare import (
    Case,
    cases,
    comparisons,
    findings,
    identical_in_gross_slip,
    slip_falls_at_the_edges,
    slips_less_where_it_lifts,
    tables_figure,
)
from studies.rig_stiffness_2d.compare import main as compare
from wirewear.cli import cli
from wirewear.cli.study_kinds import load_any_study
from wirewear.errors import ResultError, StudyError
from wirewear.planar.rig_stiffness import (
    RigStiffnessResult,
    differences,
    read_rig_stiffness_result,
    run_rig_stiffness_study,
)
from wirewear.planar.rig_stiffness.model import plan_contact
from wirewear.planar.rig_stiffness.reading import rig_stiffness_study_from_tables
from wirewear.planar.rig_stiffness.results import RigStiffnessRun, scenario_difference, write_rig_stiffness_result
from wirewear.planar.rig_stiffness.tables import RigStiffnessStudy

STUDY = Path(__file__).resolve().parent.parent / "studies" / "rig_stiffness_2d" / "study.toml"


def tables() -> dict[str, Any]:
    return tomllib.loads(STUDY.read_text(encoding="utf-8"))


def study(*, contact: str, cases: tuple[int, ...], **mesh: float) -> RigStiffnessStudy:
    """The shipped study with one contact, some of its cases, and another resolution."""
    changed = tables()
    del changed["flat" if contact == "cylinder" else "cylinder"]
    for key in ("tangential_stiffness_N_per_mm2", "rotational_stiffness_N_per_rad"):
        changed[contact][key] = [changed[contact][key][case - 1] for case in cases]
    changed["mesh"] = mesh
    return rig_stiffness_study_from_tables(changed, "study.toml")


def run_of(case: int, scenario: int, *, contact: str = "flat", centre_um: float = 0.0) -> RigStiffnessRun:
    """A made-up run: an elliptic pressure 1 mm wide about a centre."""
    x = np.linspace(-2000.0, 2000.0, 801)
    pressure = 100.0 * np.sqrt(np.maximum(1.0 - ((x - centre_um) / 500.0) ** 2, 0.0))
    angle = 2.0 * np.pi * np.arange(16) / 16
    return RigStiffnessRun(
        contact=contact,
        case=case,
        scenario=scenario,
        stiffness=(7.0e3, 3.17e5)[scenario - 1],
        regime="partial slip",
        measured_stiffness_N_per_mm2=6.1e3,
        largest_tilt_deg=0.0 if scenario == 1 else 0.18,
        largest_force_N_per_mm=200.0,
        slip_amplitude_of_loop_um=1.0,
        dissipated_energy_mJ_per_mm=0.1,
        pressure_centre_um=centre_um,
        pressed_width_um=1000.0,
        max_pressure_MPa=100.0,
        cycles=3,
        shakedown_change=1e-3,
        force_balance=1e-12,
        penetration=1e-12,
        complementarity=1e-12,
        displacement_um=35.0 * np.cos(angle),
        tangential_force_N_per_mm=200.0 * np.cos(angle - 0.1),
        tilt_deg=0.18 * np.cos(angle),
        x_um=x,
        pressure_MPa=pressure,
        shear_MPa=0.5 * pressure,
        slip_amplitude_um=np.where(pressure > 0.0, 2.0, 0.0),
    )


def test_the_shipped_study_has_the_articles_springs_and_runs_all_alike_do_not_bear_out_its_findings() -> None:
    shipped = load_any_study(STUDY)
    assert isinstance(shipped, RigStiffnessStudy)
    assert plan_contact(shipped, "cylinder", "standard").pad.along.fine_mm == pytest.approx(0.005)
    made_up = [
        replace(run_of(case, scenario, contact=name), stiffness=stiffness)
        for name, contact in shipped.contacts.items()
        for scenario, springs in (
            (1, contact.tangential_stiffness_N_per_mm2),
            (2, contact.rotational_stiffness_N_per_rad),
        )
        for case, stiffness in enumerate(map(float, springs), start=1)
    ]
    result = RigStiffnessResult("all", "quick", {}, {}, tuple(made_up))
    found = cases(result)
    assert len(found) == 8
    holds = {finding.statement: finding.holds for finding in findings(found, list(differences(result)))}
    assert [statement for statement, held in holds.items() if held] == [
        "cylinder: both scenarios give the same loop (within 1 % of its largest force)"
    ]
    sliding = [replace(run, regime="gross slip") for run in made_up]
    gross = cases(RigStiffnessResult("all", "quick", {}, {}, tuple(sliding)))
    assert identical_in_gross_slip(gross[4:], list(differences(result))[4:]).holds
    of_the_article = [row for row in comparisons(found) if "translating [" in row.name]
    assert [row.name for row in of_the_article if row.holds] == ["flat 1: K_t,m translating [N/mm²]"]


@pytest.mark.parametrize(
    ("table", "values", "complaint"),
    [
        ("cylinder", {"radius_mm": -1.0}, r"radius_mm in \[cylinder\] of study.toml is -1.0, but must lie between"),
        ("flat", {"edge_radius_um": 3.0}, "given as edge_radius_mm, in millimetres"),
        ("flat", {"tangential_stiffness_N_per_mm2": 7e3}, "must be a list with a number for each case"),
        ("flat", {"rotational_stiffness_N_per_rad": "stiff"}, 'or "equal"'),
        ("flat", {"tangential_stiffness_N_per_mm2": [7e3, "soft"]}, "holds an item that is the text 'soft'"),
        ("flat", {"tangential_stiffness_N_per_mm2": [7e3]}, "gives 1 tangential and 4 rotational stiffnesses"),
        ("flat", {"rotational_stiffness_N_per_rad": [5e3, 1e6, 1e6, 1e6]}, "the pad tips over"),
        ("conditions", {"most_cycles": 1}, "most_cycles in .conditions. of study.toml is 1, but must"),
    ],
)
def test_a_mistake_in_a_rig_stiffness_study_is_told_in_one_sentence(
    table: str, values: dict[str, Any], complaint: str
) -> None:
    changed = deepcopy(tables())
    changed[table] |= values
    with pytest.raises(StudyError, match=complaint):
        rig_stiffness_study_from_tables(changed, "study.toml")


def test_a_study_without_a_contact_is_refused() -> None:
    changed = tables()
    del changed["cylinder"], changed["flat"]
    with pytest.raises(StudyError, match=r"has no contact: give a table \[cylinder\] or \[flat\]"):
        rig_stiffness_study_from_tables(changed, "study.toml")


def test_a_pad_too_narrow_for_its_contact_is_refused() -> None:
    changed = tables()
    changed["cylinder"]["pad_half_width_mm"] = 0.7
    with pytest.raises(StudyError, match=r"\[cylinder\]: the pad is too narrow"):
        plan_contact(rig_stiffness_study_from_tables(changed, "study.toml"), "cylinder", "quick")


def test_a_pressure_that_only_moves_is_not_reshaped() -> None:
    difference = scenario_difference(run_of(1, 1), run_of(1, 2, centre_um=-120.0))
    assert difference.pressure_centre_um == pytest.approx(-120.0)
    assert difference.pressure_reshaped < 1e-3
    narrower = replace(run_of(1, 2), pressure_MPa=2.0 * np.interp(2.0 * run_of(1, 2).x_um, *_profile()))
    # Semi-ellipses of the same area, one twice as narrow, cross at 1/sqrt(5) of the wider one's half-width.
    exact = 2.0 / np.pi * (np.arcsin(2.0 / np.sqrt(5.0)) - np.arcsin(1.0 / np.sqrt(5.0)))
    assert scenario_difference(run_of(1, 1), narrower).pressure_reshaped == pytest.approx(exact, rel=1e-2)


def _profile() -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    run = run_of(1, 1)
    return run.x_um, run.pressure_MPa


def test_a_result_reads_back_as_it_was_written(tmp_path: Path) -> None:
    result = RigStiffnessResult("made up", "quick", {"a": 1}, {}, (run_of(1, 1), run_of(1, 2)))
    write_rig_stiffness_result(tmp_path, result)
    again = read_rig_stiffness_result(tmp_path)
    assert [run.scalars for run in again.runs] == [run.scalars for run in result.runs]
    assert np.array_equal(again.runs[1].shear_MPa, result.runs[1].shear_MPa)
    assert (tmp_path / "cases.csv").read_text().count("\n") == 3
    with pytest.raises(ResultError, match="there is no result file"):
        read_rig_stiffness_result(tmp_path / "nothing.h5")


def test_slip_at_edges_and_where_a_pad_lifts_is_judged_by_the_runs() -> None:
    row: dict[str, float | str | None] = {}
    one, two = run_of(1, 1), run_of(1, 2)
    edge = np.abs(one.x_um) > 400.0
    less = replace(two, slip_amplitude_um=np.where(edge, 0.5, 1.0) * two.slip_amplitude_um)
    assert slip_falls_at_the_edges([Case(row, one, less)]).holds
    assert not slip_falls_at_the_edges([Case(row, less, two)]).holds
    lifted = replace(less, pressure_MPa=np.where(one.x_um > 400.0, 0.0, less.pressure_MPa))
    assert slips_less_where_it_lifts([Case(row, one, lifted)]).holds
    assert not slips_less_where_it_lifts([Case(row, one, less)]).holds
    assert not slips_less_where_it_lifts([Case(row, replace(one, slip_amplitude_um=0.1 * one.x_um**0), lifted)]).holds


@pytest.mark.slow
def test_a_rotational_spring_is_found_with_which_the_loop_is_as_stiff() -> None:
    """Within 3 % of the article's spring for the same contact, and the same loop."""
    changed = tables()
    del changed["flat"]
    changed["cylinder"] |= {"tangential_stiffness_N_per_mm2": [1.0e4], "rotational_stiffness_N_per_rad": "equal"}
    changed["mesh"] = {"contact_mesh_um": 30.0, "increments_per_cycle": 32}
    result = run_rig_stiffness_study(rig_stiffness_study_from_tables(changed, "study.toml"))
    one, two = result.runs
    assert two.measured_stiffness_N_per_mm2 == pytest.approx(one.measured_stiffness_N_per_mm2, rel=2e-3)
    assert two.stiffness == pytest.approx(1.06e6, rel=0.03)
    assert differences(result)[0].loop < 0.01


def test_a_run_with_other_springs_is_not_compared_with_the_article(tmp_path: Path) -> None:
    other = replace(run_of(1, 1), stiffness=1.0e3)
    write_rig_stiffness_result(tmp_path, RigStiffnessResult("other", "quick", {}, {}, (other, run_of(1, 2))))
    answer = CliRunner().invoke(compare, [str(tmp_path)])
    assert answer.exit_code == 2
    assert "flat, case 1 is no case of the article" in answer.stderr


@pytest.mark.slow
def test_a_cylinder_gives_the_same_loop_whether_its_rig_translates_or_rotates() -> None:
    result = run_rig_stiffness_study(
        study(contact="cylinder", cases=(1,), contact_mesh_um=30.0, increments_per_cycle=32)
    )
    (difference,) = differences(result)
    assert difference.loop < 0.01
    assert difference.pressure_reshaped < 0.01
    case = cases(result)[0]
    assert case.translating.measured_stiffness_N_per_mm2 == pytest.approx(4.35e3, rel=0.05)
    assert case.rotating.largest_tilt_deg == pytest.approx(0.167, rel=0.08)
    assert {case.translating.regime, case.rotating.regime} == {"partial slip"}
    run = case.translating
    # In a cycle each point slides four times its amplitude against friction times pressure.
    work = 4e-6 * 0.9 * np.trapezoid(run.pressure_MPa * run.slip_amplitude_um, run.x_um)
    assert work == pytest.approx(run.dissipated_energy_mJ_per_mm, rel=0.05)


@pytest.mark.slow
def test_a_tilting_flat_presses_on_its_edge_and_is_as_stiff_as_the_article_says(tmp_path: Path) -> None:
    chosen = study(contact="flat", cases=(1,), contact_mesh_um=40.0, increments_per_cycle=32)
    told: list[float] = []
    result = run_rig_stiffness_study(chosen, output=tmp_path, progress=lambda share, _: told.append(share))
    assert told == sorted(told)
    assert told[-1] <= 1.0
    assert (tmp_path / "flat.png").stat().st_size > 10_000
    found = cases(read_rig_stiffness_result(tmp_path))
    assert all(row.holds for row in comparisons(found))
    pressure, narrowing, *_ = findings(found, list(differences(result)))
    assert narrowing.holds
    assert "share of the load" in pressure.evidence
    (difference,) = differences(result)
    assert difference.pressure_reshaped > 0.1
    assert difference.pressure_centre_um < -500.0
    assert tables_figure(found).axes[0].lines
    assert max(run.force_balance for run in result.runs) < 1e-8


def test_variants_and_resumption_do_not_apply(tmp_path: Path) -> None:
    answer = CliRunner().invoke(cli, ["run", str(STUDY), "--resume", "--output", str(tmp_path)])
    assert answer.exit_code == 2
    assert "--resume does not apply" in answer.stderr
