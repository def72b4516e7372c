"""What owners of line-contact rigs believe: McColl's test of steel, and tests drawn around it."""

from dataclasses import dataclass

import numpy as np

#: Largest share of the stroke that a stated holder may take, and that the bodies and the holder may take together.
MOST_LOST, MOST_TAKEN = 0.15, 0.3

#: Half-width of the expected scar over the radius, and its depth in µm, within which tests are drawn.
WIDEST_SCAR, DEPTHS_um = 0.12, (0.8, 12.0)

MATERIALS_MPa = ((200000.0, 0.3), (116000.0, 0.32), (210000.0, 0.3), (70000.0, 0.33))

#: Tangential displacement over force per mm of bodies of 10 mm, times the contact modulus; a rough figure for drawing.
_SOFTNESS = 8.0


@dataclass(frozen=True)
class LineNominal:
    """Bodies, conditions and statements of a record; `stiffness_N_per_mm` None is a holder assumed rigid."""

    radius_mm: float = 6.0
    length_mm: float = 10.0
    pad_MPa: tuple[float, float] = MATERIALS_MPa[0]
    specimen_MPa: tuple[float, float] = MATERIALS_MPa[0]
    load_N: float = 185.0
    amplitude_um: float = 25.0
    frequency_Hz: float = 20.0
    cycles: int = 18000
    friction: float = 0.9
    pad_wear_mm3_per_J: float = 2.1e-5
    specimen_wear_mm3_per_J: float = 3.2e-5
    stiffness_N_per_mm: float | None = None

    @property
    def expected_area_mm2(self) -> float:
        """Cross-section that both bodies lose in gross slip on a rigid rig."""
        energy_J = 4e-6 * self.friction * self.load_N * self.amplitude_um * self.cycles
        return (self.pad_wear_mm3_per_J + self.specimen_wear_mm3_per_J) * energy_J / self.length_mm

    @property
    def expected_scar_mm(self) -> float:
        """Half-width of the scar: a chord of the cylinder with that area, A = 2 w³/(3 R)."""
        return float((1.5 * self.radius_mm * self.expected_area_mm2) ** (1.0 / 3.0))

    @property
    def expected_depth_um(self) -> float:
        """Depth of both bodies together."""
        return 500.0 * self.expected_scar_mm**2 / self.radius_mm

    @property
    def taken_um(self) -> float:
        """Part of the amplitude that bodies and holder take."""
        force = self.friction * self.load_N
        modulus = 1.0 / sum((1.0 - ratio**2) / young for young, ratio in (self.pad_MPa, self.specimen_MPa))
        bodies = 1e3 * _SOFTNESS * force / self.length_mm / modulus
        return bodies + (0.0 if self.stiffness_N_per_mm is None else 1e3 * force / self.stiffness_N_per_mm)

    @property
    def sensible(self) -> bool:
        """Whether it slides over most of the stroke and wears a scar that fits on the bodies."""
        held = self.stiffness_N_per_mm
        lost = 0.0 if held is None else 1e3 * self.friction * self.load_N / held
        low, high = DEPTHS_um
        return (
            lost < MOST_LOST * self.amplitude_um
            and self.taken_um < MOST_TAKEN * self.amplitude_um
            and self.expected_scar_mm < WIDEST_SCAR * self.radius_mm
            and low < self.expected_depth_um < high
        )


def drawn_line_nominals(number: int, random: np.random.Generator) -> tuple[LineNominal, ...]:
    """So many nominal tests, McColl's first."""
    drawn = [LineNominal()]
    while len(drawn) < number:
        nominal = _drawn(random)
        if nominal.sensible:
            drawn.append(nominal)
    return tuple(drawn)


def _drawn(random: np.random.Generator) -> LineNominal:
    pad = MATERIALS_MPa[random.integers(len(MATERIALS_MPa))]
    specimen = pad if random.random() < 0.6 else MATERIALS_MPa[random.integers(len(MATERIALS_MPa))]
    length = float(random.choice([4.0, 6.0, 8.0, 10.0]))
    both = float(np.exp(random.uniform(np.log(1e-5), np.log(1.5e-4))))
    share = random.uniform(0.3, 0.7)
    stiffness = None if random.random() < 0.4 else float(round(length * np.exp(random.uniform(6.5, 9.0)), -2))
    return LineNominal(
        radius_mm=float(random.choice([5.0, 6.0, 10.0, 15.0, 20.0])),
        length_mm=length,
        pad_MPa=pad,
        specimen_MPa=specimen,
        load_N=float(round(length * np.exp(random.uniform(np.log(8.0), np.log(80.0))))),
        amplitude_um=float(round(random.uniform(20.0, 70.0))),
        frequency_Hz=float(random.choice([1.0, 2.0, 5.0, 10.0, 20.0])),
        cycles=int(random.choice([5000, 10000, 20000, 50000])),
        friction=round(random.uniform(0.5, 0.95), 2),
        pad_wear_mm3_per_J=float(f"{both * share:.2e}"),
        specimen_wear_mm3_per_J=float(f"{both * (1.0 - share):.2e}"),
        stiffness_N_per_mm=stiffness,
    )
