"""Checks that the keys of a study fit together, each of which is valid by itself.

An idle key is one that is stated but has no effect, because another takes its place.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from wirewear.base.errors import StudyError
from wirewear.test.bodies import Wire
from wirewear.test.conditions import held_keys
from wirewear.test.drive import BulkTable
from wirewear.test.fidelity import FIDELITIES
from wirewear.test.keys import NO_PIVOT, Inconsistency, Table, merged
from wirewear.test.kinds import kind_named
from wirewear.test.life import LifeTable
from wirewear.test.messages import Keys, place, table_above, validated
from wirewear.test.own_bodies import OwnBody, StiffBody
from wirewear.test.programme import logged_ends, placed, too_many
from wirewear.test.shapes import ShapedBody
from wirewear.test.surfaces import StatedSurface, unfit_layers
from wirewear.test.tables import CommonTables, ContactTables


def default_loop_cycles(cycles: int) -> tuple[int, ...]:
    """The cycles 1, 2, 5, 10, 20, 50, ... below `cycles`, and `cycles` itself."""
    decades = [10**exponent for exponent in range(len(str(cycles)))]
    series = {factor * decade for decade in decades for factor in (1, 2, 5)}
    return tuple(sorted({cycle for cycle in series if cycle < cycles} | {cycles}))


def checked_tables(
    data: Mapping[str, object], where: str, overrides: Mapping[str, object] | None = None, prefix: str = ""
) -> CommonTables:
    """The tables of a study from nested values, checked, blocks of its programme included, with the cycles to record
    filled in.
    where: name of their origin for messages. overrides: values that a variant states under `prefix`, so that messages
    name its table. Raises StudyError, in one sentence, if they are not valid.
    """

    def spelled(keys: Keys) -> str:
        table = ".".join(str(key) for key in keys[:-1])
        return f"{prefix}.{table}".rstrip(".") if prefix and _holds(overrides or {}, keys) else table

    tables = validated(kind_named(data.get("kind")).tables, data, where, StudyError, spelled)
    contradiction = inconsistency(tables)
    if contradiction is not None:
        keys, problem = contradiction
        variant = f" (in the variant {prefix.removeprefix('variants.')!r})" if prefix else ""
        raise StudyError(f"{keys[-1]} {place(keys, where, spelled)} {problem}{variant}.")
    for number, block in enumerate(tables.programme, 1):
        alone = {key: value for key, value in data.items() if key != "programme"}
        checked_tables(merged(alone, placed(block.values, alone)), f"block {number} of the programme in {where}")
    # The cycles that a test records: those asked for as far as it goes, and its last in place of later ones; else the
    # series, with the ends of a programme's blocks when they come first and last.
    end = tables.conditions.cycles
    asked = tables.log.loop_cycles or (*default_loop_cycles(end), *logged_ends(tables.programme, end))
    return tables.model_copy(update={"log": tables.log.of_cycles(tuple(sorted({min(cycle, end) for cycle in asked})))})


def _holds(overrides: Mapping[str, Any], keys: Keys) -> bool:
    here: Any = overrides
    for key in keys:
        if not isinstance(here, Mapping) or key not in here:
            return False
        here = here[key]
    return True


def inconsistency(tables: CommonTables) -> Inconsistency | None:
    """The first contradiction between a study's keys; None if all fit."""
    checks = (type(tables).contradiction, *(_OF_A_POINT if isinstance(tables, ContactTables) else ()), *_OF_ALL)
    return next((found for check in checks if (found := check(tables)) is not None), None)


def _stroke(tables: ContactTables) -> Inconsistency | None:
    amplitude_um = tables.conditions.displacement_amplitude_um
    thinnest_mm = min(min(body.diameters_mm) for body in tables.bodies_of_test())
    if amplitude_um > 1e3 * thinnest_mm:
        return Inconsistency(
            ("conditions", "displacement_amplitude_um"),
            f"is {amplitude_um:g} µm, but must not exceed the smallest diameter, {1e3 * thinnest_mm:g} µm",
        )
    return None


def _wear(tables: ContactTables) -> Inconsistency | None:
    wear = tables.wear
    if wear is None:
        return None
    energy, archard = wear.energy_wear_coefficient_mm3_per_J, wear.archard_wear_coefficient_mm3_per_N_m
    if (energy is None) == (archard is None):
        return Inconsistency(
            ("wear", "energy_wear_coefficient_mm3_per_J"),
            f"and archard_wear_coefficient_mm3_per_N_m are {'both missing' if energy is None else 'both given'}, "
            "but exactly one of them says how the bodies wear",
        )
    if wear.of_law.coefficient != ("energy" if archard is None else "archard"):
        return Inconsistency(
            ("wear", "law"),
            f'is "{wear.of_law.name}", which takes {wear.of_law.coefficient}_wear_coefficient_'
            f"{'mm3_per_J' if archard is not None else 'mm3_per_N_m'}: give that in place of the other coefficient",
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


def _layers(tables: CommonTables) -> Inconsistency | None:
    stated = [layer for layers in tables.layers.values() for layer in layers]
    problem = unfit_layers(stated, tables.contact.friction)
    if any(tables.coatings) and any(tables.yields.values()):
        problem = "have elastic constants of their own, which does not go with a yield_stress_MPa of a body"
    return None if problem is None else Inconsistency(("layers",), problem)


def _bulk(tables: ContactTables) -> Inconsistency | None:
    for body in tables.bodies_of_test():
        if body.bulk is None:
            continue
        if isinstance(body, OwnBody | StiffBody):
            stated = "is of the program's own shapes, but of a body from a file it is not known where it is pulled"
            return Inconsistency(("bodies", body.name, "bulk"), stated)
        if min(body.curvatures_per_mm) > 0.0 and not body.has_axis:
            return Inconsistency(("bodies", body.name, "bulk"), "is given, but a ball is no bar that is pulled or bent")
        if problem := body.bulk.unfit(is_round=isinstance(body, Wire)):
            return Inconsistency(("bodies", body.name, "bulk"), problem)
    return None


def _near_zone(tables: ContactTables) -> Inconsistency | None:
    for body in tables.bodies_of_test():
        if tables.contact.plasticity == "near zone" and (body.face is not None or body.surface is not None):
            return Inconsistency(
                ("contact", "plasticity"),
                f'is "near zone", which presses round, unworn bodies, but "{body.name}" '
                f'{"has a measured surface" if body.face is None else "is a pad"}: "limited pressure" takes it',
            )
    return None


def _holder(tables: ContactTables) -> Inconsistency | None:
    holder = tables.holder
    if holder.rotational_stiffness_N_mm_per_rad != "rigid" and holder.pivot_height_mm is None:
        return Inconsistency(("holder", "rotational_stiffness_N_mm_per_rad"), NO_PIVOT)
    if tables.conditions.approach_um is not None and tables.conditions.load_cycle is not None:
        return Inconsistency(
            ("conditions", "load_cycle"), "says how the load goes, but approach_um holds the bodies at a fixed approach"
        )
    if tables.conditions.approach_um is not None and holder.normal_spring_stiffness_N_per_mm > 0.0:
        return Inconsistency(
            ("conditions", "approach_um"),
            "holds the bodies at a fixed approach, which leaves normal_spring_stiffness_N_per_mm nothing to do: "
            "give one of the two",
        )
    return None


def _effects(tables: ContactTables) -> Inconsistency | None:
    if tables.conditions.approach_um is not None:
        for effect in tables.effects:
            if effect.needs_load:
                return Inconsistency(
                    ("effects",),
                    f"hold {effect.name}, which needs a test under load, but approach_um holds the bodies at a fixed "
                    "approach",
                )
    return None


def _explicit(tables: ContactTables) -> Inconsistency | None:
    if tables.wear is not None and tables.wear.update == "explicit":
        if held := held_keys(tables.conditions):
            return Inconsistency(("conditions", held[0]), 'does not go with update = "explicit" of [wear]')
        if tables.wear.of_law.timed:
            return Inconsistency(
                ("wear", "law"),
                f'is "{tables.wear.of_law.name}", which the explicit wear update does not know: use "implicit"',
            )
        for effect in tables.effects:
            if effect.needs_whole_cycles:
                return Inconsistency(
                    ("effects",), f'hold {effect.name}, which the explicit wear update does not know: use "implicit"'
                )
    return None


def _programme(tables: CommonTables) -> Inconsistency | None:
    problem = too_many(tables.programme, tables.conditions.cycles)
    return None if problem is None else Inconsistency(("programme",), problem)


def _held(tables: CommonTables) -> Inconsistency | None:
    held = held_keys(tables.conditions)
    if len(held) > 1:
        return Inconsistency(("conditions", held[0]), f"and {held[1]} are both given, but a drive holds one of them")
    return None


def _fidelities(tables: ContactTables) -> Inconsistency | None:
    for name in FIDELITIES:
        settings = getattr(tables.fidelity, name)
        fine, outer = settings.contact_mesh_um, settings.outer_mesh_um
        if fine is not None and outer is not None and fine > outer:
            return Inconsistency(
                ("fidelity", name, "contact_mesh_um"),
                f"is {fine:g} µm, but must not exceed outer_mesh_um = {outer:g} µm",
            )
    return None


Check = Callable[[Any], Inconsistency | None]
_OF_ALL: tuple[Check, ...] = (_layers, _programme, _held)
_OF_A_POINT: tuple[Check, ...] = (_stroke, _wear, _bulk, _near_zone, _holder, _effects, _explicit, _fidelities)


#: Yields keys that tables state but that have no effect, because others take their place.
Rule = Callable[[CommonTables], Iterator[Inconsistency]]


def require_no_idle_key(runs: Sequence[CommonTables], where: str) -> None:
    """Raise StudyError, in one sentence, for a key that is stated but has no effect in any of `runs`, the tables of a
    study's variants and blocks. where: name of the study for messages.
    """
    for rule in _RULES:
        idle = [{found.keys: found for found in rule(tables)} for tables in runs]
        for keys, found in idle[0].items():
            if all(keys in other for other in idle):
                raise StudyError(f"{keys[-1]} {place(keys, where, table_above)} {found.problem}.")


def _taken_over(tables: CommonTables) -> Iterator[Inconsistency]:
    holder, mesh, life = tables.holder, tables.mesh, tables.life or LifeTable()
    stiffness = next(key for key in type(holder).model_fields if key.startswith("rotational_stiffness"))
    length = life.averaging_length_um
    averaged = "is given, but averaging_length_um takes its place: give one of the two"
    pivots = holder.pivot_height_mm is not None and getattr(holder, stiffness) == "rigid"
    moves = getattr(mesh, "move_nodes_at_stages", False) and mesh.move_nodes_every_um is not None
    for acts_not, keys, problem in (
        (pivots, ("holder", "pivot_height_mm"), f"is given, but without {stiffness} nothing turns about that pivot"),
        (moves, ("mesh", "move_nodes_at_stages"), "is true, but move_nodes_every_um says when nodes are moved"),
        (length and life.critical_distance_um is not None, ("life", "critical_distance_um"), averaged),
        (length and life.averaging != "volume", ("life", "averaging"), averaged),
    ):
        if acts_not:
            yield Inconsistency(keys, problem)


def _shapes(tables: CommonTables) -> Iterator[Inconsistency]:
    for keys, body in _inner(tables, ShapedBody):
        yield from (Inconsistency((*keys, *idle.keys), idle.problem) for idle in body.idle())


def _phases(tables: CommonTables) -> Iterator[Inconsistency]:
    for keys, bulk in _inner(tables, BulkTable):
        if bulk.phase_deg and not any(value for key, value in bulk if "amplitude" in key):
            yield Inconsistency(
                (*keys, "phase_deg"), "is given, but no amplitude of the stress, which alone has a phase"
            )


def _stops(tables: CommonTables) -> Iterator[Inconsistency]:
    coefficients = () if tables.wear is None else (value for key, value in tables.wear if "wear_coefficient" in key)
    if tables.stop is None or any(coefficients) or tables.contact.friction_law.remembers:
        return
    for key in ("depth_um", "worn_volume_mm3", "accumulated_energy_J"):
        if getattr(tables.stop, key) is not None:
            yield Inconsistency(("stop", key), "is given, but without [wear] nothing changes that it could wait for")


def _inner(tables: Table, kind: type[Any], *above: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """All tables of the class `kind` nested in `tables`, each with the keys that lead to it, which begin with
    `above`.
    """
    for key, value in tables:
        if isinstance(value, kind):
            yield (*above, key), value
        if isinstance(value, Table) and not isinstance(value, StatedSurface):
            yield from _inner(value, kind, *above, key)


_RULES: Sequence[Rule] = (_taken_over, _shapes, _phases, _stops)
