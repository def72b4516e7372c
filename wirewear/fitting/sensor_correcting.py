"""A record whose displacements are corrected for the load; a calibration on one screen, and as JSON."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from wirewear.base.errors import RecordError
from wirewear.fitting.sensor_calibration import Calibration, LoadedMotion, LoadPolynomial
from wirewear.loops import Measured
from wirewear.records import ExperimentRecord, MeasuredEvolution
from wirewear.records.tables import Noise
from wirewear.views.loops_report import rounded


def calibration_json(study: str, calibration: Calibration, correction: "Correction | None") -> dict[str, Any]:
    """The calibration as JSON; `record` is null where none was corrected."""
    polynomial = calibration.polynomial
    return {
        "format": 1,
        "study": study,
        "near": calibration.near,
        "remote_compliance_um_per_N": calibration.remote_compliance_um_per_N,
        "linear_um_per_N": _measured_json(polynomial.linear_um_per_N),
        "quadratic_um_per_N2": _measured_json(polynomial.quadratic_um_per_N2),
        "largest_force_N": polynomial.largest_force_N,
        "residual_rms_um": polynomial.residual_rms_um,
        "residual_largest_um": polynomial.residual_largest_um,
        "loads": [
            {
                "normal_load_N": motion.normal_load_N,
                "linear_um_per_N": slope(motion),
                "tangential_force_N": motion.tangential_force_N.tolist(),
                "remote_um": motion.remote_um.tolist(),
                "near_um": motion.near_um.tolist(),
            }
            for motion in calibration.motions
        ],
        "record": None
        if correction is None
        else {
            "name": correction.record.name,
            "largest_correction_um": correction.largest_um,
            "largest_force_N": correction.largest_force_N,
            "error_um": correction.error_um,
            "added_noise_um": correction.noise_um,
            "notes": list(correction.notes),
        },
    }


def _measured_json(measured: Measured) -> dict[str, Any]:
    return {"value": measured.value, "interval95": list(measured.interval95)}


def slope(motion: LoadedMotion) -> float:
    """Least-squares remote − near per tangential force under one normal load, µm/N."""
    force, difference = motion.tangential_force_N, motion.remote_um - motion.near_um
    return float(force @ difference / (force @ force))


def calibration_text(calibration: Calibration, correction: "Correction | None") -> RenderableType:
    """Compliance under each load, the polynomial with its error, and what it did to a record."""
    polynomial = calibration.polynomial
    table = Table(box=box.SIMPLE, pad_edge=False, title="Remote minus near displacement", title_justify="left")
    for heading in ("normal load\n[N]", "forces up to\n[N]", "difference there\n[µm]", "slope\n[µm/N]"):
        table.add_column(heading, justify="right")
    for motion in calibration.motions:
        most = int(np.argmax(motion.tangential_force_N))
        difference = motion.remote_um[most] - motion.near_um[most]
        largest = motion.tangential_force_N[most]
        table.add_row(f"{motion.normal_load_N:g}", f"{largest:.3g}", f"{difference:.4g}", f"{slope(motion):.4g}")
    rms, most_um = polynomial.residual_rms_um, polynomial.residual_largest_um
    lines = [
        f"linear_um_per_N = {_with_interval(polynomial.linear_um_per_N)}",
        f"quadratic_um_per_N2 = {_with_interval(polynomial.quadratic_um_per_N2)}",
        f"motions lie {rms:.2g} um from it (root mean square), at most {most_um:.2g} um",
    ]
    if correction is not None:
        lines.append(
            f"record: displacements changed by up to {correction.largest_um:.3g} ± {correction.error_um:.2g} um"
            + ("" if correction.noise_um is None else f"; noise added {correction.noise_um:.2g} um")
        )
        lines += correction.notes
    return Group(table, Text("\n".join(lines)))


def _with_interval(measured: Measured) -> str:
    return " ± ".join(rounded(measured))


@dataclass(frozen=True)
class Correction:
    """A corrected record, and how far the correction can be trusted.

    Attributes:
        record: with displacements at the near point.
        largest_um: the largest change of a sample.
        largest_force_N: the largest |Q| of its loops.
        error_um: the polynomial's own error at that force, half of a 95 % interval.
        noise_um: standard deviation that the force's noise adds to each displacement, or None where it is not stated.
        notes: sentences to be read with it.
    """

    record: ExperimentRecord
    largest_um: float
    largest_force_N: float
    error_um: float
    noise_um: float | None
    notes: tuple[str, ...]


def corrected_record(record: ExperimentRecord, polynomial: LoadPolynomial) -> Correction:
    """Take linear · Q + quadratic · Q² from every displacement of a record.

    Amplitudes of the evolution and the asked one fall by linear · Q at the tips, where the quadratic part moves both
    alike; slip amplitudes, energies and scars stay (Q = 0, and ∮Q df(Q) = 0). Missing samples stay missing.
    Raises RecordError if the correction is no smaller than the motion itself.
    """
    sensor = polynomial.sensor
    loops = tuple(loop.read_as(sensor.corrected(loop.signals())) for loop in record.loops)
    changes = [np.abs(new.displacement_um - old.displacement_um) for new, old in zip(loops, record.loops, strict=True)]
    largest = float(max(np.nanmax(change, initial=0.0) for change in changes))
    force = float(max(np.nanmax(np.abs(loop.tangential_force_N), initial=0.0) for loop in record.loops))
    asked = record.tables.conditions.displacement_amplitude_um
    at_tips = sensor.linear_um_per_N * _median_tip_force(record)
    if at_tips >= asked:
        raise RecordError(
            f"the polynomial would take {at_tips:.3g} um from the amplitude of {asked:g} um of the record "
            f"{record.name!r}: its compliance does not belong to this rig."
        )
    noise = record.tables.noise.tangential_force_N
    added = None if noise is None else abs(sensor.linear_um_per_N) * noise
    halves = [
        0.5 * float(np.ptp(figure.interval95))
        for figure in (polynomial.linear_um_per_N, polynomial.quadratic_um_per_N2)
    ]
    error = float(np.hypot(halves[0] * force, halves[1] * force**2))
    tables = record.tables.model_copy(
        update={
            "name": f"{record.name}, displacement corrected for the load",
            "conditions": record.tables.conditions.model_copy(update={"displacement_amplitude_um": asked - at_tips}),
            "noise": _with_noise(record, added),
        }
    )
    evolution = tuple(_corrected_evolution(part, sensor.linear_um_per_N) for part in record.evolution)
    notes = _notes(polynomial, force)
    return Correction(
        replace(record, tables=tables, loops=loops, evolution=evolution), largest, force, error, added, notes
    )


def _median_tip_force(record: ExperimentRecord) -> float:
    """Median over the loops of half the difference of the forces at both ends of the stroke."""
    halves = []
    for loop in record.loops:
        whole = loop.complete
        if whole.displacement_um.size:
            ends = int(np.argmax(whole.displacement_um)), int(np.argmin(whole.displacement_um))
            halves.append(0.5 * float(whole.tangential_force_N[ends[0]] - whole.tangential_force_N[ends[1]]))
    return float(np.median(halves)) if halves else 0.0


def _with_noise(record: ExperimentRecord, added_um: float | None) -> Noise:
    noise = record.tables.noise
    if noise.displacement_um is None or added_um is None:
        return noise
    return noise.model_copy(update={"displacement_um": float(np.hypot(noise.displacement_um, added_um))})


def _corrected_evolution(part: MeasuredEvolution, linear_um_per_N: float) -> MeasuredEvolution:
    columns = dict(part.columns)
    columns["displacement_amplitude_um"] = (
        columns["displacement_amplitude_um"] - linear_um_per_N * columns["max_tangential_force_N"]
    )
    return replace(part, columns=columns)


def _notes(polynomial: LoadPolynomial, force_N: float) -> tuple[str, ...]:
    if force_N <= 1.1 * polynomial.largest_force_N:
        return ()
    fitted = f"the polynomial was fitted up to {polynomial.largest_force_N:.3g} N"
    return (f"forces reach {force_N:.3g} N, but {fitted}: calibrate under larger normal loads",)
