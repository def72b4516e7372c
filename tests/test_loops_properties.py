"""Loops of all kinds of disturbance: figures are finite and within their bounds, or the loop is refused."""

import numpy as np
import pytest

from tests.test_loops_bounds import assert_bounded
from wirewear.loops import LoopError, LoopFigures, analyse_loop


def drawn(seed: int) -> tuple[LoopFigures | None, float]:
    """Figures of a disturbed spring-and-Coulomb loop (None: refused), and its energy in mJ."""
    random = np.random.default_rng(seed)
    samples, cycles = int(random.integers(40, 401)), float(random.uniform(0.9, 3.0) if seed % 2 else 1.0)
    friction, load, amplitude = (
        10.0 ** random.uniform(-3.0, 0.18),
        random.uniform(0.5, 20.0),
        random.uniform(5.0, 500.0),
    )
    limit, taken = friction * load, random.uniform(0.001, 0.5) * amplitude
    time = np.arange(-2 * samples, int(samples * cycles)) / samples
    drive = amplitude * np.sin(2.0 * np.pi * (time + random.random()))
    force, held = np.empty_like(drive), 0.0
    for at, step in enumerate(np.diff(drive, prepend=drive[0])):
        held = float(np.clip(held + step * limit / taken, -limit, limit))
        force[at] = held
    time, drive, force = time[2 * samples :], drive[2 * samples :], force[2 * samples :]
    noise = random.choice([0.0, 0.003, 0.01])
    drive = drive + noise * amplitude * random.standard_normal(drive.size)
    force = force + noise * limit * random.standard_normal(drive.size)
    kind = seed % 6
    if kind == 1:
        force = np.clip(force, -random.uniform(0.5, 1.1) * limit, random.uniform(0.5, 1.1) * limit)
    elif kind == 2:
        force = np.roll(force, int(random.integers(1, 6)))
    elif kind == 3:
        drive = drive + random.uniform(-0.1, 0.1) * amplitude * time
    elif kind == 4:
        ring = np.cos(np.pi * np.arange(force.size))
        force = force + limit * random.uniform(0.0, 0.8) * ring * np.exp(-(time % 0.5) * 8)
    sign, offset = random.choice([-1.0, 1.0]), random.uniform(-0.3, 0.3) * limit
    try:
        figures = analyse_loop(drive + 100.0 * offset, sign * force + offset, load, time_s=time)
    except LoopError:
        return None, 0.0
    return figures, 4e-3 * limit * (amplitude - taken)


def check(count: int) -> None:
    told = []
    for seed in range(count):
        figures, energy = drawn(seed)
        if figures is None:
            continue
        assert_bounded(figures)
        found = figures.dissipated_energy_mJ
        assert np.isfinite([found.value, *found.interval95, *figures.slip_amplitude_um.interval95]).all()
        near = abs(found.value / energy - 1.0) < 0.03
        told.append(bool(figures.notes) or near or found.interval95[0] <= energy <= found.interval95[1])
    assert np.mean(told) > 0.95


def test_figures_of_any_disturbed_loop_are_bounded_and_right_or_noted() -> None:
    check(200)


@pytest.mark.slow
def test_figures_of_two_thousand_disturbed_loops_are_bounded_and_right_or_noted() -> None:
    check(2000)
