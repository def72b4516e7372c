"""Causes of the reserved set for tests: each at no size, and what each is read as."""

from studies.blind.generators.cases import TrueEffect
from studies.blind.generators.finite_element.changes import OUTSIDE_SETS as OF_RUNS
from studies.blind.generators.finite_element.changes import instruments_of
from studies.blind.generators.independent.reserved import RESERVED
from studies.blind.generators.nominal import Nominal
from tests.test_blind_unseen import Named

#: Each cause at a size that changes nothing.
NOTHING: dict[str, Named] = {
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

#: Those that are read of a loop and leave it as it is, and those at the seams of a run.
READ = [effect for effect in RESERVED if instruments_of([TrueEffect(effect, NOTHING[effect])], Nominal())]
AT_SEAMS = [effect for effect in OF_RUNS["reserved"] if effect not in READ]

#: What tells the ends of a stroke apart, in the force or in the displacement, or keeps no time with it.
ONE_WAY_IN_FORCE = {"halting_logger", "spreading_glaze", "telescoping_slide", "hunting_servo", "touching_stop"}
ONE_WAY_IN_DISPLACEMENT = {"cyclic_encoder", "laser_out_of_range"}
LOADS = {"hunting_servo", "touching_stop"}  #: What is load, which both forces follow.
