"""Stresses inside wires from two runs of one study, coarse and fine: how far apart they are, and where.

Usage: python -m studies.benchmarks.inside_convergence COARSE.h5 FINE.h5 [--cycle 1 --cycle 100] [--at mid-forward]

Von Mises stresses are compared where both bodies have the same material: in the section along the motion and in the one
across it through the middle of the contact, down to three of its half-widths and as far to either side. Points within
half a half-width of the contact's edge are left out: there the tension has a cusp, and a row of nodes more or less in
contact moves the edge by an element.

Lines along the motion follow, at depths in half-widths, each over its own largest stress. Two half-widths deep elements
are nearly as large as the stresses' own waves. There the field at the nodes swings about the elements' means, which are
several times closer to the closed form: the last two columns compare these, interpolated between the elements' middles.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import cKDTree

from studies.study_script import StudyScript
from wirewear.results import RunResult, read_result
from wirewear.results.scar import WIRES
from wirewear.stress import BodyState, body_grid, body_states, von_mises

Array = NDArray[np.float64]

#: Half-widths around the contact that are compared, points a half-width, and the nearest to the edge, in half-widths.
REACH, PER_HALF_WIDTH, FROM_EDGE = 3.0, 10, 0.5
#: Depths of the lines, in half-widths, and how far they reach to either side.
DEPTHS, ALONG = (0.25, 0.5, 1.0, 2.0, 3.0), 2.0


@dataclass(frozen=True)
class Contact:
    """Middle (3,) of a contact, its edge (k, 3), half its width along the motion, in µm in the test's axes."""

    middle: Array
    edge: Array
    half_width: float


@dataclass(frozen=True)
class Difference:
    """Von Mises stresses of two fields at the same points, over the largest of the fine one there.

    mean, largest, at_peak: of the differences, and of the largest values. root: of the mean squares' ratio.
    """

    mean: float
    largest: float
    at_peak: float
    root: float
    peak_MPa: float

    @classmethod
    def of(cls, coarse: Array, fine: Array) -> "Difference":
        """From von Mises stresses (k,) in MPa."""
        apart, peak = np.abs(coarse - fine), float(fine.max())
        root = float(np.linalg.norm(coarse - fine) / np.linalg.norm(fine))
        return cls(float(apart.mean()) / peak, float(apart.max()) / peak, float(coarse.max()) / peak - 1.0, root, peak)


def contact_of(state: BodyState) -> Contact:
    """Where a wire is in contact."""
    forces = state.applied[state.patch_nodes]
    edge = state.body.surface.under(forces).edge()
    world = state.world_points_um(np.column_stack([edge, state.body.patch.height(edge)]))
    nodes = state.world_points_um(state.places_mm[state.patch_nodes])
    middle = np.average(nodes, axis=0, weights=np.abs(forces[:, 2]))
    across = np.abs(world[:, 1] - middle[1])
    beside = world[across <= np.quantile(across, 0.2)]
    return Contact(middle, world, 0.5 * float(np.ptp(beside[:, 0])))


def section(contact: Contact, inwards: float, axis: int) -> Array:
    """Points (k, 3) of the section along an axis, away from the contact's edge."""
    a = contact.half_width
    steps = np.arange(-REACH, REACH + 1e-9, 1.0 / PER_HALF_WIDTH)
    s, d = (each.ravel() for each in np.meshgrid(a * steps, a * steps[steps >= 0.0], indexing="ij"))
    points = np.tile(contact.middle, (len(s), 1))
    points[:, axis] += s
    points[:, 2] += inwards * d
    away = cKDTree(contact.edge).query(points)[0]
    return np.asarray(points[away >= FROM_EDGE * a])


def line(contact: Contact, inwards: float, depth: float) -> Array:
    """Points (k, 3) along the motion at a depth in half-widths."""
    steps = np.linspace(-ALONG, ALONG, 81) * contact.half_width
    points = np.tile(contact.middle, (len(steps), 1))
    points[:, 0] += steps
    points[:, 2] += inwards * depth * contact.half_width
    return points


def stress_at(state: BodyState, points_um: Array) -> Array:
    """Von Mises stresses (k,) in MPa at points in the test's axes by the nodes; not a number outside the body."""
    import pyvista

    found = pyvista.PolyData(points_um).sample(body_grid(state))
    values = np.array(found["von_mises_MPa"], dtype=float)
    values[np.asarray(found["vtkValidPointMask"]) == 0] = np.nan
    return values


def mean_at(state: BodyState, points_um: Array) -> Array:
    """Von Mises stress at points (n, 3) in MPa, linear between the elements' means; NaN above the uppermost middle."""
    middles = state.world_points_um(state.body.points.positions.mean(axis=1))
    centre, reach = points_um.mean(axis=0), np.ptp(points_um, axis=0).max()
    near = np.abs(middles - centre).max(axis=1) < reach
    stress = von_mises(state.stress_at_points[near].mean(axis=1))
    return np.asarray(LinearNDInterpolator(middles[near], stress)(points_um))


def compared(
    coarse: BodyState, fine: BodyState, points_um: Array, by: Callable[[BodyState, Array], Array] = stress_at
) -> Difference:
    """How far two states are apart at points that lie in both bodies."""
    values = [by(state, points_um) for state in (coarse, fine)]
    both = np.isfinite(values[0]) & np.isfinite(values[1])
    return Difference.of(values[0][both], values[1][both])


def printed(results: Sequence[RunResult], cycles: Sequence[float], at: str) -> None:
    """The differences of both wires at cycles."""
    titles = f"{'peak':>8} {'of peak':>8} {'mean':>7} {'largest':>8} {'r.m.s.':>7}   elements' means: of peak, mean"
    for cycle in cycles:
        for wire in WIRES:
            coarse, fine = (body_states(result, wire, cycle, [at])[0] for result in results)
            contacts = [contact_of(state) for state in (coarse, fine)]
            contact, inwards = contacts[1], 1.0 if wire == "fixed" else -1.0
            widths = " and ".join(f"{one.half_width:.1f}" for one in contacts)
            print(f"cycle {fine.forces.cycle}, {wire} wire, half-widths {widths} µm{'':6}{titles}", flush=True)
            parts = [(f"section along {'xy'[axis]}", section(contact, inwards, axis)) for axis in (0, 1)]
            for name, points in parts:
                print(_row(name, compared(coarse, fine, points)), flush=True)
            for depth in DEPTHS:
                points = line(contact, inwards, depth)
                means = compared(coarse, fine, points, mean_at)
                row = _row(f"line {depth:g} half-widths deep", compared(coarse, fine, points))
                print(f"{row} {means.at_peak:+18.1%} {means.mean:8.1%}", flush=True)


def _row(name: str, one: Difference) -> str:
    return f"  {name:<48} {one.peak_MPa:8.0f} {one.at_peak:+8.1%} {one.mean:7.1%} {one.largest:8.1%} {one.root:7.1%}"


@click.command(cls=StudyScript)
@click.argument("coarse", type=click.Path(path_type=Path))
@click.argument("fine", type=click.Path(path_type=Path))
@click.option("--cycle", "cycles", type=float, multiple=True, default=(1, 100, 1000, 100_000), show_default=True)
@click.option("--at", default="mid-forward", show_default=True)
def main(coarse: Path, fine: Path, cycles: tuple[float, ...], at: str) -> None:
    """Compare the stresses inside the wires of two results, COARSE and FINE, and print."""
    printed([read_result(path) for path in (coarse, fine)], cycles, at)


if __name__ == "__main__":
    main()
