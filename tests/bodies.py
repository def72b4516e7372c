"""Small bodies for the tests of geometry and solvers, each meshed and condensed once per session."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from geometry import BodyMesh, ContactPatch, Cylinder, Elastic, GradedAxis, HexMesh, WireGeometry, build_body
from geometry.arrays import Array
from geometry.body import gmsh_session
from solvers.contact import ContactProblem, advance, press, unloaded_state
from solvers.contact_state import ContactState, Holder, IncrementReport
from solvers.elasticity.condensation import CondensedBody
from solvers.elasticity.placement import PlacedBody, place
from solvers.wear import WearRates
from wirewear.simulation import problem as wires

# Threads cost more than they gain on problems this small, most of all on a busy machine.
_ONE_THREAD = {"limits": 1, "user_api": "blas"}
DIAMETER_mm = 0.45
RADIUS_mm = 0.225
LOAD_N = 2.0
FRICTION = 0.62
RIG_N_per_mm = 167.0
AMPLITUDE_mm = 0.06
#: Pressed on a mesh of such elements, the wires meet Hertz within 2 % (`test_contact_normal`).
ELEMENTS_THAT_MEET_HERTZ_mm = 0.0041
STEEL = Elastic(210_000.0, 0.3)


def brick(shape: tuple[int, int, int], size_mm: tuple[float, float, float], distortion: float = 0.0) -> HexMesh:
    """A block on z <= 0 with its top at z = 0 and its centre line at x = y = 0; inner nodes moved at random.

    Surfaces: 'grip' is the bottom, 'top' the top. Distortion is relative to the smallest element.
    """
    counts = np.array(shape) + 1
    lines = [np.linspace(-0.5 * s, 0.5 * s, n) for s, n in zip(size_mm[:2], counts[:2], strict=True)]
    lines.append(np.linspace(-size_mm[2], 0.0, counts[2]))
    points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    step = min(float(np.diff(line).min()) for line in lines)
    noise = np.random.default_rng(7).uniform(-1.0, 1.0, points.shape) * distortion * step
    points[1:-1, 1:-1, 1:-1] += noise[1:-1, 1:-1, 1:-1]
    n = np.arange(counts.prod()).reshape(counts)
    bottom = [n[:-1, :-1, :-1], n[1:, :-1, :-1], n[1:, 1:, :-1], n[:-1, 1:, :-1]]
    top = [n[:-1, :-1, 1:], n[1:, :-1, 1:], n[1:, 1:, 1:], n[:-1, 1:, 1:]]
    cells = np.stack(bottom + top, axis=-1).reshape(-1, 8)
    surfaces = {
        "grip": np.stack([side[..., 0] for side in bottom[::-1]], axis=-1).reshape(-1, 4),
        "top": np.stack([side[..., -1] for side in top], axis=-1).reshape(-1, 4),
    }
    return HexMesh(points.reshape(-1, 3), cells, surfaces)


def patch_on(mesh: HexMesh, radius_mm: float = 1e6) -> ContactPatch:
    """The whole top of a brick as a contact patch, flat unless a radius is given."""
    top = mesh.surface_nodes("top")
    axial, transverse = (np.unique(mesh.points[top, k]) for k in (0, 1))
    order = np.lexsort((mesh.points[top, 1], mesh.points[top, 0]))
    return ContactPatch(axial, transverse, top[order].reshape(len(axial), len(transverse)), Cylinder(radius_mm))


def rigid(axial_mm: Array, transverse_mm: Array, *, upper: bool, angle_rad: float, radius_mm: float) -> PlacedBody:
    """A patch placed in the world without any elastic body behind it, for tests of geometry alone."""
    nodes = np.arange(len(axial_mm) * len(transverse_mm)).reshape(len(axial_mm), len(transverse_mm))
    profile = Cylinder(radius_mm)
    patch = ContactPatch(axial_mm, transverse_mm, nodes, profile)
    corner = CondensedBody.whole(
        ContactPatch(axial_mm[:1], transverse_mm[:1], nodes[:1, :1], profile), np.zeros((3, 3))
    )
    return replace(place(corner, upper=upper, axis_angle_rad=angle_rad), patch=patch)


def wire_geometry(fine_mm: float, axial_fine_mm: float, axial_half_mm: float) -> WireGeometry:
    """A steel wire 1 mm long with a patch of the given extent along its axis and of 80 um across."""
    return WireGeometry(
        DIAMETER_mm, 1.0, GradedAxis(fine_mm, axial_fine_mm, 2.0 * fine_mm, axial_half_mm),
        GradedAxis(fine_mm, 0.02, 2.0 * fine_mm, 0.04), 0.12,
    )  # fmt: skip


@cache
def wire(fine_mm: float, axial_fine_mm: float = 0.02, axial_half_mm: float = 0.04) -> BodyMesh:
    """The mesh of such a wire."""
    return build_body(wire_geometry(fine_mm, axial_fine_mm, axial_half_mm))


@cache
def condensed_wire(fine_mm: float, axial_fine_mm: float = 0.02, axial_half_mm: float = 0.04) -> CondensedBody:
    """Such a wire of steel, condensed; kept in the session's cache, which its processes share."""
    return wires.condensed_body(wire_geometry(fine_mm, axial_fine_mm, axial_half_mm), STEEL)


@cache
def placed_wire(fine_mm: float, upper: bool, long_patch: bool) -> PlacedBody:
    """The lower wire lies along the motion, the upper one across it; a long patch has room for the whole stroke."""
    extent = (0.08, 0.11) if long_patch else (0.02, 0.04)
    return place(condensed_wire(fine_mm, *extent), upper=upper, axis_angle_rad=np.pi / 2 if upper else 0.0)


def crossed_wires(
    fine_mm: float,
    *,
    long_patch: bool = False,
    friction: float = FRICTION,
    rig_N_per_mm: float | None = None,
    spring_N_per_mm: float = 0.0,
    wear: tuple[float, float] = (0.0, 0.0),
    primary_is_upper: bool = True,
) -> ContactProblem:
    """Two steel wires crossed at right angles under 2 N."""
    compliance = 0.0 if rig_N_per_mm is None else 1.0 / rig_N_per_mm
    return ContactProblem(
        upper=placed_wire(fine_mm, upper=True, long_patch=False),
        lower=placed_wire(fine_mm, upper=False, long_patch=long_patch),
        holder=Holder(LOAD_N, compliance, spring_N_per_mm),
        friction=friction,
        wear=WearRates(*wear),
        primary_is_upper=primary_is_upper,
    )


def pressed(problem: ContactProblem) -> tuple[ContactState, IncrementReport]:
    """Fresh wires under the normal load."""
    with threadpool_limits(**_ONE_THREAD):
        return press(problem, unloaded_state(problem))


def driven(
    problem: ContactProblem, state: ContactState, drives_mm: Array, cycles: float = 0.0
) -> tuple[list[ContactState], list[list[IncrementReport]]]:
    """States and reports of increments to these drive positions, one after another."""
    states, reports = [], []
    with threadpool_limits(**_ONE_THREAD):
        for drive in drives_mm:
            state, pieces = advance(problem, state, float(drive), cycles)
            states.append(state)
            reports.append(pieces)
    return states, reports


def ball_of_tetrahedra(
    path: Path, radius_mm: float, half_mm: float, height_mm: float, element_mm: float, order: int
) -> None:
    """Write a square column cut from a ball, whose contact at the origin faces +z, with surfaces 'contact' and 'grip'.

    The column is half_mm wide to each side and height_mm high; its elements have four nodes or, of order 2, ten.
    """
    with gmsh_session() as gmsh:
        solids, size = gmsh.model.occ, 2.0 * half_mm
        ball = solids.addSphere(0.0, 0.0, -radius_mm, radius_mm)
        solids.intersect([(3, ball)], [(3, solids.addBox(-half_mm, -half_mm, -height_mm, size, size, 2.0 * height_mm))])
        solids.synchronize()
        faces = [tag for _, tag in gmsh.model.getEntities(2)]
        for name, kind in (("contact", "Sphere"), ("grip", "Plane")):
            gmsh.model.addPhysicalGroup(2, [tag for tag in faces if gmsh.model.getType(2, tag) == kind], name=name)
        gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], name="body")
        gmsh.option.setNumber("Mesh.MeshSizeMax", element_mm)
        gmsh.option.setNumber("Mesh.ElementOrder", order)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(path))
