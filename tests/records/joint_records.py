"""Records of a joint: a slider behind a rig and its own spring, as a rig with one fault would read it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.arrays import Array

FORCE_N, RIG_N_per_mm, OWN_N_per_mm, AMPLITUDE_um = 39.0, 900.0, 4500.0, 500.0

TABLES = """
format = 1
name = "friction damper"
[contact]
kind = "joint"
contact_stiffness_N_per_mm = {own}
[conditions]
{load}displacement_amplitude_um = 500.0
frequency_Hz = {frequency}
cycles = 30
[stated]
{friction}
tangential_stiffness_N_per_mm = 900.0
[files]
loops = "loops.csv"
"""


@dataclass(frozen=True)
class Rig:
    """What is not as stated: friction at the end over that stated, a spring, play, lags, gain and scale of readings."""

    friction: float = 1.0
    last_friction: float | None = None
    spring_N_per_mm: float = float("inf")
    play_um: float = 0.0
    force_lag_s: float = 0.0
    gain: float = 1.0
    mass_kg: float = 0.0
    frequency_Hz: float = 0.25

    def swinging(self, count: int) -> tuple[Array, Array]:
        """Displacement and force (count,) of a joint whose holder has a mass and 1 % of critical damping, by central
        differences.
        """
        turns, parts = 12, 40
        angle = 2.0 * np.pi * np.arange(turns * parts * count) / (parts * count)
        step, spring, own = 1.0 / (self.frequency_Hz * parts * count), 1e3 * RIG_N_per_mm, 1e3 * OWN_N_per_mm
        damper = 0.02 * np.sqrt(spring * self.mass_kg)
        moved = before = slip = 0.0
        held = np.zeros(angle.size)
        for i, place in enumerate((1e-6 * AMPLITUDE_um * np.sin(angle)).tolist()):
            force = own * (place - moved - slip)
            if abs(force) > FORCE_N:
                force = np.copysign(FORCE_N, force)
                slip = place - moved - force / own
            pushed = (force - spring * moved - damper * (moved - before) / step) / self.mass_kg
            before, moved = moved, 2.0 * moved - before + pushed * step**2
            held[i] = spring * before
        return AMPLITUDE_um * np.sin(angle[-parts * count :: parts]), held[-parts * count :: parts]

    def loop(self, cycle: int, count: int) -> tuple[Array, Array]:
        """Displacement and force (count,) of the closed loop of a cycle of 30, as they are read."""
        stroke = AMPLITUDE_um / self.gain * np.sin(2.0 * np.pi * np.arange(2 * count) / count)
        last = self.friction if self.last_friction is None else self.last_friction
        friction = FORCE_N * (self.friction + (last - self.friction) * np.log(cycle) / np.log(30.0))
        stiffness = 1e-3 / (1.0 / RIG_N_per_mm + 1.0 / OWN_N_per_mm + 1.0 / self.spring_N_per_mm)
        most, slip, read = friction / stiffness + 0.5 * self.play_um, 0.0, 0.0
        force = np.zeros(stroke.size)
        # Evenly sampled, a filter of the first order forgets by this much.
        kept = np.exp(-4.0 / count / self.force_lag_s) if self.force_lag_s else 0.0
        for i, place in enumerate(stroke):
            slip = min(max(slip, place - most), place + most)
            stretched = place - slip
            true = stiffness * np.sign(stretched) * max(abs(stretched) - 0.5 * self.play_um, 0.0)
            read = kept * read + (1.0 - kept) * true
            force[i] = read
        return self.gain * stroke[count:], force[count:]


def joint(
    folder: Path,
    load: str = "",
    friction: str = "friction_force_N = 39.0",
    own: object = OWN_N_per_mm,
    rig: Rig = Rig(),
) -> Path:
    """A record of a joint of two repeats and three cycles."""
    folder.mkdir(parents=True, exist_ok=True)
    tables = TABLES.format(load=load, friction=friction, own=own, frequency=rig.frequency_Hz)
    (folder / "experiment.toml").write_text(tables, encoding="utf-8")
    random, count = np.random.default_rng(1), 400
    swings = rig.swinging(count) if rig.mass_kg else None
    lines = ["repeat,cycle,sample,time_s,displacement_um,tangential_force_N"]
    for repeat in (1, 2):
        for cycle in (1, 5, 30):
            stroke, force = swings or rig.loop(cycle, count)
            noise = 0.1 * random.standard_normal(count)
            rows = enumerate(zip(stroke, force + noise, strict=True))
            lines += [f"{repeat},{cycle},{i},{i / count / rig.frequency_Hz},{x},{q}" for i, (x, q) in rows]
    (folder / "loops.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder
