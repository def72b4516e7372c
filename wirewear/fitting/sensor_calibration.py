"""A calibration from end to end, and the options of its command."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from wirewear.base.errors import SensorError, StudyError
from wirewear.fitting.sensor_loading import NEAR_POINTS, LoadedMotion, NearPoint, loaded_motions
from wirewear.loops import Measured
from wirewear.loops.sensor import Sensor
from wirewear.study import Study

FEWEST_MOTIONS = 4


@dataclass(frozen=True)
class LoadPolynomial:
    """remote − near = linear · Q + quadratic · Q², Q the tangential force.

    Attributes:
        linear_um_per_N: with its 95 % interval.
        quadratic_um_per_N2: with its 95 % interval.
        largest_force_N: up to which |Q| it was fitted.
        residual_rms_um: of the motions about it.
        residual_largest_um: the largest of them, without its sign.
    """

    linear_um_per_N: Measured
    quadratic_um_per_N2: Measured
    largest_force_N: float
    residual_rms_um: float
    residual_largest_um: float

    @property
    def sensor(self) -> Sensor:
        """The sensor that reads so."""
        return Sensor(linear_um_per_N=self.linear_um_per_N.value, quadratic_um_per_N2=self.quadratic_um_per_N2.value)


def fitted_polynomial(motions: Sequence[LoadedMotion]) -> LoadPolynomial:
    """Fit the polynomial to motions under all loads alike, by least squares (Infante-García et al. 2020, section 2.1).

    How far the normal load changes the compliance is part of the residual, and so of the intervals (Student's t).

    Raises:
        SensorError: fewer than four motions under load.
    """
    force, remote, near = (
        np.concatenate([getattr(motion, name) for motion in motions])
        for name in ("tangential_force_N", "remote_um", "near_um")
    )
    difference = remote - near
    if np.unique(force).size < FEWEST_MOTIONS:
        raise SensorError(f"a polynomial in the load needs motions under at least {FEWEST_MOTIONS} tangential forces")
    scale = float(np.abs(force).max())
    design = np.column_stack([force / scale, (force / scale) ** 2])
    coefficients = np.linalg.lstsq(design, difference, rcond=None)[0]
    residual = difference - design @ coefficients
    freedom = force.size - 2
    covariance = np.linalg.inv(design.T @ design) * float(residual @ residual) / freedom
    half = float(stdtrit(freedom, 0.975)) * np.sqrt(np.diag(covariance))

    def measured(index: int) -> Measured:
        value, part, unit = float(coefficients[index]), float(half[index]), scale ** (index + 1)
        return Measured(value / unit, ((value - part) / unit, (value + part) / unit))

    return LoadPolynomial(
        measured(0),
        measured(1),
        scale,
        float(np.sqrt(np.mean(residual**2))),
        float(np.abs(residual).max()),
    )


@dataclass(frozen=True)
class Calibration:
    """Motions under each normal load and the polynomial through all of them."""

    near: NearPoint
    remote_compliance_um_per_N: float
    motions: tuple[LoadedMotion, ...]
    polynomial: LoadPolynomial


def calibrate(
    study: Study,
    *,
    normal_loads_N: Sequence[float] = (),
    near: NearPoint = "moving-wire",
    remote_compliance_um_per_N: float = 0.0,
    fidelity: str = "standard",
    progress: Callable[[float, str], None] = lambda _share, _text: None,
) -> Calibration:
    """Simulate the motions of `loaded_motions` and fit the polynomial in the load.

    Raises:
        StudyError: a load is not positive, the contact has no friction, or the study has variants to choose from.
        SolverError: the contact does not converge.
    """
    motions = loaded_motions(
        study.alone(),
        normal_loads_N=normal_loads_N,
        near=near,
        remote_compliance_um_per_N=remote_compliance_um_per_N,
        fidelity=fidelity,
        progress=progress,
    )
    return Calibration(near, remote_compliance_um_per_N, motions, fitted_polynomial(motions))


def parse_loads(text: str) -> tuple[float, ...]:
    """``"1, 2, 3"`` as numbers.

    Raises:
        StudyError: a part is no number.
    """
    try:
        return tuple(float(part) for part in text.split(",") if part.strip())
    except ValueError:
        raise StudyError(f"--loads is {text!r}, but must be normal loads in newtons, such as 1,2,3.") from None


def parse_near(text: str) -> NearPoint:
    """The near point of that name.

    Raises:
        StudyError: there is none.
    """
    for point in NEAR_POINTS:
        if text == point:
            return point
    raise StudyError(f"--near is {text!r}, but must be one of {', '.join(NEAR_POINTS)}.")
