"""Export of a simulation as a record or as height files, read by simulated sensors as a laboratory would read it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from geometry import Arc, Flat, Profile
from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.base.files import TABLE_FILE_NAME
from wirewear.base.memory import free_memory, size_text
from wirewear.base.words import counted
from wirewear.base.writing import all_or_none, prepared_folder, require_absent, write_csv, writing
from wirewear.loops import LoopError, LoopFigures, Sensor, analyse_loop
from wirewear.records.contact_tables import RECORDS, AnyTables
from wirewear.records.scars import SCAR_STEP_um
from wirewear.records.tables import Noise, known_of
from wirewear.records.values import AnyRecord, ExperimentRecord, MeasuredEvolution, MeasuredLoop
from wirewear.records.writing import frame_of, loops_frame
from wirewear.results import BODIES, Loop, RunResult, Scar, age_at, sensor_of
from wirewear.test.faces import FACE_KEYS, PadFace
from wirewear.test.keys import Table
from wirewear.test.lengths import extent_of, lengthened
from wirewear.test.messages import validated
from wirewear.test.surfaces import surfaces_in

#: The map reaches this many times as far as the scar, so that most of it is unworn; of a body's radius at most a share,
#: beyond which no instrument sees its flanks.
REACH, FLANK = 1.6, 0.9

#: Heights of a body's surface again for every repeat, as columns x_um, y_um and height_um (or without y_um).
Surface = Callable[[], Mapping[str, Array]]

_IDEAL = Sensor()


def write_as_heights(
    folder: Path, loops: Sequence[MeasuredLoop], surfaces: Mapping[str, Surface], repeats: int, *, overwrite: bool
) -> list[Path]:
    """Write loops.csv and one file of heights for each surface and repeat to `folder`; return their paths. surfaces: by
    file name. repeats: their number. overwrite: True to replace existing files. Raises RecordError if a file cannot be
    written, or exists and must not be overwritten.
    """
    frames = {"loops": loops_frame(loops)}
    frames |= {f"{n}_{r}": frame_of(own()) for n, own in surfaces.items() for r in range(1, repeats + 1)}
    files = {folder / f"{name}.csv": frame for name, frame in frames.items()}
    require_absent(() if overwrite else files, RecordError)
    prepared_folder(folder)
    with writing(RecordError, f"cannot write to {folder}"), all_or_none(files) as partials:
        for partial, frame in zip(partials, files.values(), strict=True):
            write_csv(partial, frame)
    return list(files)


def scar_surfaces(result: RunResult, noise_um: float, seed: int) -> dict[str, Surface]:
    """Functions that give the heights of each body's map at the end of a run with new noise, by file name. noise_um:
    standard deviation of one height. seed: of the noise.
    """
    random = np.random.default_rng([seed, 1])
    last = max((scar.cycle for scar in result.scars), default=0)
    ends = [scar for scar in result.scars if scar.cycle == last]
    return {f"scar_{scar.body}": surface_of_body(scar, noise_um, random) for scar in ends}


def profile_surfaces(result: RunResult, noise_um: float, seed: int) -> dict[str, Surface]:
    """Functions that give the heights of pad and specimen along the motion at the end of a run with new noise, by file
    name. noise_um: standard deviation of one height. seed: of the noise.
    """
    random = np.random.default_rng([seed, 1])
    last = max(scar.cycle for scar in result.scars)
    pad = PadFace(**{key: result.study["pad"].get(key) for key in FACE_KEYS}).profile
    bore = result.study["specimen"].get("bore_radius_mm")
    found = {}
    for body, face in zip(BODIES, (pad, Flat() if bore is None else Arc(-bore)), strict=True):
        own = result.scar(last, body)
        found[f"profile_{body}"] = surface_of_profile(own.axial_um, own.depth_um[:, 0], face, noise_um, random)
    return found


def surface_of_body(scar: Scar, noise_um: float, random: np.random.Generator) -> Surface:
    """A function that gives the heights of a worn body with new noise, in the body's frame: x along its axis, y across.
    noise_um: standard deviation of one height. random: source of the noise.
    """
    worn = scar.depth_um > 0.01 * scar.max_depth_um
    axial, transverse = (
        _lines(float(np.abs(line[worn.any(axis=axis)]).max(initial=SCAR_STEP_um)))
        for line, axis in ((scar.axial_um, 1), (scar.transverse_um, 0))
    )
    axial, transverse = (
        line[np.abs(line) <= FLANK * 500.0 * diameter]
        for line, diameter in ((axial, scar.diameter_along_mm), (transverse, scar.diameter_mm))
    )
    a, t = np.meshgrid(axial, transverse, indexing="ij")
    height = (scar.unworn_height_um(a, t) - scar.depth_at(*scar.sliding_coordinates(a, t))).ravel()

    def surface() -> Mapping[str, Array]:
        noise = noise_um * random.standard_normal(height.size)
        return {"x_um": a.ravel(), "y_um": t.ravel(), "height_um": height + noise}

    return surface


def surface_of_profile(
    x_um: Array, depth_um: Array, face: Profile, noise_um: float, random: np.random.Generator
) -> Surface:
    """A function that gives the heights of a line contact's worn body along the motion with new noise.

    x_um, depth_um: (n,) positions and worn depths. face: unworn shape. noise_um: standard deviation of one height.
    random: source of the noise.
    """
    x = _lines(float(np.abs(x_um[depth_um > 0.01 * depth_um.max()]).max(initial=SCAR_STEP_um)), SCAR_STEP_um / 5.0)
    plane_mm = np.column_stack([1e-3 * x, np.zeros_like(x)])
    height = 1e3 * face.height(plane_mm) - np.interp(x, x_um, depth_um, left=0.0, right=0.0)
    return lambda: {"x_um": x, "height_um": height + noise_um * random.standard_normal(x.size)}


def _lines(half_um: float, step_um: float = SCAR_STEP_um) -> Array:
    """Coordinates in µm of a map's lines for a scar of this half length."""
    count = int(np.ceil(REACH * half_um / step_um))
    return np.arange(-count, count + 1) * np.float64(step_um)


def record_of_result(
    result: RunResult,
    length_mm: float | None = None,
    *,
    sensor: Sensor = _IDEAL,
    depth_noise_um: float = 0.0,
    repeats: int = 1,
    seed: int = 0,
    samples: int | None = None,
) -> AnyRecord:
    """The record that a laboratory would have made of a simulated test, with sensors that have the effects of its
    study.

    length_mm: length of a line contact for which forces and their noise are given, by default the study's. sensor: its
    errors and noise, besides the effects. depth_noise_um: standard deviation of one depth. repeats: number of times
    that the same test is read with new noise. seed: of the noise. samples: number to which each loop is resampled
    evenly; None for the simulation's increments. Figures of the evolution are the true ones times the ratio of read to
    true figures of the logged loops, interpolated over log cycle.
    Raises RecordError if the result began with a measured surface, is of a pin in a bore or has logged no loops, its
    study says too little or has unequal wires, or the length of a line contact is missing or given for another contact.
    """
    length_mm = RECORDS[result.contact_kind].length_of(result.study, length_mm, result.label)
    if any(surfaces_in(result.study)):
        raise RecordError(
            f"the result {result.label!r} is of a test that began with a measured surface, which records do not state."
        )
    for key, what in (("bore_radius_mm", "a pin in a bore"), ("shaft_radius_mm", "a shaft in a hub")):
        if result.study.get("specimen", {}).get(key) is not None:
            raise RecordError(f"the result {result.label!r} is of {what}, which records do not state.")
    if not result.loops:
        raise RecordError(f"the result {result.label!r} has logged no loops, so there is nothing to export.")
    whole = result.of_extent(extent_of(length_mm))
    sensor = replace(sensor, **lengthened(vars(sensor), result.times(length_mm)))
    sensors = [sensor_of(whole.study, sensor, age_at(whole, loop.cycle)) for loop in whole.loops]
    tables = _tables(whole, sensors[0])
    random = np.random.default_rng(seed)
    period = 1.0 / tables.conditions.frequency_Hz
    true_loops = [true_loop(loop, period, samples) for loop in whole.loops]
    loops: list[MeasuredLoop] = []
    evolution: list[MeasuredEvolution] = []
    _require_room(whole, repeats, samples)
    scars: list[Any] = []
    last = max((scar.cycle for scar in whole.scars), default=0)
    for repeat in range(1, repeats + 1):
        read = [
            replace(loop.read_as(own.read(loop.signals(period), random)), repeat=repeat)
            for loop, own in zip(true_loops, sensors, strict=True)
        ]
        loops += read
        if whole.evolution["cycle"].size:
            evolution.append(_evolution(whole, repeat, true_loops, read))
        ends = (scar for scar in whole.scars if scar.cycle == last)
        scars += [tables.worn.surface.of_run(scar, repeat, depth_noise_um, random) for scar in ends]
    return ExperimentRecord(tables, tuple(loops), tuple(evolution), tuple(scars))


def _require_room(result: RunResult, repeats: int, samples: int | None) -> None:
    """Raise RecordError if the record would take more memory than is free."""
    count = repeats * sum(samples or loop.time_s.size for loop in result.loops)
    # Memory that a sample of a record takes until it is written; measured.
    needed, free = 250 * count, free_memory()
    if needed > free:
        raise RecordError(
            f"{counted(repeats)} repeats of {len(result.loops)} loops are {counted(count)} samples, which take "
            f"{size_text(needed)} of memory, of which {size_text(free)} are free: give fewer --repeats or "
            "--samples, or allow more by --most-memory."
        )


def _tables(result: RunResult, sensor: Sensor) -> AnyTables:
    study, model = result.study, RECORDS[result.contact_kind]
    stated = model.stated_by(study)
    conditions, stated_rig = (
        cast("type[Table]", model.model_fields[key].annotation) for key in ("conditions", "stated")
    )
    data = {
        "format": 1,
        "name": result.full_name,
        **model.bodies_of(study, result.label),
        **_programme(study, model),
        # The simulation imposes the true motion, whatever its sensors read.
        "conditions": {**known_of(conditions, stated), "drive": "stroke"},
        # What is ideal is not stated.
        "stated": {k: v for k, v in known_of(stated_rig, stated).items() if v != stated_rig.model_fields[k].default},
        # Nothing asks whether a noise of the normal force is none or not known.
        "noise": {
            name: own for name in Noise.model_fields if (own := getattr(sensor.noise, name)) or name != "normal_force_N"
        },
        "metadata": {"source": "simulated"},
        "files": {"loops": "loops.csv"},
    }
    where = f"the {TABLE_FILE_NAME} of the result {result.label!r}"
    tables = validated(model, data, where, RecordError)
    tables.require_whole(where)
    return tables


def _programme(study: Mapping[str, Any], model: Any) -> dict[str, Any]:
    """Programme of a study as a record states it. Raises RecordError if the rig changes within it."""
    blocks = study.get("programme") or ()
    tables = ("conditions", "contact", "wear")
    if any(block.get("holder") for block in blocks):
        raise RecordError("a record states one rig, but the rig of this run changes from block to block")
    whole = [
        {key: value for key, value in block.items() if key not in (*tables, "holder")}
        | {name: model.stated_by({name: block[name]}) for name in tables if block.get(name)}
        for block in blocks
    ]
    return {"programme": whole} if whole else {}


def true_loop(loop: Loop, period_s: float = 1.0, samples: int | None = None) -> MeasuredLoop:
    """Simulated loop as a loop of a record without noise; samples: number to which it is resampled evenly over
    `period_s`, None for its increments.
    """
    time = loop.time_s - loop.time_s[0]
    x, q, p = loop.displacement_um, loop.tangential_force_N, loop.normal_force_N
    if samples is not None:
        even = np.arange(samples) * period_s / samples
        x, q, p = (np.interp(even, time, channel, period=period_s) for channel in (x, q, p))
        time = even
    return MeasuredLoop(0, loop.cycle, time, x, q, None if np.isnan(p).any() else p)


def _evolution(
    result: RunResult, repeat: int, true_loops: Sequence[MeasuredLoop], read: Sequence[MeasuredLoop]
) -> MeasuredEvolution:
    evolution = result.evolution
    cycle = np.round(evolution["cycle"])
    # Before the first whole cycle, rounding may bring two rows together.
    first = np.unique(cycle, return_index=True)[1]
    columns: dict[str, Array] = {"cycle": cycle[first]}
    pairs = [(true.cycle, _figures(true), _figures(other)) for true, other in zip(true_loops, read, strict=True)]
    known = [(number, true, other) for number, true, other in pairs if true is not None and other is not None]
    for name in ("displacement_amplitude_um", "slip_amplitude_um", "max_tangential_force_N", "dissipated_energy_mJ"):
        column = evolution[name][first]
        if known:
            ratios = [_ratio(_figure(other, name), _figure(true, name)) for _, true, other in known]
            logged = np.log(np.maximum([number for number, _, _ in known], 0.5))
            column = column * np.interp(np.log(np.maximum(cycle[first], 0.5)), logged, ratios)
        columns[name] = column
    return MeasuredEvolution(repeat, columns)


def _ratio(read: float, true: float) -> float:
    """Read over true figure; 1 if the true one is 0."""
    return read / true if true else 1.0


def _figures(loop: MeasuredLoop) -> LoopFigures | None:
    try:
        # Under a load of 1 N, the largest Q/P is the largest force, found so that noise does not raise it.
        return analyse_loop(loop.displacement_um, loop.tangential_force_N, 1.0, time_s=loop.time_s)
    except LoopError:
        return None


def _figure(figures: LoopFigures, name: str) -> float:
    return float(getattr(figures, {"max_tangential_force_N": "friction_max"}.get(name, name)).value)


def chosen_run(results: Sequence[RunResult], variant: str | None, path: Path) -> RunResult:
    """The run of the given variant or, if that is None, the only one. Raises RecordError if there are several and none
    is chosen, or none has that variant; path: names the result in messages.
    """
    names = ", ".join(result.variant or result.name for result in results)
    chosen = [result for result in results if variant is None or result.variant == variant]
    if len(chosen) == 1:
        return chosen[0]
    if not chosen:
        if not any(result.variant for result in results):
            raise RecordError(
                f"there is no variant {variant!r} in {path}, which holds a run without any: leave --variant out."
            )
        raise RecordError(f"there is no variant {variant!r} in {path}: choose one of {names}.")
    raise RecordError(f"{path} holds several runs: choose one of {names} with --variant.")


def parse_channels(text: str, known: Sequence[str], option: str, *, signed: bool = False) -> dict[str, float]:
    """Numbers by name from a text such as "a=0.1,b=2"; option: names the option in messages. Raises RecordError if a
    name is not among `known`, or a value is not a finite number (≥ 0 unless `signed`).
    """
    values: dict[str, float] = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, _, number = (piece.strip() for piece in part.partition("="))
        try:
            value = float(number)
        except ValueError:
            value = np.nan
        if name not in known or not (np.isfinite(value) and (signed or value >= 0.0)):
            raise RecordError(
                f"{option} holds {part!r}, but must be a list like {known[0]}=0.1 of {', '.join(known)}, with "
                f"numbers{'' if signed else ' that are not negative'}."
            )
        values[name] = value
    return values
