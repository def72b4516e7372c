"""The pressure limit of bodies that yield, the size of their contact, and what a result records of both.

Where the elastic pressure would exceed the limit, the softer body takes a print (permanent indentation) instead.
"""

from math import pi, sqrt

from solvers import ContactProblem, IncrementReport, PressureLimit
from wirewear import reference
from wirewear.results.values import YIELD_STRESS
from wirewear.test import AnyStudy, Study
from wirewear.test.gaps import hertz_of

STRAIN = "fresh_indentation_strain"  #: Name in results of 0.2 a/R of the fresh contact of bodies that yield.
_ALIKE = 1e-6  #: Yield stresses that differ by less, relative, are equal.


def limit_of_points(study: Study) -> PressureLimit | None:
    """The pressure limit of a contact at a point; None if no body is stated to yield, or plasticity is "none"."""
    contact = hertz_of(study.conditions.normal_load_N, *study.bodies)
    axes = contact.minor_semi_axis_mm, contact.major_semi_axis_mm
    return pressure_limit(study, study.conditions.normal_load_N, contact.peak_pressure_MPa, axes, power=3.0)


def pressure_limit(
    study: AnyStudy, load: float, pressure_MPa: float, semi_axes_mm: tuple[float, float], *, power: float
) -> PressureLimit | None:
    """The pressure limit of a contact, from its elastic contact under `load` in N (line contacts N/mm); None for
    elastic bodies. pressure_MPa, semi_axes_mm: largest pressure and (minor, major) semi-axes of that contact. power:
    exponent with which its load grows with its largest pressure, 3 at a point, 2 on a line.
    """
    stated = {name: own for name, own in study.tables.yields.items() if own is not None}
    if not stated or study.contact.plasticity == "none":
        return None
    (driven, held), materials = study.tables.materials, study.tables.materials
    softer = min(stated, key=lambda name: stated[name][0])
    stress, hardening = stated[softer]
    alike = len(stated) == 2 and abs(stated[driven][0] - stated[held][0]) <= _ALIKE * stress
    minor, major = semi_axes_mm
    ratio = reference.first_yield_ratio(minor / major, materials[softer].poissons_ratio)
    modulus = reference.contact_modulus(materials[driven], materials[held])
    beyond = (pressure_MPa / (ratio * stress)) ** power
    upper_share = 0.5 if alike else float(softer == held)
    # Equal bodies share the curvature of the gap.
    curving = max(upper_share, 1.0 - upper_share)
    return PressureLimit(
        yield_stress_MPa=stress,
        first_yield_ratio=ratio,
        first_yield_load=load / beyond,
        overlap_mm=pressure_MPa * minor / modulus,
        upper_share=upper_share,
        hardening_MPa=hardening,
        # The strain is 0.2 a/R (Tabor, The Hardness of Metals (1951)); a/R about 1.6 p0/E*, of lines 2 p0/E*.
        first_yield_strain=0.2 * curving * (1.57 if power > 2.0 else 2.0) * ratio * stress / modulus,
    )


def spread_by_yield(limit: PressureLimit | None, load: float, pressure_MPa: float, *, line: bool = False) -> float:
    """Ratio (≥ 1) of the pressed contact's size to Hertz's, whose largest pressure under `load` is `pressure_MPa`; 1
    without a limit.

    Limited pressures need a larger area to bear the load, surrounded by what Hertz's rim keeps: at a point within 2 %
    of the finite elements of docs/yielding.md for pressures of up to six times the limit. line: True for a line
    contact.
    """
    over = 0.0 if limit is None else pressure_MPa / float(limit.limit_MPa(load))
    if over <= 1.0:
        return 1.0
    mean = 0.25 * pi if line else 2.0 / 3.0
    widened = mean * over + (1.0 - mean) / over
    return widened if line else sqrt(widened)


def limit_settings(problem: ContactProblem, pressed: IncrementReport, *, line: bool) -> dict[str, float]:
    """Values that a result records of the pressure limit and the fresh contact, by key; empty without a limit. line:
    True for a line contact.
    """
    limit = problem.limit
    if limit is None:
        return {}
    load = problem.holder.normal_load_N
    first_mean_MPa = (0.25 * pi if line else 2.0 / 3.0) * limit.first_yield_ratio * limit.yield_stress_MPa
    wider = pressed.contact_area * first_mean_MPa / limit.first_yield_load
    return {
        YIELD_STRESS: limit.yield_stress_MPa,
        "fresh_first_yield_load_N": limit.first_yield_load,
        "fresh_pressure_limit_MPa": float(limit.limit_MPa(load)),
        "fresh_mean_pressure_over_yield": pressed.normal_force / pressed.contact_area / limit.yield_stress_MPa,
        STRAIN: limit.first_yield_strain * (wider if line else sqrt(wider)),
    }
