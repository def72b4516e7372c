"""Oxygen that does not reach the middle of a contact: how far it gets, and what its lack does to scars."""

from copy import deepcopy
from typing import Any

import numpy as np
import pytest

from solvers import OxygenSupply, SolverError
from tests.test_planar_study import TABLES
from wirewear.planar import run_planar_study
from wirewear.planar.reading import planar_study_from_tables
from wirewear.results import RunResult

STARVED = {"name": "contact_oxygenation", "supply_W": 0.01, "starved_factor": 0.2}


def run(*effects: dict[str, Any], frequency_Hz: float = 20.0) -> RunResult:
    tables = deepcopy(TABLES) | {"effects": list(effects)}
    tables["conditions"] |= {"frequency_Hz": frequency_Hz, "cycles": 5000}
    tables["log"] = {"loop_cycles": [1, 5000]}
    return run_planar_study(planar_study_from_tables(tables, "study.toml"), fidelity="quick")


def test_oxygen_gets_as_far_as_the_root_of_its_supply_over_the_power_density() -> None:
    supply = OxygenSupply(0.3, 0.2, 2.0)
    assert supply.reach_mm(0.3) == pytest.approx(1.0)
    assert supply.reach_mm(1.2) == pytest.approx(0.5)
    factors = supply.factors(np.array([0.0, 0.6, 0.85, 1.0, 3.0]), 1.0)
    assert factors == pytest.approx([1.0, 1.0, 0.6, 0.2, 0.2])
    for bad in ((0.0, 0.2, 1.0), (1.0, -0.1, 1.0), (1.0, 0.2, 0.0)):
        with pytest.raises(SolverError, match="oxygen needs"):
            OxygenSupply(*bad)


@pytest.fixture(scope="module")
def nominal() -> RunResult:
    return run()


@pytest.mark.slow
def test_plenty_of_oxygen_changes_nothing_and_its_lack_takes_wear_by_the_factor(nominal: RunResult) -> None:
    plenty = run(STARVED | {"supply_W": 1e5})
    none = run(STARVED | {"supply_W": 1e-8})
    area = {r: r.worn_volume_mm3[-1] for r in (nominal, plenty, none)}
    energy = {r: r.evolution["accumulated_energy_J"][-1] for r in (nominal, plenty, none)}
    assert area[plenty] == pytest.approx(area[nominal], rel=1e-9)
    # Nodes that a jump brings into contact breathe.
    assert area[none] / energy[none] == pytest.approx(0.2 * area[nominal] / energy[nominal], rel=0.1)


@pytest.mark.slow
def test_a_faster_test_wears_less_per_energy_and_books_close(nominal: RunResult) -> None:
    rates = []
    for frequency in (2.0, 200.0):
        result = run(STARVED, frequency_Hz=frequency)
        assert result.quality["volume_against_energy"] < 1e-9
        assert result.quality["mirror_error"] < 1e-6
        rates.append(result.evolution["worn_volume_pad_mm3"][-1] / result.evolution["accumulated_energy_J"][-1])
    whole = nominal.evolution["worn_volume_pad_mm3"][-1] / nominal.evolution["accumulated_energy_J"][-1]
    assert rates[1] < rates[0] <= whole * (1.0 + 1e-9)
