"""Cases of the generator by finite elements."""

from dataclasses import replace

import numpy as np

from studies.blind import generator_of
from studies.blind.generators.cases import Case, planned_cases
from studies.blind.generators.nuisances import Nuisances
from studies.blind.generators.waveform import Waveform
from wirewear.results import Loop

GENERATOR = generator_of("T1")


def a_case(place: int = 0, number: int = 60, seed: int = 4) -> Case:
    return planned_cases(number, seed, GENERATOR.library, GENERATOR.outside)[place]


def a_loop(cycle: int = 100, increments: int = 40, height_N: float = 1.2) -> Loop:
    """A trapezoid of 60 µm, sticking over the first 10 µm after each reversal, and a load that follows the place."""
    phase = 2.0 * np.pi * np.arange(increments) / increments
    place, rising = 60.0 * np.sin(phase), np.cos(phase) >= 0.0
    stuck = np.clip(np.where(rising, place + 60.0, 60.0 - place) / 5.0 - 1.0, -1.0, 1.0)
    force = height_N * np.where(rising, stuck, -stuck)
    normal = 2.0 + 1e-3 * place
    return Loop(cycle, phase / (6.0 * np.pi), place, place, force, normal, np.zeros(increments))


def plain_nuisances() -> Nuisances:
    return replace(a_case().nuisances, waveform=Waveform())
