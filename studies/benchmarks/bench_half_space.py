"""The normal problem of two crossed wires: wirewear beside tamaas's half-space and Hertz's closed form.
Last of wires that yield at 1 400 MPa, their pressures limited as in wirewear.

Usage: python -m studies.benchmarks.bench_half_space [--contact-mesh-um 5] [--points 512]

tamaas (pip install tamaas) solves by Polonsky and Keer's conjugate gradients on a periodic domain of 16 contact radii.
The images' mean displacement is corrected to first order: the approach is measured between the middle of the contact
and the domain's mean plane, which lies below the distant half-space by the load's own periodic sum, 3.9003 P/(pi E* L)
(a square lattice of point loads in a uniform counter-pressure). wirewear's wires are gripped cylinders: their bending
and the half-space's missing rest are in its approach, but hardly in its pressures.
"""

import time
from dataclasses import dataclass
from importlib.util import find_spec

import click
import numpy as np
from numpy.typing import NDArray

from studies.study_script import StudyScript
from wirewear import reference
from wirewear.simulation.workbench import contact_problem, press, unloaded_state

from .crossed_wires import discretised, study

Array = NDArray[np.float64]

ABSENT = "tamaas is not installed, so there is no half-space to compare with: pip install tamaas"
RADIUS_mm, LOAD_N, DOMAIN_RADII = 0.225, 2.0, 16.0
# Potential in the middle of a square lattice of unit charges in a uniform background, without the middle one (Ewald).
LATTICE = 3.900265


@dataclass(frozen=True)
class Normal:
    """Peak pressure in MPa, contact area in mm², approach and print of both bodies in mm, pressures at distances."""

    name: str
    peak_pressure_MPa: float
    area_mm2: float
    approach_mm: float
    distance_mm: Array
    pressure_MPa: Array
    seconds: float
    print_mm: float = 0.0


def hertz() -> reference.PointContact:
    steel = reference.Elastic(210_000.0, 0.3)
    return reference.hertz_point(LOAD_N, RADIUS_mm, reference.contact_modulus(steel, steel))


def by_wirewear(contact_mesh_um: float, wires: str = "") -> Normal:
    """Pressed gripped wires solved by wirewear. wires: further TOML lines of [wires]; contact_mesh_um: size of
    elements. Seconds are without condensation.
    """
    of = study(contact_mesh_um, wires=wires)
    problem = contact_problem(of, discretised(of), lambda _stage: None)
    start = time.process_time()
    state, report = press(problem, unloaded_state(problem))
    seconds = time.process_time() - start
    distance = np.hypot(*problem.primary.node_positions.T)
    pressure, approach = state.traction[:, 2], -state.holder_z
    prints = sum(float(own.max()) for own in state.wear.prints if own is not None)
    return Normal("wirewear", report.max_pressure, report.contact_area, approach, distance, pressure, seconds, prints)


def by_tamaas(points: int, limit_MPa: float = 0.0) -> Normal:
    """Tamaas's solution on a periodic half-space; limit_MPa: of the pressure, 0: none."""
    import tamaas

    exact, steel = hertz(), reference.Elastic(210_000.0, 0.3)
    length, modulus = DOMAIN_RADII * exact.contact_radius_mm, reference.contact_modulus(steel, steel)
    # Kato's steps are the gap as a pressure, which fits where the longest wave's compliance is one.
    unit = np.pi / length
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [np.pi, np.pi], [points, points])
    model.E, model.nu = 1.0, 0.0
    x = (np.arange(points) - points // 2) * length / points
    squared = x[:, None] ** 2 + x[None, :] ** 2
    surface = -unit * squared / (2.0 * RADIUS_mm)
    solver = tamaas.PolonskyKeerRey(model, surface, 1e-10)
    if limit_MPa:
        solver = tamaas.KatoSaturated(model, surface, 1e-8, limit_MPa / modulus)
    start = time.process_time()
    solver.solve(LOAD_N / length**2 / modulus)
    seconds = time.process_time() - start
    left = np.asarray(model["KatoSaturated::residual_displacement"]) / unit if limit_MPa else 0.0 * squared
    model.solveNeumann()
    pressure, moved = modulus * np.asarray(model.traction), np.asarray(model.displacement) / unit
    approach = float((moved + left)[points // 2, points // 2] - moved.mean()) + periodic_correction(length, modulus)
    most, area = float(pressure.max()), float((pressure > 0.0).sum()) * (length / points) ** 2
    return Normal("tamaas", most, area, approach, np.sqrt(squared), pressure, seconds, float(left.max()))


def periodic_correction(length_mm: float, modulus_MPa: float) -> float:
    """Sinking of a periodic half-space's middle that its images take away, mm."""
    return LATTICE * LOAD_N / (np.pi * modulus_MPa * length_mm)


def table(solutions: list[Normal], exact: reference.PointContact) -> list[str]:
    """Each solution beside Hertz, and the pressure's root-mean-square difference from his profile, in p0."""
    area = np.pi * exact.contact_radius_mm**2
    rows = [
        (
            f"{'':10}{'p0 [MPa]':>10}{'':>8}{'area [um2]':>12}{'':>8}{'approach [um]':>14}"
            f"{'':>8}{'profile':>9}{'CPU [s]':>9}"
        ),
        f"{'Hertz':10}{exact.peak_pressure_MPa:10.1f}{'':>8}{1e6 * area:12.1f}{'':>8}{1e3 * exact.approach_mm:14.4f}",
    ]
    for one in solutions:
        inside = one.distance_mm < exact.contact_radius_mm
        difference = one.pressure_MPa[inside] - exact.pressure(one.distance_mm[inside])
        profile = float(np.sqrt((difference**2).mean())) / exact.peak_pressure_MPa
        errors = (
            one.peak_pressure_MPa / exact.peak_pressure_MPa - 1.0,
            one.area_mm2 / area - 1.0,
            one.approach_mm / exact.approach_mm - 1.0,
        )
        rows.append(
            f"{one.name:10}{one.peak_pressure_MPa:10.1f}{100 * errors[0]:7.2f}%{1e6 * one.area_mm2:12.1f}"
            f"{100 * errors[1]:7.2f}%{1e3 * one.approach_mm:14.4f}{100 * errors[2]:7.2f}%{100 * profile:8.2f}%"
            f"{one.seconds:9.3f}{1e3 * one.print_mm:11.4f}"
        )
    return rows


@click.command(cls=StudyScript)
@click.option(
    "--contact-mesh-um",
    type=click.FloatRange(0.0, min_open=True),
    default=5.0,
    show_default=True,
    help="Size of the contact's elements.",
)
@click.option("--points", type=click.IntRange(2), default=512, show_default=True, help="Of tamaas, on a side.")
def main(contact_mesh_um: float, points: int) -> None:
    """Solve the normal problem by wirewear, tamaas and Hertz, and print."""
    if find_spec("tamaas") is None:
        click.echo(ABSENT)
        return
    yielding = by_wirewear(contact_mesh_um, "yield_stress_MPa = 1400.0")
    solutions = [by_wirewear(contact_mesh_um), by_tamaas(points)]
    solutions += [yielding, by_tamaas(points // 2, yielding.peak_pressure_MPa)]
    click.echo("\n".join(table(solutions, hertz())))


if __name__ == "__main__":
    main()
