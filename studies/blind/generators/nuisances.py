"""What is different from record to record without being an effect: scatter, noise, waveform, channels, cycle lists."""

from dataclasses import dataclass

import numpy as np

from studies.blind.generators.nominal import Nominal
from studies.blind.generators.waveform import Waveform

#: Standard deviations of a repeat's zero errors over those of the channels' noise.
DISPLACEMENT_ZERO, FORCE_ZERO = 0.3, 0.2


@dataclass(frozen=True)
class Scatter:
    """Standard deviations between repeats: relative for friction, load and wear, in degrees for the crossing angle."""

    friction: float
    load: float
    wear: float
    angle_deg: float


@dataclass(frozen=True)
class SpecimenDraw:
    """One repeat's departures from the nominal specimens and its zero errors."""

    friction: float = 1.0
    load: float = 1.0
    wear: float = 1.0
    angle_deg: float = 0.0
    displacement_zero_um: float = 0.0
    force_zero_N: float = 0.0


@dataclass(frozen=True)
class Nuisances:
    """Everything about a record that says nothing of its effect."""

    repeats: int
    scatter: Scatter
    displacement_noise_um: float
    force_noise_N: float
    correlation: float
    outlier_share: float
    waveform: Waveform
    amplitude_drift: float
    drive: str
    samples: int
    has_normal_force: bool
    has_evolution: bool
    has_scars: bool
    loop_cycles: tuple[tuple[int, ...], ...]
    evolution_cycles: tuple[int, ...]

    @property
    def all_cycles(self) -> tuple[int, ...]:
        """Every cycle at which anything is recorded, increasing."""
        logged = set(self.evolution_cycles) if self.has_evolution else set()
        return tuple(sorted(logged.union(*self.loop_cycles)))

    @property
    def stated_noise(self) -> dict[str, float]:
        """The noise that a record states of its channels."""
        noise = {"displacement_um": self.displacement_noise_um, "tangential_force_N": self.force_noise_N}
        return noise | ({"normal_force_N": self.force_noise_N} if self.has_normal_force else {})

    def specimen(self, random: np.random.Generator) -> SpecimenDraw:
        """By how much the specimens of one repeat deviate, drawn by the scatter."""
        scatter = self.scatter
        friction, load, wear, angle, zero, force = random.standard_normal(6)
        return SpecimenDraw(
            1.0 + scatter.friction * friction,
            1.0 + scatter.load * load,
            float(np.exp(scatter.wear * wear)),
            scatter.angle_deg * angle,
            DISPLACEMENT_ZERO * self.displacement_noise_um * zero,
            FORCE_ZERO * self.force_noise_N * force,
        )


def drawn_nuisances(nominal: Nominal, random: np.random.Generator) -> Nuisances:
    """Nuisances of one record, drawn without a look at its effect."""
    repeats = int(random.choice([1, 2, 3], p=[0.15, 0.2, 0.65]))
    peak = nominal.friction * nominal.load_N
    return Nuisances(
        repeats=repeats,
        scatter=Scatter(
            friction=random.uniform(0.004, 0.015),
            load=random.uniform(0.002, 0.008),
            wear=random.uniform(0.02, 0.06),
            angle_deg=random.uniform(0.1, 0.5),
        ),
        displacement_noise_um=round(random.uniform(0.08, 0.25) * nominal.amplitude_um / 60.0, 3),
        force_noise_N=round(random.uniform(0.004, 0.01) * peak, 4),
        correlation=0.0 if random.random() < 0.5 else random.uniform(0.3, 0.8),
        outlier_share=random.uniform(0.0, 0.002),
        waveform=Waveform(random.normal(0.0, 0.01), random.normal(0.0, 0.008)),
        amplitude_drift=random.normal(0.0, 0.002),
        drive="sensor" if random.random() < 0.6 else "stroke",
        samples=int(random.choice([200, 256, 400])),
        has_normal_force=bool(random.random() < 0.75),
        has_evolution=bool(random.random() < 0.85),
        has_scars=bool(random.random() < 0.75),
        loop_cycles=_loop_cycles(nominal.cycles, repeats, random),
        evolution_cycles=tuple(np.unique(np.round(np.geomspace(10, nominal.cycles, 40)).astype(int)).tolist()),
    )


def _loop_cycles(last: int, repeats: int, random: np.random.Generator) -> tuple[tuple[int, ...], ...]:
    """Cycles of each repeat's loops: the series 100, 300, 1000, ... and the last; one record in five lacks some."""
    series = [cycle for cycle in (100, 300, 1000, 3000, 10000, 30000, 60000, 100000) if cycle < last]
    whole = (*series, last)
    if random.random() < 0.8:
        return (whole,) * repeats
    kept = [tuple(cycle for cycle in whole if cycle in (100, last) or random.random() < 0.75) for _ in range(repeats)]
    return tuple(kept)
