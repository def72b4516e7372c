"""What layers of other materials on a run's body change of the stress in it."""

from collections.abc import Sequence

import numpy as np

from geometry import ContactPatch, Elastic
from solvers.stress.coats import CoatStress
from wirewear.results import ContactForces, RunResult


def coats_of(
    result: RunResult, forces: ContactForces, patch: ContactPatch, body: Elastic, positions: Sequence[int]
) -> list[CoatStress | None]:
    """The change at positions of a cycle; None without layers of other materials, or where they are worn off. Layers
    are as thick everywhere as on average under what the body carries.
    """
    coating = result.coating(forces.body, body)
    if coating is None:
        return [None] * len(positions)
    order = slice(None, None, -1 if result.is_upper(forces.body) else 1)
    depth = np.maximum(1e-3 * result.scar(forces.cycle, forces.body).depth_um, 0.0)
    depth = (depth[:, order] if depth.ndim == 2 else depth).ravel()[forces.nodes]
    load = np.abs(forces.force_N[..., 2]).sum(axis=0)
    worn = float(load @ np.minimum(depth, coating.thickness_mm) / load.sum()) if load.any() else 0.0
    left = coating.worn(worn)
    if not left.layers:
        return [None] * len(positions)
    traction = np.zeros((len(positions), patch.size, 3))
    traction[:, forces.nodes] = forces.force_N[list(positions)]
    traction /= patch.node_areas()[:, None]
    return [CoatStress(left, patch, one.reshape(*patch.shape, 3)) for one in traction]
