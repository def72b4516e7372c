"""Calibration of a remote displacement sensor: simulated motions under load, a polynomial, corrected records."""

from wirewear.calibration.calibration import Calibration, calibrate, parse_loads, parse_near
from wirewear.calibration.correcting import Correction, corrected_record
from wirewear.calibration.loading import NEAR_POINTS, LoadedMotion, NearPoint, loaded_motions
from wirewear.calibration.polynomial import LoadPolynomial, fitted_polynomial

__all__ = [
    "NEAR_POINTS",
    "Calibration",
    "Correction",
    "LoadPolynomial",
    "LoadedMotion",
    "NearPoint",
    "calibrate",
    "corrected_record",
    "fitted_polynomial",
    "loaded_motions",
    "parse_loads",
    "parse_near",
]
