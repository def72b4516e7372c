"""What is odd about a record's scar maps."""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from wirewear.records.values import WIRES, ExperimentRecord, MeasuredScar
from wirewear.records.wording import listed

#: Depth at the map's edge, as a share of the deepest point, from which on the scar seems cut off.
CUT_OFF = 0.2

#: Missing points, as a share of the map, from which on it is worth a remark.
GAPS = 0.01

#: Depth below zero, as a share of the deepest point, that noise does not explain.
RAISED = 0.1

Finding = tuple[Literal["problem", "note"], str]


def scar_findings(record: ExperimentRecord) -> Iterator[Finding]:
    """Level and sentence of each finding."""
    for wire in WIRES:
        scars = record.scars_of(wire)
        without = sorted(set(record.repeats) - {scar.repeat for scar in scars})
        if not scars:
            yield "note", f"There is no scar of the {wire} wire."
        elif without:
            yield "note", f"There is no scar of the {wire} wire for the repeats {listed(without)}."
        for scar in scars:
            yield from _findings(scar)


def _findings(scar: MeasuredScar) -> Iterator[Finding]:
    name = f"the {scar.wire} wire's scar of repeat {scar.repeat}"
    depth = scar.depth_um
    if not np.isfinite(depth).any():
        yield "problem", f"All depths are missing in {name}."
        return
    gaps = float(np.mean(~np.isfinite(depth)))
    if gaps > GAPS:
        yield "note", f"{100.0 * gaps:.2g} % of the points are missing in {name}."
    # A single wild point should neither make nor hide a scar.
    deepest = float(np.nanpercentile(depth, 99.5))
    if deepest <= 0.0:
        yield "note", f"Nothing is worn in {name}."
        return
    lowest = float(np.nanpercentile(depth, 0.5))
    if lowest < -RAISED * deepest:
        yield "problem", f"Depths fall to {lowest:.3g} µm in {name}, where worn depth is never negative."
    edges = np.concatenate([depth[0], depth[-1], depth[:, 0], depth[:, -1]])
    edge = float(np.nanpercentile(edges, 98)) if np.isfinite(edges).any() else 0.0
    if edge > CUT_OFF * deepest:
        yield (
            "problem",
            f"The map seems to cut off {name}: at its edge the depth is still {edge:.3g} µm of {deepest:.3g} µm.",
        )
