"""Calibration of a displacement sensor by loaded contacts, as JSON and as a table."""

import numpy as np
from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from wirewear.diagnosis.fit.sensor_calibration import Calibration, Correction, slope
from wirewear.loops import Measured
from wirewear.views.loops_report import rounded


def calibration_json(study: str, calibration: Calibration, correction: "Correction | None") -> dict[str, object]:
    """Calibration as plain values for JSON; study: its name; correction: None if no record was corrected, "record" is
    then null.
    """
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


def _measured_json(measured: Measured) -> dict[str, object]:
    return {"value": measured.value, "interval95": list(measured.interval95)}


def calibration_text(calibration: Calibration, correction: "Correction | None") -> RenderableType:
    """Table of the compliance under each load, the fitted polynomial with its error and, if there is one, the
    correction of a record, to be printed with rich.
    """
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
        f"linear_um_per_N = {' ± '.join(rounded(polynomial.linear_um_per_N))}",
        f"quadratic_um_per_N2 = {' ± '.join(rounded(polynomial.quadratic_um_per_N2))}",
        f"motions lie {rms:.2g} um from it (root mean square), at most {most_um:.2g} um",
    ]
    if correction is not None:
        lines.append(
            f"record: displacements changed by up to {correction.largest_um:.3g} ± {correction.error_um:.2g} um"
            + ("" if correction.noise_um is None else f"; noise added {correction.noise_um:.2g} um")
        )
        lines += correction.notes
    return Group(table, Text("\n".join(lines)))
