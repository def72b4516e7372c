"""Drives that hold a figure of the loop by their amplitude, and tests that stop where the worn contact says so."""

from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solvers import SolverError
from tests.studies import COARSE, WEARING, coarse
from tests.test_planar_study import TABLES
from wirewear import StudyError
from wirewear.effects.sensors import DisplacementGain
from wirewear.planar import planar_study_from_tables, run_planar_study
from wirewear.simulation.ending import FIGURES, Ending
from wirewear.simulation.runs import run_study, simulate
from wirewear.study.tables import Stop

ON_A_RIG = (
    COARSE.replace("cycles = 1\n", "cycles = 200\n{held}\n")
    + WEARING
    + "[holder]\n"
    + ("tangential_stiffness_N_per_mm = 167.0\n")
)


def held(text: str, base: str = ON_A_RIG) -> str:
    return base.replace("{held}", text)


@pytest.mark.parametrize(
    ("key", "target", "column"),
    [
        ("held_slip_amplitude_um", 8.0, "slip_amplitude_um"),
        ("held_tangential_force_N", 0.9, "max_tangential_force_N"),
        ("held_energy_mJ", 0.03, "dissipated_energy_mJ"),
    ],
)
def test_what_a_drive_holds_is_held_at_every_loop_by_its_amplitude(key: str, target: float, column: str) -> None:
    evolution = simulate(coarse(held(f"{key} = {target}")), fidelity="quick").evolution
    assert evolution[column] == pytest.approx(target, rel=2.5e-3)
    assert np.abs(evolution["held_error"]).max() <= 2e-3
    assert evolution["displacement_amplitude_um"].max() < 20.0


def test_a_held_motion_is_that_of_the_bodies_against_each_other() -> None:
    result = simulate(coarse(held("held_motion_um = 9.0")), fidelity="quick")
    for loop in result.loops:
        assert 0.5 * np.ptp(loop.relative_displacement_um) == pytest.approx(9.0, rel=2e-3)


def test_a_held_reading_is_wrong_by_the_gain_of_its_sensor() -> None:
    study = coarse(held("held_reading_um = 12.0")).with_effects(DisplacementGain(gain=1.2))
    evolution = simulate(study, fidelity="quick").evolution
    assert evolution["displacement_amplitude_um"] == pytest.approx(10.0, rel=1e-3)


def test_line_contacts_hold_too() -> None:
    tables = deepcopy(TABLES)
    tables["conditions"] |= {"cycles": 200, "held_energy_mJ_per_mm": 0.3}
    tables["log"] = {"loop_cycles": [1, 200]}
    evolution = run_planar_study(planar_study_from_tables(tables, "study.toml"), fidelity="quick").evolution
    assert evolution["dissipated_energy_mJ"] == pytest.approx(0.3, rel=3e-3)


def test_a_force_above_friction_cannot_be_held_and_the_run_says_so() -> None:
    with pytest.raises(
        SolverError, match=r"cannot hold held_tangential_force_N = 1.5: at its largest amplitude, 20 um"
    ):
        simulate(coarse(held("held_tangential_force_N = 1.5")), fidelity="quick")


def test_a_drive_holds_one_figure() -> None:
    with pytest.raises(StudyError, match="held_energy_mJ are both given, but a drive holds one"):
        coarse(held("held_slip_amplitude_um = 5\nheld_energy_mJ = 1"))


def test_a_test_stops_where_a_scar_is_as_deep_as_stated(tmp_path: Path) -> None:
    study = coarse(held("") + "[stop]\ndepth_um = 0.25\naccumulated_energy_J = 5.0\n").with_values(
        {"conditions.cycles": 20_000}
    )
    (result,) = run_study(study, fidelity="quick", output=tmp_path)
    end = result.evolution["cycle"][-1]
    deepest = max(float(result.evolution[f"max_depth_{body}_um"][-1]) for body in ("moving", "fixed"))
    assert deepest == pytest.approx(0.25, rel=max(2e-3, 1.0 / end))
    assert result.status == "complete"
    assert result.message.endswith("cycles simulated: depth_um has reached its stop")
    assert result.loops[-1].cycle == end
    (again,) = run_study(study, fidelity="quick", output=tmp_path, resume=True)
    assert again.evolution["cycle"][-1] == end


def grown(figures: dict[float, float], target: float) -> Ending:
    ending = Ending({"depth_um": target})
    ending.course["depth_um"] = list(figures.items())
    return ending


def test_the_end_is_foreseen_where_a_figure_grows_by_a_power_of_the_cycles() -> None:
    ending = grown({float(n): 0.1 * n**0.5 for n in (1, 10, 100, 400, 1000, 2000, 4000)}, 20.0)
    assert ending.foreseen() == "; depth_um = 20 is expected after 40\u2009000 cycles (40\u2009000 to 40\u2009000)"


def test_the_interval_of_a_foreseen_end_holds_that_of_a_power_that_changes() -> None:
    def depth(n: float) -> float:
        return float(0.1 * n**0.5 / (1.0 + n / 2e4))

    ending = grown({float(n): depth(n) for n in (1, 10, 100, 400, 1000, 2000, 4000)}, depth(8000.0))
    ends: Any = ending._ends("depth_um")
    assert ends[1] < 8000.0 < ends[2]


@pytest.mark.parametrize("figures", [{}, {1.0: 0.1}, {1.0: 0.1, 2.0: 0.1, 8.0: 0.1, 16.0: 0.1}])
def test_no_end_is_foreseen_of_a_figure_that_is_young_or_does_not_grow(figures: dict[float, float]) -> None:
    assert grown(figures, 20.0).foreseen() == ""


def test_every_figure_that_a_study_may_state_is_known() -> None:
    assert set(FIGURES) == set(Stop.model_fields)
