"""How far largest pressures of runs of one study agree: at single nodes, and as means over a length.

Usage: python -m studies.benchmarks.pressure_peaks RESULT.h5... [--cycle 100000] [--over 15]

A contact's crest may be as narrow as an element at every level of fidelity; then its pressure at a node grows with each
refinement; means over a length do not. Both are the largest over all recorded positions of the cycle.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wirewear.results import ContactForces, largest_mean_pressure_MPa, read_result

Array = NDArray[np.float64]


def line_shares(lines: Array) -> Array:
    """Length that belongs to each of the mesh lines (n,)."""
    halves = 0.5 * np.diff(lines)
    return np.asarray(np.concatenate([halves, [0.0]]) + np.concatenate([[0.0], halves]))


def largest_at_nodes(forces: ContactForces) -> float:
    """The largest normal force over its node's area, in MPa."""
    lines = forces.geometry.axial.lines(), forces.geometry.transverse.lines()
    areas = np.outer(*map(line_shares, lines)).ravel()[forces.nodes]
    return float((np.abs(forces.force_N[:, :, 2]) / areas).max())


def main() -> None:
    """Read the command line and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("results", type=Path, nargs="+")
    parser.add_argument("--cycle", type=int, default=100_000)
    parser.add_argument("--over", type=float, default=15.0, help="µm")
    given = parser.parse_args()
    for path in given.results:
        for forces in read_result(path).contact_forces:
            if forces.cycle == given.cycle:
                at_nodes = largest_at_nodes(forces)
                mean = largest_mean_pressure_MPa(forces.places_um, forces.force_N[:, :, 2], given.over)
                print(f"{path} {forces.wire:>6}: {at_nodes:6.0f} MPa at a node, {mean:6.0f} MPa over {given.over:g} µm")


if __name__ == "__main__":
    main()
