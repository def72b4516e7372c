"""A made-up result with contact forces on coarse wires: a sliding Hertz-like pressure over a shallow bowl."""

from dataclasses import replace

import numpy as np

from tests import bodies
from tests.synthetic_results import result
from wirewear.results import ContactForces, RunResult, Scar

CYCLE, POSITIONS = 100, 8
AMPLITUDE_um, FRICTION, LOAD_N = 20.0, 0.5, 2.0
DEPTH_um, RADIUS_mm = 2.0, 0.03


def run_with_forces() -> RunResult:
    """Both wires at one cycle; the contact stays in the middle of each, the shear turns with the motion."""
    wires = ("moving", "fixed")
    return replace(
        result(milestones=(CYCLE,)),
        scars=tuple(_scar(wire) for wire in wires),
        contact_forces=tuple(_forces(wire) for wire in wires),
    )


def _scar(wire: str) -> Scar:
    patch = bodies.wire(0.02).patch
    a, t = np.meshgrid(patch.axial_mm, patch.transverse_mm, indexing="ij")
    depth = DEPTH_um * np.maximum(1.0 - (a**2 + t**2) / RADIUS_mm**2, 0.0)
    nothing = np.zeros_like(depth)
    angle = 90.0 if wire == "fixed" else 0.0
    lines = 1e3 * patch.axial_mm, 1e3 * patch.transverse_mm
    return Scar(CYCLE, wire, 0.45, angle, *lines, depth, nothing, nothing, nothing)


def _forces(wire: str) -> ContactForces:
    patch = bodies.wire(0.02).patch
    r = np.hypot(*patch.grid().T)
    pressure = np.sqrt(np.maximum(1.0 - (r / RADIUS_mm) ** 2, 0.0)) * patch.node_areas()
    nodes = np.flatnonzero(pressure)
    share = LOAD_N * pressure[nodes] / pressure.sum()
    phase = (np.arange(POSITIONS) + 1.0) / POSITIONS
    # Between the reversals the moving wire is rubbed against its motion.
    forward = np.where(phase <= 0.5, -1.0, 1.0)
    force = np.zeros((POSITIONS, len(nodes), 3))
    force[:, :, 2] = -share
    along = 0 if wire == "moving" else 1
    force[:, :, along] = FRICTION * np.outer(-forward, share)
    tangential = FRICTION * LOAD_N * forward
    if wire == "fixed":  # its own transverse axis is the test's x axis, and it feels the reaction
        force[:, :, along] *= -1.0
    drive = AMPLITUDE_um * np.cos(2.0 * np.pi * phase)
    return ContactForces(
        cycle=CYCLE, body=wire, axis_angle_deg=90.0 if wire == "fixed" else 0.0, geometry=bodies.wire(0.02).geometry,
        material=bodies.STEEL, phase=phase, drive_um=drive, holder_x_um=np.zeros(POSITIONS),
        holder_z_um=np.full(POSITIONS, -0.5), tangential_force_N=tangential, nodes=nodes, force_N=force,
    )  # fmt: skip
