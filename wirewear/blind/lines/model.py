"""Records of line contacts by finite elements of another mesh and other jumps than a diagnosis' nominal run.

A case is one run; its repeats are that run, read for specimens of other friction, load and wear: forces are
proportional to friction and load once the contact slides, and what wears follows the dissipated energy, so that
another wear rate is another cycle of the same run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from wirewear.blind.cases import Case, TrueEffect
from wirewear.blind.finite_element.changes import OUTSIDE, SATURATION
from wirewear.blind.finite_element.readings import moments
from wirewear.blind.generator import MadeRecord
from wirewear.blind.line_nominal import LineNominal, drawn_line_nominals
from wirewear.blind.nominal import Nominal
from wirewear.blind.nuisances import SpecimenDraw
from wirewear.blind.sampling import Channels, logged_channels, loop_figures
from wirewear.effects import Age, Effect, Seam, applied, effect_named
from wirewear.errors import RunError, WirewearError
from wirewear.line_records import LineRecord, MeasuredProfile
from wirewear.line_records.believed import believed_study
from wirewear.line_records.tables import LineRecordTables
from wirewear.line_records.values import BODIES
from wirewear.planar.results import PlanarLoop, PlanarResult
from wirewear.planar.tables import PlanarStudy
from wirewear.planar.whole_contact import per_mm
from wirewear.records import MeasuredEvolution, MeasuredLoop
from wirewear.sensor import LoopSignals, Sensor

Array = NDArray[np.float64]

#: Effects of the contract that a line contact can have.
LINE_LIBRARY = (
    "tangential_compliance",
    "rotational_compliance",
    "free_play",
    "friction_offset",
    "friction_evolution",
    "roughness_compliance",
    "third_body",
    "misalignment",
    "normal_load_drift",
    "wear_rate_offset",
    "wear_rate_evolution",
    "contact_oxygenation",
    "displacement_gain",
    "displacement_load_coupling",
    "force_crosstalk",
    "sensor_lag",
)

#: Loops are logged at these shares of decades too; scars of other wear rates are read beyond the test's end.
BETWEEN = (1, 10, 100, 300, 1000, 3000, 10000, 30000)
LATE = (0.6, 0.85, 1.0, 1.2)

#: Contact elements and width of the patch against those of the level "quick", and jumps: other than a diagnosis takes.
REFINED, WIDER, JUMP_TOLERANCE = 1.2, 1.1, 0.07

#: Even times of a cycle, before the record's sampling; points of a profile; its noise, and how far it reaches.
TIMES, POINTS, PROFILE_NOISE_um, PROFILE_MARGIN = 1024, 181, 0.03, 1.7

#: Shares of the test at which gaps are sized.
COMPARED = (0.02, 0.2, 1.0)


@dataclass(frozen=True)
class LineModel:
    """Cylinders on flats of the program, one run a case; the drive imposes the true stroke."""

    tier: str = "L1"
    library: Sequence[str] = LINE_LIBRARY
    outside: Sequence[str] = (*OUTSIDE, SATURATION)

    @property
    def description(self) -> str:
        """What the manifest says of it."""
        return (
            f"line contacts, mesh refined by {REFINED:g} on a patch {WIDER:g} times as wide, jump tolerance "
            f"{JUMP_TOLERANCE:g}"
        )

    def nominals(self, number: int, random: np.random.Generator) -> tuple[Nominal, ...]:
        """Nominal tests of a batch."""
        return cast("tuple[Nominal, ...]", drawn_line_nominals(number, random))

    def make(self, case: Case) -> MadeRecord:
        """The record of a case; the same for the same case.

        Raises:
            RunError: the contact does not slip, does not converge, or cannot be meshed.
        """
        case = replace(case, nuisances=replace(case.nuisances, drive="stroke", amplitude_drift=0.0))
        random = np.random.default_rng(case.seed)
        believed = run_of(_nominal(case), ())
        changes = tuple(_effect(true) for true in case.effects if true.effect != SATURATION)
        inside = tuple(effect for effect in changes if effect.seam is not Seam.SENSOR)
        true = run_of(_nominal(case), inside) if inside else believed
        repeats = [_repeat(true, changes, case, repeat, random) for repeat in range(1, case.nuisances.repeats + 1)]
        record = LineRecord(
            record_tables(case),
            tuple(loop for loops, _, _ in repeats for loop in loops),
            tuple(rows for _, evolution, _ in repeats for rows in evolution),
            tuple(profile for _, _, profiles in repeats for profile in profiles),
        )
        return MadeRecord(record, case.nuisances, _differences(believed, true, changes, case))


def _nominal(case: Case) -> LineNominal:
    return cast("LineNominal", case.nominal)


def _effect(true: TrueEffect) -> Effect[Any]:
    kind = OUTSIDE.get(true.effect) or effect_named(true.effect)
    return kind(**true.parameters)


def record_tables(case: Case) -> LineRecordTables:
    """The tables of experiment.toml: all from the nominal test and the nuisances."""
    nuisances = case.nuisances
    noise = {"displacement_um": nuisances.displacement_noise_um, "tangential_force_N": nuisances.force_noise_N}
    if nuisances.has_normal_force:
        noise["normal_force_N"] = nuisances.force_noise_N
    return _tables(_nominal(case), case.name, noise)


def _tables(nominal: LineNominal, name: str, noise: Mapping[str, float]) -> LineRecordTables:
    stated: dict[str, Any] = {
        "friction": nominal.friction,
        "pad_energy_wear_coefficient_mm3_per_J": nominal.pad_wear_mm3_per_J,
        "specimen_energy_wear_coefficient_mm3_per_J": nominal.specimen_wear_mm3_per_J,
    }
    if nominal.stiffness_N_per_mm is not None:
        stated["tangential_stiffness_N_per_mm"] = nominal.stiffness_N_per_mm
    return LineRecordTables.model_validate(
        {
            "format": 1,
            "name": name,
            "contact": {"kind": "cylinder-on-flat", "length_mm": nominal.length_mm},
            "pad": {"radius_mm": nominal.radius_mm, **_elastic(nominal.pad_MPa)},
            "specimen": _elastic(nominal.specimen_MPa),
            "conditions": {
                "normal_load_N": nominal.load_N,
                "displacement_amplitude_um": nominal.amplitude_um,
                "frequency_Hz": nominal.frequency_Hz,
                "cycles": nominal.cycles,
                "drive": "stroke",
            },
            "stated": stated,
            "noise": dict(noise),
            "files": {},
        }
    )


def _elastic(constants: tuple[float, float]) -> dict[str, float]:
    return {"youngs_modulus_MPa": constants[0], "poissons_ratio": constants[1]}


@lru_cache(maxsize=24)
def run_of(nominal: LineNominal, effects: tuple[Effect[Any], ...]) -> PlanarResult:
    """The run of a test with effects of the whole contact in it.

    Raises:
        RunError: it cannot be meshed, or the contact did not converge.
    """
    from solvers import SolverError
    from wirewear.planar.run import run_planar_study

    try:
        return run_planar_study(_study(nominal, effects), fidelity="quick")
    except (SolverError, WirewearError) as error:
        raise RunError(f"a line contact cannot be made: {error}") from error


def _study(nominal: LineNominal, effects: tuple[Effect[Any], ...]) -> PlanarStudy:
    from wirewear.planar.model import plan

    tables = _tables(nominal, "blind", {})
    tables = tables.model_copy(update={"conditions": tables.conditions.model_copy(update={"cycles": _length(nominal)})})
    logged = {cycle for cycle in BETWEEN if cycle < nominal.cycles}
    logged |= {round(share * nominal.cycles) for share in LATE}
    study = believed_study(tables, {"log": {"loop_cycles": sorted(logged)}})
    study = study.model_copy(update={"effects": per_mm(effects, nominal.length_mm)})
    quick = plan(study, "quick").pad.along
    mesh = study.mesh.model_copy(
        update={
            "contact_mesh_um": 1e3 * quick.fine_mm / REFINED,
            "scar_half_width_um": 1e3 * WIDER * quick.half_extent_mm,
            "jump_tolerance": JUMP_TOLERANCE,
        }
    )
    return study.model_copy(update={"mesh": mesh})


def _length(nominal: LineNominal) -> int:
    return round(LATE[-1] * nominal.cycles)


def _repeat(
    run: PlanarResult,
    changes: Sequence[Effect[Any]],
    case: Case,
    repeat: int,
    random: np.random.Generator,
) -> tuple[list[MeasuredLoop], list[MeasuredEvolution], list[MeasuredProfile]]:
    draw = case.nuisances.specimen(random)
    readings = read_test(run, changes, case, draw, case.nuisances.all_cycles)
    loops, evolution = logged_channels(readings, case, repeat, random)
    profiles = []
    if case.nuisances.has_scars:
        nominal = _nominal(case)
        half = PROFILE_MARGIN * 1e3 * nominal.expected_scar_mm + nominal.amplitude_um
        x = np.linspace(-half, half, POINTS)
        for body in BODIES:
            depth = np.interp(x, *profile_at(run, body, _dose(draw) * nominal.cycles), left=0.0, right=0.0)
            profiles.append(MeasuredProfile(repeat, body, x, depth + PROFILE_NOISE_um * random.standard_normal(POINTS)))
    return loops, evolution, profiles


def _dose(draw: SpecimenDraw) -> float:
    return draw.friction * draw.load * draw.wear


def profile_at(run: PlanarResult, body: str, cycle: float) -> tuple[Array, Array]:
    """Places and depths of a body after so many cycles, between logged ones in proportion."""
    own = sorted((profile for profile in run.profiles if profile.body == body), key=lambda profile: profile.cycle)
    cycles = np.array([profile.cycle for profile in own], dtype=float)
    after = int(np.clip(np.searchsorted(cycles, cycle), 1, len(own) - 1))
    share = float(np.clip((cycle - cycles[after - 1]) / (cycles[after] - cycles[after - 1]), 0.0, 1.2))
    depth = (1.0 - share) * own[after - 1].depth_um + share * own[after].depth_um
    return own[after].x_um, depth


def read_test(
    run: PlanarResult, changes: Sequence[Effect[Any]], case: Case, draw: SpecimenDraw, cycles: Sequence[int]
) -> Iterator[tuple[int, Channels]]:
    """Noise-free readings of one specimen at cycles, at even times of the rig's waveform."""
    nominal = _nominal(case)
    shape = case.nuisances.waveform.shape()
    loops = [(loop.cycle, _at_even_times(loop, shape, nominal.length_mm)) for loop in run.loops]
    known = np.array([cycle for cycle, _ in loops], dtype=float)
    time_s = np.arange(TIMES) / (TIMES * nominal.frequency_Hz)
    strength, load = draw.friction * draw.load, draw.load
    lost = sum(true.parameters["loss_at_plateau"] for true in case.effects if true.effect == SATURATION)
    cubic = lost / (nominal.friction * nominal.load_N) ** 2
    for cycle in cycles:
        worn_as = max(cycle * _dose(draw), known[0])
        after = int(np.clip(np.searchsorted(known, worn_as), 1, len(loops) - 1))
        share = float(np.clip(np.log(worn_as / known[after - 1]) / np.log(known[after] / known[after - 1]), 0.0, 1.0))
        x, q, p = (
            (1.0 - share) * one + share * other for one, other in zip(loops[after - 1][1], loops[after][1], strict=True)
        )
        sensor = applied(changes, Seam.SENSOR, Sensor(), Age(float(cycle), 0.0))
        read = sensor.read(LoopSignals(time_s, x, strength * q, load * p, 1.0 / nominal.frequency_Hz))
        force = read.tangential_force_N - cubic * (strength * q) ** 3 + draw.force_zero_N
        normal = load * p if read.normal_force_N is None else read.normal_force_N
        yield cycle, (read.displacement_um + draw.displacement_zero_um, force, normal)


def _at_even_times(loop: PlanarLoop, shape: Array, length_mm: float) -> Channels:
    """Displacement, tangential and normal force of the whole contact at the times of another waveform."""
    passed = moments(loop, shape)
    even = np.arange(TIMES) / TIMES
    channels = (
        loop.displacement_um,
        length_mm * loop.tangential_force_N_per_mm,
        length_mm * loop.normal_force_N_per_mm,
    )
    first, second, third = (np.interp(even, passed, channel, period=1.0) for channel in channels)
    return first, second, third


def _differences(
    believed: PlanarResult, true: PlanarResult, changes: Sequence[Effect[Any]], case: Case
) -> dict[str, float]:
    """What the case's effects change of figures, over one test's scatter: noise of the figure and that of specimens."""
    if not case.effects:
        return {}
    cycles = sorted({max(round(share * case.nominal.cycles), 1) for share in COMPARED})
    nothing = replace(case, effects=())
    same = SpecimenDraw()
    pairs = zip(
        read_test(believed, (), nothing, same, cycles), read_test(true, changes, case, same, cycles), strict=True
    )
    rows = [(_figures(before), _figures(after)) for (_, before), (_, after) in pairs]
    scatter = _scatter(case)
    found = {
        name: float(np.sqrt(np.mean([((a[name] - b[name]) / scatter(name, b)) ** 2 for b, a in rows])))
        for name in rows[0][0]
        if name != "normal_force_N" or case.nuisances.has_normal_force
    }
    if case.nuisances.has_scars:
        found |= _profile_differences(believed, true, case)
    return {name: round(value, 3) for name, value in found.items()}


def _figures(channels: Channels) -> dict[str, float]:
    x, q, p = channels
    figures = dict(loop_figures(x, q))
    top, low = int(np.argmax(x)), int(np.argmin(x))
    count = x.size
    # Travel from a reversal to half of the force, on either branch.
    half = 0.25 * float(np.ptp(q))
    falls, rises = np.roll(q, -top), np.roll(q, -low)
    down = int(np.argmax(falls < falls.max() - half))
    up = int(np.argmax(rises > rises.min() + half))
    figures["stick_um"] = 0.5 * (float(x[top] - x[(top + down) % count]) + float(x[(low + up) % count] - x[low]))
    figures["mean_force_N"] = float(q.mean())
    figures["normal_force_N"] = float(p.mean())
    return figures


def _scatter(case: Case) -> Any:
    own, nominal, samples = case.nuisances, case.nominal, np.sqrt(case.nuisances.samples / 8.0)
    force = own.force_noise_N / samples
    place = own.displacement_noise_um / np.sqrt(4.0)
    friction = float(np.hypot(own.scatter.friction, own.scatter.load))

    def size(name: str, before: Mapping[str, float]) -> float:
        plateau = nominal.friction * nominal.load_N
        sizes: dict[str, float] = {
            "displacement_amplitude_um": max(place, 1e-3 * nominal.amplitude_um),
            "slip_amplitude_um": float(np.hypot(place, 0.003 * nominal.amplitude_um)),
            "max_tangential_force_N": float(np.hypot(force, friction * plateau)),
            "dissipated_energy_mJ": float(np.hypot(0.003, friction)) * before["dissipated_energy_mJ"],
            "stick_um": float(np.hypot(place, 0.05 * before["stick_um"])),
            "mean_force_N": float(np.hypot(0.2 * own.force_noise_N, 0.002 * plateau)),
            "normal_force_N": float(np.hypot(force, own.scatter.load * nominal.load_N)),
        }
        return sizes[name]

    return size


def _profile_differences(believed: PlanarResult, true: PlanarResult, case: Case) -> dict[str, float]:
    scatter = case.nuisances.scatter
    spread = float(np.sqrt(scatter.wear**2 + scatter.friction**2 + scatter.load**2))
    found = {}
    for body in BODIES:
        x, before = profile_at(believed, body, float(case.nominal.cycles))
        after = np.interp(x, *profile_at(true, body, float(case.nominal.cycles)), left=0.0, right=0.0)
        size = np.hypot(spread * float(before.max()), PROFILE_NOISE_um)
        inside = before > 0.05 * before.max()
        found[f"scar_{body}"] = float(np.sqrt(np.mean(((after - before)[inside] / size) ** 2)))
    return found
