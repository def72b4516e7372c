"""A contact at a point as the input of Abaqus or CalculiX: both bodies as worn at a recorded cycle, pressed together,
then moved once to and fro behind the rig's spring.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from geometry import BodyMesh, Elastic, HexMesh
from geometry.arrays import Array, IntArray
from solvers.elasticity.placement import rotation_to_world
from solvers.laws.friction_law import Coulomb
from wirewear.base.errors import ResultError
from wirewear.base.writing import write_text
from wirewear.results import RunResult
from wirewear.stress.bodies import meshed_body
from wirewear.test import Study, study_from_tables

_STIFFNESS = 30.0  #: Of the penalty for penetration, over modulus by element size: it is some 1 % of the approach.
_STICKING = 0.1  #: Of the stiffness against elastic slip, over that one.
_INCREMENTS = 20  #: Of each half stroke, at first.


def write_deck(result: RunResult, path: Path, cycle: float, dialect: str) -> Path:
    """Write the deck of the recorded cycle nearest to `cycle` to a file, in mm, N and MPa; return the file.

    dialect: "abaqus" or "calculix", which differ in words for friction and hard contact. The driven, lower body's grip
    follows the node DRIVE; the upper one's follows HOLDER, which does not turn and which the normal load of that cycle
    and the rig's spring act on. What wear by UMESHMOTION needs stands there for Abaqus as comments.

    Raises ResultError if the run has recorded no contact forces, whose meshes these are, if a body is from a file, or
    if the study has what a deck cannot state: it is named.
    """
    study: Study = study_from_tables(result.study, result.label)
    _require_simple(study, result)
    lower, upper = (_Placed(result, cycle, name) for name in result.bodies)
    upper.rest_on(lower)
    upper.node, upper.cell = 1 + len(lower.points), 1 + len(lower.mesh.cells)
    drive, spring_element = upper.node + len(upper.points), upper.cell + len(upper.mesh.cells)
    bodies, holder = (lower, upper), drive + 1
    stiff = _STIFFNESS * max(one.material.youngs_modulus_MPa / one.element_mm for one in bodies)
    friction = _real(study.contact.friction)
    hard = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE="
    lines = [
        "*HEADING",
        f"{result.label}, cycle {lower.cycle}, by wirewear: mm, N, MPa",
        "*NODE, NSET=ALL",
        *(row for one in bodies for row in _rows(one.points, one.node)),
        *_rows(np.array([[0.0, 0.0, lower.points[:, 2].min()], [0.0, 0.0, upper.points[:, 2].max()]]), drive),
        "*NSET, NSET=DRIVE", f"{drive},", "*NSET, NSET=HOLDER", f"{holder},",
        *lower.lines(drive), *upper.lines(holder),
        "*SURFACE INTERACTION, NAME=WEARING",
        *([f"{hard}LINEAR", _real(stiff)] if dialect == "calculix" else [f"{hard}HARD"]),
        "*FRICTION",
        f"{friction}, {_real(_STICKING * stiff)}" if dialect == "calculix" else friction,
        "*CONTACT PAIR, INTERACTION=WEARING, TYPE=SURFACE TO SURFACE",
        f"CONTACT_{upper.name}, CONTACT_{lower.name}",
    ]  # fmt: skip
    spring = study.holder.tangential_stiffness_N_per_mm
    held = "HOLDER, 1, 2" if spring == "rigid" else "HOLDER, 2, 2"
    if spring != "rigid":
        lines += [
            "*ELEMENT, TYPE=SPRING1, ELSET=RIG",
            f"{spring_element}, {holder}",
            "*SPRING, ELSET=RIG",
            "1",
            _real(spring),
        ]
    lines += ["*BOUNDARY", "DRIVE, 1, 3", held]
    amplitude_mm = 1e-3 * study.conditions.displacement_amplitude_um
    stroke = [("first quarter", amplitude_mm), ("back", -amplitude_mm), ("forth", amplitude_mm)]
    receding = [f"** {line}" for one in bodies for line in one.receding()] if dialect == "abaqus" else []
    steps = [
        # A load alone would find nothing to rest on.
        ("pressed together as far as in the run", ["*BOUNDARY", f"HOLDER, 3, 3, {_real(-upper.approach_mm)}"]),
        ("held by the load",
         ["*BOUNDARY, OP=NEW", "DRIVE, 1, 3", held, "*CLOAD", f"HOLDER, 3, {_real(-upper.load_N)}"]),
        *((what, ["*BOUNDARY", f"DRIVE, 1, 1, {_real(at)}", *receding]) for what, at in stroke),
    ]  # fmt: skip
    total = "ONLY" if dialect == "calculix" else "YES"
    for what, conditions in steps:
        lines += [
            f"** {what}", "*STEP, NLGEOM, INC=1000", "*STATIC", f"{1 / _INCREMENTS:g}, 1., 1e-6, {1 / _INCREMENTS:g}",
            *conditions, "*NODE PRINT, NSET=DRIVE", "U", "*NODE PRINT, NSET=HOLDER", "U",
            f"*NODE PRINT, NSET=GRIP_{lower.name}, TOTALS={total}", "RF", "*END STEP",
        ]  # fmt: skip
    return write_text(path, "\n".join(lines) + "\n")


def _require_simple(study: Study, result: RunResult) -> None:
    tables, law = study.tables, study.contact.friction_law
    beyond = {
        "a holder that turns": study.holder.rotational_stiffness_N_mm_per_rad != "rigid",
        "a load cycle or programme": study.conditions.load_cycle is not None or bool(tables.programme),
        "effects": bool(tables.effects),
        "bulk stress": bool(tables.drive.bulk),
        "coats of their own modulus": any(tables.coatings),
        "elastic grips": any(body.grip_stiffness_N_per_mm3 != "rigid" for body in study.bodies),
        f"{law.name} friction": not isinstance(law, Coulomb),
    }
    if any(beyond.values()):
        lacking = " or ".join(words for words, stated in beyond.items() if stated)
        raise ResultError(f"{result.label}: a deck cannot state {lacking}: export a run without.")


class _Placed:
    """A body of a run, meshed as worn at a cycle, where it stands in the test's axes; `node` and `cell` are the numbers
    of its first node and element.
    """

    node, cell, approach_mm = 1, 1, 0.0

    def __init__(self, result: RunResult, cycle: float, name: str) -> None:
        forces = result.forces(cycle, name)
        body: BodyMesh = meshed_body(result, forces)
        if body.host is not None:
            raise ResultError(f"the {result.called(name)} is from a file of its own, which a deck does not hold.")
        self.name, self.cycle = name.upper().replace(" ", "_"), forces.cycle
        self.mesh: HexMesh = body.mesh
        # A loading spring gives way as the bodies wear.
        self.load_N = abs(float(forces.force_N[:, :, 2].sum(axis=1).mean()))
        self.height_mm = 1e-3 * float(forces.holder_z_um.mean())
        self.element_mm = float(min(np.diff(lines).min() for lines in (body.patch.axial_mm, body.patch.transverse_mm)))
        self.material: Elastic = forces.meshed[1]
        turn = rotation_to_world(upper=result.is_upper(name), axis_angle_rad=float(np.radians(forces.axis_angle_deg)))
        self.points: Array = self.mesh.points @ turn.T

    def rest_on(self, lower: "_Placed") -> None:
        """Move this upper body until it just touches the lower one; it stands `approach_mm` lower in the run."""
        below, own = (one.points[one.mesh.surface_nodes("contact")] for one in (lower, self))
        height = LinearNDInterpolator(below[:, :2], below[:, 2])(own[:, :2])
        touching_mm = -float(np.nanmin(own[:, 2] - height))
        self.points, self.approach_mm = self.points + [0.0, 0.0, touching_mm], touching_mm - self.height_mm

    def lines(self, leader: int) -> Iterator[str]:
        """Elements, material, surfaces, and equations by which the grip follows the node `leader`."""
        name, material = self.name, self.material
        yield f"*ELEMENT, TYPE=C3D8, ELSET={name}"
        for number, corners in enumerate(self.mesh.cells + self.node, self.cell):
            yield ", ".join(map(str, (number, *corners)))
        yield from (f"*MATERIAL, NAME=OF_{name}", "*ELASTIC")
        yield f"{_real(material.youngs_modulus_MPa)}, {_real(material.poissons_ratio)}"
        yield from (f"*SOLID SECTION, ELSET={name}, MATERIAL=OF_{name}", f"*SURFACE, NAME=CONTACT_{name}, TYPE=ELEMENT")
        for own, side in _sides(self.mesh, self.mesh.surfaces["contact"]):
            yield f"{self.cell + own}, S{side + 1}"
        yield f"*NSET, NSET=WORN_{name}"
        yield from (f"{one}," for one in self.mesh.surface_nodes("contact") + self.node)
        gripped = self.mesh.surface_nodes("grip") + self.node
        yield from (f"*NSET, NSET=GRIP_{name}", *(f"{one}," for one in gripped))
        for one in gripped:
            for axis in (1, 2, 3):
                yield from ("*EQUATION", "2", f"{one}, {axis}, 1., {leader}, {axis}, -1.")

    def receding(self) -> Iterator[str]:
        """What makes nodes of the patch recede by a user subroutine UMESHMOTION."""
        yield from (f"*ADAPTIVE MESH, ELSET={self.name}", "*ADAPTIVE MESH CONSTRAINT, TYPE=VELOCITY, USER")
        yield f"WORN_{self.name}"


def _real(value: float) -> str:
    """A number with a decimal point, without which CalculiX reads none."""
    return text if "." in (text := f"{value:.9g}") or "e" in text else f"{text}."


def _rows(points: Array, first: int) -> Iterator[str]:
    return (f"{number}, {x:.12g}, {y:.12g}, {z:.12g}" for number, (x, y, z) in enumerate(points, first))


def _sides(mesh: HexMesh, facets: IntArray) -> Iterator[tuple[int, int]]:
    """Cell and side, both from 0, of each facet; the sides of `HexMesh.SIDES` are in the order of both programs."""
    corners = np.sort(mesh.cells[:, mesh.SIDES], axis=2)
    places = {tuple(own): divmod(place, len(mesh.SIDES)) for place, own in enumerate(corners.reshape(-1, 4).tolist())}
    return (places[tuple(own)] for own in np.sort(facets, axis=1).tolist())
