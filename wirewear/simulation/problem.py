"""The contact problem of a study at a point from its meshes, and the problem at an age of the test.

Condensing a body reduces its stiffness to the nodes of its patch, the finely meshed part that may touch. The primary
body is the one whose nodes carry the contact tractions, the other is the secondary. The driven (moving) body lies
below.
"""

from collections.abc import Callable
from dataclasses import asdict, replace
from functools import lru_cache
from math import inf, radians, sin
from pathlib import Path
from typing import Protocol, TypedDict

import numpy as np

import solvers
from geometry import BodyGeometry, BodyMesh, ContactPatch, Elastic, Profile, build_body
from geometry.arrays import Array
from geometry.stiffness_files import OwnStiffness, write_stiffness
from solvers.elasticity.elimination import inverse
from solvers.elasticity.embedding import condense_meshed
from solvers.elasticity.patch_compliance import Bricks, PatchCompliance
from solvers.elasticity.placement import rotation_to_world
from wirewear.base.cache import (
    CONDENSATION_CODE,
    allowed_bytes,
    identity_of,
    keep_within,
    kept_file,
    mark_used,
    not_kept,
)
from wirewear.base.errors import StudyError
from wirewear.base.memory import size_text
from wirewear.base.words import counted
from wirewear.base.writing import in_one_step
from wirewear.effects import Age, Seam, Specimens, applied, problem_with
from wirewear.results.scar import called
from wirewear.simulation.near_zone import NearZone, near_zone_of
from wirewear.simulation.yielding import limit_of_points
from wirewear.test import AnyStudy, Study
from wirewear.test.bodies import Body
from wirewear.test.surfaces import StatedSurface


def condensed_body(geometry: BodyGeometry, material: Elastic, directory: Path | None = None) -> solvers.CondensedBody:
    """A body meshed and condensed, or loaded from the cache (None) or `directory` if it has been condensed before.
    A cached file that cannot be read is replaced; one that cannot be written is left out.
    """
    if isinstance(geometry, OwnStiffness):
        return _of_file(geometry, material)
    asked = {"shape": type(geometry).__name__, "geometry": geometry.as_table(), "material": asdict(material)}
    name = f"body-{identity_of(asked, CONDENSATION_CODE, {}).name}.npz"
    path = kept_file(name) if directory is None else directory / name
    stored = None if path is None else _load(path, geometry.profile)
    if path is not None and stored is not None:
        mark_used(path)
        return replace(stored, bricks=Bricks(material, geometry.layers))
    meshed = build_body(geometry)
    body = condense_meshed(meshed, material)
    if path is not None:
        _store(path, body)
    return replace(body, bricks=Bricks(material, geometry.layers))


def condensed_worn_body(
    geometry: BodyGeometry, material: Elastic, worn_depth_mm: Array
) -> tuple[solvers.CondensedBody, float]:
    """(body, smallest scaled Jacobian of its mesh): a body condensed after its patch's nodes were moved down by a
    vertical depth (n_a, n_t) in mm below the unworn surface.

    A body from a file of its stiffness stays as it is, with 1. Nothing is cached, since every state of wear occurs
    once. Raises GeometryError, naming the place, if an element is distorted too much.
    """
    if isinstance(geometry, OwnStiffness):
        return _of_file(geometry, material), 1.0
    worn = _fresh_body(geometry).worn(worn_depth_mm)
    body = condense_meshed(worn, material)
    return replace(body, bricks=Bricks(material, geometry.layers)), worn.smallest_scaled_jacobian


@lru_cache(maxsize=2)
def _of_file(geometry: OwnStiffness, material: Elastic) -> solvers.CondensedBody:
    """The body of a file with a condensed stiffness. StudyError if its stiffness is not positive definite."""
    stiffness, patch = geometry.read.of_free
    try:
        compliance = inverse(stiffness)
    except solvers.SolverError:
        raise StudyError(
            f"the stiffness in {Path(geometry.source.file).name} is not positive definite for a body that is held: "
            "give the one of a body that resists every deformation"
        ) from None
    of_patch = np.ascontiguousarray(compliance[: 3 * patch.size, : 3 * patch.size])
    bricks = None if geometry.read.layers is None else Bricks(material, geometry.layers)
    return replace(solvers.CondensedBody.whole(patch, of_patch), bricks=bricks)


def write_condensed(path: Path, geometry: BodyGeometry, material: Elastic) -> None:
    """Write the stiffness of a body, meshed here and condensed to its patch, as `stiffness_files` reads it."""
    body = condensed_body(geometry, material)
    write_stiffness(path, body.patch, inverse(body.compliance), geometry.layers)


@lru_cache(maxsize=2)
def _fresh_body(geometry: BodyGeometry) -> BodyMesh:
    """The mesh of a body, kept since both bodies of a run are worn again and again from the same fresh mesh."""
    return build_body(geometry)


def _load(path: Path, profile: Profile) -> solvers.CondensedBody | None:
    try:
        # What numpy opens itself it leaves open where the archive is damaged.
        with path.open("rb") as file, np.load(file) as data:
            lines, nodes = (data["axial"], data["transverse"]), data["nodes"]
            patch = ContactPatch(*lines, nodes, profile)
            planes = tuple(data["planes"].tolist())
            return solvers.CondensedBody(patch, PatchCompliance(patch.shape, planes, data["blocks"]))
    except Exception:  # noqa: BLE001 - a damaged archive raises errors of zipfile and zlib, too many to name
        return None


def _store(path: Path, body: solvers.CondensedBody) -> None:
    patch = body.patch
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with in_one_step(path) as partial, partial.open("wb") as file:
            np.savez(
                file,
                axial=patch.axial_mm,
                transverse=patch.transverse_mm,
                nodes=patch.nodes,
                planes=np.array(body.folded.planes, dtype=np.int64),
                blocks=body.folded.blocks,
            )
        keep_within(path.parent, allowed_bytes(), newest=path)
    except OSError as problem:
        not_kept(path, problem)


Announce = Callable[[str], None]  #: Called with the name of each part of a preparation as it begins.


class BothMeshes(Protocol):
    """The geometries of the meshes of both bodies: the driven (moving) and the held (fixed) one."""

    @property
    def moving(self) -> BodyGeometry:
        """Geometry of the driven body's mesh."""

    @property
    def fixed(self) -> BodyGeometry:
        """Geometry of the held body's mesh."""


def contact_problem(study: Study, meshes: BothMeshes, announce: Announce) -> solvers.ContactProblem:
    """The contact problem of a study without effects that depend on the age of the test: both bodies meshed and
    condensed (or loaded), placed, the upper one on its rig. announce: called with the name of each part of the work.
    """
    lower, upper = _placed(study, *condense_bodies(study, meshes, announce))
    limit, near = limit_of_points(study), near_zone_of(study)
    announce("pressing the bodies together")
    return solvers.ContactProblem(
        upper=upper,
        lower=lower,
        **laws_of(study),
        primary_is_upper=held_is_primary(study),
        formulation=study.contact.formulation,
        limit=limit if near is None or limit is None else near.limited(limit),
    )


def with_nodes_moved(
    problem: solvers.ContactProblem, study: Study, meshes: BothMeshes, depths: tuple[Array, Array], announce: Announce
) -> tuple[solvers.ContactProblem, float]:
    """(problem, smallest scaled Jacobian of both meshes): the problem with the surface nodes of both bodies moved down.

    depths: of the driven and the held body in mm, (n_a, n_t) each, below the unworn surface. The bodies are condensed
    again; announce: called with the name of each part. Raises GeometryError if an element is distorted too much.
    """
    driven, held = study.bodies
    announce(f"moving the nodes of the {called(driven.name)}")
    moving, first = condensed_worn_body(meshes.moving, driven.material, depths[0])
    announce(f"moving the nodes of the {called(held.name)}")
    fixed, second = condensed_worn_body(meshes.fixed, held.material, depths[1])
    lower, upper = _placed(study, moving, fixed)
    return replace(problem, lower=lower, upper=upper), min(first, second)


def worn_depths(problem: solvers.ContactProblem, state: solvers.ContactState) -> tuple[Array, Array]:
    """(driven, held): worn depths in mm, (n_a, n_t) each, without prints."""
    wear = state.wear
    if problem.primary_is_upper:
        return wear.secondary_depth, wear.primary_depth
    return wear.primary_depth, wear.secondary_depth


def held_is_primary(study: Study) -> bool:
    """True if the held body is the primary, False if the driven one; exchanging the bodies exchanges the answer."""
    limit = limit_of_points(study)
    if limit is not None and limit.upper_share in (0.0, 1.0):
        # The nodes that carry the tractions keep a print as it is, where the surface that faces them averages it.
        return limit.upper_share == 1.0
    if study.contact.primary_wire != "auto":
        return study.contact.primary_wire == "fixed"
    driven_share = 0.5 if study.wear is None else study.wear.moving_share
    driven, held = map(_precedence, study.bodies, (driven_share, 1.0 - driven_share))
    return held >= driven


def _precedence(body: Body, worn_share: float) -> tuple[float, ...]:
    """Key by which the body with the larger one is the primary, whichever of them is driven.

    Wear of the primary is not spread over elements on its way: the body that wears more comes first, then one that the
    contact stays with, then one that lies across the motion; softer ones come before stiffer ones.
    """
    across = sin(radians(body.axis_angle_deg)) ** 2 if body.has_axis else 0.0
    leading = (1.0, inf) if body.face is not None else (0.0, sum(body.curvatures_per_mm))
    order = worn_share, *leading, across, -body.youngs_modulus_MPa, -body.poissons_ratio
    return tuple(float(f"{value:.9g}") for value in order)


def _placed(
    study: Study, moving: solvers.CondensedBody, fixed: solvers.CondensedBody
) -> tuple[solvers.PlacedBody, solvers.PlacedBody]:
    """The driven body placed below and the held one above the contact; the world's x axis is the direction of
    motion.
    """
    motion = radians(study.motion_angle_deg)
    crossing = radians(specimens_of(study).crossing_angle_deg)
    driven, held = study.bodies
    moving = measured(moving, driven.surface, driven.axis_angle_deg, upper=False)
    fixed = measured(fixed, held.surface, held.axis_angle_deg, upper=True)
    lower = solvers.place(moving, upper=False, axis_angle_rad=-motion)
    upper = solvers.place(fixed, upper=True, axis_angle_rad=crossing - motion)
    of_driven, of_held = study.tables.coatings
    if held_is_primary(study):
        return lower, solvers.coated(solvers.facing(upper, lower), of_held, of_driven)
    return solvers.coated(solvers.facing(lower, upper), of_driven, of_held), upper


def measured(
    condensed: solvers.CondensedBody, surface: StatedSurface | None, axis_angle_deg: float, *, upper: bool
) -> solvers.CondensedBody:
    """A condensed body with the surface that was measured of it before the test; unchanged for None. Its mesh keeps the
    unworn shape. axis_angle_deg: angle of the body's axis to the motion. upper: True for the held body.
    """
    if surface is None:
        return condensed
    angle = radians(axis_angle_deg) if surface.frame == "test" else 0.0
    to_map = rotation_to_world(upper=upper, axis_angle_rad=angle)[:2, :2]
    profile = surface.lowering(condensed.patch.profile, to_map)
    return replace(condensed, patch=replace(condensed.patch, profile=profile))


class Laws(TypedDict):
    """Arguments of `ContactProblem` that follow from a study."""

    holder: solvers.Holder
    friction: float
    friction_law: solvers.FrictionLaw
    timing: solvers.DriveTiming
    wear: solvers.WearRates


def laws_of(study: AnyStudy) -> Laws:
    """Rig, friction, drive and wear of a study, without effects, as keyword arguments of `ContactProblem`."""
    return Laws(
        holder=study.tables.rig,
        friction=study.contact.friction,
        friction_law=study.contact.friction_law,
        timing=solvers.DriveTiming(study.drive, study.conditions.frequency_Hz),
        wear=study.tables.wear_rates,
    )


def problem_at(problem: solvers.ContactProblem, study: Study, age: Age) -> solvers.ContactProblem:
    """The contact problem with the study's effects and the variation of its wear coefficient at an age of the test."""
    if study.wear is not None and study.wear.variation != "none":
        problem = replace(problem, wear=problem.wear.scaled(study.wear.factor(age.cycles, age.energy_J)))
    return problem_with(problem, study.effects, age)


def specimens_of(study: Study) -> Specimens:
    """Crossing angle and flattening of the bodies as they were mounted, effects included."""
    return applied(study.effects, Seam.SPECIMENS, Specimens(study.crossing_angle_deg), Age.new())


def fresh_state(problem: solvers.ContactProblem, study: Study, near: NearZone | None) -> solvers.ContactState:
    """The state of bodies that just touch, flattened if an effect asks for that, with the prints of pressing if their
    metal flows.
    """
    amplitude, state = 1e-3 * study.conditions.displacement_amplitude_um, solvers.unloaded_state(problem)
    if near is not None:
        state = replace(state, wear=near.pressed(problem, state.wear))
    return solvers.flattened(problem, state, specimens_of(study).flattening_mm, amplitude)


def condense_bodies(
    study: Study, meshes: BothMeshes, announce: Announce
) -> tuple[solvers.CondensedBody, solvers.CondensedBody]:
    """(driven, held): both bodies condensed, or loaded from the cache. announce: called with the name of each part."""
    driven, held = study.bodies
    announce(f"condensing the {called(driven.name)}")
    moving = condensed_body(meshes.moving, driven.material)
    announce(f"condensing the {called(held.name)}")
    return moving, condensed_body(meshes.fixed, held.material)


def too_much(study: str, nodes: int, needed: float, free: float, remedy: str) -> StudyError:
    """The error for a study, called `study`, with `nodes` nodes in a contact, whose `needed` bytes of memory exceed the
    `free` ones. remedy: what would fit, in words.
    """
    return StudyError(
        f"the study {study} asks for {counted(nodes)} nodes in a contact and {size_text(needed)} of memory, of which "
        f"{size_text(free)} are free: {remedy}, or allow more by --most-memory."
    )
