"""What the sensors of a study, as its effects make them, read of a simulated loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from wirewear.base.errors import StudyError
from wirewear.base.quantity import as_sentence
from wirewear.effects import Age, Seam, applied, effects_of_tables
from wirewear.loops.sensor import Sensor
from wirewear.loops.signals import LoopSignals
from wirewear.results.values import Loop, RunResult

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
    truth = LoopSignals(loop.time_s, loop.displacement_um, loop.tangential_force_N, loop.normal_force_N, period_s)
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


def read_loops(result: RunResult) -> tuple[Loop, ...]:
    """The result's loops as the sensors of its study read them, without noise."""
    if not result.study.get("effects"):
        return result.loops
    sensors = [sensor_of(result.study, age=age_at(result, loop.cycle)) for loop in result.loops]
    period_s = 1.0 / float(result.study["conditions"]["frequency_Hz"])
    return tuple(
        loop if sensor == _IDEAL else read_loop(loop, sensor, period_s)
        for loop, sensor in zip(result.loops, sensors, strict=True)
    )
