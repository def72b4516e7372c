"""How much more or less than the nominal model a study's effects let the wires wear: what meshes must hold."""

from __future__ import annotations

from math import pi

import numpy as np

from solvers import WearRates
from wirewear.effects import Age, ContactLaw, Loading, Seam, Specimens, applied
from wirewear.study import Study

_AGES = 200


def wear_factors(study: Study) -> tuple[float, float]:
    """Mean and largest factor of all effects on the wear per cycle in gross slip, over the cycles of the test."""
    nominal = study.contact.friction * study.conditions.normal_load_N
    if not study.effects or nominal == 0.0:
        return 1.0, 1.0
    factors = [_work(study, cycles) / nominal for cycles in np.linspace(0.0, study.conditions.cycles, _AGES)]
    return float(np.mean(factors)), max(factors)


def _work(study: Study, cycles: float) -> float:
    """Friction force times the factor on the wear coefficient at a cycle, N; by Archard's law likewise."""
    age = Age(cycles, 0.0)
    friction = applied(study.effects, Seam.CONTACT, ContactLaw(study.contact.friction), age).friction
    load = applied(study.effects, Seam.LOADING, Loading(study.conditions.normal_load_N), age).normal_load_N
    return friction * load * applied(study.effects, Seam.WEAR, WearRates(1.0, 1.0), age).upper_mm3_per_mJ


def flattened_volume(study: Study) -> float:
    """Volume in mm³ on which the unworn wires overlap when they are flattened by an effect, crossed at right angles."""
    angle = study.wires.crossing_angle_deg
    depth = applied(study.effects, Seam.SPECIMENS, Specimens(angle), Age.new()).flattening_mm
    radii = study.moving_wire.diameter_mm / 2.0, study.fixed_wire.diameter_mm / 2.0
    return pi * float(np.sqrt(radii[0] * radii[1])) * depth**2
