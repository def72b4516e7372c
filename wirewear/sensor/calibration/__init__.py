"""Calibration of a remote displacement sensor: simulated motions under load, a polynomial, corrected records."""

from wirewear.sensor.calibration.calibration import Calibration, calibrate, parse_loads, parse_near
from wirewear.sensor.calibration.correcting import Correction, corrected_record
from wirewear.sensor.calibration.loading import NEAR_POINTS, LoadedMotion, NearPoint, loaded_motions
from wirewear.sensor.calibration.polynomial import LoadPolynomial, fitted_polynomial

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
