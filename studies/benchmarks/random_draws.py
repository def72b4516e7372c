"""Random studies of wires and of other contacts at a point within stated physical ranges, each from its own seed."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wirewear import reference
from wirewear.base.files import toml_text
from wirewear.test.gaps import hertz_of
from wirewear.test.points import LowerAndUpper

#: Ranges the studies are drawn from; lengths and stiffnesses on a logarithmic scale.
DIAMETER_mm = (0.2, 2.0)
LOAD_N = (0.5, 20.0)
FRICTION = (0.05, 1.2)
STROKE_PER_THRESHOLD = 0.3
MOST_STROKE_PER_RADIUS = 10.0
#: Major semi-axis of the fresh contact over the thinner wire's diameter.
LARGEST_CONTACT = 0.15
LEAST_AMPLITUDE_mm = 1e-4
ANGLE_deg = (30.0, 90.0)
MODULUS_MPa = (70e3, 210e3)
RIG_N_per_mm = (10.0, 3e4)
RIGID_SHARE = 0.25
CYCLES = 10_000
#: Of other contacts at a point: shapes, and what they have of wires' ranges at another scale.
SHAPES = ("wire", "tube", "cylinder", "ball", "barrel", "flat")
DIAMETER_OF_SHAPE_mm, LOAD_ON_SHAPES_N = (0.4, 40.0), (0.5, 500.0)
BORE_PER_DIAMETER = (0.2, 0.8)
LARGEST_PRESSURE_MPa = 8e3  #: Of their fresh contact.
#: Volume that gross slip would wear over the test, in areas of the fresh contact times its approach; steel wires of
#: 0.45 mm wear some 60 of them.
VOLUME_PER_CONTACT = (1.0, 100.0)
LARGEST_VOLUME = 0.003  #: The same over the cube of the thinner wire's diameter: scars stay below some 8 % of it.
#: Share of the studies that have any effects, and of the effects that one of these has.
WITH_EFFECTS = 0.6
EACH_EFFECT = 0.25


class _Draw:
    """A source of random numbers."""

    def __init__(self, seed: int, index: int) -> None:
        self._random = np.random.default_rng([seed, index])

    def uniform(self, low: float, high: float) -> float:
        return float(self._random.uniform(low, high))

    def log_uniform(self, low: float, high: float) -> float:
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def happens(self, share: float) -> bool:
        return bool(self._random.random() < share)

    def shape(self) -> str:
        return SHAPES[int(self._random.integers(len(SHAPES)))]


@dataclass(frozen=True)
class _Pair:
    """Two wires that make sense under a load: (moving, fixed)."""

    diameters_mm: tuple[float, float]
    angle_deg: float
    load_N: float
    steel: reference.Elastic
    fixed: reference.Elastic

    kind = "crossed-wires"

    @property
    def lines(self) -> list[str]:
        """Lines of a study's file that state the bodies."""
        return [
            "[wires]",
            f"diameter_mm = {self.diameters_mm[0]!r}",
            f"youngs_modulus_MPa = {self.steel.youngs_modulus_MPa!r}",
            "poissons_ratio = 0.3",
            f"crossing_angle_deg = {self.angle_deg!r}",
            "[wires.fixed]",
            f"diameter_mm = {self.diameters_mm[1]!r}",
            f"youngs_modulus_MPa = {self.fixed.youngs_modulus_MPa!r}",
        ]

    @property
    def hertz(self) -> reference.PointContact:
        """Their fresh contact."""
        radii = self.diameters_mm[0] / 2.0, self.diameters_mm[1] / 2.0
        return reference.hertz_crossed_cylinders(
            self.load_N, *radii, self.angle_deg, first=self.steel, second=self.fixed
        )

    def sliding_threshold_mm(self, friction: float, stiffness_N_per_mm: float) -> float:
        """Displacement at which they begin to slide behind a rig."""
        modulus = reference.tangential_contact_modulus(self.steel, self.fixed)
        tangential = reference.mindlin_stiffness(modulus, self.hertz.contact_radius_mm)
        return 1.5 * friction * self.load_N / tangential + friction * self.load_N / stiffness_N_per_mm


@dataclass(frozen=True)
class _Shapes(_Pair):
    """Two bodies of any shapes, given by their tables."""

    tables: dict[str, dict[str, Any]]

    kind = "point-contact"

    @property
    def lines(self) -> list[str]:
        """Lines of a study's file that state the bodies."""
        return [toml_text({"bodies": self.tables})]

    @property
    def hertz(self) -> reference.PointContact:
        """Their fresh contact."""
        return hertz_of(self.load_N, *LowerAndUpper.model_validate(self.tables).of_test())


def draw(seed: int, index: int) -> str:
    """The TOML of one random study of wires."""
    random = _Draw(seed, index)
    diameters = _diameters(random)
    load, friction = random.log_uniform(*LOAD_N), random.uniform(*FRICTION)
    angle = 90.0 if random.happens(0.4) else random.uniform(*ANGLE_deg)
    motion = 0.0 if random.happens(0.6) else random.uniform(-90.0, 90.0)
    return _drawn(
        random,
        f"random study {index} of seed {seed}",
        friction,
        motion,
        lambda steel, fixed: _Pair(diameters, angle, load, steel, fixed),
    )


def draw_shapes(seed: int, index: int) -> str:
    """The TOML of one random study of bodies of any shapes that touch at a point."""
    random = _Draw(seed, index)
    load, friction = random.log_uniform(*LOAD_ON_SHAPES_N), random.uniform(*FRICTION)

    def touching(lower: reference.Elastic, upper: reference.Elastic) -> _Shapes:
        while True:
            tables = {name: _shape(random, own) for name, own in (("lower", lower), ("upper", upper))}
            diameters = [own[key] for own in tables.values() for key in own if key.startswith("diameter")]
            alike = max(diameters, default=1.0) < 20.0 * min(diameters, default=0.0)
            if alike and LowerAndUpper.model_validate(tables).contradiction() is None:
                found = _Shapes((min(diameters), max(diameters)), 90.0, load, lower, upper, tables)
                room = LARGEST_PRESSURE_MPa / found.hertz.peak_pressure_MPa
                return replace(found, load_N=load * min(room, 1.0) ** 3)

    return _drawn(random, f"random point contact {index} of seed {seed}", friction, 0.0, touching)


def _shape(random: _Draw, material: reference.Elastic) -> dict[str, Any]:
    shape = random.shape()
    own: dict[str, Any] = {"shape": shape, "youngs_modulus_MPa": material.youngs_modulus_MPa, "poissons_ratio": 0.3}
    if shape != "flat":
        own["diameter_mm"] = random.log_uniform(*DIAMETER_OF_SHAPE_mm)
    if shape == "barrel":
        own["diameter_along_mm"] = own["diameter_mm"] * random.log_uniform(0.2, 5.0)
    if shape == "tube":
        own["bore_mm"] = own["diameter_mm"] * random.uniform(*BORE_PER_DIAMETER)
    if shape in ("wire", "tube") and random.happens(0.3):
        own["held_at"] = "ends"
    return own | {"axis_angle_deg": random.uniform(-90.0, 90.0)}


def _drawn(
    random: _Draw,
    name: str,
    friction: float,
    motion: float,
    pair_of: Callable[[reference.Elastic, reference.Elastic], _Pair],
) -> str:
    rigid = random.happens(RIGID_SHARE)
    stiffness = random.log_uniform(*RIG_N_per_mm)
    steel = reference.Elastic(MODULUS_MPa[1], 0.3)
    fixed = reference.Elastic(random.uniform(*MODULUS_MPa), 0.3) if random.happens(0.3) else steel
    pair = pair_of(steel, fixed)
    room = LARGEST_CONTACT * min(pair.diameters_mm) / pair.hertz.major_semi_axis_mm
    if room < 1.0:
        pair = replace(pair, load_N=pair.load_N * room**3)
    load, hertz, diameters = pair.load_N, pair.hertz, pair.diameters_mm
    threshold = pair.sliding_threshold_mm(friction, math.inf if rigid else stiffness)
    longest = max(MOST_STROKE_PER_RADIUS * hertz.contact_radius_mm, 1.2 * threshold)
    amplitude = min(random.log_uniform(STROKE_PER_THRESHOLD * threshold, longest), 0.9 * min(diameters))
    amplitude = max(amplitude, LEAST_AMPLITUDE_mm)
    volume = random.log_uniform(*VOLUME_PER_CONTACT) * math.pi * hertz.contact_radius_mm**2 * hertz.approach_mm
    volume = min(volume, LARGEST_VOLUME * min(diameters) ** 3)
    energy_J = 4e-3 * friction * load * amplitude * CYCLES
    held, quoted = random.happens(0.1), '"rigid"'
    approach = [f"approach_um = {1e3 * hertz.approach_mm * random.uniform(1.0, 3.0)!r}"] if held else []
    return "\n".join(
        [
            "format = 1",
            f'name = "{name}"',
            f'kind = "{pair.kind}"',
            *pair.lines,
            "[conditions]",
            f"normal_load_N = {load!r}",
            f"displacement_amplitude_um = {1e3 * amplitude!r}",
            f"motion_angle_deg = {motion!r}",
            "frequency_Hz = 1.0",
            f"cycles = {CYCLES}",
            *approach,
            *_contact(random, friction),
            *_wear(random, min(volume / energy_J, 9e-3), friction, energy_J),
            "[holder]",
            f"tangential_stiffness_N_per_mm = {quoted if rigid else repr(stiffness)}",
            *_rotation(random),
            *([] if held or random.happens(0.8) else [f"normal_spring_stiffness_N_per_mm = {_spring(random, load)!r}"]),
            "[log]",
            f"loop_cycles = [1, 10, 30, 100, 300, 1000, 3000, {CYCLES}]",
            *_effects(random, held, friction, amplitude, pair),
        ]
    )


def _diameters(random: _Draw) -> tuple[float, float]:
    moving, fixed = (random.log_uniform(*DIAMETER_mm) for _ in range(2))
    if random.happens(0.5):
        fixed = moving
    # Very unequal wires are not what a crossed-wire test uses.
    return moving, min(max(fixed, moving / 2.5), moving * 2.5)


def _contact(random: _Draw, friction: float) -> list[str]:
    lines = [
        "[contact]",
        f"friction = {friction!r}",
        f'primary_wire = "{"moving" if random.happens(0.3) else "fixed"}"',
    ]
    if random.happens(0.1):
        strength = random.log_uniform(100.0, 1e3)
        lines.append(f'friction_law = {{name = "shear-limited", shear_strength_MPa = {strength!r}}}')
    return lines


def _wear(random: _Draw, per_J: float, friction: float, energy_J: float) -> list[str]:
    law = f"energy_wear_coefficient_mm3_per_J = {per_J!r}"
    if random.happens(0.3):
        law = f"archard_wear_coefficient_mm3_per_N_m = {min(per_J * friction, 9e-3)!r}"
    lines = ["[wear]", law, f"moving_share = {random.uniform(0.0, 1.0) if random.happens(0.5) else 0.5!r}"]
    if random.happens(0.2):
        by, end = ("cycles", float(CYCLES)) if random.happens(0.5) else ("energy_J", energy_J)
        first, last = random.log_uniform(0.3, 3.0), random.log_uniform(0.3, 3.0)
        lines += [
            f'variation = "{by}"',
            f"variation_points = [[0, {first!r}], [{random.uniform(0.1, 0.9) * end!r}, {last!r}]]",
        ]
    return lines


def _rotation(random: _Draw) -> list[str]:
    if not random.happens(0.15):
        return []
    height = random.log_uniform(1.0, 20.0)
    return [
        f"rotational_stiffness_N_mm_per_rad = {random.log_uniform(100.0, RIG_N_per_mm[1]) * height**2!r}",
        f"pivot_height_mm = {height!r}",
    ]


def _spring(random: _Draw, load: float) -> float:
    """A loading spring that gives way by 0.1 to 3 mm under the load, N/mm."""
    return load / random.log_uniform(0.1, 3.0)


def _effects(random: _Draw, held: bool, friction: float, amplitude_mm: float, pair: _Pair) -> list[str]:
    if not random.happens(WITH_EFFECTS):
        return []
    amplitude, approach, angle = 1e3 * amplitude_mm, 1e3 * pair.hertz.approach_mm, pair.angle_deg
    ends = random.uniform(0.5, 1.5), random.uniform(0.5, 1.5)
    wears = random.log_uniform(0.3, 3.0), random.log_uniform(0.3, 3.0)
    # The crossing angle as it truly is must stay within its range too.
    turned = random.uniform(-5.0, 5.0 if angle <= 85.0 else 0.0) if angle >= 35.0 else random.uniform(0.0, 5.0)
    every = {
        "free_play": f"gap_um = {random.uniform(0.05, 0.8) * amplitude!r}",
        "roughness_compliance": f"layer_um = {random.log_uniform(0.05, 1.0) * approach!r}\n"
        f"cycles = {random.log_uniform(30.0, 1e5)!r}",
        "third_body": f"retained_fraction = {random.uniform(0.05, 0.7)!r}\n"
        f"modulus_MPa = {random.log_uniform(100.0, 5e4)!r}",
        "misalignment": f"angle_deg = {random.uniform(-3.0, 3.0)!r}",
        "plasticity": f"flattening_um = {random.log_uniform(0.05, 1.0) * approach!r}",
        "crossing_angle_error": f"angle_deg = {turned!r}",
        "friction_evolution": f"initial = {ends[0] * friction!r}\nfinal = {ends[1] * friction!r}\n"
        f"cycles = {random.log_uniform(30.0, CYCLES)!r}",
        "wear_rate_evolution": f"initial_factor = {wears[0]!r}\nfinal_factor = {wears[1]!r}\n"
        f"cycles = {random.log_uniform(30.0, CYCLES)!r}",
        "normal_load_drift": f"fraction_per_100k_cycles = {random.uniform(-0.9, 2.0)!r}",
    }
    needs_load = {"misalignment", "normal_load_drift", "plasticity"}
    of_wires = {"crossing_angle_error"} if pair.kind != _Pair.kind else set()
    left = of_wires | (needs_load if held else set())
    chosen = [name for name in every if random.happens(EACH_EFFECT) and name not in left]
    return [f'[[effects]]\nname = "{name}"\n{every[name]}' for name in chosen]
