"""Bodies that come from no mesh of ours, and bodies that yield, put into a contact without a change to it."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import pytest

import solvers
from geometry import ContactPatch, Cylinder
from geometry.arrays import Array, IntArray
from tests.bodies import driven, pressed
from tests.solvers.wear_jumps import LINE_LOAD_N_per_mm, hertz_of_line, line_contact
from wirewear.reference import Elastic, contact_modulus, hertz_point

RADIUS_mm, LOAD_N, MODULUS_MPa, STEP_mm = 0.225, 2.0, 160_000.0, 0.004
_SQUARE = 2.9732  # Mean of 1/r over a square and itself, times its side.


@dataclass(frozen=True)
class HalfSpace:
    """An incompressible half-space by Boussinesq and Cerruti: displacements are worked out when they are asked for."""

    places: Array  #: (n, 2) of the nodes.
    asked: list[int] = field(default_factory=list)
    rotation: Array = field(default_factory=lambda: np.eye(3))

    @cached_property
    def dense(self) -> Array:
        everywhere = np.arange(len(self.places))
        return self.between(everywhere, everywhere)

    def between(self, moved: IntArray, loaded: IntArray, out: Array | None = None, add: Array | None = None) -> Array:
        self.asked.append(len(moved) * len(loaded))
        apart = self.places[moved][:, None] - self.places[loaded]
        apart = np.concatenate([apart, np.zeros((*apart.shape[:2], 1))], axis=2) @ self.rotation.T
        distance = np.linalg.norm(apart, axis=2)
        own = distance < 1e-9
        along = apart / np.where(own, 1.0, distance)[..., None]
        shape = 0.5 * (np.eye(3) + along[..., :, None] * along[..., None, :])
        shape[own] = np.diag([0.75, 0.75, 0.5])
        one_over = np.where(own, _SQUARE / STEP_mm, 1.0 / np.where(own, 1.0, distance))
        found = 1.5 / (np.pi * MODULUS_MPa) * one_over[..., None, None] * shape
        flat = np.ascontiguousarray(found.transpose(0, 2, 1, 3)).reshape(3 * len(moved), 3 * len(loaded))
        if add is not None and out is not None:
            out += flat * np.tile(add, len(loaded))
            return out
        if out is not None:
            out[:] = flat
            return out
        return flat

    def diagonal(self) -> Array:
        nodes = np.arange(len(self.places))
        return np.concatenate([self.between(node, node).diagonal() for node in nodes[:, None]])

    def turned(self, rotation: Array) -> "HalfSpace":
        return replace(self, rotation=rotation @ self.rotation)


@dataclass(frozen=True)
class FromClosedForm:
    """A cylinder's shape on a half-space."""

    patch: ContactPatch
    folded: HalfSpace
    bricks: None = None
    yields: bool = False

    def update(self, print_mm: Array, _force_N: Array, /) -> Array:
        return print_mm


@pytest.fixture(scope="module")
def half_space() -> FromClosedForm:
    lines = STEP_mm * np.arange(-7.0, 8.0)
    patch = ContactPatch(lines, lines, np.arange(225).reshape(15, 15), Cylinder(RADIUS_mm))
    return FromClosedForm(patch, HalfSpace(patch.grid()))


def crossed(body: solvers.ContactBody) -> solvers.ContactProblem:
    upper, lower = (
        solvers.place(body, upper=upper, axis_angle_rad=angle) for upper, angle in ((True, np.pi / 2), (False, 0.0))
    )
    return solvers.ContactProblem(upper, lower, solvers.Holder(LOAD_N), 0.6, solvers.WearRates(1e-8, 1e-8))


@pytest.mark.seconds
def test_a_body_that_is_no_matrix_is_pressed_slid_and_worn_as_its_matrix(half_space: FromClosedForm) -> None:
    matrix = solvers.CondensedBody.whole(half_space.patch, half_space.folded.dense)
    states = []
    for body in (half_space, matrix):
        problem = crossed(body)
        state, report = pressed(problem)
        states.append(driven(problem, state, np.array([0.002, 0.006]), cycles=10.0)[0][-1])
    own, known = states
    assert max(half_space.folded.asked[1:]) < half_space.patch.size**2
    assert own.traction == pytest.approx(known.traction, abs=1e-9 * known.traction.max())
    assert own.wear.primary_depth.max() > 0.0
    assert own.wear.primary_depth == pytest.approx(known.wear.primary_depth, rel=1e-9)
    material = Elastic(MODULUS_MPa, 0.5)
    hertz = hertz_point(LOAD_N, RADIUS_mm, contact_modulus(material, material))
    assert -state.holder_z == pytest.approx(hertz.approach_mm, rel=0.05)
    assert report.max_pressure == pytest.approx(hertz.peak_pressure_MPa, rel=0.08)


@dataclass(frozen=True)
class Yielding:
    """A body whose surface is left lower by what the pressure has been above its yield pressure."""

    of: solvers.CondensedBody
    yield_MPa: float
    softness_mm_per_MPa: float
    yields: bool = True
    bricks: None = None

    @property
    def patch(self) -> ContactPatch:
        return self.of.patch

    @property
    def folded(self) -> solvers.Compliance:
        return self.of.folded

    def beyond(self, force_N: Array) -> Array:
        pressure = (-force_N[:, 2] / self.patch.node_areas()).reshape(self.patch.shape)
        return self.softness_mm_per_MPa * np.maximum(pressure - self.yield_MPa, 0.0)

    def update(self, print_mm: Array, force_N: Array, /) -> Array:
        return np.maximum(print_mm, self.beyond(force_N))


@pytest.mark.seconds
@pytest.mark.parametrize("upper_yields", [True, False])
def test_a_body_that_yields_keeps_the_print_that_its_load_has_left(upper_yields: bool) -> None:
    elastic = line_contact()
    placed = elastic.upper if upper_yields else elastic.lower
    body = Yielding(
        solvers.CondensedBody.whole(placed.patch, _in_own_axes(placed)), yield_MPa=300.0, softness_mm_per_MPa=5e-8
    )
    soft = solvers.place(body, upper=upper_yields, axis_angle_rad=0.0)
    problem = replace(elastic, upper=soft) if upper_yields else replace(elastic, lower=soft)
    state, report = pressed(problem)
    left, other = state.wear.prints if upper_yields else state.wear.prints[::-1]
    assert other is None
    assert left is not None
    assert report.normal_force == pytest.approx(LINE_LOAD_N_per_mm, rel=1e-6)
    assert report.max_pressure < 0.98 * hertz_of_line().peak_pressure_MPa
    force = state.primary_force if upper_yields else -state.secondary_force
    assert left == pytest.approx(body.beyond(force * [1.0, 1.0, -1.0 if upper_yields else 1.0]), abs=2e-3 * left.max())
    half = replace(problem, holder=solvers.Holder(0.5 * LINE_LOAD_N_per_mm))
    again, _ = solvers.press(half, replace(solvers.unloaded_state(half), wear=state.wear))
    assert again.wear.prints[0 if upper_yields else 1] == pytest.approx(left, abs=1e-15)
    fresh, _ = pressed(replace(elastic, holder=solvers.Holder(0.5 * LINE_LOAD_N_per_mm)))
    assert -again.holder_z > -fresh.holder_z + 0.3 * left.max()
    carried = solvers.transferred_wear(state.wear, *(2 * [(problem.primary.patch, problem.secondary.patch)]))
    kept = carried.prints[0 if upper_yields else 1]
    assert kept == pytest.approx(left, abs=1e-12)


def _in_own_axes(placed: solvers.PlacedBody) -> Array:
    turn = placed.folded.rotation
    size = placed.patch.size
    return np.asarray(
        np.einsum("ka,ikjl,lb->iajb", turn, placed.compliance.reshape(size, 3, size, 3), turn).reshape(3 * size, -1)
    )
