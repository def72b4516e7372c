"""Records made by the fast forward model itself, on wear states that follow simple formulas.

The states look like those of the steel wires (slopes of a scar grow with its length, friction is constant).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.signal import lfilter

from geometry.arrays import Array
from wirewear.diagnosis.infer.search import search
from wirewear.diagnosis.observe.channels import half_width, loop_area
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.record_diagnosis import Diagnosed, judged
from wirewear.diagnosis.surrogate.forward import PredictedLoops, simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.nominal import nominal_study
from wirewear.diagnosis.surrogate.nominal_model import nominal_inputs
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.effects import effect_named
from wirewear.records import AnyRecord, ExperimentRecord, MeasuredEvolution, MeasuredLoop, RecordTables

CYCLES = (100, 1000, 10_000, 100_000)
EVOLUTION_CYCLES = (20, 50, 300, 3000, 30_000)
NOISE_um, NOISE_N = 0.15, 0.008
STATED = {
    "friction": 0.62,
    "energy_wear_coefficient_mm3_per_J": 3.0e-5,
    "tangential_stiffness_N_per_mm": 167.0,
    "normal_spring_stiffness_N_per_mm": 1.0,
}


def autoregressive(count: int, correlation: float, random: np.random.Generator) -> Array:
    """AR(1) noise of deviation 1 from its first sample on."""
    white = random.standard_normal(count)
    white[1:] *= np.sqrt(1.0 - correlation**2)
    return np.asarray(lfilter([1.0], [1.0, -correlation], white))


def states() -> WearStates:
    """Wear states whose slope at the scar's ends is 0.06 V^(1/3)… in closed form, rising to 0.2."""
    radius, slip = 225.0, 52.0
    volume = np.concatenate([[0.0], np.geomspace(20.0, 1.3e6, 12)])
    similarity = volume * radius / slip**4
    slope = 0.06 * (similarity[:, None] / 4.0) ** 0.35 * np.array([0.6, 0.5, 0.3, 0.2, 0.1])
    # Bowls of length L and depth V/(c L²): enough for scars to follow the volume.
    length = 2.0 * (slip + 0.9 * volume**0.35)
    width = 24.0 + 1.7 * volume**0.35
    depth = 2.5 * volume / (length * width)
    wire = np.stack([0.5 * volume, 0.5 * depth, length, width], axis=1)
    return WearStates(
        radius_um=radius, friction=0.62, normal_load_N=2.0, fresh_area_um2=640.0, volume_um3=volume,
        slip_um=np.full(13, slip), similarity=similarity, slope=slope, angle=np.zeros((13, 2)),
        stiffness_N_per_um=2.4 + 0.02 * volume**0.35, load_drop_N=5e-8 * volume, lift_N=np.zeros((13, 2)),
        scars=np.stack([wire, wire], axis=1),
    )  # fmt: skip


def tables(drive: str = "sensor", **stated: float | str) -> RecordTables:
    """experiment.toml of the steel wires."""
    return RecordTables.model_validate(
        {
            "format": 1,
            "name": "made by the fast model",
            "wires": {"diameter_mm": 0.45, "youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3},
            "conditions": {
                "normal_load_N": 2.0,
                "displacement_amplitude_um": 60.0,
                "frequency_Hz": 3.0,
                "cycles": CYCLES[-1],
                "drive": drive,
            },
            "stated": {**STATED, **stated},
            "files": {"loops": "loops.csv"},
        }
    )


def nominal(drive: str = "stroke") -> SurrogateInputs:
    """The model of that record without any effect."""
    stated = tables(drive)
    return nominal_inputs(nominal_study(ExperimentRecord(stated, ())), stated.conditions.drive)


def with_effect(setup: SurrogateInputs, name: str, values: Mapping[str, float]) -> SurrogateInputs:
    """The setup with an effect of the library."""
    return setup.with_effect(effect_named(name)(**values))


def record(
    effects: Mapping[str, Mapping[str, float]] | None = None,
    *,
    repeats: int = 3,
    seed: int = 1,
    samples: int = 200,
    drive: str = "sensor",
    scatter: float = 1.0,
    evolution: bool = True,
    normal: bool = True,
    cycles: tuple[int, ...] = CYCLES,
    stiffness_N_per_mm: float | str = 167.0,
) -> ExperimentRecord:
    """A record of that many repeats with scattered friction and wear, and noisy samples."""
    random = np.random.default_rng(seed)
    stated = tables(drive, tangential_stiffness_N_per_mm=stiffness_N_per_mm)
    base = nominal_inputs(nominal_study(ExperimentRecord(stated, ())), stated.conditions.drive)
    for name, values in (effects or {}).items():
        base = with_effect(base, name, values)
    loops, rows = [], []
    at = np.array(sorted({*cycles, *EVOLUTION_CYCLES}), dtype=float)
    for repeat in range(1, repeats + 1):
        friction, wear, zero = scatter * random.standard_normal(3) * (0.01, 0.04, 0.1)
        setup = replace(base, friction_factor=1 + friction, wear_factor=1 + wear, displacement_offset_um=zero)
        course = simulate(states(), setup, at)
        loops += [
            _loop(course, int(np.searchsorted(at, cycle)), repeat, cycle, samples, random, normal=normal)
            for cycle in cycles
        ]
        rows.append(_evolution(course, repeat))
    return ExperimentRecord(stated, tuple(loops), tuple(rows) if evolution else ())


def _loop(
    course: PredictedLoops,
    row: int,
    repeat: int,
    cycle: int,
    samples: int,
    random: np.random.Generator,
    *,
    normal: bool,
) -> MeasuredLoop:
    phase = 2.0 * np.pi * (np.arange(samples) + random.random()) / samples
    x, q, p = course.displacement_um[row], course.tangential_force_N[row], course.normal_force_N[row]
    top, low = float(x.max()), float(x.min())
    place = 0.5 * (top + low) + 0.5 * (top - low) * np.sin(phase)
    forward = np.cos(phase) > 0.0
    rising, falling = (np.maximum.accumulate(sign * x[side]) for side, sign in enumerate((1.0, -1.0)))

    def read(channel: Array) -> Array:
        there, back = np.interp(place, rising, channel[0]), np.interp(-place, falling, channel[1])
        return np.asarray(np.where(forward, there, back))

    return MeasuredLoop(
        repeat=repeat,
        cycle=cycle,
        time_s=np.arange(samples) / samples / 3.0,
        displacement_um=place + NOISE_um * random.standard_normal(samples),
        tangential_force_N=read(q) + NOISE_N * random.standard_normal(samples),
        normal_force_N=read(p) + NOISE_N * random.standard_normal(samples) if normal else None,
    )


def _evolution(course: PredictedLoops, repeat: int) -> MeasuredEvolution:
    x, q = course.displacement_um, course.tangential_force_N
    return MeasuredEvolution(
        repeat,
        {
            "cycle": course.cycles,
            "displacement_amplitude_um": 0.5 * (x.max(axis=(1, 2)) - x.min(axis=(1, 2))),
            "slip_amplitude_um": half_width(x, q),
            "max_tangential_force_N": np.abs(q).max(axis=(1, 2)),
            "dissipated_energy_mJ": loop_area(x, q),
        },
    )


def diagnosed(one: ExperimentRecord, *left_out: str) -> Diagnosed:
    """The diagnosis of a record on these states."""
    return concluded(one, nominal_study(one), states(), reduce(one), left_out)


def concluded(
    record: AnyRecord,
    study: Any,
    states: WearStates,
    observed: Observations,
    left_out: Sequence[str] = (),
    setup: SurrogateInputs | None = None,
) -> Diagnosed:
    """The diagnosis of a reduced record on the wear states of its nominal model, in circumstances as it states them."""
    inputs = replace(setup or nominal_inputs(study, record.tables.conditions.drive), motion=observed.motion)
    return judged(record, study, states, observed, search(states, inputs, observed, left_out))
