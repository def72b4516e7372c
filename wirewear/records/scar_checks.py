"""What is odd about a record's scar maps."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from wirewear.records.course_checks import accumulated_energy_J
from wirewear.records.exchanges import copied_scars
from wirewear.records.remarks import CheckedRecord, Remark, listed
from wirewear.records.scar_geometry import unlike_sizes
from wirewear.records.surfaces import MeasuredScar
from wirewear.records.values import ExperimentRecord
from wirewear.results.scar import WIRES

Array = NDArray[np.float64]

#: Depth at the map's edge, as a share of the deepest point, from which on the scar seems cut off.
CUT_OFF = 0.2

#: Missing points, as a share of the map, from which on it is worth a remark.
GAPS = 0.01

#: Depth below zero, as a share of the deepest point, that noise does not explain.
RAISED = 0.1

#: Depths that no profilometer's noise reaches [µm].
BEYOND_NOISE_um = 1.0

#: Factors between worn volume and what energy and stated wear make it: wear is seldom known better than within the
#: first, and off by the second only where units are wrong.
OTHER_WEAR, IMPOSSIBLE_WEAR = 5.0, 30.0


def scar_remarks(checked: CheckedRecord) -> Iterator[Remark]:
    """What is odd, one after another."""
    record = checked.record
    diameter_um = 1e3 * record.tables.wires.diameter_mm
    for wire in WIRES:
        scars = record.scars_of(wire)
        without = sorted(set(record.repeats) - {scar.repeat for scar in scars})
        if not scars:
            yield Remark("note", "scars", f"There is no scar of the {wire} wire.")
        elif without:
            yield Remark("note", "scars", f"There is no scar of the {wire} wire for the repeats {listed(without)}.")
        for scar in scars:
            yield from _findings(scar, diameter_um)
    for text in unlike_sizes(record):
        yield Remark("problem", "scars", text)
    noisy = record.tables.noise.displacement_um or record.tables.noise.tangential_force_N
    simulated = record.tables.metadata.source == "simulated"
    for text in copied_scars(record.scars):
        yield Remark("problem" if noisy and not simulated else "note", "scars", text)
    yield from _unlike_wear(record)


def _unlike_wear(record: ExperimentRecord) -> Iterator[Remark]:
    """Worn volumes that are far from what the tests' energies and the stated coefficient make them."""
    stated = record.tables.stated.energy_wear_coefficient_mm3_per_J
    for repeat in record.repeats if stated else ():
        volumes = [scar.volume_mm3 for scar in record.scars if scar.repeat == repeat]
        energy_J = accumulated_energy_J(record, repeat) if len(volumes) == len(WIRES) else None
        if not stated or not energy_J or not sum(volumes) > 0.0:
            continue
        ratio = sum(volumes) / (stated * energy_J)
        if not 1.0 / OTHER_WEAR < ratio < OTHER_WEAR:
            text = (
                f"The scars of repeat {repeat} have lost {ratio:.3g} times what {energy_J:.3g} J of friction wear at "
                f"the stated {stated:g} mm³/J: they may be of another test, or in another unit."
            )
            yield Remark("problem" if not 1.0 / IMPOSSIBLE_WEAR < ratio < IMPOSSIBLE_WEAR else "note", "scars", text)


def _findings(scar: MeasuredScar, diameter_um: float) -> Iterator[Remark]:
    name = f"the {scar.body} wire's scar of repeat {scar.repeat}"
    depth = scar.depth_um
    if not np.isfinite(depth).any():
        yield Remark("problem", "scars", f"All depths are missing in {name}.")
        return
    if scar.gaps > GAPS:
        yield Remark("note", "scars", f"{100.0 * scar.gaps:.2g} % of the points are missing in {name}.")
    # A single wild point should neither make nor hide a scar.
    lowest, deepest = (float(np.nanpercentile(depth, share)) for share in (0.5, 99.5))
    if deepest > diameter_um:
        text = f"Depths reach {deepest:.3g} µm in {name}, more than the wire's diameter of {diameter_um:.3g} µm."
        yield Remark("problem", "scars", text, refuses=True)
        return
    if lowest < -BEYOND_NOISE_um and -lowest > deepest:
        text = f"Depths fall to {lowest:.3g} µm in {name} and rise to {deepest:.3g} µm only: their sign seems wrong."
        yield Remark("problem", "scars", text, refuses=True)
    elif lowest < -max(RAISED * deepest, BEYOND_NOISE_um):
        text = f"Depths fall to {lowest:.3g} µm in {name}: material is piled up there, or the zero is off."
        yield Remark("note", "scars", text)
    if deepest <= 0.0:
        yield Remark("note", "scars", f"Nothing is worn in {name}.")
        return
    edge = float(np.percentile(scar.rim_um, 98))
    if edge > CUT_OFF * deepest:
        text = f"The map seems to cut off {name}: at its edge the depth is still {edge:.3g} µm of {deepest:.3g} µm."
        yield Remark("problem", "scars", text)
