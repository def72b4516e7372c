"""Calibration of a displacement sensor by loading a stuck contact, and correction of records with it.

The remote point is where the sensor measures; the near point is where the displacement at the contact is defined.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from scipy.special import stdtrit

from geometry.arrays import Array
from solvers import ContactProblem, ContactState, PlacedBody, advance, press, unloaded_state
from wirewear.base.errors import RecordError, SensorError, StudyError
from wirewear.loops import Measured, Sensor
from wirewear.records import ExperimentRecord, MeasuredEvolution
from wirewear.records.tables import Noise
from wirewear.simulation import contact_problem, discretise, require_affordable_wires
from wirewear.test import Study
from wirewear.test.any_study import alone

#: Where the near displacement is taken: the moving wire at the contact, against ground or against the fixed wire at
#: the contact; or the moving wire's holder against the fixed wire's.
NearPoint = Literal["moving-wire", "between-wires", "between-holders"]
NEAR_POINTS: tuple[NearPoint, ...] = get_args(NearPoint)

USUAL_LOADS = (0.5, 1.0, 1.5)  #: Loads for which the default is taken, in shares of the study's own.
SHARES = (0.25, 0.5, 0.75, 1.0)  #: Tangential forces, in shares of friction times normal load.
_STICKING = 20.0  # So much that nothing slips, but for nodes at the very edge.

FEWEST_MOTIONS = 4


@dataclass(frozen=True, eq=False)
class LoadedMotion:
    """Displacements in µm of the remote and the near point under one normal load and tangential forces, each (n,)."""

    normal_load_N: float
    tangential_force_N: Array
    remote_um: Array
    near_um: Array


def _stuck(study: Study, largest_load_N: float, fidelity: str, announce: Callable[[str], None]) -> ContactProblem:
    """Contact problem of the study's fresh wires without slip, on a patch for the contact under the largest load."""
    # Travel for which the patch has room; stuck wires move by less against each other.
    conditions = {"normal_load_N": largest_load_N, "displacement_amplitude_um": 2.0, "approach_um": None}
    still = study.changed({"conditions": conditions, "wear": None})
    meshes = discretise(still, fidelity)
    require_affordable_wires(still, fidelity, meshes)
    return replace(contact_problem(still, meshes, announce), friction=_STICKING)


def _loaded(
    problem: ContactProblem, load_N: float, largest_N: float, near: NearPoint, remote_mm_per_N: float
) -> LoadedMotion:
    problem = replace(problem, holder=replace(problem.holder, normal_load_N=load_N))
    pressed, _ = press(problem, unloaded_state(problem))
    base = _near(problem, pressed, near)
    rows: list[tuple[float, float, float]] = []
    for direction in (1.0, -1.0):
        drive = direction * 1e-5
        state, reports = advance(problem, pressed, drive, 0.0)
        for share in SHARES:
            # The stuck contact is linear but for the nodes at its edge.
            drive *= share * largest_N / abs(reports[-1].tangential_force)
            state, reports = advance(problem, state, drive, 0.0)
            force = reports[-1].tangential_force
            rows.append((force, drive + remote_mm_per_N * force, _near(problem, state, near) - base))
    force_N, remote_mm, near_mm = np.array(sorted(rows)).T
    return LoadedMotion(load_N, force_N, 1e3 * remote_mm, 1e3 * near_mm)


def _near(problem: ContactProblem, state: ContactState, near: NearPoint) -> float:
    """Displacement of the near point along x in mm."""
    if near == "between-holders":
        return state.drive - state.holder_x
    upper_force, lower_force = (
        (state.primary_force, state.secondary_force)
        if problem.primary_is_upper
        else (state.secondary_force, state.primary_force)
    )
    moving = state.drive + _surface_motion(problem.lower, -lower_force)
    if near == "moving-wire":
        return moving
    return moving - (state.holder_x + _surface_motion(problem.upper, upper_force))


def _surface_motion(body: PlacedBody, force: Array) -> float:
    """Elastic displacement of a body's surface along x in mm, averaged over the pressure, under nodal forces (n, 3)."""
    loaded = np.flatnonzero(force.any(axis=1))
    columns = (3 * loaded[:, None] + np.arange(3)).ravel()
    displacement = body.compliance[np.ix_(3 * loaded, columns)] @ force[loaded].ravel()
    weights = np.abs(force[loaded, 2])
    return float(weights @ displacement / weights.sum())


@dataclass(frozen=True)
class LoadPolynomial:
    """The displacement of the remote point less that of the near one, in µm, as linear · Q + quadratic · Q² with the
    tangential force Q in N; coefficients with 95 % intervals.
    """

    linear_um_per_N: Measured
    quadratic_um_per_N2: Measured
    largest_force_N: float  #: Largest |Q| of the fit.
    residual_rms_um: float  #: Root mean square of the fit's residuals.
    residual_largest_um: float  #: Largest absolute residual.

    @property
    def sensor(self) -> Sensor:
        """The sensor that reads the remote point, with the near point's displacement as the true one."""
        return Sensor(linear_um_per_N=self.linear_um_per_N.value, quadratic_um_per_N2=self.quadratic_um_per_N2.value)


def fitted_polynomial(motions: Sequence[LoadedMotion]) -> LoadPolynomial:
    """Remote less near displacement as a polynomial of the tangential force, linear and quadratic, fitted to motions
    under all normal loads by least squares (Infante-García et al. 2020, section 2.1).

    The effect of the normal load on the compliance is part of the residual, and so of the intervals (Student's t).
    Raises SensorError for fewer than four tangential forces.
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
        measured(0), measured(1), scale, float(np.sqrt(np.mean(residual**2))), float(np.abs(residual).max())
    )


@dataclass(frozen=True)
class Calibration:
    """Result of a calibration: motions under each normal load, and the polynomial fitted to all of them."""

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
    """Calibrate a remote displacement sensor by simulating the study's fresh wires, stuck, under tangential forces up
    to ±µP.

    The remote point is the back of the moving wire, where its holder grips it, behind a compliance of
    `remote_compliance_um_per_N` between the sensor's point and that holder. As nothing slips, the result is the
    compliance between the points.

    normal_loads_N: positive; by default 0.5, 1 and 1.5 times the study's.  near: where the near displacement is taken.
    remote_compliance_um_per_N: as the rig's owner states it.
    fidelity: of the mesh, which covers only the contact itself.
    progress: called with the share done and what is being done.
    Raises StudyError if the study has variants to choose from, a load is not positive, the contact has no friction, or
    its mesh takes more memory than there is; SolverError if the contact does not converge.
    """
    study = alone(study)
    loads = sorted(normal_loads_N or [share * study.conditions.normal_load_N for share in USUAL_LOADS])
    if (wrong := next((load for load in loads if not 0.0 < load < np.inf), None)) is not None:
        raise StudyError(f"the normal loads of a calibration must be positive, finite numbers, not {wrong:g} N.")
    if study.contact.friction == 0.0:
        raise StudyError("a contact without friction carries no tangential force to calibrate with.")
    problem = _stuck(study, loads[-1], fidelity, lambda text: progress(0.0, text))
    motions = []
    for number, load in enumerate(loads):
        progress(number / len(loads), f"loading tangentially under {load:g} N")
        motions.append(_loaded(problem, load, study.contact.friction * load, near, 1e-3 * remote_compliance_um_per_N))
    return Calibration(near, remote_compliance_um_per_N, tuple(motions), fitted_polynomial(motions))


def parse_loads(text: str) -> tuple[float, ...]:
    """Numbers in a text such as "1, 2, 3"; none for "". Raises StudyError if a part is not a number."""
    try:
        return tuple(float(part) for part in text.split(",") if part.strip())
    except ValueError:
        raise StudyError(f"--loads is {text!r}, but must be normal loads in newtons, such as 1,2,3.") from None


def parse_near(text: str) -> NearPoint:
    """The near point with this name. Raises StudyError if there is none."""
    for point in NEAR_POINTS:
        if text == point:
            return point
    raise StudyError(f"--near is {text!r}, but must be one of {', '.join(NEAR_POINTS)}.")


def slope(motion: LoadedMotion) -> float:
    """Least-squares slope through zero of remote less near displacement over tangential force, in µm/N, under one
    normal load.
    """
    force, difference = motion.tangential_force_N, motion.remote_um - motion.near_um
    return float(force @ difference / (force @ force))


@dataclass(frozen=True)
class Correction:
    """Corrected record, and the size and error of the correction."""

    record: ExperimentRecord  #: Record with displacements at the near point.
    largest_um: float  #: Largest change of a sample.
    largest_force_N: float  #: The largest |Q| of its loops.
    error_um: float  #: The polynomial's own error at that force, half of a 95 % interval.
    #: Standard deviation that the force's noise adds to each displacement, or None where it is not stated.
    noise_um: float | None
    notes: tuple[str, ...]  #: Sentences on the limits of the correction.


def corrected_record(record: ExperimentRecord, polynomial: LoadPolynomial) -> Correction:
    """A record corrected to the near point: linear · Q + quadratic · Q² is subtracted from every displacement.

    Amplitudes of the evolution and the asked amplitude are lowered by linear · Q at the tips, as the quadratic part
    moves both tips alike. Slip amplitudes, energies and scars stay (Q = 0, and ∮Q df(Q) = 0), as do missing samples.
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
    """Median over the loops of half the force difference between both ends of the stroke, in N."""
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
