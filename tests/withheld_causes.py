"""Causes of the withheld set for tests: each at no size, as drawn, as read of a loop and as worn."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from tests.test_blind_unseen import LOOP, STEEL, Named
from wirewear.blind.cases import TrueEffect
from wirewear.blind.finite_element.changes import OUTSIDE_SETS as OF_RUNS
from wirewear.blind.finite_element.changes import instruments_of
from wirewear.blind.independent.effects import changed
from wirewear.blind.independent.sensing import Reading, read
from wirewear.blind.independent.wear_test import Snapshot, snapshots
from wirewear.blind.independent.withheld import WITHHELD
from wirewear.blind.instruments import Signals, read_by
from wirewear.blind.nominal import Nominal
from wirewear.blind.sizes import drawn_parameters

Array = NDArray[np.float64]

#: Each cause at a size that changes nothing.
NOTHING: dict[str, Named] = {
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
    "changing_air": {
        **{f"factor_{i}": 1.0 for i in (1, 2, 3)},
        **{f"cycle_{i}": 10.0**i for i in (1, 2, 3)},
    },
    "swinging_load": {"share": 0.0, "cycles": 1e3, "phase_rad": 1.0},
    "incubated_wear": {"share": 0.0, "cycle": 1e3, "abruptness": 5.0},
    "hard_skin": {"factor": 1.0, "depth_um": 2.0},
    "used_wire": {"depth_um": 0.0, "aside_um": 0.0},
    "rolled_wire": {"crown_factor": 1.0},
}

#: Those that are read of a loop and leave it as it is, and those at the seams of a run.
READ = [effect for effect in WITHHELD if instruments_of([TrueEffect(effect, NOTHING[effect])], Nominal())]
AT_SEAMS = [effect for effect in OF_RUNS["withheld"] if effect not in READ]

#: What tells the ends of a stroke, or the directions, apart.
ONE_WAY = {"overloaded_cell", "loose_plug", "hard_spot", "debris_ridge"}


def seen(effect: str, signals: Signals = LOOP, at: float = 100.0, /, **parameters: float) -> Signals:
    return read_by(instruments_of([TrueEffect(effect, parameters)], Nominal()), signals, at)


def drawn(effect: str, seed: int = 1) -> Named:
    return drawn_parameters(effect, "easy", Nominal(), np.random.default_rng(seed))


@cache
def worn(effect: str = "", last: int = 2000, /, **parameters: float) -> tuple[Snapshot, Reading]:
    """Some thousand cycles on a coarse grid."""
    world = changed(STEEL, effect, parameters) if effect else STEEL
    *_, shot = snapshots(world, [last], 10)
    return shot, read(world, shot.loop, last)


def shown(effect: str, /, **parameters: float) -> Reading:
    return worn(effect, **parameters)[1]
