"""A finished simulation of a line contact as an experiment record: read by sensors, for a contact of some length."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from geometry import Flat
from wirewear.base.errors import RecordError
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.planar.tables import CYLINDER_ON_FLAT, FACE_KEYS, KINDS, PadFace
from wirewear.records.as_heights import Surface, surface_of_profile
from wirewear.records.exporting import true_loop
from wirewear.records.line_tables import LineRecordTables
from wirewear.records.line_values import Array, LineRecord, MeasuredProfile
from wirewear.records.values import MeasuredEvolution, MeasuredLoop
from wirewear.results import BODIES, RunResult, read_loops
from wirewear.study.messages import validated

_IDEAL = Sensor()
_COEFFICIENTS = {
    "energy_mm3_per_J": "energy_wear_coefficient_mm3_per_J",
    "archard_mm3_per_N_m": "archard_wear_coefficient_mm3_per_N_m",
}


def line_record_of_result(
    result: RunResult,
    length_mm: float,
    *,
    sensor: Sensor = _IDEAL,
    depth_noise_um: float = 0.0,
    repeats: int = 1,
    seed: int = 0,
    samples: int | None = None,
) -> LineRecord:
    """The record that a laboratory would have taken of a simulated line contact of that length.

    Each repeat is the same test read anew; the noise of forces is that of the whole contact's. `samples` re-samples
    each loop evenly; without it, the simulation's own increments are kept.

    Raises:
        RecordError: the result has logged nothing.
    """
    if not result.loops:
        raise RecordError(f"the result {result.full_name!r} has logged no loops, so there is nothing to export.")
    result = result.of_length(length_mm)
    tables, random = _tables(result, length_mm, sensor), np.random.default_rng(seed)
    noiseless = replace(
        sensor, noise=replace(sensor.noise, displacement_um=0.0, tangential_force_N=0.0, normal_force_N=0.0)
    )
    period_s = 1.0 / tables.conditions.frequency_Hz
    read = [true_loop(loop, period_s, samples) for loop in read_loops(result, noiseless)]
    last = max(scar.cycle for scar in result.scars)
    loops: list[MeasuredLoop] = []
    profiles: list[MeasuredProfile] = []
    evolution: list[MeasuredEvolution] = []
    for repeat in range(1, repeats + 1):
        loops += [_noisy(loop, repeat, sensor.noise, random) for loop in read]
        evolution.append(_evolution(result, repeat))
        for body in BODIES:
            own = result.scar(last, body)
            rough = depth_noise_um * random.standard_normal(own.axial_um.size)
            profiles.append(MeasuredProfile(repeat, body, own.axial_um, own.depth_um[:, 0] + rough))
    return LineRecord(tables, tuple(loops), tuple(evolution), tuple(profiles))


def profile_surfaces(result: RunResult, noise_um: float, random: np.random.Generator) -> dict[str, Surface]:
    """Both bodies of a run at its end across the scar, by names of files."""
    last = max(scar.cycle for scar in result.scars)
    pad = PadFace(**{key: result.study["pad"].get(key) for key in FACE_KEYS}).profile
    found = {}
    for body, face in zip(BODIES, (pad, Flat()), strict=True):
        own = result.scar(last, body)
        found[f"profile_{body}"] = surface_of_profile(own.axial_um, own.depth_um[:, 0], face, noise_um, random)
    return found


def _noisy(loop: MeasuredLoop, repeat: int, noise: SensorNoise, random: np.random.Generator) -> MeasuredLoop:
    def noisy(channel: Array, size: float) -> Array:
        return channel + size * random.standard_normal(channel.size)

    normal = loop.normal_force_N
    return replace(
        loop,
        repeat=repeat,
        displacement_um=noisy(loop.displacement_um, noise.displacement_um),
        tangential_force_N=noisy(loop.tangential_force_N, noise.tangential_force_N),
        normal_force_N=None if normal is None else noisy(normal, noise.normal_force_N),
    )


def _evolution(result: RunResult, repeat: int) -> MeasuredEvolution:
    e = result.evolution
    columns: dict[str, Array] = {
        "cycle": np.round(e["cycle"]),
        "displacement_amplitude_um": e["displacement_amplitude_um"],
        "slip_amplitude_um": e["slip_amplitude_um"],
        "max_tangential_force_N": e["max_tangential_force_N"],
        "dissipated_energy_mJ": e["dissipated_energy_mJ"],
    }
    return MeasuredEvolution(repeat, columns)


def _body(described: Mapping[str, Any]) -> dict[str, Any]:
    keys = ("youngs_modulus_MPa", "poissons_ratio", "height_mm", "half_width_mm")
    return {key: described[key] for key in keys if described.get(key) is not None}


def _tables(result: RunResult, length_mm: float, sensor: Sensor) -> LineRecordTables:
    study: dict[str, Any] = dict(result.study)
    face = {key: study["pad"][key] for key in FACE_KEYS if study["pad"].get(key) is not None}
    asked, wear = study["conditions"], study["wear"]
    stated = {"friction": study["contact"]["friction"]}
    for body in BODIES:
        for own, named in _COEFFICIENTS.items():
            if wear[f"{body}_{own}"] > 0.0:
                stated[f"{body}_{named}"] = wear[f"{body}_{own}"]
    data = {
        "format": 1,
        "name": result.full_name,
        "contact": {"kind": CYLINDER_ON_FLAT if "radius_mm" in face else KINDS[0], "length_mm": length_mm},
        "pad": face | _body(study["pad"]),
        "specimen": _body(study["specimen"]),
        "conditions": {
            "normal_load_N": length_mm * asked["normal_load_N_per_mm"],
            "displacement_amplitude_um": asked["displacement_amplitude_um"],
            "frequency_Hz": asked["frequency_Hz"],
            "cycles": asked["cycles"],
            "motion": asked["motion"],
            # The simulation imposes the true motion, whatever its sensors read.
            "drive": "stroke",
        },
        "stated": stated,
        "noise": {
            name: getattr(sensor.noise, name) for name in ("displacement_um", "tangential_force_N", "normal_force_N")
        },
        "metadata": {"source": "simulated"},
        "files": {"loops": "loops.csv"},
    }
    return validated(LineRecordTables, data, f"the record of {result.full_name!r}", RecordError)
