"""Causes of no library for tests: each at no size; as drawn, as read of a loop and as worn; what each is read as."""

from dataclasses import replace
from functools import cache

import numpy as np

from geometry.arrays import Array
from studies.blind.generators.cases import TrueEffect
from studies.blind.generators.finite_element.changes import instruments_of, outside_of
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.sensing import Reading, read
from studies.blind.generators.independent.wear_test import Snapshot, snapshots
from studies.blind.generators.independent.worlds import nominal_world
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.signals import Signals, read_by
from studies.blind.generators.sizes import drawn_parameters

Named = dict[str, float]
STEEL = nominal_world(Nominal(), "dahl", held_on_sensor=False)
TURN = np.asarray(2.0 * np.pi * np.arange(1440) / 1440, dtype=np.float64)
#: A sine of 60 µm at 3 Hz, and a force that is odd over half a cycle.
LOOP = Signals(
    np.asarray(TURN / (6.0 * np.pi)), 1.0 / 3.0, np.asarray(60.0 * np.sin(TURN)),
    np.asarray(1.2 * np.tanh(8.0 * np.cos(TURN - 0.3))), np.full(1440, 2.0),
)  # fmt: skip
#: A block that slides on Coulomb friction without any give, and where it does so in either direction.
BLOCK = replace(LOOP, tangential_force_N=np.asarray(1.2 * np.sign(np.cos(TURN + 1e-9))))
FORTH, BACK = np.cos(TURN) > 0.05, np.cos(TURN) < -0.05
#: Each cause of the unseen, the withheld and the reserved set at a size that changes nothing.
NOTHING: dict[str, Named] = {
    "leaking_charge": {"time_s": 1e9},
    "ringing_force_cell": {"natural_frequency_Hz": 1e9, "damping": 0.05},
    "hysteretic_displacement": {"share": 0.0},
    "fading_supply": {"change": 0.0, "cycles": 1e3},
    "creeping_joint": {"um_per_N": 0.0, "time_s": 0.1},
    "dragging_guide": {"force_N": 0.0, "over_um": 3.0},
    "sticking_lever": {"share": 0.0, "over_um": 3.0},
    "bouncing_weight": {"share": 0.0, "phase_rad": 1.0},
    "hooked_friction": {"rise": 0.0},
    "film_breakthrough": {"share": 0.0, "cycle": 1e3, "abruptness": 4.0},
    "relaxing_load": {"loss": 0.0, "cycles": 1e3},
    "unequal_wear": {"moving_share": 0.5},
    "pressure_dependent_wear": {"exponent": 0.0, "pressure_MPa": 40.0},
    "one_sided_holder": {"um_per_N": 0.0},
    "other_gauge": {"diameter_factor": 1.0},
    "overloaded_cell": {"loss": 0.0, "zero_N": 0.0, "cycle": 100.0},
    "loose_plug": {"zero_N": 0.0, "cycle_1": 10.0, "cycle_2": 100.0, "cycle_3": 1e3, "cycle_4": 1e4},
    "slew_limited_amplifier": {"N_per_s": 1e9},
    "crossover_distortion": {"band_N": 0.0},
    "averaging_logger": {"time_s": 0.0},
    "hard_spot": {"rise": 0.0, "place": 0.2, "width": 0.1},
    "debris_ridge": {"force_N": 0.0, "begins": 0.5, "cycles": 1e3},
    "thinning_grease": {"force_N": 0.0, "cycles": 1e3},
    "rattling_weight": {"share": 0.0, "frequency_Hz": 20.0, "time_s": 0.03},
    "cracking_flexure": {"um_per_N": 0.0, "cycles": 1e3, "power": 3.0},
    "wearing_pivot": {"gap_um": 0.0, "cycles": 1e3},
    "opening_joint": {"preload_N": 0.5, "um_per_N": 0.0},
    "microslipping_joint": {"um_per_N2": 0.0},
    "shedding_film": {"share": 0.0, "cycles": 1e3},
    "changing_air": {**{f"factor_{i}": 1.0 for i in (1, 2, 3)}, **{f"cycle_{i}": 10.0**i for i in (1, 2, 3)}},
    "swinging_load": {"share": 0.0, "cycles": 1e3, "phase_rad": 1.0},
    "incubated_wear": {"share": 0.0, "cycle": 1e3, "abruptness": 5.0},
    "hard_skin": {"factor": 1.0, "depth_um": 2.0},
    "used_wire": {"depth_um": 0.0, "aside_um": 0.0},
    "rolled_wire": {"crown_factor": 1.0},
    "cyclic_encoder": {"error_um": 0.0, "pitch_um": 20.0, "phase_rad": 1.0},
    "coarse_converter": {"step_N": 1e-9},
    "laser_out_of_range": {"limit_um": 1e9},
    "halting_logger": {"time_s": 0.0},
    "stick_slip": {"share": 0.0, "per_stroke": 6.0},
    "rolling_debris": {"loss": 0.0, "over": 0.4},
    "spreading_glaze": {"share": 0.0, "end": 1.0, "cycles": 1e3},
    "snapping_leaf": {"jump_um": 0.0, "force_N": 0.6},
    "telescoping_slide": {"um_per_N": 0.0},
    "orbiting_holder": {"across": 0.0},
    "hunting_servo": {"share": 0.0, "frequency_Hz": 13.0},
    "touching_stop": {"share": 0.0, "begins": 0.4},
    "sticking_slide": {"loss": 0.0, "cycles": 100.0},
    "lopsided_wear": {"slant": 0.0},
    # What happens at an hour of the test shortens steps there: these happen once it is over.
    "spalled_flake": {"depth_um": 0.0, "radius_um": 30.0, "x_um": 0.0, "y_um": 0.0, "cycle": 1e9},
    "remounted_wire": {"aside_um": 0.0, "cycle": 1e9},
    "grooved_wire": {"depth_um": 0.0, "half_width_um": 30.0, "aside_um": 0.0},
}

#: Those that are read of a loop and leave it as it is, and those of the two later sets at the seams of a run.
READ = [effect for effect, nothing in NOTHING.items() if instruments_of([TrueEffect(effect, nothing)], Nominal())]
AT_SEAMS = [effect for name in ("withheld", "reserved") for effect in outside_of(name) if effect not in READ]
#: What distinguishes the ends of a stroke or the directions, in the force or in the displacement, or keeps no time.
ONE_WAY_IN_FORCE = {
    "sticking_lever", "overloaded_cell", "loose_plug", "hard_spot", "debris_ridge", "halting_logger", "spreading_glaze",
    "telescoping_slide", "hunting_servo", "touching_stop",
}  # fmt: skip
ONE_WAY_IN_DISPLACEMENT = {"cyclic_encoder", "laser_out_of_range"}


def seen(effect: str, signals: Signals = LOOP, at: float = 100.0, /, **parameters: float) -> Signals:
    return read_by(instruments_of([TrueEffect(effect, parameters)], Nominal()), signals, at)


def drawn(effect: str, seed: int = 1) -> Named:
    return drawn_parameters(effect, "easy", Nominal(), np.random.default_rng(seed))


def unevenness(values: Array) -> float:
    """How far a channel is from being odd over half a cycle."""
    return float(np.abs(values + np.roll(values, values.size // 2)).max() / np.abs(values).max())


def area_mJ(signals: Signals) -> float:
    x, q = signals.displacement_um, signals.tangential_force_N
    return -1e-3 * float(np.sum(0.5 * (x + np.roll(x, -1)) * (np.roll(q, -1) - q)))


@cache
def worn(effect: str = "", last: int = 2000, /, **parameters: float) -> tuple[Snapshot, Reading]:
    """Some thousand cycles on a coarse grid."""
    world = changed(STEEL, effect, parameters) if effect else STEEL
    *_, shot = snapshots(world, [last], 10)
    return shot, read(world, shot.loop, last)
