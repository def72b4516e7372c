"""Thirty-nine tests of titanium: what the script says of them follows from the table, either way."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy import stats

from studies.titanium_energy.compare import (
    FINDINGS,
    main,
    only_w_shaped_tests_are_off,
    w_shaped_tests_are_off,
)
from studies.titanium_energy.laws import energy_line, off_the_line
from studies.titanium_energy.measured import MeasuredTest, read_tests


@pytest.fixture(scope="module")
def tests() -> tuple[MeasuredTest, ...]:
    return read_tests()


def test_the_line_and_its_interval_are_those_of_a_regression_through_the_origin() -> None:
    """A test made by the line with known scatter: its figures by Student's t, worked out apart."""
    energy = np.array([1000.0, 2000.0, 3000.0, 5000.0])
    volume = 2e-4 * energy + np.array([0.01, -0.02, 0.01, 0.0])
    made = [replace(read_tests()[0], energy_J=e, volume_mm3=v) for e, v in zip(energy, volume, strict=True)]
    line = energy_line(made)
    slope = float(volume @ energy / (energy @ energy))
    scatter = float(np.sqrt(((volume - slope * energy) ** 2).sum() / 3))
    half = float(stats.t.ppf(0.975, 3) * scatter * np.sqrt(1 + 4000.0**2 / (energy @ energy)))
    assert line.coefficient_mm3_per_J == pytest.approx(slope)
    assert line.predicted_mm3(4000.0) == pytest.approx((4000.0 * slope, half))
    assert np.ptp(line.interval_mm3_per_J) < 2.0 * half / 4000.0


def test_the_prediction_interval_holds_a_further_test_in_95_of_100_cases() -> None:
    rng, hits = np.random.default_rng(1), 0
    base = read_tests()[0]
    for _ in range(400):
        energy = rng.uniform(500.0, 10000.0, 12)
        volume = 3e-4 * energy + rng.normal(0.0, 0.3, 12)
        made = [replace(base, energy_J=e, volume_mm3=v) for e, v in zip(energy, volume, strict=True)]
        predicted, half = energy_line(made[1:]).predicted_mm3(made[0].energy_J)
        hits += abs(made[0].volume_mm3 - predicted) <= half
    assert 0.92 <= hits / 400 <= 0.98


def test_all_w_shaped_tests_leave_the_line_and_three_others_do_too(tests: tuple[MeasuredTest, ...]) -> None:
    off = {t.name for t in off_the_line(tests)}
    assert off >= {t.name for t in tests if t.scar == "W"}
    assert off - {t.name for t in tests if t.scar == "W"} == {"RP_f_25", "RP_f_26", "RP_f_28"}
    assert w_shaped_tests_are_off(tests).holds
    assert not only_w_shaped_tests_are_off(tests).holds


def test_the_script_prints_its_verdicts_and_draws(tmp_path: Path) -> None:
    outcome = CliRunner().invoke(main, ["--output", str(tmp_path / "new")])
    assert outcome.exit_code == 0, outcome.output
    assert outcome.output.count("holds") + outcome.output.count("does not hold") >= len(FINDINGS)
    assert (tmp_path / "new" / "titanium_energy.png").exists()
