"""Checks between keys of a study: each alone may be fine, and yet they do not fit together."""

from typing import NamedTuple

from wirewear.study.fidelity import FIDELITIES
from wirewear.study.tables import StudyTables, WireOverride


class Inconsistency(NamedTuple):
    """A key that does not fit another, and the rest of the sentence that begins with it."""

    keys: tuple[str, ...]
    problem: str


def inconsistency(tables: StudyTables) -> Inconsistency | None:
    """The first contradiction within a study, if there is one."""
    for check in (_wires, _wear, _holder, _effects, _explicit, _fidelities):
        found = check(tables)
        if found is not None:
            return found
    return None


def _wires(tables: StudyTables) -> Inconsistency | None:
    wires = tables.wires
    for keys, override in (
        (("wires", "length_mm"), WireOverride()),
        (("wires", "moving", "length_mm"), wires.moving),
        (("wires", "fixed", "length_mm"), wires.fixed),
    ):
        length = override.length_mm or wires.length_mm
        diameter = override.diameter_mm or wires.diameter_mm
        if length is not None and length < diameter:
            return Inconsistency(keys, f"is {length:g} mm, but must be at least the wire's diameter, {diameter:g} mm")
    thinnest_mm = min(wires.diameter_mm, *(w.diameter_mm or wires.diameter_mm for w in (wires.moving, wires.fixed)))
    amplitude_um = tables.conditions.displacement_amplitude_um
    if amplitude_um > 1e3 * thinnest_mm:
        return Inconsistency(
            ("conditions", "displacement_amplitude_um"),
            f"is {amplitude_um:g} µm, but must not exceed the thinner wire's diameter, {1e3 * thinnest_mm:g} µm",
        )
    return None


def _wear(tables: StudyTables) -> Inconsistency | None:
    wear = tables.wear
    if wear is None:
        return None
    energy, archard = wear.energy_wear_coefficient_mm3_per_J, wear.archard_wear_coefficient_mm3_per_N_m
    if (energy is None) == (archard is None):
        return Inconsistency(
            ("wear", "energy_wear_coefficient_mm3_per_J"),
            f"and archard_wear_coefficient_mm3_per_N_m are {'both missing' if energy is None else 'both given'}, "
            "but exactly one of them says how the wires wear",
        )
    if (wear.variation == "none") != (not wear.variation_points):
        return Inconsistency(
            ("wear", "variation"),
            f'is "{wear.variation}", which does not go with {len(wear.variation_points)} variation_points: '
            "give both, or neither",
        )
    if (wear.update == "explicit") != (wear.explicit_jump_cycles is not None):
        return Inconsistency(
            ("wear", "update"),
            f'is "{wear.update}", but explicit_jump_cycles belongs to update = "explicit" and must be given with it',
        )
    return None


def _holder(tables: StudyTables) -> Inconsistency | None:
    holder = tables.holder
    if holder.rotational_stiffness_N_mm_per_rad != "rigid" and holder.pivot_height_mm is None:
        return Inconsistency(
            ("holder", "rotational_stiffness_N_mm_per_rad"),
            "says that the holder rotates, but pivot_height_mm, the height of its pivot above the contact, is missing",
        )
    if tables.conditions.approach_um is not None and holder.normal_spring_stiffness_N_per_mm > 0.0:
        return Inconsistency(
            ("conditions", "approach_um"),
            "holds the wires at a fixed approach, which leaves normal_spring_stiffness_N_per_mm nothing to do: "
            "give one of the two",
        )
    return None


def _effects(tables: StudyTables) -> Inconsistency | None:
    if tables.conditions.approach_um is not None:
        for effect in tables.effects:
            if effect.needs_load:
                return Inconsistency(
                    ("effects",),
                    f"hold {effect.name}, which needs a test under load, but approach_um holds the wires at a fixed "
                    "approach",
                )
    return None


def _explicit(tables: StudyTables) -> Inconsistency | None:
    if tables.wear is not None and tables.wear.update == "explicit":
        for effect in tables.effects:
            if effect.needs_whole_cycles:
                return Inconsistency(
                    ("effects",), f'hold {effect.name}, which the explicit wear update does not know: use "implicit"'
                )
    return None


def _fidelities(tables: StudyTables) -> Inconsistency | None:
    for name in FIDELITIES:
        settings = getattr(tables.fidelity, name)
        fine, outer = settings.contact_mesh_um, settings.outer_mesh_um
        if fine is not None and outer is not None and fine > outer:
            return Inconsistency(
                ("fidelity", name, "contact_mesh_um"),
                f"is {fine:g} µm, but must not exceed outer_mesh_um = {outer:g} µm",
            )
    return None
