"""Friction laws that differ by place: of pressure, of sliding speed, of the energy that a place has taken."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import gamma, pi, sqrt
from typing import ClassVar

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import solvers
from geometry.arrays import Array
from solvers import Coulomb
from tests.bodies import FRICTION, driven, pressed
from tests.solvers.wear_jumps import LINE_LOAD_N_per_mm, STROKE_mm, at_the_end, hertz_of_line, jumped, line_contact
from wirewear.effects import Age, problem_with
from wirewear.reference import LineContact

pytestmark = pytest.mark.seconds
FREQUENCY_Hz = 2.0
INCREMENTS = 64
_ONE_THREAD = {"limits": 1, "user_api": "blas"}


@pytest.fixture(scope="module")
def line() -> solvers.ContactProblem:
    """A cylinder on a flat, neither of which wears."""
    return replace(
        line_contact(), wear=solvers.WearRates(), timing=solvers.DriveTiming(solvers.Drive(STROKE_mm), FREQUENCY_Hz)
    )


@pytest.fixture(scope="module")
def hertz() -> LineContact:
    return hertz_of_line()


def loop(problem: solvers.ContactProblem, state: solvers.ContactState, increments: int) -> solvers.CycleTrace:
    with threadpool_limits(**_ONE_THREAD):
        return solvers.closed_cycle(problem, state, solvers.Drive(STROKE_mm), increments)[1]


@pytest.mark.parametrize("exponent", [2.0 / 3.0, 1.2])
def test_friction_by_a_power_of_the_pressure_is_its_integral_over_a_hertz_pressure(
    line: solvers.ContactProblem, hertz: LineContact, exponent: float
) -> None:
    reference = 500.0
    law = solvers.PowerOfPressure(reference, exponent)
    last = driven(replace(line, friction_law=law), pressed(line)[0], np.array([0.005, 0.01]))[1][-1][-1]
    of_shape = sqrt(pi) * gamma(0.5 * exponent + 1.0) / gamma(0.5 * exponent + 1.5)
    peak = hertz.peak_pressure_MPa
    expected = FRICTION * reference ** (1.0 - exponent) * peak**exponent * hertz.half_width_mm * of_shape
    assert last.sticking == 0
    assert last.tangential_force == pytest.approx(expected, rel=4e-3)


@pytest.mark.parametrize(
    "law", [solvers.Rate(0.6, 0.08), solvers.LogarithmicRate(0.05, 0.08), solvers.LogarithmicRate(-0.05, 0.08)]
)
def test_friction_by_speed_follows_the_drive_and_its_work_is_the_loops_area(
    line: solvers.ContactProblem, law: solvers.FrictionLaw
) -> None:
    problem = replace(line, friction_law=law)
    trace = loop(problem, at_the_end(problem, STROKE_mm), INCREMENTS)
    speed = 2.0 * pi * FREQUENCY_Hz * np.sqrt(STROKE_mm**2 - trace.drive**2)
    slides = np.abs(trace.drive) < 0.75 * STROKE_mm
    nowhere = np.zeros((1, 1))
    rest = solvers.WearState(nowhere, nowhere, nowhere, nowhere)
    known = solvers.LocalState(rest, np.ravel, np.ravel, lambda: speed, lambda: speed, primary_is_upper=True)
    expected = FRICTION * LINE_LOAD_N_per_mm * np.asarray(law.factor(known))
    assert np.ptp(expected[slides]) > 0.01 * expected.max()
    # Bodies that give way to a falling friction slide a little faster than the drive.
    assert np.abs(trace.tangential_force)[slides] == pytest.approx(expected[slides], rel=5e-3)
    drive, force = trace.drive, trace.tangential_force
    area = 0.5 * abs(float(np.sum(drive * np.roll(force, -1) - np.roll(drive, -1) * force)))
    assert trace.friction_work == pytest.approx(area, rel=7e-3)


def run_in(hertz: LineContact, law: solvers.RunningIn, cycles: float, slip: Callable[[float], float]) -> float:
    """Friction force after so many cycles by the ordinary differential equations of the energies of both surfaces,
    under a Hertz pressure that slides as far as `slip` of the force says.
    """
    half, peak = hertz.half_width_mm, hertz.peak_pressure_MPa
    x = np.linspace(-half - STROKE_mm, half + STROKE_mm, 801)
    pressure = peak * np.sqrt(np.clip(1.0 - (x / half) ** 2, 0.0, None))
    passed = (np.arange(40) + 0.5) / 40 * pi

    def friction(energy: Array) -> Array:
        fresh = np.exp(-energy / law.energy_mJ_per_mm2)
        return np.asarray(FRICTION * (law.final_ratio + (1.0 - law.final_ratio) * fresh) * pressure)

    def rates(energies: Array) -> Array:
        amplitude = slip(float(np.trapezoid(friction(0.5 * energies.sum(axis=0)), x)))
        found = np.zeros_like(energies)
        for along in passed:
            moved, path = -amplitude * np.cos(along), 2.0 * amplitude * np.sin(along) * pi / 40
            work = friction(0.5 * (energies[0] + np.interp(x - moved, x, energies[1]))) * path
            found += [work, np.interp(x + moved, x, work)]
        return found

    energies, steps = np.zeros((2, len(x))), 200
    for _ in range(steps):
        energies = energies + cycles / steps * rates(energies + 0.5 * cycles / steps * rates(energies))
    return float(np.trapezoid(friction(0.5 * energies.sum(axis=0)), x))


def test_friction_that_runs_in_follows_both_bodies_energies(line: solvers.ContactProblem, hertz: LineContact) -> None:
    law = solvers.RunningIn(0.5, 1000.0)
    problem = replace(line, friction_law=law)
    state, done = at_the_end(problem, STROKE_mm), 0.0
    fresh = loop(line, at_the_end(line, STROKE_mm), INCREMENTS)
    force = float(np.abs(fresh.tangential_force).max())
    # What bodies give way by is lost to the slip.
    compliance = (STROKE_mm - fresh.friction_work / (4.0 * force)) / force
    controller, wanted = solvers.JumpController(0.01), 1.0

    def attempt(state: solvers.ContactState, _before: float, cycles: float) -> tuple[solvers.ContactState, float]:
        jump = jumped(problem, state, cycles, stroke_mm=STROKE_mm)
        return jump.state, jump.pressure_change

    for end in (20.0, 60.0, 200.0):
        while done < end:
            step = solvers.take_step(controller, state, wanted, done, (end,), end, attempt)
            state, wanted, done = step.state, step.next_jump, done + step.jump
        found = abs(float(loop(problem, state, 32).middle.primary_force[:, 0].sum()))
        expected = run_in(hertz, law, end, lambda force: STROKE_mm - compliance * force)
        assert found == pytest.approx(expected, rel=2e-3)


@dataclass(frozen=True)
class Flash:
    """Temperature by friction power, over what the surfaces give off per area."""

    loss_W_per_mm2_K: float
    friction: float = FRICTION

    def at(self, local: solvers.LocalState, /) -> Array:
        return 293.0 + 1e-3 * self.friction * local.pressure_MPa * local.speed_mm_per_s / self.loss_W_per_mm2_K


class Even:
    """One temperature at all nodes."""

    def at(self, local: solvers.LocalState, /) -> Array:
        return np.full_like(local.pressure_MPa, 393.0)


@dataclass(frozen=True)
class Softens(Coulomb):
    """Friction that falls with a temperature, of which no solver knows, and with the cycles."""

    name: ClassVar[str] = "softens"
    timed: ClassVar[bool] = True
    ages: ClassVar[bool] = True

    per_K: float
    per_cycle: float = 0.0

    def factor(self, local: solvers.LocalState, /) -> Array:
        return 1.0 - self.per_K * (local["temperature_K"] - 293.0) - self.per_cycle * local.cycle


@dataclass(frozen=True)
class Oxidises(solvers.WearLaw):
    """Wear that grows with the temperature."""

    name: ClassVar[str] = "oxidises"

    per_K: float

    def work_per_slip(self, friction: solvers.Friction, /) -> solvers.Friction:
        assert friction.local is not None
        hotter = friction.local["temperature_K"] - 293.0
        return replace(friction, coefficient=friction.coefficient * (1.0 + self.per_K * hotter))


def test_friction_follows_a_local_field_that_only_law_and_producer_know(
    line: solvers.ContactProblem, hertz: LineContact
) -> None:
    law = Softens(per_K=0.01)
    problem = replace(line, friction_law=law, fields={"temperature_K": Flash(0.01)})
    trace = loop(problem, at_the_end(problem, STROKE_mm), INCREMENTS)
    hottest = 1e-3 * FRICTION * hertz.peak_pressure_MPa * 2.0 * pi * FREQUENCY_Hz * STROKE_mm / 0.01
    # The mean of Hertz's pressure, weighted by itself, is 8/(3 pi) of its peak.
    expected = FRICTION * LINE_LOAD_N_per_mm * (1.0 - law.per_K * hottest * 8.0 / (3.0 * pi))
    assert law.per_K * hottest > 0.05
    assert abs(float(trace.middle.primary_force[:, 0].sum())) == pytest.approx(expected, rel=5e-3)
    with pytest.raises(solvers.SolverError, match="temperature_K"):
        pressed(replace(line, friction_law=law))


def test_a_wear_law_reads_a_local_field_alike_in_increments_and_jumps(line: solvers.ContactProblem) -> None:
    wearing = solvers.WearRates(1e-6, 1e-6, law=Oxidises(0.01))
    for field, ratio in ((Even(), 2.0), (Flash(0.01), None)):
        problem = replace(line, wear=wearing, fields={"temperature_K": field})
        start = at_the_end(problem, STROKE_mm)
        with threadpool_limits(**_ONE_THREAD):
            stepped = solvers.run_cycle(problem, start, solvers.Drive(STROKE_mm), INCREMENTS, 1.0)[0].wear
        leapt = jumped(problem, start, 1.0, stroke_mm=STROKE_mm).state.wear
        for wear in (stepped, leapt):
            of_energy = wear.primary_volume_mm3 / (1e-6 * wear.energy_mJ)
            assert of_energy > 1.02
            if ratio is not None:
                assert of_energy == pytest.approx(ratio, rel=1e-9)
        assert leapt.primary_volume_mm3 == pytest.approx(stepped.primary_volume_mm3, rel=0.01)


def test_a_law_that_ages_knows_the_cycles_done(line: solvers.ContactProblem) -> None:
    law = Softens(per_K=0.0, per_cycle=1e-3)
    aged = problem_with(replace(line, friction_law=law, fields={"temperature_K": Even()}), (), Age(250.0, 0.0))
    last = driven(aged, pressed(aged)[0], np.array([0.005, 0.01]))[1][-1][-1]
    assert last.sticking == 0
    assert last.tangential_force == pytest.approx(0.75 * FRICTION * LINE_LOAD_N_per_mm, rel=1e-3)
    assert problem_with(line, (), Age(250.0, 0.0)) is line
