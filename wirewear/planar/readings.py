"""What the sensors of a study, as its effects make them, read of a line contact's loops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wirewear.effects import Age
from wirewear.loops.sensor import Sensor
from wirewear.loops.signals import LoopSignals
from wirewear.planar.results import PlanarLoop, PlanarResult
from wirewear.results import sensor_of


def read_planar_loops(result: PlanarResult, sensor: Sensor | None = None) -> tuple[PlanarLoop, ...]:
    """The result's loops as its sensors read them, without noise; forces per mm of thickness."""
    own = sensor or Sensor()
    if not result.study.get("effects") and own == Sensor():
        return result.loops
    period_s = 1.0 / float(result.study["conditions"]["frequency_Hz"])
    return tuple(_read(loop, sensor_of(result.study, own, _age(result, loop.cycle)), period_s) for loop in result.loops)


def _age(result: PlanarResult, cycle: int) -> Age:
    cycles, energy_J = result.evolution["cycle"], result.evolution["accumulated_energy_J_per_mm"]
    return Age(float(cycle), float(np.interp(cycle, cycles, energy_J)) if cycles.size else 0.0)


def _read(loop: PlanarLoop, sensor: Sensor, period_s: float) -> PlanarLoop:
    normal = None if np.isnan(loop.normal_force_N_per_mm).any() else loop.normal_force_N_per_mm
    truth = LoopSignals(loop.time_s, loop.displacement_um, loop.tangential_force_N_per_mm, normal, period_s)
    read = sensor.read(truth)
    holder_um = loop.displacement_um - loop.relative_displacement_um
    return replace(
        loop,
        displacement_um=read.displacement_um,
        relative_displacement_um=read.displacement_um - holder_um,
        tangential_force_N_per_mm=read.tangential_force_N,
        normal_force_N_per_mm=loop.normal_force_N_per_mm if read.normal_force_N is None else read.normal_force_N,
    )
