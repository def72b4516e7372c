"""What owners of rigs state: the steel-wire test of the article, tests drawn around it, tests of balls on flats."""

from dataclasses import dataclass, replace
from math import hypot, pi, radians, sin, tan
from typing import Any, ClassVar, Self

import numpy as np

#: Largest share of the stroke that a stated holder may take, and of the radius that the expected scar may reach.
MOST_LOST, WIDEST_SCAR = 0.2, 0.57
MATERIALS_MPa = ((210000.0, 0.3), (193000.0, 0.29), (116000.0, 0.32))


@dataclass(frozen=True)
class Nominal:
    """Wires, conditions and statements of a record; `stiffness_N_per_mm` None is a holder assumed rigid.

    bodies: names of the driven and the held one.
    """

    kind: ClassVar[str] = "crossed-wires"
    bodies: ClassVar[tuple[str, str]] = ("moving", "fixed")

    diameter_mm: float = 0.45
    youngs_modulus_MPa: float = 210000.0
    poissons_ratio: float = 0.3
    load_N: float = 2.0
    amplitude_um: float = 60.0
    frequency_Hz: float = 3.0
    cycles: int = 100000
    friction: float = 0.62
    wear_mm3_per_J: float = 3e-5
    stiffness_N_per_mm: float | None = 167.0
    spring_N_per_mm: float = 1.0
    crossing_angle_deg: float = 90.0

    @property
    def elastic(self) -> dict[str, float]:
        """The material of both bodies."""
        return {"youngs_modulus_MPa": self.youngs_modulus_MPa, "poissons_ratio": self.poissons_ratio}

    @property
    def tables(self) -> dict[str, Any]:
        """The bodies, in the words of records and studies alike."""
        elastic, angle = self.elastic, self.crossing_angle_deg
        return {"wires": {"diameter_mm": self.diameter_mm, **elastic, "crossing_angle_deg": angle}}

    @property
    def stated(self) -> dict[str, float]:
        """What its owner states besides the rig's stiffness."""
        return {
            "friction": self.friction,
            "energy_wear_coefficient_mm3_per_J": self.wear_mm3_per_J,
            "normal_spring_stiffness_N_per_mm": self.spring_N_per_mm,
        }

    @property
    def expected_scar_mm(self) -> float:
        """Half-width of the scar, V = π R h² of crossed wires (a scar longer than the stroke)."""
        energy_J = 4e-6 * self.friction * self.load_N * self.amplitude_um * self.cycles
        return float((2.0 * self.diameter_mm * self.wear_mm3_per_J * energy_J / pi) ** 0.25)

    @property
    def scar_reach_mm(self) -> tuple[float, float]:
        """How far that scar reaches along and across the motion: the gap of wires cut off by a plane, as at 90°."""
        half = 0.5 * radians(self.crossing_angle_deg)
        along, across = (sin(2.0 * half) ** 0.25 * own for own in (hypot(1.0 / tan(half), tan(half)) / 2.0**0.5, 1.0))
        return self.expected_scar_mm * round(along, 12), self.expected_scar_mm * round(across, 12)

    @classmethod
    def drawn(cls, random: np.random.Generator) -> Self:
        """One around the article's."""
        modulus, ratio = MATERIALS_MPa[random.integers(len(MATERIALS_MPa))]
        stiffness = (
            None if random.random() < 0.3 else round(float(np.exp(random.uniform(np.log(80.0), np.log(600.0)))), 0)
        )
        return cls(
            diameter_mm=float(random.choice([0.3, 0.4, 0.5, 0.6, 0.8])),
            youngs_modulus_MPa=modulus,
            poissons_ratio=ratio,
            load_N=round(random.uniform(1.0, 4.0), 1),
            amplitude_um=round(random.uniform(30.0, 80.0)),
            frequency_Hz=float(random.choice([1.0, 2.0, 3.0, 5.0, 10.0])),
            cycles=int(random.choice([20000, 50000, 100000, 200000])),
            friction=round(random.uniform(0.45, 0.8), 2),
            wear_mm3_per_J=float(f"{np.exp(random.uniform(np.log(8e-6), np.log(5e-5))):.1e}"),
            stiffness_N_per_mm=stiffness,
            spring_N_per_mm=float(random.choice([0.5, 1.0, 2.0, 5.0])),
        )


class TurnedWires(Nominal):
    """Wires that cross at any angle, the moving one along its axis."""

    @classmethod
    def drawn(cls, random: np.random.Generator) -> Self:
        """A test of wires that cross at 15 to 75°."""
        return replace(super().drawn(random), crossing_angle_deg=round(random.uniform(15.0, 75.0)))


@dataclass(frozen=True)
class BallNominal(Nominal):
    """A ball on a flat of the same material, by default half an inch of steel: the gap of wires of that diameter."""

    kind: ClassVar[str] = "ball-on-flat"
    bodies: ClassVar[tuple[str, str]] = ("flat", "ball")

    diameter_mm: float = 12.7
    load_N: float = 100.0
    amplitude_um: float = 50.0
    frequency_Hz: float = 10.0
    cycles: int = 20000
    wear_mm3_per_J: float = 2e-5
    stiffness_N_per_mm: float | None = 20000.0
    spring_N_per_mm: float = 0.0

    @property
    def tables(self) -> dict[str, Any]:
        """A ball held above a driven flat."""
        return {"bodies": {"ball": {"diameter_mm": self.diameter_mm, **self.elastic}, "flat": self.elastic}}

    @classmethod
    def drawn(cls, random: np.random.Generator) -> Self:
        """What machines of the standard ASTM G204 press and move."""
        modulus, ratio = MATERIALS_MPa[random.integers(len(MATERIALS_MPa))]
        stiffness = None if random.random() < 0.3 else float(f"{np.exp(random.uniform(np.log(4e3), np.log(4e4))):.2g}")
        return cls(
            diameter_mm=float(random.choice([6.0, 10.0, 12.7, 20.0, 25.4])),
            youngs_modulus_MPa=modulus,
            poissons_ratio=ratio,
            load_N=round(random.uniform(20.0, 150.0)),
            amplitude_um=round(random.uniform(25.0, 100.0)),
            frequency_Hz=float(random.choice([5.0, 10.0, 20.0])),
            cycles=int(random.choice([5000, 10000, 20000, 50000])),
            friction=round(random.uniform(0.4, 0.8), 2),
            wear_mm3_per_J=float(f"{np.exp(random.uniform(np.log(5e-6), np.log(4e-5))):.1e}"),
            stiffness_N_per_mm=stiffness,
        )


def drawn_nominals(number: int, random: np.random.Generator, kind: type[Nominal] = Nominal) -> tuple[Nominal, ...]:
    """The first test of a kind, the article's of wires, and `number` − 1 others."""
    drawn = [kind()]
    while len(drawn) < number:
        nominal = kind.drawn(random)
        lost_um = (
            0.0
            if nominal.stiffness_N_per_mm is None
            else 1e3 * nominal.friction * nominal.load_N / nominal.stiffness_N_per_mm
        )
        if (
            lost_um < MOST_LOST * nominal.amplitude_um
            and nominal.expected_scar_mm < WIDEST_SCAR * nominal.diameter_mm / 2
        ):
            drawn.append(nominal)
    return tuple(drawn)
