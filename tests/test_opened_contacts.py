"""Loops whose normal force falls to zero within the cycle, as where wear parts bodies under a held approach."""

import contextlib
import dataclasses
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tests.studies import minimal
from tests.synthetic_loops import Recipe, SyntheticLoop
from tests.synthetic_results import result
from wirewear import RunResult, record_of_result
from wirewear.faces import cli
from wirewear.loops import LoopError, analyse_loop, position_resolved_friction
from wirewear.loops.cleaning import OPENS
from wirewear.results import write_result
from wirewear.views.comparison import compare
from wirewear.views.run_page import write_page


def opening(count: int) -> np.ndarray:
    """A normal force that is zero about mid-stroke and presses towards both ends."""
    phase = 2.0 * np.pi * np.arange(count) / count
    return np.asarray(np.maximum(2.0 * np.abs(np.sin(phase)) - 0.5, 0.0))


def test_a_loop_that_opens_has_all_figures_but_coefficients_of_friction() -> None:
    _, displacement, force = SyntheticLoop(Recipe()).sampled(200)
    without = analyse_loop(displacement, force)
    opened = analyse_loop(displacement, force, opening(200))
    assert opened.friction_max is opened.friction_energy is opened.friction_geometry_independent is None
    for name in ("displacement_amplitude_um", "slip_amplitude_um", "dissipated_energy_mJ"):
        assert getattr(opened, name).value == getattr(without, name).value
    assert OPENS in opened.notes
    assert OPENS not in without.notes
    assert not any("no normal force was given" in note for note in opened.notes)
    assert any("no normal force was given" in note for note in without.notes)


def test_a_loop_that_dissipates_nothing_tells_no_friction_by_its_energy() -> None:
    displacement = 60.0 * np.sin(2.0 * np.pi * np.arange(64) / 64)
    figures = analyse_loop(displacement, np.where(np.abs(displacement) > 55.0, 1e-3 * displacement, 0.0), 1.0)
    assert figures.dissipated_energy_mJ.value == 0.0
    assert figures.friction_energy is None


@pytest.mark.parametrize("samples", [16, 24, 40, 64, 96])
def test_any_loop_of_a_contact_that_touches_for_a_part_of_the_stroke_is_analysed_or_refused(samples: int) -> None:
    phase = 2.0 * np.pi * np.arange(samples) / samples
    displacement = 60.0 * np.sin(phase)
    for beyond in range(0, 60, 5):
        for size in (1e-9, 1e-3, 1.0):
            touching = np.abs(displacement) > beyond
            for force in (displacement, np.sign(displacement), displacement + np.sign(np.cos(phase))):
                for one in (touching, touching & (displacement > 0.0)):
                    with contextlib.suppress(LoopError):
                        analyse_loop(displacement, np.where(one, size * force, 0.0), 1.0)


def test_bodies_that_are_apart_for_most_of_the_cycle_are_said_to_be() -> None:
    displacement = 60.0 * np.sin(2.0 * np.pi * np.arange(64) / 64)
    with pytest.raises(LoopError, match="the bodies are apart"):
        analyse_loop(displacement, 1e-3 * displacement, np.maximum(np.abs(displacement) - 50.0, 0.0))


def test_friction_by_position_needs_a_contact_that_stays_closed() -> None:
    _, displacement, force = SyntheticLoop(Recipe()).sampled(200)
    with pytest.raises(LoopError, match="this contact opens"):
        position_resolved_friction(displacement, force, opening(200))


@pytest.fixture
def run() -> RunResult:
    """The last loop has opened, and pressed for less than half of it."""
    made = dataclasses.replace(result(), study=minimal())
    *early, last = made.loops
    shut = opening(last.time_s.size)
    apart = np.where(shut > np.quantile(shut, 0.6), shut, 0.0)
    barely = np.where(apart > 0.0, 1e-5 * last.displacement_um, 0.0)
    changed = dataclasses.replace(last, normal_force_N=apart, tangential_force_N=barely)
    return dataclasses.replace(made, loops=(*early, changed))


def test_a_simulated_loop_that_cannot_be_analysed_is_left_out_of_a_comparison(run: RunResult) -> None:
    record = record_of_result(dataclasses.replace(result(), study=minimal()))
    comparison = compare(run, record)
    assert [pair.cycle for pair in comparison.loops] == sorted(loop.cycle for loop in run.loops)[:-1]
    assert any(f"the simulated loop of cycle {run.loops[-1].cycle} was left out" in note for note in comparison.notes)


def test_commands_on_a_run_whose_wires_part_leave_out_what_cannot_be_told(run: RunResult, tmp_path: Path) -> None:
    write_result(tmp_path / "run" / "result.h5", run)
    assert write_page([run], tmp_path).is_file()
    for command in (
        ["loops", "run", "--output", "loops.png"],
        ["maps", "run", "--output", "maps"],
        ["export", "run", "--as-record", "record"],
        ["check", "record"],
        ["maps", "record", "--output", "maps"],
    ):
        words = [str(tmp_path / word) if word in ("run", "record", "maps", "loops.png") and at else word
                 for at, word in enumerate(command)]  # fmt: skip
        ended = CliRunner().invoke(cli, words, catch_exceptions=False)
        # A record of such loops has problems to be told.
        assert ended.exit_code == (1 if command[0] == "check" else 0), ended.output
