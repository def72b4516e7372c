"""Friction laws: their slopes, gross slip under a Hertz pressure, the balance of work, and how studies choose them."""

import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from solvers import (
    Archard,
    ContactProblem,
    Coulomb,
    Friction,
    FrictionLaw,
    PowerOfPressure,
    ShearLimited,
    friction_laws,
)
from solvers.contact.linearising import sliding_force
from solvers.elasticity.pairing import pair
from tests.bodies import FRICTION, LOAD_N, STEEL, AMPLITUDE_mm, RADIUS_mm, RIG_N_per_mm, crossed_wires, driven, pressed
from tests.worked_examples import install_example
from wirewear.base.errors import StudyError
from wirewear.reference import Elastic, contact_modulus, hertz_point
from wirewear.test import load_study

STRENGTH_MPa = 1000.0
LAW = ShearLimited(STRENGTH_MPa)


@pytest.mark.parametrize("law", [Coulomb(), LAW])
def test_a_laws_derivative_is_that_of_its_limit_and_starts_at_the_coefficient(law: FrictionLaw) -> None:
    pressure = np.geomspace(1e-3, 1e4, 40)
    step = 1e-4 * pressure
    slope = (law.limit(0.5, pressure + step) - law.limit(0.5, pressure - step)) / (2.0 * step)
    assert law.derivative(0.5, pressure) == pytest.approx(slope, rel=1e-6, abs=1e-9)
    friction = Friction(0.5, law)
    assert friction.limit(np.array([-5.0, 0.0])) == pytest.approx(0.0, abs=0.0)
    assert friction.derivative(np.array([-5.0, 0.0])) == pytest.approx(0.5)


def test_a_power_of_the_pressure_is_finite_however_small_its_reference() -> None:
    law, pressure = PowerOfPressure(1e-200, 0.5), np.array([0.0, 1e-3, 1.0, 1e4])
    assert law.limit(0.5, pressure) == pytest.approx(0.5e-100 * np.sqrt(pressure), rel=1e-6)
    assert law.derivative(0.5, pressure[1:]) == pytest.approx(0.25e-100 / np.sqrt(pressure[1:]), rel=1e-6)


@pytest.mark.seconds
@pytest.mark.parametrize(("mesh_mm", "tolerance"), [(0.005, 0.04), pytest.param(0.0035, 0.01, marks=pytest.mark.slow)])
def test_gross_slip_under_a_hertz_pressure_needs_the_laws_integral(mesh_mm: float, tolerance: float) -> None:
    problem = replace(crossed_wires(mesh_mm), friction_law=LAW)
    states, reports = driven(problem, pressed(problem)[0], np.array([0.0012, 0.0024]))
    last = reports[-1][-1]
    assert last.sticking == 0
    assert last.force_error < 1e-9
    # Integral of k (1 - exp(-mu p / k)) over the pressure p0 sqrt(1 - r²/a²) of a Hertz contact.
    steel = Elastic(STEEL.youngs_modulus_MPa, STEEL.poissons_ratio)
    hertz = hertz_point(LOAD_N, RADIUS_mm, contact_modulus(steel, steel))
    beta = FRICTION * hertz.peak_pressure_MPa / STRENGTH_MPa
    share = 0.5 - (1.0 - (1.0 + beta) * np.exp(-beta)) / beta**2
    force = 2.0 * np.pi * hertz.major_semi_axis_mm**2 * STRENGTH_MPa * share
    assert last.tangential_force == pytest.approx(force, rel=tolerance)
    assert last.tangential_force < 0.5 * FRICTION * LOAD_N
    # Node by node friction is the law's limit at the node's pressure, but for one factor for what lies between nodes.
    state = states[-1]
    nodes = np.flatnonzero(state.traction[:, 2] > 0.0)
    depth = state.wear.primary_depth, state.wear.secondary_depth
    frames = pair(problem.surface, problem.secondary, nodes, problem.offset(state.drive, 0.0), *depth).frames
    local = np.einsum("ikj,ij->ik", frames, state.traction[nodes])
    shear = np.linalg.norm(local[:, 1:], axis=1)
    factors = shear / LAW.limit(FRICTION, local[:, 0])
    assert factors == pytest.approx(np.full(len(factors), factors.mean()), rel=1e-4)


@pytest.fixture(scope="module")
def limited() -> ContactProblem:
    return replace(crossed_wires(0.010, long_patch=True, rig_N_per_mm=RIG_N_per_mm), friction_law=LAW)


@pytest.mark.seconds
def test_friction_work_under_another_law_is_the_loops_area(limited: ContactProblem) -> None:
    start, _ = driven(limited, pressed(limited)[0], AMPLITUDE_mm * np.sin(0.5 * np.pi * np.arange(1, 6) / 5))
    drives = AMPLITUDE_mm * np.cos(2.0 * np.pi * np.arange(1, 161) / 160)
    _, reports = driven(limited, start[-1], drives)
    force = np.array([pieces[-1].tangential_force for pieces in reports])
    work = sum(piece.friction_work for pieces in reports for piece in pieces)
    area = 0.5 * abs(float(np.sum(drives * np.roll(force, -1) - np.roll(drives, -1) * force)))
    assert work == pytest.approx(area, rel=2e-3)


@pytest.mark.seconds
def test_wear_by_energy_follows_the_friction_law_and_by_archard_the_pressure(limited: ContactProblem) -> None:
    half = AMPLITUDE_mm * np.sin(np.pi * np.arange(1, 11) / 10)

    def after(problem: ContactProblem) -> tuple[float, float]:
        wear = driven(problem, pressed(problem)[0], half, 20.0)[0][-1].wear
        return wear.energy_mJ, wear.primary_volume_mm3

    energy, volume = after(replace(limited, wear=replace(limited.wear, upper_mm3_per_mJ=1e-8)))
    assert volume == pytest.approx(1e-8 * energy, rel=1e-12)
    archard = replace(limited.wear, upper_mm3_per_mJ=1e-8, law=Archard())
    _, archards = after(replace(limited, wear=archard))
    _, coulombs = after(replace(limited, friction_law=Coulomb(), wear=archard))
    # More friction takes more of the stroke up in the rig: Q / K twice a half cycle.
    assert 1.0 < archards / coulombs < 1.2


def test_a_law_without_bend_is_coulombs(limited: ContactProblem) -> None:
    drives = np.array([0.002, 0.006, 0.012])
    one, other = (
        driven(replace(limited, friction_law=law), pressed(limited)[0], drives)[0][-1]
        for law in (Coulomb(), ShearLimited(1e12))
    )
    assert other.traction == pytest.approx(one.traction, abs=1e-5 * one.traction.max())


STUDY = (Path(__file__).parents[2] / "studies" / "steel_wires" / "study.toml").read_text()


def study_with(tmp_path: Path, law: str) -> Path:
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("[contact]", f"[contact]\nfriction_law = {law}"))
    return path


@pytest.mark.parametrize(
    ("law", "says"),
    [
        ('"shear-limited"', "takes shear_strength_MPa, but is given none"),
        ('"stribeck"', "there is no friction law 'stribeck'"),
        ("3", 'must be "coulomb" or a table'),
        ('{ name = "shear-limited", shear_strength_MPa = "high" }', "must be a finite number"),
    ],
)
def test_a_study_with_a_wrong_law_is_refused_with_the_reason(tmp_path: Path, law: str, says: str) -> None:
    with pytest.raises(StudyError, match=re.escape(says)):
        load_study(study_with(tmp_path, law))


def test_the_worked_example_of_the_docs_runs_as_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = install_example("A friction law", tmp_path, monkeypatch)
    (choice,) = example.tables
    friction_laws.cache_clear()
    try:
        path = tmp_path / "study.toml"
        path.write_text(re.sub(r"\[contact\]\n.*\n", choice, STUDY))
        law = load_study(path).contact.friction_law
        assert law.name == example.name
        test_a_laws_derivative_is_that_of_its_limit_and_starts_at_the_coefficient(law)
        problem = replace(crossed_wires(0.010), friction_law=law)
        state, reports = driven(problem, pressed(problem)[0], np.array([0.0015, 0.003]))
        expected = sliding_force(problem, state[-1])
        assert reports[-1][-1].tangential_force == pytest.approx(expected, rel=0.01)
    finally:
        friction_laws.cache_clear()
        sys.modules.pop("my_laws.softening", None)
        sys.modules.pop("my_laws", None)
