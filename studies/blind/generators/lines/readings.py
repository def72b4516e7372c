"""A line contact's run read as a test of one specimen: loops at any cycle and profiles after it."""

from collections.abc import Iterator, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.cases import Case
from studies.blind.generators.files import line_record_tables
from studies.blind.generators.finite_element.changes import instruments_of
from studies.blind.generators.finite_element.readings import channels_of, moments
from studies.blind.generators.line_nominal import LineNominal
from studies.blind.generators.nuisances import SpecimenDraw
from studies.blind.generators.sampling import Channels
from studies.blind.generators.signals import Signals, read_by
from wirewear.effects import Age, Effect, Seam, applied
from wirewear.loops import LoopSignals, Sensor
from wirewear.records.contact_tables import LineRecordTables
from wirewear.results import Loop, RunResult

Array = NDArray[np.float64]

TIMES = 1024  #: Even times of a cycle, before the record's sampling.


def nominal_of(case: Case) -> LineNominal:
    """The nominal test of a case of line contacts."""
    return cast("LineNominal", case.nominal)


def record_tables(case: Case) -> LineRecordTables:
    """The tables of experiment.toml: all from the nominal test and the nuisances."""
    return line_record_tables(nominal_of(case), case.name, case.nuisances.stated_noise)


def dose_of(draw: SpecimenDraw) -> float:
    """How many cycles of the run one cycle of this specimen wears as much as."""
    return draw.friction * draw.load * draw.wear


def profile_at(run: RunResult, body: str, cycle: float) -> tuple[Array, Array]:
    """Places and depths of a body after so many cycles, between logged ones in proportion."""
    own = sorted(run.scars_of(body), key=lambda scar: scar.cycle)
    cycles = np.array([scar.cycle for scar in own], dtype=float)
    after = int(np.clip(np.searchsorted(cycles, cycle), 1, len(own) - 1))
    share = float(np.clip((cycle - cycles[after - 1]) / (cycles[after] - cycles[after - 1]), 0.0, 1.2))
    depth = (1.0 - share) * own[after - 1].depth_um + share * own[after].depth_um
    return own[after].axial_um, depth[:, 0]


def read_test(
    run: RunResult, changes: Sequence[Effect[Any]], case: Case, draw: SpecimenDraw, cycles: Sequence[int]
) -> Iterator[tuple[int, Channels]]:
    """Noise-free readings of one specimen at cycles, at even times of the rig's waveform."""
    nominal = nominal_of(case)
    shape = case.nuisances.waveform.shape()
    loops = [(loop.cycle, _at_even_times(loop, shape)) for loop in run.of_length(nominal.length_mm).loops]
    known = np.array([cycle for cycle, _ in loops], dtype=float)
    time_s = np.arange(TIMES) / (TIMES * nominal.frequency_Hz)
    strength, load = draw.friction * draw.load, draw.load
    instruments = instruments_of(case.effects, case.nominal)
    for cycle in cycles:
        worn_as = max(cycle * dose_of(draw), known[0])
        after = int(np.clip(np.searchsorted(known, worn_as), 1, len(loops) - 1))
        share = float(np.clip(np.log(worn_as / known[after - 1]) / np.log(known[after] / known[after - 1]), 0.0, 1.0))
        x, q, p = (
            (1.0 - share) * one + share * other for one, other in zip(loops[after - 1][1], loops[after][1], strict=True)
        )
        sensor = applied(changes, Seam.SENSOR, Sensor(), Age(float(cycle), 0.0))
        true = read_by(instruments, Signals(time_s, 1.0 / nominal.frequency_Hz, x, strength * q, load * p), cycle)
        read = sensor.read(
            LoopSignals(time_s, true.displacement_um, true.tangential_force_N, true.normal_force_N, true.period_s)
        )
        force = read.tangential_force_N + draw.force_zero_N
        normal = load * p if read.normal_force_N is None else read.normal_force_N
        yield cycle, (read.displacement_um + draw.displacement_zero_um, force, normal)


def _at_even_times(loop: Loop, shape: Array) -> Channels:
    """Displacement, tangential and normal force at the times of another waveform."""
    passed = moments(loop, shape)
    even = np.arange(TIMES) / TIMES
    first, second, third = (np.interp(even, passed, channel, period=1.0) for channel in channels_of(loop))
    return first, second, third
