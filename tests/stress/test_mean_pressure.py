"""Pressures averaged over a length are what closed forms say, wherever grid lines lie."""

from math import acos, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_matrix, vstack

from geometry.arrays import Array
from tests.studies import COARSE, WEARING, coarse
from tests.sweeps.in_place import InPlace
from wirewear import largest_mean_pressure_MPa
from wirewear.results.contact_forces import averaging
from wirewear.sweeps import uncertainty
from wirewear.sweeps.sweep import SweepRow, figures_named
from wirewear.sweeps.uncertainty import fitted, inputs_of, run_uncertain, sweep_of
from wirewear.test import Study
from wirewear.views.uncertainty_page import page, sentence

HOLDER = "[holder]\ntangential_stiffness_N_per_mm = 300.0\n"
SCATTER = "[scatter]\nfriction = 0.05\nnormal_load = 0.03\n"


def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def scattering(text: str = SCATTER) -> Study:
    return coarse(COARSE + WEARING + HOLDER + text)


def test_a_polynomial_of_the_second_degree_is_found_exactly() -> None:
    points = rng().standard_normal((30, 3))
    at = rng().standard_normal((5, 3))

    def curve(x: np.ndarray) -> np.ndarray:
        value: np.ndarray = 1.0 + 2.0 * x[:, 0] - x[:, 1] * x[:, 2] + 0.5 * x[:, 2] ** 2
        return value

    model = fitted(points, curve(points))
    assert model.error < 1e-12
    np.testing.assert_allclose(model.at(at), curve(at), atol=1e-12)


def test_inputs_scatter_as_the_study_states_and_angles_stay_below_a_right_one() -> None:
    study = scattering("[scatter]\nfriction = 0.05\nwear = 0.2\ncrossing_angle_deg = 2.0\n")
    assert [(one.key, round(one.deviation, 9)) for one in inputs_of(study)] == [
        ("contact.friction", 0.031),
        ("wear.energy_wear_coefficient_mm3_per_J", 6e-6),
        ("wires.crossing_angle_deg", 2.0),
    ]
    sweep, deviations = sweep_of(study, "quick", runs=40)
    assert sweep.design.points[0].tolist() == [0.62, 3e-5, 90.0]
    assert np.all(sweep.design.points[:, 2] <= 90.0)
    np.testing.assert_allclose(90.0 - sweep.design.points[:, 2], 2.0 * np.abs(deviations[:, 2]), atol=1e-9)
    np.testing.assert_allclose(deviations[1:].std(axis=0), 1.0, atol=0.06)


def test_intervals_are_those_of_the_closed_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """µP with 5 % and 3 %: its logarithm scatters by the root of both squares."""

    def sliding(study: Study, values: dict[str, float], fidelity: str, number: int, results: Path | None) -> SweepRow:
        force = values["contact.friction"] * values["conditions.normal_load_N"]
        figures: dict[str, float | None] = dict.fromkeys(figures_named(("moving", "fixed")))
        figures["max_tangential_force_N"] = force
        return SweepRow(number, figures, "", 1.0, 1)

    monkeypatch.setattr("wirewear.sweeps.running.run_case", sliding)
    monkeypatch.setattr(uncertainty, "_bands", lambda *_: ())
    found = run_uncertain(scattering(), tmp_path, InPlace())
    (one,) = found.intervals
    size = 1.96 * float(np.hypot(0.05, 0.03)) * 1.24
    assert one.nominal == pytest.approx(1.24)
    assert (one.low, one.high) == pytest.approx((1.24 - size, 1.24 + size), abs=0.08 * size)
    assert one.error < 1e-9
    assert "contact.friction ± 0.031" in sentence(found)
    assert "tangential force" in page(found)


def graded(half: float, smallest: float, growth: float) -> Array:
    """Lines from -half to half or a little beyond, whose spacings grow outwards."""
    steps = [smallest]
    while sum(steps) < half:
        steps.append(growth * steps[-1])
    out = np.cumsum(steps)
    return np.concatenate([-out[::-1], [0.0], out])


def weights(axial: Array, transverse: Array, over: float) -> csr_matrix:
    return vstack(list(averaging(axial, transverse, over)), format="csr")


def bounds(lines: Array) -> Array:
    """Where the nodes' cells begin and end."""
    return np.concatenate([lines[:1], 0.5 * (lines[1:] + lines[:-1]), lines[-1:]])


def hertzian(a: Array, t: Array, radius: float) -> Array:
    return np.sqrt(np.maximum(1.0 - (a[:, None] ** 2 + t**2) / radius**2, 0.0))


@pytest.mark.parametrize("over", [6.0, 15.0, 30.0, 60.0, 90.0])
def test_the_mean_over_the_middle_of_a_hertz_contact_is_the_load_on_that_disc(over: float) -> None:
    """Load within r of p0 √(1 − r²/a²): 2/3 π a² p0 (1 − (1 − r²/a²)^(3/2))."""
    radius, share = 30.0, min(0.5 * over / 30.0, 1.0)
    load = 2.0 / 3.0 * pi * radius**2 * (1.0 - (1.0 - share**2) ** 1.5)
    exact = load / (0.25 * pi * over**2)
    axial, transverse = graded(50.0, 1.0, 1.06), graded(50.0, 1.3, 1.05)
    found = largest_mean_pressure_MPa(hertzian(axial, transverse, radius), axial, transverse, over_um=over)
    assert found == pytest.approx(exact, rel=5e-3)


def test_the_means_beside_the_middle_are_those_of_the_field_over_the_same_discs() -> None:
    """Against quadrature of the field in polar coordinates about each place."""
    radius, over = 30.0, 20.0
    axial, transverse = graded(50.0, 0.8, 1.04), graded(50.0, 1.1, 1.03)
    found = weights(axial, transverse, over) @ hertzian(axial, transverse, radius).ravel()
    for a in (10, len(axial) // 2 + 7, len(axial) // 2 + 20):
        for t in (len(transverse) // 2 - 12, len(transverse) // 2 + 3):
            x, y = axial[a], transverse[t]
            r, angle = np.meshgrid((np.arange(400) + 0.5) / 400 * 0.5 * over, np.arange(400) / 400 * 2.0 * pi)
            beyond = ((x + r * np.cos(angle)) ** 2 + (y + r * np.sin(angle)) ** 2) / radius**2
            exact = float((np.sqrt(np.maximum(1.0 - beyond, 0.0)) * r).sum() / r.sum())
            assert found[a * len(transverse) + t] == pytest.approx(exact, abs=4e-3)


@pytest.mark.parametrize("from_edge", [-6.0, -2.5, 0.0, 3.1, 7.5, 9.0])
def test_a_disc_cut_by_the_edge_of_a_punch_keeps_the_pressure_inside(from_edge: float) -> None:
    """An even pressure ends at a line between two nodes, where the rim's node carries what its cell has of it.

    The part of a disc of radius r on one side of a line at the distance d is (acos(-d/r) + (d/r) √(1 − d²/r²)) / π.
    """
    over, edge = 15.0, 4.37
    axial, transverse = graded(40.0, 0.5, 1.04), graded(12.0, 0.7, 1.1)
    cells = bounds(axial)
    carried = np.clip(edge - cells[:-1], 0.0, np.diff(cells)) / np.diff(cells)
    pressure = np.repeat(100.0 * carried[:, None], len(transverse), axis=1)
    means = (weights(axial, transverse, over) @ pressure.ravel()).reshape(pressure.shape)
    share = min(max(from_edge / (0.5 * over), -1.0), 1.0)
    exact = 100.0 * (acos(-share) + share * sqrt(1.0 - share**2)) / pi
    # Between two nodes the mean is all but straight.
    assert np.interp(edge - from_edge, axial, means[:, len(transverse) // 2]) == pytest.approx(exact, abs=0.3)


@pytest.mark.parametrize("elements", [40, 80, 160])
def test_the_largest_mean_of_a_flat_punch_is_that_over_the_length_beside_its_edge(elements: int) -> None:
    """p = P / (π √(a² − x²)) is infinite at the edge, and its mean over L there P acos(1 − L/a) / (π L).

    The rim's node carries what ends within its cell, so nodal pressures grow without end as the mesh is refined.
    """
    half, over, load = 50.0, 15.0, 1000.0
    lines = np.linspace(-60.0, 60.0, elements + 1) + 0.17
    cells = np.clip(bounds(lines), -half, half)
    pressure = (load / pi * np.diff(np.arcsin(cells / half))) / np.diff(bounds(lines))
    exact = load * acos(1.0 - over / half) / (pi * over)
    found = largest_mean_pressure_MPa(pressure, lines, over_um=over)
    # About nodes, the best segment may miss the edge by half an element.
    assert found == pytest.approx(exact, rel=0.8 * float(np.diff(lines)[0]) / over)
    assert found <= exact * (1.0 + 1e-9)


def test_means_of_a_single_nodes_force_do_not_grow_as_the_mesh_is_refined() -> None:
    means, nodes = [], []
    for element in (5.0, 2.5):
        lines = np.arange(-50.0, 50.1, element)
        pressure = np.zeros((lines.size, lines.size))
        pressure[lines.size // 2, lines.size // 2] = 2000.0 / element**2
        nodes.append(pressure.max())
        means.append(largest_mean_pressure_MPa(pressure, lines, lines, over_um=15.0))
    assert nodes[1] == pytest.approx(4.0 * nodes[0])
    assert means == pytest.approx(2 * [2000.0 / (0.25 * pi * 15.0**2)])


@pytest.mark.seconds
@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.floats(0.05, 30.0))
def test_forces_are_kept(seed: int, over: float) -> None:
    """Means about all places of a plane hold each force once; nodes of an even grid stand for such places."""
    random = np.random.default_rng(seed)
    lines = np.arange(-40.0, 40.1, 2.0)
    pressure = np.zeros((lines.size, lines.size))
    pressure[15:26, 15:26] = random.uniform(0.0, 100.0, (11, 11))
    assert (weights(lines, lines, over) @ pressure.ravel()).sum() == pytest.approx(pressure.sum())
