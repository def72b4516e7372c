"""Loops that are straight lines between few points: told from curves, and read at those points."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from geometry.arrays import Array
from tests.diagnosis_cases import autoregressive, tables
from wirewear.diagnosis.observe.mending import corners_of, read_at_corners
from wirewear.records import ExperimentRecord, MeasuredLoop

AMPLITUDE_um, PLATEAU_N, STICK_um, FREQUENCY_Hz = 60.0, 1.2, 8.0, 3.0
Drive = Callable[[Array], Array]


def sine(phase: Array) -> Array:
    """A drive with the harmonics of a worn eccentric."""
    return np.asarray(np.sin(phase) + 0.01 * np.sin(2.0 * phase) + 0.008 * np.sin(3.0 * phase))


def triangle(phase: Array) -> Array:
    """A drive of constant speed."""
    return np.asarray(2.0 / np.pi * np.arcsin(np.sin(phase)))


@cache
def true_loop(points: int, drive: Drive = sine) -> tuple[Array, Array]:
    """Displacement [µm] and force [N] of Coulomb friction behind a spring at even times (points,)."""
    place = AMPLITUDE_um * drive(2.0 * np.pi * np.arange(points) / points)
    force, at = np.zeros(points), 0.0
    for _ in range(2):
        for step, now in enumerate(place):
            at += now - place[step - 1]
            limit = STICK_um * (1.0 + 0.3 * (now / AMPLITUDE_um) ** 2)
            at = float(np.clip(at, -limit, limit))
            force[step] = PLATEAU_N * at / STICK_um
    return place, force


def logged(
    points: int | None,
    samples: int,
    *,
    loops: int = 8,
    correlation: float = 0.0,
    size: float = 1.0,
    coupling: float = 0.0,
    drive: Drive = sine,
) -> list[MeasuredLoop]:
    """Loops at so many samples, straight between points (None: as good as curves), with a laboratory's noise."""
    random = np.random.default_rng(5)
    place, force = true_loop(points or 8192, drive)
    place = place + coupling * force
    time = np.arange(samples) / samples
    known = np.arange(place.size) / place.size
    x, q = (np.interp(time, known, channel, period=1.0) for channel in (place, force))
    return [
        MeasuredLoop(
            1,
            cycle,
            time / FREQUENCY_Hz,
            x + size * 0.15 * autoregressive(samples, correlation, random),
            q + size * 0.008 * autoregressive(samples, correlation, random),
            None,
        )
        for cycle in range(1, loops + 1)
    ]


def record(loops: list[MeasuredLoop]) -> ExperimentRecord:
    return ExperimentRecord(tables(), tuple(loops), (), ())


@pytest.mark.parametrize("points", [30, 40, 48])
@pytest.mark.parametrize("samples", [128, 256, 400])
def test_lines_between_few_points_are_seen_under_noise(points: int, samples: int) -> None:
    assert corners_of(logged(points, samples), FREQUENCY_Hz) == points


@pytest.mark.first_case
@pytest.mark.parametrize("size", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("correlation", [0.0, 0.8])
@pytest.mark.parametrize("coupling", [0.0, 2.0])
@pytest.mark.parametrize("drive", [sine, triangle])
def test_curves_are_no_lines(size: float, correlation: float, coupling: float, drive: Drive) -> None:
    for samples in (96, 256):
        loops = logged(None, samples, size=size, correlation=correlation, coupling=coupling, drive=drive)
        assert corners_of(loops, FREQUENCY_Hz) is None


def test_a_record_is_read_at_its_corners_whatever_outliers_it_has() -> None:
    loops = logged(40, 256)
    spoiled = loops[3].displacement_um.copy()
    spoiled[[20, 90]] += 25.0
    loops[3] = replace(loops[3], displacement_um=spoiled)
    read, note = read_at_corners(record(loops))
    assert note is not None
    assert "40 points a cycle" in note
    place, force = true_loop(40)
    for loop in read.loops:
        assert loop.time_s == pytest.approx(np.arange(40) / 40 / FREQUENCY_Hz)
        # Six samples a line leave less noise than one has.
        assert np.std(loop.displacement_um - place) < 0.12
        assert np.abs(loop.displacement_um - place).max() < 0.5
        assert np.std(loop.tangential_force_N - force) < 0.0065
