"""After a diagnosis: the full simulation with the leading effects in it, or one effect fitted to some cycles alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.base.words import counted
from wirewear.base.writing import temporary_folder
from wirewear.diagnosis.answer import Confirmed, Estimate, estimates
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.inference import fit
from wirewear.diagnosis.infer.shrink import achieved
from wirewear.diagnosis.surrogate.forward import PredictedLoops, simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.nominal import ObserverOf
from wirewear.diagnosis.surrogate.nominal_model import JointModel, LineModel, PointModel, nominal_model
from wirewear.effects import Age, Seam, applied
from wirewear.loops.branches import lean_of
from wirewear.loops.sensor import Sensor
from wirewear.results import read_loops
from wirewear.test.conditions import held_keys

if TYPE_CHECKING:
    from wirewear.diagnosis.record_diagnosis import Diagnosed
    from wirewear.results import Loop

_KNOWN = constants("confirmation")

#: Increments of a loop that is compared with a measured one, and points that it is interpolated to.
_INCREMENTS, _POINTS = _KNOWN.count("increments"), _KNOWN.count("points")

#: Said of wires whose gap, on what was left out of the fit, shows in scars alone.
SCARS_ALONE = "the gap shows in scars alone, and --confirm compares loops: the full simulation was not asked"

#: Said of joints.
NO_BODIES = "a joint states no bodies: there is no full simulation that could confirm the answer"


def confirmed(diagnosed: Diagnosed, *, observer_of: ObserverOf | None = None) -> Diagnosed:
    """The diagnosis with the shrink that the full simulation with the leading effects achieves; unchanged if there are
    none.

    Loops are compared, and profiles of line contacts. If the gap of wires shows in scars alone, or there are no bodies
    to simulate, a note says so. observer_of: makes the observer of a run from its name. Raises StudyError or
    SolverError if the simulation with the effects cannot be run.
    """
    best = diagnosed.search.best
    if diagnosed.diagnosis.verdict == "no_gap" or not best.candidates:
        return diagnosed
    shrink, nominal = diagnosed.diagnosis.shrink, nominal_model(diagnosed.study)
    if isinstance(nominal, JointModel):
        return _noted(diagnosed, NO_BODIES)
    if shrink.scar_held_out and not nominal.predicts_scars:
        return _noted(diagnosed, SCARS_ALONE)
    share, after = achieved(
        diagnosed.search.problem,
        diagnosed.search.covariance,
        diagnosed.observed,
        shrink,
        _simulated(diagnosed, nominal, observer_of),
    )
    diagnosis = replace(diagnosed.diagnosis, confirmed=Confirmed(share, after, best.names))
    return replace(diagnosed, diagnosis=diagnosis)


def _noted(diagnosed: Diagnosed, note: str) -> Diagnosed:
    diagnosis = diagnosed.diagnosis
    return replace(diagnosed, diagnosis=replace(diagnosis, notes=(*diagnosis.notes, note)))


def _simulated(
    diagnosed: Diagnosed, nominal: PointModel | LineModel, observer_of: ObserverOf | None
) -> Callable[[Array], PredictedLoops]:
    """Loops that a run of the study with the leading effects leaves, and profiles where these are predicted."""
    from wirewear.simulation import Observer, run_study

    last = diagnosed.study.conditions.cycles
    logged = sorted({loop.cycle for loop in diagnosed.observed.loops if loop.cycle <= last})
    amplitude_um = _true_amplitude_um(diagnosed, np.array(logged or [last], dtype=float))
    leading = [candidate.effect(coordinates) for candidate, coordinates, _ in diagnosed.search.best.parts()]
    study = nominal.with_effects(leading, amplitude_um, _INCREMENTS).logging(tuple(sorted({*logged, last})))
    quiet = observer_of or (lambda _: nullcontext(Observer()))
    with temporary_folder("wirewear-confirm-") as folder:
        (result,) = run_study(study, fidelity="quick", output=folder, observer_of=quiet)
    ends = [result.scar(last, body) for body in result.bodies] if nominal.predicts_scars else []
    profiles = {own.body: (own.axial_um, own.depth_um[:, 0]) for own in ends}
    return lambda cycles: as_predicted(read_loops(result), cycles, profiles)


def _true_amplitude_um(diagnosed: Diagnosed, cycles: Array) -> float:
    """The true stroke's half, by the fast model: a drive that follows a wrong sensor misses what was asked."""
    setup, asked = diagnosed.search.best.setup, diagnosed.study.conditions
    if held_keys(asked):
        return float(asked.displacement_amplitude_um)  # the run finds its own
    if setup.drive == "stroke" or not any(effect.seam is Seam.SENSOR for effect in setup.effects):
        return setup.amplitude_um
    read = simulate(diagnosed.states, setup, cycles)
    tip = read.tangential_force_N[:, 0, -1]
    sensor = applied(setup.effects, Seam.SENSOR, Sensor(), Age.new())
    outermost = np.full_like(tip, setup.amplitude_um)
    if sensor.linear_um_per_N < 0.0:
        # Where the reading leans against the force it is outermost at the knee, not where the drive turns.
        x = read.displacement_um
        outermost -= 0.5 * (x.max(axis=(1, 2)) - x.min(axis=(1, 2)) - x[:, 0, -1] + x[:, 1, -1])
    return float(np.mean((outermost - sensor.linear_um_per_N * tip) / sensor.displacement_gain))


def as_predicted(
    read: Sequence[Loop], cycles: Array, profiles: Mapping[str, tuple[Array, Array]] | None = None
) -> PredictedLoops:
    """Loops of a full simulation in the form of the fast model: two branches for each of `cycles` (n,), from the
    nearest logged loop. profiles: positions and depths in µm by body; none by default. Slip, energy, volume and skew
    are NaN, scars 1.
    """
    loops = {loop.cycle: loop for loop in read}
    x, q, p = (np.empty((cycles.size, 2, _POINTS)) for _ in range(3))
    for row, cycle in enumerate(cycles):
        loop = loops[min(loops, key=lambda known: abs(np.log(max(known, 1) / max(cycle, 1.0))))]
        place = loop.displacement_um - 0.5 * (loop.displacement_um.max() + loop.displacement_um.min())
        drive = place + lean_of(place, loop.tangential_force_N) * loop.tangential_force_N
        n, top, low = place.size, int(np.argmax(drive)), int(np.argmin(drive))
        for side, (start, end) in enumerate(((low, top), (top, low))):
            steps = (end - start) % n
            at = start + np.linspace(0.0, steps, _POINTS)
            for channel, values in ((x, place), (q, loop.tangential_force_N), (p, loop.normal_force_N)):
                channel[row, side] = np.interp(at, np.arange(2 * n), np.concatenate([values, values]))
    nothing = np.full(cycles.size, np.nan)
    return PredictedLoops(
        cycles, x, q, p, nothing, nothing, nothing, np.ones((2, 4)), np.full(2, np.nan), profiles or {}
    )


def calibrated(
    diagnosed: Diagnosed, effect: str, cycles: Sequence[int]
) -> tuple[Mapping[str, Estimate], SurrogateInputs]:
    """Parameters by name of an effect fitted to the loops of these cycles alone, and the nominal inputs with that
    effect. Raises RecordError if the effect was not considered, or the record has no loops of these cycles.
    """
    found = diagnosed.search
    alone = next((one for one in found.singles if one.names == (effect,)), None)
    keep = np.isin(found.problem.layout.cycle, list(cycles))
    if alone is None or not keep.any():
        raise RecordError(
            f"{effect} cannot be calibrated on the cycles {', '.join(map(counted, cycles))} of the record "
            f"{diagnosed.record.name!r}: name an effect of the library and cycles that have loops."
        )
    known = fit(found.problem.part(keep, found.covariance), alone.candidates)
    ((candidate, coordinates, deviations),) = known.parts()
    return estimates(candidate, coordinates, deviations, max(found.remainder.misfit, 1.0)), known.setup
