"""What the sensors of a study, as its effects make them, read of a simulated loop."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from wirewear.base.errors import StudyError
from wirewear.base.quantity import as_sentence
from wirewear.effects import Age, Seam, applied, effects_of_tables
from wirewear.loops import LoopSignals, Sensor
from wirewear.results.values import Loop, RunResult, longer

_IDEAL = Sensor()
_NEW = Age.new()


def sensor_of(study: Mapping[str, Any], sensor: Sensor = _IDEAL, age: Age = _NEW) -> Sensor:
    """A sensor with the effects of a resolved study, such as results hold, added to its own errors at an age.

    Raises:
        StudyError: the study has an effect that is not installed here.
    """
    try:
        effects = effects_of_tables(study.get("effects", []))
    except ValueError as problem:
        raise StudyError(as_sentence(f"effects of the study {study.get('name', '')!r} {problem}")) from None
    return applied(effects, Seam.SENSOR, sensor, age)


def age_at(result: RunResult, cycle: int) -> Age:
    """How far a test had come when it logged a cycle."""
    cycles, energy_J = result.evolution["cycle"], result.evolution["accumulated_energy_J"]
    return Age(float(cycle), float(np.interp(cycle, cycles, energy_J)) if cycles.size else 0.0)


def read_loop(loop: Loop, sensor: Sensor, period_s: float) -> Loop:
    """A loop with displacements and forces as a sensor reads them; its friction work stays the true one.

    The displacement relative to the fixed wire's holder is that read, less the holder's true one.
    """
    known = None if np.isnan(loop.normal_force_N).any() else loop.normal_force_N
    truth = LoopSignals(loop.time_s, loop.displacement_um, loop.tangential_force_N, known, period_s)
    read = sensor.read(truth)
    holder_um = loop.displacement_um - loop.relative_displacement_um
    normal = loop.normal_force_N if read.normal_force_N is None else read.normal_force_N
    return replace(
        loop,
        displacement_um=read.displacement_um,
        relative_displacement_um=read.displacement_um - holder_um,
        tangential_force_N=read.tangential_force_N,
        normal_force_N=normal,
    )


def read_loops(result: RunResult, sensor: Sensor = _IDEAL) -> tuple[Loop, ...]:
    """The result's loops as a sensor with the effects of its study reads them, without noise.

    Studies of line contacts state effects as they are of one millimetre.
    """
    if result.length_mm not in (None, 1.0):
        return tuple(longer(loop, result.length_mm) for loop in read_loops(result.of_length(1.0), sensor))
    if not result.study.get("effects") and sensor == _IDEAL:
        return result.loops
    sensors = [sensor_of(result.study, sensor, age_at(result, loop.cycle)) for loop in result.loops]
    period_s = 1.0 / float(result.study["conditions"]["frequency_Hz"])
    return tuple(
        loop if own == _IDEAL else read_loop(loop, own, period_s)
        for loop, own in zip(result.loops, sensors, strict=True)
    )
