"""Tests by others: wires of other materials, sizes and angles than the article's, lines on shallow bodies, balls on
flats in partial slip, joints, and wires under programmes of blocks.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import cos, pi, radians
from typing import Any, ClassVar

import numpy as np

from studies.blind.generators.line_nominal import LineNominal
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.other_simulators.pair import SHARES, Array

#: Simulators that may be looked at, and those for scoring alone; of each, tests take turns.
SIMULATORS = {
    "development": ("foundation", "strips"),
    "scoring": ("half_space", "layers", "half_space"),
    "sticking": ("sticking",),
    "joints": ("joint",),
    "programmes": ("blocks",),
    "held": ("energy", "force"),
    "swinging": ("swinging",),
}

#: Aluminium, titanium, bronze, zirconia's like, steel: Young's modulus and Poisson's ratio.
MATERIALS_MPa = (
    (70000.0, 0.33),
    (114000.0, 0.32),
    (128000.0, 0.34),
    (205000.0, 0.3),
    (193000.0, 0.29),
    (210000.0, 0.3),
)

LARGEST_FALL = 0.35  #: How far a pad's face falls over its height at most, so that it is a layer.
#: Part of the stroke that bodies of line contacts take; what rims and sides add to a layer is a tenth of it or less.
MOST_OF_BODIES = 0.08

#: Most of the stroke that contact and rig take, widest scar over the radius, scars' depths of both bodies [mm], least
#: energy of a cycle [mJ] (five digits of it are written), and scars' half-lengths over the amplitude.
MOST_TAKEN, WIDEST, DEPTHS_mm, LEAST_mJ, LENGTHS = 0.25, 0.4, (1e-3, 0.05), 5e-3, (0.3, 12.0)
#: Of partial slip: force over friction's limit, strokes, and largest pressure.
REACHED, STROKES_um, LARGEST_MPa = (0.3, 0.97), (0.4, 20.0), 2500.0
#: Of joints: part of the stroke that their own stiffness takes, and by how much their sliders' limits differ.
JOINT_TAKES, SPREAD = (0.02, 0.35), (0.0, 0.2)
#: Share of a joint's load by which it swings.
SWING = (0.15, 0.6)
#: Of held energies: over what sliding over the whole stroke would dissipate.
HELD = (0.4, 0.75)
#: Of programmes: load and stroke of a block over the largest ones, and how often the blocks take turns.
LIGHTER, SHORTER, TURNS = (0.5, 1.0), (0.5, 0.9), (1, 4)


@dataclass(frozen=True)
class Block:
    """Cycles under a load and a stroke of their own."""

    cycles: int
    load_N: float
    amplitude_um: float

    @property
    def table(self) -> dict[str, Any]:
        """A block of a record's programme."""
        own = {"normal_load_N": self.load_N, "displacement_amplitude_um": self.amplitude_um}
        return {"cycles": self.cycles, "conditions": own}


@dataclass(frozen=True)
class WireTest(Nominal):
    """Crossed wires, and who simulates them.

    blocks: of cycles, which take turns; none if load and stroke remain. held: key and value of what the drive holds
    in place of its stroke. swing: share of the load by which it swings in a cycle, and how often. slides, wears:
    whether the contact must slide, and whether it wears. hides: by which part of the range of sizes effects are drawn
    larger. looser: share of what bodies give way by that nobody knows. shares: of the load, where it is traced.
    """

    slides: ClassVar[bool] = True
    wears: ClassVar[bool] = True
    hides: ClassVar[float] = 0.0
    looser: ClassVar[float] = 0.0
    shares: ClassVar[Array] = SHARES

    simulator: str = "foundation"
    crossing_angle_deg: float = 90.0
    blocks: tuple[Block, ...] = ()
    held: tuple[str, float] | None = None
    swing: tuple[float, int] | None = None

    @property
    def ends(self) -> tuple[int, ...]:
        """Cycles with which its blocks end."""
        if not self.blocks:
            return ()
        lengths = [block.cycles for block in self.blocks]
        return tuple(np.cumsum(lengths * (self.cycles // sum(lengths))).tolist())

    @property
    def modulus_MPa(self) -> float:
        """Combined plane-strain modulus E*."""
        return 0.5 * self.youngs_modulus_MPa / (1.0 - self.poissons_ratio**2)

    @property
    def easier(self) -> float:
        """Mindlin's ratio of tangential to normal compliance."""
        return (2.0 - self.poissons_ratio) / (2.0 - 2.0 * self.poissons_ratio)

    @property
    def hertz_mm(self) -> float:
        """Radius of the fresh contact at a right angle."""
        return float((0.375 * self.load_N * self.diameter_mm / self.modulus_MPa) ** (1.0 / 3.0))

    @property
    def elongation(self) -> float:
        """How much longer the scar of oblique wires is than that of wires at a right angle."""
        return float((1.0 - abs(cos(radians(self.crossing_angle_deg)))) ** -0.5)

    @property
    def gives_mm(self) -> float:
        """What half-spaces give way by where all slides (Mindlin)."""
        return self.friction * self.easier * 2.0 * self.hertz_mm**2 / self.diameter_mm

    @property
    def unsure_mm(self) -> float:
        """What nobody knows of that: 3 % of a sticking ball's compliance."""
        return self.looser * self.gives_mm

    @property
    def sensible(self) -> bool:
        """Whether it slides over most of its stroke and wears a scar that can be measured."""
        scar, amplitude, taken = self.expected_scar_mm, 1e-3 * self.amplitude_um, self.gives_mm
        if self.stiffness_N_per_mm is not None:
            taken += self.friction * self.load_N / self.stiffness_N_per_mm
        return (
            taken < MOST_TAKEN * amplitude
            and 1.3 * self.hertz_mm < scar < 0.5 * WIDEST * self.diameter_mm
            and DEPTHS_mm[0] < scar**2 / self.diameter_mm < DEPTHS_mm[1]
            and 4.0 * self.friction * self.load_N * amplitude > LEAST_mJ
            and LENGTHS[0] * amplitude < scar < LENGTHS[1] * amplitude
        )


@dataclass(frozen=True)
class LineTest(LineNominal):
    """A cylinder on a flat, both shallow, so that they are elastic layers."""

    slides: ClassVar[bool] = True
    wears: ClassVar[bool] = True
    hides: ClassVar[float] = 0.0
    unsure_mm: ClassVar[float] = 0.0
    blocks: ClassVar[tuple[Block, ...]] = ()
    held: ClassVar[None] = None
    swing: ClassVar[None] = None
    ends: ClassVar[tuple[int, ...]] = ()

    simulator: str = "layers"
    elongation: float = 1.0
    heights_mm: tuple[float, float] = (4.0, 4.0)

    @property
    def half_widths_mm(self) -> tuple[float, float]:
        """Of pad and specimen, along the motion."""
        pad, specimen = self.heights_mm
        return 2.0 * pad, 3.0 * specimen

    @property
    def sensible(self) -> bool:
        """Whether it slides over most of its stroke, and the pad is a layer: its face falls by few of its height."""
        flat = self.half_widths_mm[0] ** 2 / (2.0 * self.radius_mm) < LARGEST_FALL * self.heights_mm[0]
        bodies_um = replace(self, stiffness_N_per_mm=None).taken_um
        return super().sensible and flat and bodies_um < MOST_OF_BODIES * self.amplitude_um


@dataclass(frozen=True)
class StickingTest(WireTest):
    """A ball on a flat of its material whose middle sticks: few cycles, in which nothing wears."""

    kind: ClassVar[str] = "ball-on-flat"
    bodies: ClassVar[tuple[str, str]] = ("flat", "ball")
    slides: ClassVar[bool] = False
    wears: ClassVar[bool] = False
    hides: ClassVar[float] = 0.5
    looser: ClassVar[float] = 0.02
    #: Cores whose sizes are close where little slips.
    shares: ClassVar[Array] = (1.0 - np.linspace(0.95, 0.0, 36) ** 2) ** 3

    simulator: str = "sticking"

    @property
    def tables(self) -> dict[str, Any]:
        """A ball held above a driven flat."""
        return {"bodies": {"ball": {"diameter_mm": self.diameter_mm, **self.elastic}, "flat": self.elastic}}

    def way_um(self, reached: float) -> float:
        """Amplitude of the stroke that comes to a share of friction's limit."""
        own_mm = self.gives_mm * float(1.0 - (1.0 - reached) ** (2.0 / 3.0))
        return 1e3 * (own_mm + reached * self.friction * self.load_N / (self.stiffness_N_per_mm or np.inf))

    @property
    def sensible(self) -> bool:
        """Whether it moves by what a sensor resolves, and the metal does not yield."""
        peak_MPa = 1.5 * self.load_N / (pi * self.hertz_mm**2)
        return STROKES_um[0] < self.amplitude_um < STROKES_um[1] and peak_MPa < LARGEST_MPa


@dataclass(frozen=True)
class JointTest(WireTest):
    """A joint of known friction and stiffness; spread: by which part its sliders' limits lie around their mean."""

    kind: ClassVar[str] = "joint"
    wears: ClassVar[bool] = False

    simulator: str = "joint"
    own_N_per_mm: float = 1000.0
    spread: float = 0.1

    @property
    def tables(self) -> dict[str, Any]:
        """The joint's own stiffness."""
        return {"contact": {"kind": self.kind, "contact_stiffness_N_per_mm": self.own_N_per_mm}}

    @property
    def stated(self) -> dict[str, float]:
        """`[stated]` of its record by key: the coefficient of friction, and no wear."""
        return {"friction": self.friction}

    @property
    def sensible(self) -> bool:
        """Whether the energy of a cycle can be written."""
        return 4.0 * self.friction * self.load_N * 1e-3 * self.amplitude_um > LEAST_mJ


Test = WireTest | LineTest


def drawn_tests(number: int, simulators: Sequence[str], random: np.random.Generator) -> tuple[Test, ...]:
    """So many different tests; simulators take turns."""
    drawn: list[Test] = []
    while len(drawn) < number:
        simulator = simulators[len(drawn) % len(simulators)]
        drawing = _of_others.get(simulator)
        test = drawing(random) if drawing else _drawn_wires(simulator, random)
        if test.sensible:
            drawn.append(test)
    return tuple(drawn)


def _drawn_wires(simulator: str, random: np.random.Generator) -> WireTest:
    modulus, ratio = MATERIALS_MPa[random.integers(len(MATERIALS_MPa))]
    friction, load, amplitude = (
        round(random.uniform(0.3, 0.95), 2),
        _digits(random, 0.2, 50.0),
        _digits(random, 2.0, 100.0),
    )
    turned = simulator != "strips" and random.random() < 0.4
    return WireTest(
        diameter_mm=_digits(random, 0.3, 10.0),
        youngs_modulus_MPa=modulus,
        poissons_ratio=ratio,
        load_N=load,
        amplitude_um=amplitude,
        frequency_Hz=_digits(random, 0.5, 40.0),
        cycles=int(_digits(random, 5e3, 3e5, 1)),
        friction=friction,
        wear_mm3_per_J=_digits(random, 2e-6, 1e-4),
        stiffness_N_per_mm=None if random.random() < 0.25 else _stiffness(friction * load, amplitude, random),
        spring_N_per_mm=0.0 if random.random() < 0.5 else _digits(random, 0.1, 1.0),
        simulator=simulator,
        crossing_angle_deg=float(random.choice([60.0, 70.0, 75.0, 80.0])) if turned else 90.0,
    )


def _drawn_in_blocks(random: np.random.Generator) -> WireTest:
    """Wires of which two or three blocks take turns in any order; one has the test's own load and stroke."""
    test = _drawn_wires("half_space", random)
    count, turns = int(random.integers(2, 4)), int(random.integers(*TURNS))
    shares = random.dirichlet([4.0] * count)
    blocks = [Block(max(int(test.cycles * shares[0] / turns), 50), test.load_N, test.amplitude_um)]
    for share in shares[1:]:
        load, stroke = test.load_N * random.uniform(*LIGHTER), test.amplitude_um * random.uniform(*SHORTER)
        blocks.append(Block(max(int(test.cycles * share / turns), 50), float(f"{load:.2g}"), float(f"{stroke:.2g}")))
    order = random.permutation(count)
    cycles = turns * sum(block.cycles for block in blocks)
    return replace(test, cycles=cycles, blocks=tuple(blocks[place] for place in order))


def _drawn_holding_energy(random: np.random.Generator) -> WireTest:
    test = _drawn_wires("half_space", random)
    energy = 4e-3 * test.friction * test.load_N * test.amplitude_um * random.uniform(*HELD)
    return replace(test, held=("held_energy_mJ", float(f"{energy:.3g}")))


def _drawn_holding_force(random: np.random.Generator) -> StickingTest:
    test, reached = _drawn_sticking(random), random.uniform(*REACHED)
    held = "held_tangential_force_N", float(f"{reached * test.friction * test.load_N:.3g}")
    return replace(test, amplitude_um=float(f"{1.6 * test.way_um(reached):.3g}"), held=held)


def _drawn_sticking(random: np.random.Generator) -> StickingTest:
    modulus, ratio = MATERIALS_MPa[random.integers(len(MATERIALS_MPa))]
    friction, reached = round(random.uniform(0.3, 0.95), 2), random.uniform(*REACHED)
    test = StickingTest(
        diameter_mm=_digits(random, 5.0, 30.0),
        youngs_modulus_MPa=modulus,
        poissons_ratio=ratio,
        load_N=_digits(random, 5.0, 200.0),
        frequency_Hz=_digits(random, 0.5, 40.0),
        cycles=int(_digits(random, 2e2, 5e3, 1)),
        friction=friction,
        wear_mm3_per_J=1e-9,
        stiffness_N_per_mm=None,
        spring_N_per_mm=0.0,
    )
    if random.random() > 0.25:
        # A fifth to five times the contact's stiffness.
        own = friction * test.load_N / test.gives_mm * np.exp(random.uniform(-1.0, 1.0) * np.log(5.0))
        test = replace(test, stiffness_N_per_mm=float(f"{own:.3g}"))
    return replace(test, amplitude_um=float(f"{test.way_um(reached):.3g}"))


def _drawn_joint(random: np.random.Generator) -> JointTest:
    friction, load, amplitude = (
        round(random.uniform(0.1, 0.8), 2),
        _digits(random, 5.0, 5000.0),
        _digits(random, 5.0, 3000.0),
    )
    limit, taken = friction * load, np.exp(random.uniform(*np.log(JOINT_TAKES)))
    return JointTest(
        load_N=load,
        amplitude_um=amplitude,
        frequency_Hz=_digits(random, 0.1, 20.0),
        cycles=int(_digits(random, 3e1, 1e5, 1)),
        friction=friction,
        stiffness_N_per_mm=None if random.random() < 0.25 else _stiffness(limit, amplitude, random),
        spring_N_per_mm=0.0,
        own_N_per_mm=float(f"{1e3 * limit / (amplitude * taken):.3g}"),
        spread=random.uniform(*SPREAD),
    )


def _drawn_swinging(random: np.random.Generator) -> JointTest:
    return replace(_drawn_joint(random), swing=(round(random.uniform(*SWING), 2), int(random.integers(1, 3))))


def _drawn_line(random: np.random.Generator) -> LineTest:
    pad = MATERIALS_MPa[random.integers(len(MATERIALS_MPa))]
    specimen = pad if random.random() < 0.5 else MATERIALS_MPa[random.integers(len(MATERIALS_MPa))]
    length, friction, amplitude = (
        float(random.choice([3.0, 5.0, 8.0])),
        round(random.uniform(0.4, 0.9), 2),
        _digits(random, 10.0, 80.0),
    )
    load = _digits(random, 8.0 * length, 70.0 * length)
    both, share = random.uniform(np.log(5e-6), np.log(1.5e-4)), random.uniform(0.35, 0.65)
    return LineTest(
        radius_mm=float(random.choice([15.0, 20.0, 30.0, 40.0])),
        length_mm=length,
        pad_MPa=pad,
        specimen_MPa=specimen,
        load_N=load,
        amplitude_um=amplitude,
        frequency_Hz=_digits(random, 1.0, 30.0),
        cycles=int(_digits(random, 4e3, 1e5, 1)),
        friction=friction,
        pad_wear_mm3_per_J=float(f"{np.exp(both) * share:.2g}"),
        specimen_wear_mm3_per_J=float(f"{np.exp(both) * (1.0 - share):.2g}"),
        stiffness_N_per_mm=None if random.random() < 0.4 else _stiffness(friction * load, amplitude, random),
        heights_mm=(float(random.choice([2.0, 2.5, 3.0])), float(random.choice([3.0, 5.0, 8.0]))),
    )


_of_others: Mapping[str, Callable[[np.random.Generator], Test]]
_of_others = {
    "layers": _drawn_line,
    "sticking": _drawn_sticking,
    "joint": _drawn_joint,
    "blocks": _drawn_in_blocks,
    "energy": _drawn_holding_energy,
    "force": _drawn_holding_force,
    "swinging": _drawn_swinging,
}


def _digits(random: np.random.Generator, low: float, high: float, digits: int = 2) -> float:
    """A value between two, evenly in its logarithm, of so many digits."""
    return float(f"{np.exp(random.uniform(np.log(low), np.log(high))):.{digits}g}")


def _stiffness(force_N: float, amplitude_um: float, random: np.random.Generator) -> float:
    """Of a rig that takes 2 to 15 % of the stroke."""
    return float(f"{1e3 * force_N / (amplitude_um * np.exp(random.uniform(np.log(0.02), np.log(0.15)))):.3g}")


def expected_pressure_MPa(test: Test) -> float:
    """Mean pressure on the scar that is expected in the end."""
    scar = test.expected_scar_mm
    return test.load_N / (2.0 * scar * test.length_mm if isinstance(test, LineTest) else pi * scar**2)
