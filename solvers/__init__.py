"""Elasticity, frictional contact with finite sliding, wear and cycle jumps.

A module of this package is imported when one of its names is first used: a diagnosis needs laws and states, but no
solver.
"""

from typing import TYPE_CHECKING

from geometry.lazy import loaded_late

if TYPE_CHECKING:
    from solvers.adaptive_loop import closed_adaptive_cycle
    from solvers.bulk_stress import BulkStress
    from solvers.conduction import Conductor, surface_rise
    from solvers.contact import ContactProblem, advance, press, unloaded_state
    from solvers.contact.linearising import stuck_share
    from solvers.contact.problem import misaligned, recoated
    from solvers.contact_state import ContactState, DriveTiming, Guide, Holder, IncrementReport, WearState
    from solvers.drive import Drive, LoadCycle, Waveform, trapezoidal, triangular
    from solvers.elasticity.body import Compliance, ContactBody
    from solvers.elasticity.coats import Coating
    from solvers.elasticity.condensation import CondensedBody, condense
    from solvers.elasticity.placement import PlacedBody, coated, facing, place
    from solvers.elasticity.stuck_bodies import StuckMotion, move_stuck
    from solvers.errors import NotConvergedError, PatchLeftError, SolverError
    from solvers.fretting import (
        CycleTrace,
        HolderElements,
        bulk_work,
        closed_cycle,
        first_quarter,
        measured_holder,
        restarted,
        run_cycle,
        settled,
        sticks_throughout,
        traced_quarter,
    )
    from solvers.jumps import JumpController, JumpStep, change_by_work, take_step
    from solvers.laws.debris import DebrisFlow
    from solvers.laws.friction_law import (
        Coulomb,
        Friction,
        FrictionLaw,
        LogarithmicRate,
        PowerOfPressure,
        Rate,
        RunningIn,
        ShearLimited,
        friction_laws,
    )
    from solvers.laws.heat import FrictionHeat
    from solvers.laws.layers import ContactLayer, RoughLayer, SurfaceLayer, ThirdBody, bare_depth
    from solvers.laws.local_state import LocalField, LocalState
    from solvers.laws.wear_law import (
        Archard,
        EnergyLaw,
        EnergyThreshold,
        OxygenDistance,
        PowerReduced,
        WearLaw,
        WornCycle,
        wear_laws,
    )
    from solvers.laws.yielding import PressureLimit
    from solvers.transfer import flattened, remeshed, transferred, transferred_wear
    from solvers.wear import OxygenSupply, WearRates
    from solvers.wear_step import (
        CycleJump,
        Symmetry,
        closed_trace,
        jump_cycles,
        kept_by,
        mirror_error,
        mirrored_prints,
        symmetry_of,
    )

__all__ = [
    "Archard", "BulkStress", "Coating", "Compliance", "CondensedBody", "Conductor", "ContactBody", "ContactLayer",
    "ContactProblem", "ContactState", "Coulomb", "CycleJump", "CycleTrace", "DebrisFlow", "Drive", "DriveTiming",
    "EnergyLaw", "EnergyThreshold", "Friction", "FrictionHeat", "FrictionLaw", "Guide", "Holder", "HolderElements",
    "IncrementReport", "JumpController", "JumpStep", "LoadCycle", "LocalField", "LocalState", "LogarithmicRate",
    "NotConvergedError", "OxygenDistance", "OxygenSupply", "PatchLeftError", "PlacedBody", "PowerOfPressure",
    "PowerReduced", "PressureLimit", "Rate", "RoughLayer", "RunningIn", "ShearLimited", "SolverError", "StuckMotion",
    "SurfaceLayer", "Symmetry", "ThirdBody", "Waveform", "WearLaw", "WearRates", "WearState", "WornCycle", "advance",
    "bare_depth", "bulk_work", "change_by_work", "closed_adaptive_cycle", "closed_cycle", "closed_trace", "coated",
    "condense",
    "facing", "first_quarter", "flattened", "friction_laws", "jump_cycles", "kept_by", "measured_holder",
    "mirror_error", "mirrored_prints", "misaligned", "move_stuck", "place", "press", "recoated", "remeshed",
    "restarted", "run_cycle", "settled", "sticks_throughout", "stuck_share", "surface_rise", "symmetry_of", "take_step",
    "traced_quarter", "transferred", "transferred_wear", "trapezoidal", "triangular", "unloaded_state", "wear_laws",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
