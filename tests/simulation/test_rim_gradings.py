"""Gradings to the rim of a contact that sticks in its middle, against Mindlin and Deresiewicz by cells on a half-space.

Where tangential and normal compliances are in proportion, friction below µP takes what the pressure under P is more
than that under P - Q/µ (Jäger): whole cells slip as they would part. So loops of all forces follow from how a ball is
pressed on cells of uniform pressure, and their errors are those of the cells alone.
"""

from itertools import product

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from geometry import RimGradedAxis
from geometry.arrays import Array
from solvers import advance, press, unloaded_state
from tests.studies import MINIMAL
from wirewear import parse_study, reference
from wirewear.simulation import discretise
from wirewear.simulation.problem import condensed_body, contact_problem
from wirewear.test.fidelity import WIRE_LEVELS
from wirewear.verification.hertz import crossed_bulk_compliance

SHARES = np.array([0.15, 0.175, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85])
FULL_LOAD = 4.0 / 3.0  #: Of a contact of radius 1, by the modulus and curvature 1.


def _integral(x: Array, y: Array) -> Array:
    r = np.hypot(x, y)
    return np.asarray(np.sum([a * np.log(np.where(a == 0.0, 1.0, b + r)) for a, b in ((x, y), (y, x))], axis=0))


def _loads(lines: Array, approaches: Array) -> Array:
    """Loads that press a ball on cells about mesh lines, of which those of one quarter are given, by approach."""
    middles = 0.5 * (lines[1:] + lines[:-1])
    low, high = np.append(-middles[0], middles), np.append(middles, 2.0 * lines[-1] - middles[-1])
    count = len(lines)
    compliance = np.zeros((count, count, count, count))
    points, weights = np.polynomial.legendre.leggauss(3)
    for (u, wu), (v, wv) in product(zip(points, 0.5 * weights, strict=True), repeat=2):
        x, y = (0.5 * (low + high + at * (high - low)) for at in (u, v))
        for flip_x, flip_y in product((False, True), repeat=2):
            (x0, x1), (y0, y1) = ((-high, -low) if flip else (low, high) for flip in (flip_x, flip_y))
            near_x, far_x = (x[:, None, None, None] - edge[:, None] for edge in (x1, x0))
            near_y, far_y = (y[:, None, None] - edge for edge in (y1, y0))
            moved = _integral(far_x, far_y) - _integral(near_x, far_y) - _integral(far_x, near_y)
            moved += _integral(near_x, near_y)
            # Cells about the axes are their own images.
            moved[:, :, : int(flip_x)], moved[:, :, :, : int(flip_y)] = 0.0, 0.0
            compliance += wu * wv / np.pi * moved
    matrix = compliance.reshape(count**2, -1)
    height = (low**2 + low * high + high**2) / 6.0
    gap = np.add.outer(height, height).ravel()
    images = np.where(np.arange(count) > 0, 2.0, 1.0) * (high - low)
    areas, touching, loads = np.outer(images, images).ravel(), gap < 0.1, []
    for approach in approaches:
        for _ in range(50):
            pressure, on = np.zeros(count**2), np.flatnonzero(touching)
            pressure[on] = np.linalg.solve(matrix[np.ix_(on, on)], approach - gap[on])
            now = np.where(touching, pressure > 0.0, matrix @ pressure < approach - gap)
            if (now == touching).all():
                break
            touching = now
        loads.append(areas @ pressure)
    return np.array(loads)


def _energy_errors(axis: RimGradedAxis) -> Array:
    approaches = np.concatenate([np.linspace(0.1, 0.6, 8), np.linspace(0.63, 1.04, 50)])
    lines = axis.half_lines()
    loads = _loads(lines[: np.searchsorted(lines, 1.04) + 2], approaches)
    approach = PchipInterpolator(loads, approaches)
    stored, full = approach.antiderivative(), FULL_LOAD
    # Energy of a loop by Masing: 8 ∫ Q dδ - 4 Q δ of the first loading, δ = α(P) - α(P - Q).
    force, rest = SHARES * full, (1.0 - SHARES) * full
    delta = approach(full) - approach(rest)
    below = force * delta - (approach(full) * force - (stored(full) - stored(rest)))
    left = (1.0 - SHARES) ** (1.0 / 3.0)
    exact = 4.8 * full * (1.0 - left**5 - 5.0 / 6.0 * SHARES * (1.0 + left**2))
    return np.asarray((8.0 * below - 4.0 * force * delta) / exact - 1.0)


@pytest.mark.parametrize(
    ("level", "small", "large"),
    [
        pytest.param("quick", 0.06, 0.02, marks=pytest.mark.seconds),
        pytest.param("standard", 0.03, 0.01, marks=pytest.mark.slow),
        pytest.param("fine", 0.02, 0.005, marks=pytest.mark.slow),
    ],
)
def test_a_loop_is_as_large_as_of_a_finer_contact_however_little_slips(level: str, small: float, large: float) -> None:
    own = WIRE_LEVELS[level]
    errors = np.abs(_energy_errors(RimGradedAxis(1.0, round(own.to_rim), 1.3, own.rim_share)))
    assert errors[SHARES < 0.5].max() < small
    assert errors[SHARES >= 0.5].max() < large


@pytest.mark.slow
def test_wires_at_quick_stick_as_stiff_and_as_far_as_cattaneo_and_mindlin_say() -> None:
    study = parse_study(MINIMAL.replace("cycles = ", "held_tangential_force_N = 0.6\ncycles = "), "study")
    load, friction = study.conditions.normal_load_N, study.contact.friction
    meshes = discretise(study, "quick")
    problem = contact_problem(study, meshes, lambda _stage: None)
    radius, steel = meshes.hertz.contact_radius_mm, study.bodies[0].material
    modulus = reference.tangential_contact_modulus(steel, steel)
    exact = reference.partial_slip_point(load, friction, radius, modulus)
    body = condensed_body(meshes.fixed, steel)
    bulk = crossed_bulk_compliance(body, normal=False, contact_radius_mm=radius)
    pressed, _ = press(problem, unloaded_state(problem))
    tiny = advance(problem, pressed, 1e-6 * exact.full_slip_displacement_mm, 0.0)[0]
    stiffness = 1.0 / (tiny.drive / float(tiny.primary_force[:, 0].sum()) - bulk)
    assert stiffness == pytest.approx(exact.stiffness_N_per_mm, rel=0.01)
    state, finest = pressed, meshes.fixed.axial.finest_mm
    for share in (0.3, 0.6, 0.85):
        force = share * exact.limit_N
        place = float(reference.loading_displacement(exact, force)) + bulk * force
        state, _ = advance(problem, state, place, 0.0)
        core = float(np.sqrt(problem.surface.areas[state.core].sum() / np.pi))
        reached = float(state.primary_force[:, 0].sum())
        assert core == pytest.approx(float(reference.stick_radius(exact, reached)), abs=0.5 * finest)
