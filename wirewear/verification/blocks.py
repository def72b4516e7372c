"""A ball and barrels on flats and crossed cylinders, pressed and in partial slip, on the meshes that runs have of them.

What the size of their blocks makes of approach and displacement is read from their compliances, as of wires.
"""

from typing import Any

from solvers import CondensedBody, Holder
from wirewear import reference
from wirewear.simulation import discretise
from wirewear.study import Study, study_from_tables
from wirewear.study.bodies import hertz_of
from wirewear.verification.hertz import STEEL, bulk_compliance, condensed, crossed, pressed_rows
from wirewear.verification.partial_slip import FRICTION, sliding_rows
from wirewear.verification.rows import Level, Row

_LOAD_N = 100.0
_SHARE = 0.7
#: Half of what slides, at which runs mesh for a centre that sticks.
_STICKING_um = 1.5
_WEAR = {"energy_wear_coefficient_mm3_per_J": 2.0e-5, "moving_share": 0.5}
_FLAT: dict[str, Any] = {"shape": "flat"}
_BALL: dict[str, Any] = {"shape": "ball", "diameter_mm": 12.7}


def _barrel(diameter_along_mm: float) -> dict[str, Any]:
    return {"shape": "barrel", "diameter_mm": 5.4, "diameter_along_mm": diameter_along_mm}


def _cylinder(angle_deg: float) -> dict[str, Any]:
    return {"shape": "cylinder", "diameter_mm": 12.7, "axis_angle_deg": angle_deg}


#: Contacts whose longer axis is 1, 2, 5, 10 and 4 times the shorter one.
_PAIRS = (
    ("Ball on flat", _FLAT, _BALL),
    ("Barrel on flat, axes 2 : 1", _FLAT, _barrel(15.4)),
    ("Barrel on flat, axes 5 : 1", _FLAT, _barrel(64.0)),
    ("Barrel on flat, axes 10 : 1", _FLAT, _barrel(199.0)),
    ("Cylinders crossed at 38°", _cylinder(0.0), _cylinder(38.0)),
)


def study_of(
    lower: dict[str, Any], upper: dict[str, Any], amplitude_um: float = 30.0, cycles: int = 1, **tables: Any
) -> Study:
    """A study of two steel bodies."""
    steel = {"youngs_modulus_MPa": STEEL.youngs_modulus_MPa, "poissons_ratio": STEEL.poissons_ratio}
    conditions = {
        "normal_load_N": _LOAD_N,
        "displacement_amplitude_um": amplitude_um,
        "frequency_Hz": 1.0,
        "cycles": cycles,
    }
    return study_from_tables(
        {
            "format": 1,
            "name": "bodies of a reference problem",
            "kind": "point-contact",
            "bodies": {"lower": lower | steel, "upper": upper | steel},
            "conditions": conditions,
            "contact": {"friction": FRICTION},
            **tables,
        },
        "the reference problem",
    )


def _meshed(study: Study, level: Level) -> tuple[CondensedBody, CondensedBody]:
    meshes = discretise(study, level.fidelity)
    return condensed(meshes.moving), condensed(meshes.fixed)


def block_rows(level: Level) -> tuple[Row, ...]:
    """Peak pressure, approach and semi-axes of all; compliance, stick radius and energy of the ball's."""
    rows: list[Row] = []
    for name, lower, upper in _PAIRS:
        study = study_of(lower, upper)
        exact = hertz_of(_LOAD_N, *study.bodies)
        rows += pressed_rows(name, *_meshed(study, level), exact, study.crossing_angle_deg, level)
    study = study_of(_FLAT, _BALL, _STICKING_um, wear=_WEAR)
    flat, ball = _meshed(study, level)
    radius_mm = hertz_of(_LOAD_N, *study.bodies).contact_radius_mm
    bulk = sum(bulk_compliance(body, 0, radius_mm) for body in (flat, ball))
    modulus = reference.tangential_contact_modulus(STEEL, STEEL)
    slip = reference.partial_slip_point(_LOAD_N, FRICTION, radius_mm, modulus)
    problem = crossed(flat, ball, Holder(_LOAD_N), friction=FRICTION, angle_deg=0.0)
    return (*rows, *sliding_rows(problem, slip, bulk, ball, level, (_SHARE,), "Ball on flat, partial slip"))
