"""The full simulation with the leading effects in it, and the shrink that it achieves."""

from __future__ import annotations

from dataclasses import replace
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.shrink import achieved
from wirewear.diagnosis.model.forward import Course, simulate
from wirewear.diagnosis.model.nominal import ObserverOf
from wirewear.diagnosis.report.values import Confirmed
from wirewear.effects import Age, Seam, applied
from wirewear.results import RunResult, read_loops
from wirewear.sensor import Sensor

if TYPE_CHECKING:
    from wirewear.diagnosis.model.setup import Array
    from wirewear.diagnosis.report.diagnosed import Diagnosed
    from wirewear.study import Study

_KNOWN = constants("confirmation")

#: Increments of a loop that is compared with a measured one, and points that it is interpolated to.
_INCREMENTS, _POINTS = _KNOWN.count("increments"), _KNOWN.count("points")


def confirmed(diagnosed: Diagnosed, *, observer_of: ObserverOf | None = None) -> Diagnosed:
    """The diagnosis with what the full simulation with the leading effects achieves; unchanged without any.

    Raises:
        StudyError, SolverError: the simulation with the effects cannot be run.
    """
    best = diagnosed.search.best
    if diagnosed.diagnosis.verdict == "no_gap" or not best.candidates:
        return diagnosed
    shrink = diagnosed.diagnosis.shrink
    with TemporaryDirectory(prefix="wirewear-confirm-") as folder:
        from pathlib import Path

        from wirewear.simulation import run_study

        kwargs: dict[str, Any] = {} if observer_of is None else {"observer_of": observer_of}
        result = run_study(_with_effects(diagnosed), fidelity="quick", output=Path(folder), **kwargs)[0]
    share, after = achieved(
        diagnosed.search.problem,
        diagnosed.search.covariance,
        diagnosed.observed,
        shrink,
        lambda cycles: course_of_run(result, cycles),
    )
    diagnosis = replace(diagnosed.diagnosis, confirmed=Confirmed(share, after, best.names))
    return replace(diagnosed, diagnosis=diagnosis)


def _with_effects(diagnosed: Diagnosed) -> Study:
    """The nominal study with the leading effects, logged at the record's cycles."""
    effects = [candidate.effect(coordinates) for candidate, coordinates, _ in diagnosed.search.best.parts()]
    study = diagnosed.study.with_effects(*diagnosed.study.effects, *effects)
    logged = sorted({loop.cycle for loop in diagnosed.observed.loops if loop.cycle <= study.conditions.cycles})
    increments = study.fidelity("quick").increments_per_cycle or _INCREMENTS
    amplitude_um = _true_amplitude_um(diagnosed, np.array(logged, dtype=float))
    return study.changed(
        {
            "log": {"loop_cycles": tuple(logged)},
            "fidelity": {"quick": {"increments_per_cycle": increments}},
            "conditions": {"displacement_amplitude_um": amplitude_um},
        }
    )


def _true_amplitude_um(diagnosed: Diagnosed, cycles: Array) -> float:
    """The true stroke's half, by the fast model: a drive that follows a wrong sensor misses what was asked."""
    setup = diagnosed.search.best.setup
    if setup.drive == "stroke" or not any(effect.seam is Seam.SENSOR for effect in setup.effects):
        return setup.amplitude_um
    read = simulate(diagnosed.states, setup, cycles)
    tip = read.tangential_force_N[:, 0, -1]
    sensor = applied(setup.effects, Seam.SENSOR, Sensor(), Age.new())
    return float(np.mean((setup.amplitude_um - sensor.linear_um_per_N * tip) / sensor.displacement_gain))


def course_of_run(result: RunResult, cycles: Array) -> Course:
    """Loops of a full simulation as the fast model gives them: two branches each, as sensors read them."""
    loops = {loop.cycle: loop for loop in read_loops(result)}
    x, q, p = (np.empty((cycles.size, 2, _POINTS)) for _ in range(3))
    for row, cycle in enumerate(cycles):
        loop = loops[min(loops, key=lambda known: abs(np.log(max(known, 1) / max(cycle, 1.0))))]
        place = loop.displacement_um - 0.5 * (loop.displacement_um.max() + loop.displacement_um.min())
        n, top, low = place.size, int(np.argmax(place)), int(np.argmin(place))
        for side, (start, end) in enumerate(((low, top), (top, low))):
            steps = (end - start) % n
            at = start + np.linspace(0.0, steps, _POINTS)
            for channel, values in ((x, place), (q, loop.tangential_force_N), (p, loop.normal_force_N)):
                channel[row, side] = np.interp(at, np.arange(2 * n), np.concatenate([values, values]))
    nothing = np.full(cycles.size, np.nan)
    return Course(cycles, x, q, p, nothing, nothing, nothing, np.ones((2, 4)), float("nan"))
