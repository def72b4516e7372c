"""What owners of rigs believe: the steel-wire test of the article, and tests drawn around it."""

from dataclasses import dataclass
from math import pi

import numpy as np

#: Largest share of the stroke that a stated holder may take, and of the radius that the expected scar may reach.
MOST_LOST, WIDEST_SCAR = 0.2, 0.57
MATERIALS_MPa = ((210000.0, 0.3), (193000.0, 0.29), (116000.0, 0.32))


@dataclass(frozen=True)
class Nominal:
    """Wires, conditions and statements of a record; `stiffness_N_per_mm` None is a holder believed rigid."""

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

    @property
    def expected_scar_mm(self) -> float:
        """Half-width of the scar, V = π R h² of crossed wires (a scar longer than the stroke)."""
        energy_J = 4e-6 * self.friction * self.load_N * self.amplitude_um * self.cycles
        return float((2.0 * self.diameter_mm * self.wear_mm3_per_J * energy_J / pi) ** 0.25)


def drawn_nominals(number: int, random: np.random.Generator) -> tuple[Nominal, ...]:
    """The article's test, and `number` − 1 others."""
    drawn = [Nominal()]
    while len(drawn) < number:
        nominal = _drawn(random)
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


def _drawn(random: np.random.Generator) -> Nominal:
    modulus, ratio = MATERIALS_MPa[random.integers(len(MATERIALS_MPa))]
    stiffness = None if random.random() < 0.3 else round(float(np.exp(random.uniform(np.log(80.0), np.log(600.0)))), 0)
    return Nominal(
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
