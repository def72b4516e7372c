"""Clocks that are coarser than the samples: all of these are used, with times set evenly between the ticks."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry.arrays import Array
from tests.synthetic_loops import Recipe, SyntheticLoop
from wirewear.base.errors import RecordError
from wirewear.loops import analyse_loop
from wirewear.loops.clock import read_clock
from wirewear.records.importing import guessing, import_record
from wirewear.records.importing.guessed_scars import Touching
from wirewear.records.importing.loop_sources import read_loops

RATE_Hz, FREQUENCY_Hz = 600.0, 3.0
LOOP = SyntheticLoop(Recipe(friction=0.6, contact_stiffness=1e6))


def logged(
    starts: Sequence[int], cycles: int, tick_s: float, begin_s: float = 0.0
) -> tuple[Array, Array, Array, Array]:
    """The time that a clock shows, displacement, force and the true time of cycles that were logged in pieces."""
    samples = round(RATE_Hz / FREQUENCY_Hz)
    _, x, force = LOOP.sampled(samples)
    random = np.random.default_rng(3)
    time = np.concatenate([start / FREQUENCY_Hz + np.arange(cycles * samples) / RATE_Hz for start in starts]) + begin_s
    x, force = (np.tile(own, cycles * len(starts)) for own in (x, force))
    x, force = x + 0.1 * random.standard_normal(x.size), force + 0.005 * random.standard_normal(x.size)
    return tick_s * np.floor(time / tick_s + 1e-6), x, force, time


def written(folder: Path, *columns: Array) -> Path:
    head, path = "Time (s),Displacement (um),Force (N)\n", folder / "log.csv"
    path.write_text(head + "\n".join(",".join(f"{one:.8g}" for one in row) for row in zip(*columns, strict=True)))
    return path


def guess(path: Path, **known: Any) -> guessing.GuessedMapping:
    known = {"diameter_mm": 0.45, "normal_load_N": 2.0} | known
    elastic = {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3}
    return guessing.guessed_mapping([path], known, Touching.of("crossed-wires", known, elastic, {}))


@pytest.mark.parametrize("tick", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("begin", [0.0, 0.137])
def test_all_samples_of_a_coarse_clock_are_used(tmp_path: Path, tick: float, begin: float) -> None:
    shown, x, force, true = logged([0], 10, tick, begin)
    clock = read_clock(shown, x, force)
    assert clock.time_s is not None
    assert np.ptp(clock.time_s - true) < 0.5 / RATE_Hz
    loops = read_loops(written(tmp_path, shown, x, force), normal_load="2")
    assert len(loops) == 10
    for loop in loops:
        assert any("times were set evenly" in note for note in loop.notes)
        figures = analyse_loop(loop.displacement_um, loop.tangential_force_N, 2.0, time_s=loop.time_s)
        assert not figures.outlier_samples
        assert figures.dissipated_energy_mJ.value == pytest.approx(LOOP.energy_mJ, rel=0.005)


@pytest.mark.parametrize("tick", [0.01, 0.1, 1.0])
def test_one_cycle_of_a_coarse_clock_is_analysed_whole(tick: float) -> None:
    shown, x, force, _ = logged([0], 1, tick)
    figures = analyse_loop(x, force, 2.0, time_s=shown)
    assert not figures.outlier_samples
    assert figures.dissipated_energy_mJ.value == pytest.approx(LOOP.energy_mJ, rel=0.005)
    assert any("clock" in note for note in figures.notes)


@pytest.mark.parametrize("tick", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("starts", [(0,), (0, 99, 999)])
def test_a_coarse_clock_gives_frequency_and_cycles_also_across_gaps(
    tmp_path: Path, tick: float, starts: tuple[int, ...]
) -> None:
    found = guess(written(tmp_path, *logged(starts, 9, tick)[:3]))
    assert found.tables["conditions"]["frequency_Hz"] == pytest.approx(FREQUENCY_Hz, rel=1e-4)
    assert any("times were set evenly" in remark for remark in found.remarks)
    (tmp_path / "mapping.toml").write_text(guessing.mapping_text(found))
    record = import_record(tmp_path / "mapping.toml")
    assert record.cycles == tuple(start + 1 + cycle for start in starts for cycle in range(9))
    assert all(loop.time_s.size == 200 for loop in record.loops)
    assert any("times were set evenly" in note for note in record.notes)


@pytest.mark.parametrize("starts", [(0, 99), (0, 7, 20, 60)])
def test_pieces_shorter_than_two_ticks_are_refused_with_a_sentence(tmp_path: Path, starts: tuple[int, ...]) -> None:
    path = written(tmp_path, *logged(starts, 4, 1.0)[:3])
    with pytest.raises(RecordError, match=r"of 1 s, are too coarse to tell .* in its gaps: give a column cycle"):
        guess(path)
    assert len(read_loops(path)) == 4 * len(starts)


def test_a_short_log_whose_clock_is_useless_is_read_without_it(tmp_path: Path) -> None:
    found = guess(written(tmp_path, *logged([0], 4, 1.0)[:3]))
    assert "time_s" not in found.tables["loops"]["columns"]
    assert (found.tables["conditions"]["frequency_Hz"], found.tables["conditions"]["cycles"]) == ("?", 4)
    assert any("too coarse to tell how fast" in remark for remark in found.remarks)


def test_times_of_six_digits_have_their_rate_across_a_power_of_ten() -> None:
    """At 1200 Hz, samples share times beyond 100 s."""
    _, x, force, time = logged((0,), 4, 1e-6)
    time = 99.7 + 0.5 * time
    shown = np.array([float(f"{one:.6g}") for one in time])
    assert np.count_nonzero(np.diff(shown) == 0.0) > 0.05 * shown.size
    clock = read_clock(shown, x, force)
    assert clock.time_s is not None
    assert np.ptp(clock.time_s) == pytest.approx(np.ptp(time), rel=2e-3)


def test_rows_that_were_written_twice_are_no_coarse_clock() -> None:
    shown, x, force, _ = logged([0], 1, 1.0 / RATE_Hz)
    twice = [np.repeat(own, 2) for own in (shown, x, force)]
    assert read_clock(twice[0], twice[1], twice[2]).note == ""
    once = analyse_loop(x, force, time_s=shown)
    found = analyse_loop(twice[1], twice[2], time_s=twice[0])
    assert any("keeps each reading for 2 samples" in note for note in found.notes)
    assert (found.slip_amplitude_um, found.dissipated_energy_mJ) == (once.slip_amplitude_um, once.dissipated_energy_mJ)


@pytest.mark.parametrize("wraps_at_s", [1.0, 2.5, 0.65536, 1.0 / FREQUENCY_Hz])
@pytest.mark.parametrize("tick", [1.0 / RATE_Hz, 0.01])
def test_a_clock_that_wraps_goes_on_with_the_drive(tmp_path: Path, wraps_at_s: float, tick: float) -> None:
    shown, x, force, true = logged([0], 10, tick, 0.137)
    path = written(tmp_path, shown % wraps_at_s, x, force)
    clock = read_clock(shown % wraps_at_s, x, force)
    assert clock.time_s is not None
    assert np.ptp(clock.time_s - true) < max(tick, 3.0 / RATE_Hz)
    loops = read_loops(path, normal_load="2")
    assert len(loops) == 10
    assert all("goes back" in loop.notes[0] for loop in loops)
    assert guess(path).tables["conditions"]["frequency_Hz"] == pytest.approx(FREQUENCY_Hz, rel=0.01)


@pytest.mark.parametrize("begin_s", [0.0, 60.1])
def test_a_counter_that_wraps_once_and_a_clock_that_is_set_back_go_on(begin_s: float) -> None:
    shown, x, force, true = logged([0], 10, 1.0 / RATE_Hz, begin_s)
    once = (shown + 2.0) % 65.536
    back = np.where(true > begin_s + 1.23, shown - 0.31, shown)
    for clock in (read_clock(once, x, force), read_clock(back, x, force)):
        assert clock.time_s is not None
        assert np.ptp(clock.time_s - true) < 1.5 / RATE_Hz


def test_rows_in_another_order_and_times_that_start_again_each_cycle_are_left_as_they_are() -> None:
    shown, x, force, _ = logged([0], 4, 1.0 / RATE_Hz)
    later_first = np.r_[400:800, 0:400]
    exchanged = np.r_[0:50, 51, 50, 52:800]
    for order in (later_first, exchanged):
        assert read_clock(shown[order], x[order], force[order]).note == ""
    cycle = np.repeat([1.0, 2.0, 3.0, 4.0], 200)
    again = np.tile(shown[:200], 4)
    assert read_clock(again, x, force, [cycle]).note == ""
    assert "3 times" in read_clock(again, x, force).note
