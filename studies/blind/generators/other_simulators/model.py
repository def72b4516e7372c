"""Tier T3: records of tests by others, each simulated by the simulator of its test."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import cos, inf, radians, sin
from typing import Any, cast

import numpy as np

from studies.blind.causes import causes_of, seam_of
from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.files import line_record_tables, record_tables
from studies.blind.generators.generator import LIBRARY_EFFECTS, OTHERS, MadeRecord, weaker_of
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.other_simulators import logger as logs
from studies.blind.generators.other_simulators.foundation import FoundationWires
from studies.blind.generators.other_simulators.half_space import HalfSpaceWires
from studies.blind.generators.other_simulators.joints import Sliders
from studies.blind.generators.other_simulators.layers import ElasticLayer, LinePair
from studies.blind.generators.other_simulators.logger import Channels, Logger, drawn_logger
from studies.blind.generators.other_simulators.pair import Array, Pair
from studies.blind.generators.other_simulators.rig import periodic_loop, readings
from studies.blind.generators.other_simulators.strips import StripWires
from studies.blind.generators.other_simulators.tests_drawn import (
    SIMULATORS,
    JointTest,
    LineTest,
    Test,
    WireTest,
    drawn_tests,
    expected_pressure_MPa,
)
from studies.blind.generators.other_simulators.world import World
from studies.blind.generators.sampling import loop_figures
from wirewear.base.errors import RunError
from wirewear.records import AnyRecord, ExperimentRecord, MeasuredProfile, MeasuredScar
from wirewear.records.contact_tables import RECORDS, LineRecordTables
from wirewear.records.tables import PointRecordTables

Contact = HalfSpaceWires | FoundationWires | StripWires | LinePair | Sliders

#: Cells of a scar's half-length, and how much longer the grid is than the scar that is expected.
CELLS, WIDER = {"half_space": 20, "foundation": 26, "strips": 70, "layers": 80, "sticking": 32, "joint": 1}, 1.35
#: Cycles grow so much from jump to jump; the first jump has this share of the first snapshot's.
GROWTH, FIRST = (
    {"half_space": 1.25, "foundation": 1.12, "strips": 1.12, "layers": 1.15, "sticking": 2.0, "joint": 2.0},
    0.1,
)
SPEED_EXPONENT, PRESSURE_EXPONENT = 0.004, -0.004  #: Exponents of friction by speed and by pressure that strips have.
OF_BODIES = "roughness_compliance", "third_body", "plasticity", "crossing_angle_error"
OF_WEAR = "wear_rate_offset", "wear_rate_evolution"
#: Effects that a simulator cannot make.
CANNOT = {
    "strips": ("crossing_angle_error",),
    "layers": ("crossing_angle_error", "plasticity"),
    "sticking": (*OF_BODIES, *OF_WEAR),
    "joint": (*OF_BODIES, *OF_WEAR),
    "force": (*OF_BODIES, *OF_WEAR),
    "swinging": (*OF_BODIES, *OF_WEAR),
}
WORN_SEAMS = ("wear", "specimens")  #: Where causes enter that only wear shows.
#: Loggings from which the noise of figures is taken.
LOGGED = 24
PRESSED_um = 0.05  #: How well the middle of a stroke is known from where bodies were pressed together.


@dataclass(frozen=True, eq=False)
class Course:
    """What a test's instruments gave without noise, by cycle, and the scars: lines along, across, depths [mm]."""

    channels: Mapping[int, Channels]
    scars: Sequence[tuple[Array, Array, Array]]


@dataclass(frozen=True)
class OtherSimulators:
    """The simulators of a set: those that may be looked at, or those for scoring alone."""

    chosen: str = "development"
    tier: str = OTHERS

    @property
    def outside(self) -> Sequence[str]:
        """Causes outside the library that all simulators of the set can make: none of wear or worn specimens if one of
        them wears nothing.
        """
        causes = causes_of("others")
        return [one for one in causes if seam_of(one) not in WORN_SEAMS] if self._without(*OF_WEAR) else causes

    @property
    def description(self) -> str:
        return f"simulators by others ({self.chosen}): {', '.join(dict.fromkeys(SIMULATORS[self.chosen]))}"

    @property
    def library(self) -> Sequence[str]:
        """Effects that all of them can make."""
        return tuple(effect for effect in LIBRARY_EFFECTS if not self._without(effect))

    def _without(self, *effects: str) -> bool:
        """Whether one of its simulators can make none of them."""
        return any({*effects} <= {*CANNOT.get(simulator, ())} for simulator in SIMULATORS[self.chosen])

    def nominals(self, number: int, random: np.random.Generator) -> Sequence[Nominal]:
        """So many tests, drawn."""
        return cast("Sequence[Nominal]", drawn_tests(number, SIMULATORS[self.chosen], random))

    def make(self, case: Case) -> MadeRecord:
        """The record of a case. Raises RunError if a contact does not slide."""
        test, random = cast("object", case.nominal), np.random.default_rng((case.seed, 3))
        if not isinstance(test, WireTest | LineTest):
            raise RunError("tests of the tier T3 are drawn by its own simulators.")
        logger = drawn_logger(test, random)
        true = replace(world_of(test), drive=logger.drive)
        specimens = np.random.default_rng((case.seed, 4))
        loops, rows = [], []
        scars: list[MeasuredScar | MeasuredProfile] = []
        for repeat in range(1, logger.repeats + 1):
            draw = logger.specimen(specimens)
            world = replace(
                true,
                friction=true.friction * draw.friction,
                load_N=true.load_N * draw.load,
                wear_mm3_per_J=true.wear_mm3_per_J * draw.wear,
            )
            course = simulated(test, world.with_effects(case.effects), logger.evolution_cycles)
            zeros = draw.displacement_zero_um, draw.force_zero_N
            read = {cycle: (one[0] + zeros[0], one[1] + zeros[1], one[2]) for cycle, one in course.channels.items()}
            kept = {cycle: read[cycle] for cycle in logger.loop_cycles[repeat - 1]}
            loops += [logs.logged_loop(logger, test, (repeat, cycle), one, random) for cycle, one in kept.items()]
            if logger.has_evolution:
                rows.append(logs.logged_evolution(logger, repeat, read, random))
            if logger.has_scars:
                scars.extend(logs.logged_scars(logger, test, repeat, course.scars, random))
        record: AnyRecord = ExperimentRecord(tables_of(case, test, logger), tuple(loops), tuple(rows), tuple(scars))
        return MadeRecord(record, logger, *(sized(test, true, logger, case.effects) if case.effects else ({}, 0.0)))


def world_of(test: Test) -> World:
    """A test as its owner states it."""
    if isinstance(test, LineTest):
        wear, spring = test.pad_wear_mm3_per_J + test.specimen_wear_mm3_per_J, 0.0
        share = test.specimen_wear_mm3_per_J / wear
    else:
        wear, spring, share = test.wear_mm3_per_J, test.spring_N_per_mm, 0.5
    strips = test.simulator == "strips"
    return World(
        friction=test.friction,
        load_N=test.load_N,
        wear_mm3_per_J=wear,
        amplitude_mm=1e-3 * test.amplitude_um,
        frequency_Hz=test.frequency_Hz,
        cycles=test.cycles,
        drive="stroke",
        compliance_mm_per_N=0.0 if test.stiffness_N_per_mm is None else 1.0 / test.stiffness_N_per_mm,
        spring_N_per_mm=spring,
        moving_share=share,
        speed_exponent=SPEED_EXPONENT if strips else 0.0,
        pressure_exponent=PRESSURE_EXPONENT if strips else 0.0,
        expected_MPa=expected_pressure_MPa(test),
        least_slip=0.35 if test.slides and test.held is None else -inf,
        stated_friction=test.friction,
        stated_load_N=test.load_N,
        held=test.held,
        swing=test.swing,
        programme=tuple(
            (block.cycles, block.load_N / test.load_N, block.amplitude_um / test.amplitude_um) for block in test.blocks
        ),
    )


def contact_of(test: Test, angle_error_deg: float = 0.0) -> Contact:
    """The bodies of a test before any wear."""
    reach = 1.15e-3 * test.amplitude_um
    cells = CELLS[test.simulator]
    if isinstance(test, JointTest):
        return Sliders(test.own_N_per_mm, test.spread, reach)
    if isinstance(test, LineTest):
        half = WIDER * test.expected_scar_mm
        x = half / cells * np.arange(-cells, cells + 1.0)
        bodies = tuple(
            ElasticLayer(*constants, height)
            for constants, height in zip((test.pad_MPa, test.specimen_MPa), test.heights_mm, strict=True)
        )
        shape = _circle(x, test.radius_mm)[:, None]
        return LinePair(shape, (half / cells, test.length_mm), reach, (bodies[0], bodies[1]))
    half = WIDER * max(test.expected_scar_mm, 1.6 * test.hertz_mm) * test.elongation
    step = half / cells
    x = step * np.arange(-cells, cells + 1.0)
    radius = 0.5 * test.diameter_mm
    if test.simulator == "strips":
        return StripWires((x**2 / (2.0 * radius))[:, None], (step, 2.0 * half), reach, test.modulus_MPa, test.easier)
    angle = radians(test.crossing_angle_deg + angle_error_deg)
    shape = _circle(x[:, None] * sin(angle) - x * cos(angle), radius) + _circle(x, radius)
    if test.simulator == "foundation":
        return FoundationWires(shape, (step, step), reach, test.modulus_MPa, test.easier)
    pair = HalfSpaceWires(shape, (step, step), reach, test.modulus_MPa, test.easier)
    pair.shares = test.shares
    return pair


def _circle(x: Array, radius: float) -> Array:
    return np.asarray(radius - np.sqrt(np.maximum(radius**2 - x**2, 0.0)))


def simulated(test: Test, world: World, snapshots: Sequence[int]) -> Course:
    """A test of a world from its first cycle to its last, in jumps that grow with the cycles.

    snapshots: cycles at which channels are kept. Raises RunError if the contact does not slide.
    """
    pair = contact_of(test, world.angle_error_deg)
    half_slip = 0.9 * world.amplitude_mm
    if world.flattening_mm > 0.0:
        pair.flatten(world.flattening_mm, half_slip)
    now, first_approach = 0.0, None
    touch, settled, channels = None, None, {}
    load = world.during(now).load_N
    stops = sorted({*snapshots, *test.ends, *(end + 1 for end in test.ends[:-1])})
    for following in _schedule(stops, GROWTH[test.simulator]):
        here = world.during(now)
        layer = here.layer_at(now)
        if now - 1.0 in test.ends:
            half_slip, load = 0.9 * here.amplitude_mm, here.load_at(now, pair.approach_mm - (first_approach or 0.0))
        pressed = load, layer, pair.sweeps
        if touch is None or (now in stops and pressed != settled):
            settled = pressed
            pair.settle(load, layer)
            touch = pair.touch(load, half_slip, layer)
            first_approach = touch.approach_mm if first_approach is None else first_approach
            load = here.load_at(now, touch.approach_mm - first_approach)
        loop = periodic_loop(here, now, load, touch, pair)
        half_slip = max(loop.half_slip_mm, 0.0)
        if now in snapshots:
            channels[int(now)] = readings(here, now, loop)
        if following > now:
            volume = 1e-3 * here.wear_at(now, following) * loop.work_mJ * (following - now)
            load = here.load_at(0.5 * (now + following), touch.approach_mm - (first_approach or 0.0))
            if test.wears:
                pair.sweep(load, half_slip, volume / load, here.moving_share, layer)
        now = following
    return Course(channels, scars_of(pair))


def scars_of(pair: Pair) -> tuple[tuple[Array, Array, Array], ...]:
    """Both scars with their lines along and across [mm]."""
    found = []
    for depth in pair.scars_mm:
        size = depth.shape[0]
        across = (np.arange(depth.shape[1]) - depth.shape[1] // 2) * pair.dy
        if isinstance(pair, StripWires):
            across = pair.across_mm
        found.append((pair.dx * (np.arange(size) - size // 2), across, depth))
    return tuple(found)


def _schedule(snapshots: Sequence[int], growth: float) -> list[float]:
    """Ends of all jumps, snapshots among them; the last comes twice, so that its loop is taken."""
    at, ends = FIRST * snapshots[0], [0.0]
    while at < snapshots[-1]:
        ends.append(at)
        at *= growth
    ends = sorted({*ends[1:], *map(float, snapshots)})
    return [*ends, ends[-1]]


@lru_cache(maxsize=64)
def _plain(test: Test, world: World, snapshots: tuple[int, ...]) -> Course:
    return simulated(test, world, snapshots)


def observed(test: Test, course: Course, logger: Logger, true: World) -> dict[str, tuple[float, float]]:
    """Figures of a course by name, of three loops and of the scars, each with its scatter from test to test."""
    scatter, limit = logger.scatter, test.friction * test.load_N
    force = float(np.hypot(scatter.friction, scatter.load))
    # No scale of a displacement is known better than a few thousandths of the stroke.
    given_um = force * (1e3 * limit * true.compliance_mm_per_N + 0.03 * test.amplitude_um)
    place_um = float(np.hypot(given_um, 3e-3 * test.amplitude_um))
    zero_N = float(np.hypot(0.2 * logger.force_noise_N, 2e-3 * limit))
    # What sticks keeps the force with which it was pressed together beside the middle of its stroke.
    beside_um = 0.0 if test.slides else PRESSED_um
    found: dict[str, tuple[float, float]] = {}
    cycles = list(course.channels)
    for name, cycle in zip(("first", "middle", "last"), (cycles[0], cycles[len(cycles) // 2], cycles[-1]), strict=True):
        place, read, normal = course.channels[cycle]
        amplitude, slip, largest, energy = loop_figures(place, read).values()
        pull, off = read - read.mean(), (place - place.mean()) / np.ptp(place)
        found |= {
            f"amplitude {name}": (amplitude, place_um),
            f"slip {name}": (slip, place_um),
            # No extreme is known better than a sample.
            f"largest force {name}": (largest, float(np.hypot(force * limit, logger.force_noise_N))),
            f"energy {name}": (energy, energy * float(np.hypot(force, place_um / test.amplitude_um))),
            f"mean force {name}": (
                float(read.mean()),
                float(np.hypot(zero_N, beside_um * np.ptp(read) / np.ptp(place))),
            ),
            f"plateau {name}": (float(np.abs(pull)[np.abs(off) < 0.1].mean()), force * limit),
            f"ends {name}": (float(np.abs(pull)[np.abs(off) > 0.4].mean()), force * limit),
            f"upper end {name}": (float(pull[off > 0.4].mean()), force * limit),
        }
        if logger.has_normal_force:
            found[f"load {name}"] = float(normal.mean()), scatter.load * test.load_N
            found[f"ripple {name}"] = 0.5 * np.ptp(normal), np.hypot(logger.force_noise_N, 2e-3 * test.load_N)
    if logger.has_scars:
        wear = float(np.hypot(scatter.wear, force))
        for body, (_, _, depth) in zip(("near", "far"), course.scars, strict=True):
            found[f"volume of the {body} body"] = float(depth.sum()), wear * float(depth.sum())
            found[f"depth of the {body} body"] = float(depth.max()), 0.7 * wear * float(depth.max())
    return found


def hidden(test: Test, course: Course, logger: Logger, true: World) -> dict[str, float]:
    """What hides changes of the figures beside the scatter of specimens, as standard deviations by name: noise and
    steps of the loops in a third of the test, and, where the contact sticks, how well anyone knows what it gives.
    """
    random, plain = np.random.default_rng(1), replace(logger, outlier_share=0.0, has_normal_force=True)
    noisy = []
    for _ in range(LOGGED):
        loops = [logs.logged_loop(plain, test, (1, cycle), one, random) for cycle, one in course.channels.items()]
        read = {x.cycle: (x.displacement_um, x.tangential_force_N, x.normal_force_N) for x in loops}
        noisy.append(observed(test, replace(course, channels=cast("Any", read)), logger, true))
    alike = max(len(logger.loop_cycles[0]) / 3.0, 1.0)
    found = {name: float(np.std([one[name][0] for one in noisy]) / alike**0.5) for name in noisy[0]}
    if test.unsure_mm:
        softer = true.compliance_mm_per_N + test.unsure_mm / (test.friction * test.load_N)
        loose = _plain(test, replace(true, compliance_mm_per_N=softer), logger.evolution_cycles)
        pairs = zip(
            observed(test, loose, logger, true).items(), observed(test, course, logger, true).items(), strict=True
        )
        found = {name: float(np.hypot(found[name], one - own)) for (name, (one, _)), (_, (own, _)) in pairs}
    return found


def sized(test: Test, true: World, logger: Logger, effects: Sequence[TrueEffect]) -> tuple[dict[str, float], float]:
    """What effects change of the figures over all that hides it, and the size of the weaker of two, see `weaker_of`."""
    nominal = _plain(test, true, logger.evolution_cycles)
    without, more = observed(test, nominal, logger, true), hidden(test, nominal, logger, true)
    scatter = np.array([np.hypot(size, more[name]) for name, (_, size) in without.items()])

    def over_scatter(acting: Sequence[TrueEffect]) -> Array:
        found = observed(test, simulated(test, true.with_effects(acting), logger.evolution_cycles), logger, true)
        return np.asarray([found[name][0] - value for name, (value, _) in without.items()] / scatter)

    changed = over_scatter(effects)
    return dict(zip(without, np.abs(changed).round(3).tolist(), strict=True)), weaker_of(effects, over_scatter, changed)


def tables_of(case: Case, test: Test, logger: Logger) -> PointRecordTables | LineRecordTables:
    """The tables of experiment.toml."""
    known = logger.scatter
    scatter = {"friction": round(known.friction, 4), "normal_load": round(known.load, 4), "wear": round(known.wear, 3)}
    more: dict[str, Any] = {"scatter": scatter} if logger.states_scatter else {}
    if isinstance(test, WireTest):
        if test.blocks:
            more["programme"] = [block.table for block in test.blocks]
        plain = record_tables(replace(case, nuisances=logger)).model_dump(mode="json", exclude_unset=True)
        plain["conditions"] |= dict([test.held] if test.held else [])
        if test.swing:
            share, ratio = test.swing
            plain["conditions"]["load_cycle"] = {"amplitude_share": share, "frequency_ratio": ratio, "lag_deg": 0.0}
        return cast("PointRecordTables", RECORDS[test.kind].model_validate({**plain, **more}))
    plain = line_record_tables(test, case.name, logger.stated_noise).model_dump(mode="json", exclude_unset=True)
    for body, height, half in zip(("pad", "specimen"), test.heights_mm, test.half_widths_mm, strict=True):
        plain[body] |= {"height_mm": height, "half_width_mm": half}
    plain["conditions"]["drive"], plain["files"] = logger.drive, {"loops": "loops.csv"}
    return LineRecordTables.model_validate({**plain, **more})
