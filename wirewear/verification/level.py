"""How finely and how strictly the reference problems are run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Level:
    """Meshes and tolerances.

    hertz_resolutions: elements per contact radius of the three meshes, from coarse to fine; the last is used for the
    ellipse and partial slip as well, under loads that enlarge the contact by `enlarged`.
    loop_resolution: elements per contact radius where the contact slides.
    line_resolution: elements per half-width of the line contact, which is planar and cheap.
    slip_increments: increments per loading branch in partial slip.
    stress_tolerance: of the largest stress beneath a contact.
    surface_resolution, surface_tolerance: elements per contact radius, and tolerance, for stresses at a contact's edge.
    line_surface_resolution, line_surface_tolerance: the same of a line contact, per half-width.
    partial_slip_wear_resolution, partial_slip_wear_tolerance: elements per contact radius where partial slip wears a
    contact out, and tolerance of the worn volume.
    partial_slip_run_resolution, partial_slip_run_tolerance: the same of a whole run.
    worn_line_cycles: for how long a line contact is worn whose pressures are looked at.
    Tolerances are relative.
    """

    name: str
    hertz_resolutions: tuple[float, float, float]
    enlarged: float
    loop_resolution: float
    line_resolution: float
    slip_increments: int
    partial_slip_wear_resolution: float
    partial_slip_wear_tolerance: float
    partial_slip_run_resolution: float
    partial_slip_run_tolerance: float
    worn_line_cycles: int
    hertz_tolerances: tuple[float, float, float]
    ellipse_tolerance: float
    slip_energy_tolerance: float
    stress_tolerance: float
    surface_resolution: float
    surface_tolerance: float
    line_surface_resolution: float
    line_surface_tolerance: float


QUICK = Level(
    name="quick",
    hertz_resolutions=(2.0, 3.0, 4.0),
    enlarged=1.6,
    loop_resolution=2.0,
    line_resolution=16.0,
    slip_increments=10,
    partial_slip_wear_resolution=4.0,
    partial_slip_wear_tolerance=0.5,
    partial_slip_run_resolution=4.0,
    partial_slip_run_tolerance=0.3,
    worn_line_cycles=300,
    hertz_tolerances=(0.12, 0.03, 0.01),
    ellipse_tolerance=0.03,
    slip_energy_tolerance=0.15,
    stress_tolerance=0.02,
    surface_resolution=3.5,
    surface_tolerance=0.05,
    line_surface_resolution=12.0,
    line_surface_tolerance=0.05,
)
FULL = Level(
    name="full",
    hertz_resolutions=(2.0, 4.0, 8.0),
    enlarged=1.5,
    loop_resolution=3.0,
    line_resolution=32.0,
    slip_increments=16,
    partial_slip_wear_resolution=6.0,
    partial_slip_wear_tolerance=0.2,
    partial_slip_run_resolution=8.0,
    partial_slip_run_tolerance=0.05,
    worn_line_cycles=5000,
    hertz_tolerances=(0.12, 0.01, 0.01),
    ellipse_tolerance=0.02,
    slip_energy_tolerance=0.05,
    stress_tolerance=0.02,
    surface_resolution=5.0,
    surface_tolerance=0.02,
    line_surface_resolution=18.0,
    line_surface_tolerance=0.03,
)
