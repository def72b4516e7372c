"""Channels that answer in time, against instruments of the blind check, which know nothing of branches."""

import numpy as np
import pytest

from studies.blind.generators.instruments import LeakingCharge, Signals
from tests.diagnosis_cases import nominal, states
from wirewear.diagnosis.infer.shapes import Branches
from wirewear.diagnosis.infer.shapes_in_time import giving_late, leaking
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.readings import phases_of
from wirewear.diagnosis.model.setup import Array


def branches() -> Branches:
    setup = nominal("sensor")
    return Branches.of(simulate(states(), setup, np.array([1000.0])), setup.amplitude_um, setup.plateau_force_N)


def in_time(b: Branches) -> tuple[Signals, Array]:
    """A loop evenly in time, a cycle a second, and the phases (2m,) of its points."""
    phases = phases_of(b.course.displacement_um, b.motion)[0].ravel()
    time_s = np.arange(2048) / 2048.0

    def even(values: Array) -> Array:
        return np.asarray(np.interp(2.0 * np.pi * time_s, phases, values[0].ravel(), period=2.0 * np.pi))

    course = b.course
    force, load = even(course.tangential_force_N), even(course.normal_force_N)
    return Signals(time_s, 1.0, even(course.displacement_um), force, load), phases


def at_points(values: Array, phases: Array) -> Array:
    return np.asarray(np.interp(phases, 2.0 * np.pi * np.arange(values.size) / values.size, values, period=2.0 * np.pi))


@pytest.mark.parametrize("turn", [0.02, 0.1, 0.3])
def test_a_charge_leaks_as_the_instrument_of_its_time_constant_does(turn: float) -> None:
    b = branches()
    signals, phases = in_time(b)
    leaked = LeakingCharge(0.5 / (np.pi * turn)).read(signals, 1.0).tangential_force_N
    # A measured loop's zero is unknown: the instrument loses the mean force, and so may the shape.
    expected = at_points(leaked - leaked.mean(), phases)
    found = leaking(turn)(b, turn).tangential_force_N.ravel()
    mean = float(signals.tangential_force_N.mean())
    assert found - mean == pytest.approx(expected, abs=0.01 * b.force_N)
    assert np.abs(found - b.course.tangential_force_N.ravel()).max() > turn * b.force_N


def test_a_joint_without_delay_gives_nothing_late_and_one_of_endless_delay_gives_nothing_at_all() -> None:
    """What gives at once is the library's spring; what never gives leaves that spring with the opposite sign."""
    b = branches()
    still = b.course.displacement_um
    assert giving_late(1e-6)(b, 0.1).displacement_um == pytest.approx(still, abs=1e-3)
    never = giving_late(1e6)(b, 0.1).displacement_um
    spring = still - 0.1 * b.amplitude_um / b.force_N * (
        b.course.tangential_force_N - in_time(b)[0].tangential_force_N.mean()
    )
    centred = spring - 0.5 * (spring.max() + spring.min())
    assert never == pytest.approx(centred, abs=0.01 * b.amplitude_um)
