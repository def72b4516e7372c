"""What is odd about a record's scar maps."""

from collections.abc import Iterator
from dataclasses import dataclass
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

#: Depths that no profilometer's noise reaches [µm].
BEYOND_NOISE_um = 1.0


@dataclass(frozen=True)
class Finding:
    """Something odd about a map; `refuses` as in a remark on a record."""

    level: Literal["problem", "note"]
    text: str
    refuses: bool = False


def scar_findings(record: ExperimentRecord) -> Iterator[Finding]:
    """What is odd, one after another."""
    diameter_um = 1e3 * record.tables.wires.diameter_mm
    for wire in WIRES:
        scars = record.scars_of(wire)
        without = sorted(set(record.repeats) - {scar.repeat for scar in scars})
        if not scars:
            yield Finding("note", f"There is no scar of the {wire} wire.")
        elif without:
            yield Finding("note", f"There is no scar of the {wire} wire for the repeats {listed(without)}.")
        for scar in scars:
            yield from _findings(scar, diameter_um)


def _findings(scar: MeasuredScar, diameter_um: float) -> Iterator[Finding]:
    name = f"the {scar.wire} wire's scar of repeat {scar.repeat}"
    depth = scar.depth_um
    if not np.isfinite(depth).any():
        yield Finding("problem", f"All depths are missing in {name}.")
        return
    if scar.gaps > GAPS:
        yield Finding("note", f"{100.0 * scar.gaps:.2g} % of the points are missing in {name}.")
    # A single wild point should neither make nor hide a scar.
    lowest, deepest = (float(np.nanpercentile(depth, share)) for share in (0.5, 99.5))
    if deepest > diameter_um:
        text = f"Depths reach {deepest:.3g} µm in {name}, more than the wire's diameter of {diameter_um:.3g} µm."
        yield Finding("problem", text, refuses=True)
        return
    if lowest < -BEYOND_NOISE_um and -lowest > deepest:
        text = f"Depths fall to {lowest:.3g} µm in {name} and rise to {deepest:.3g} µm only: their sign seems wrong."
        yield Finding("problem", text, refuses=True)
    elif lowest < -max(RAISED * deepest, BEYOND_NOISE_um):
        yield Finding(
            "note", f"Depths fall to {lowest:.3g} µm in {name}: material is piled up there, or the zero is off."
        )
    if deepest <= 0.0:
        yield Finding("note", f"Nothing is worn in {name}.")
        return
    edge = float(np.percentile(scar.rim_um, 98))
    if edge > CUT_OFF * deepest:
        text = f"The map seems to cut off {name}: at its edge the depth is still {edge:.3g} µm of {deepest:.3g} µm."
        yield Finding("problem", text)
