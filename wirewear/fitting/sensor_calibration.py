"""A calibration from end to end, and the options of its command."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from wirewear.base.errors import StudyError
from wirewear.fitting.sensor_loading import NEAR_POINTS, LoadedMotion, NearPoint, loaded_motions
from wirewear.fitting.sensor_polynomial import LoadPolynomial, fitted_polynomial
from wirewear.study import Study


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
