"""Wear coefficients fitted to worn volumes and friction energies, or given by the user in place of volumes.

A kind of contact has one coefficient for each body, or a common one with the share of the first body.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.diagnosis.fit.values import FittedParameter
from wirewear.records import AnyRecord
from wirewear.records.contact_tables import AnyTables
from wirewear.records.evolution_checks import accumulated_energy_J
from wirewear.records.surfaces import SCARS
from wirewear.results.scar import called

#: Wear coefficient of both bodies with which wear states are made where the record does not show it: steel on steel's.
ANY_WEAR_mm3_per_J = 3e-5

_UNITS = {"mm3_per_J": "mm³/J", "mm3_per_N_m": "mm³/(N·m)"}

Worn = tuple[dict[str, FittedParameter], list[str]]  #: Fitted wear: parameters, and what is missing or assumed.


@dataclass(frozen=True)
class GivenWear:
    """Wear known without measured scars, one of the two: coefficient of both bodies together, or volume that both lost
    in a test.
    """

    coefficient_mm3_per_J: float | None = None
    volume_mm3: float | None = None


def fitted_wear(
    record: AnyRecord, given: GivenWear | None = None, energy_J: float | None = None
) -> tuple[dict[str, FittedParameter], dict[str, FittedParameter], list[str]]:
    """Fitted wear parameters by name, further figures by name, and sentences on what is missing.

    The further figures are the friction energy of a test in J and the worn volume of each body in mm³; a name is
    missing if the record does not show it. given: takes the place of what scars show; these then only determine the
    bodies' shares. energy_J: friction energy of each test, if it is known better than by the areas of loops. Raises
    RecordError if a volume is given, but the energy that wore it is unknown.
    """
    energies = {repeat: energy_J or accumulated_energy_J(record, repeat) for repeat in record.repeats}
    known = {repeat: energy for repeat, energy in energies.items() if energy}
    volumes = {
        body: {repeat: volume for repeat, volume in own.items() if repeat in energies}
        for body, own in record.worn_volumes_mm3.items()
    }
    unseen = dict(_unseen(record))
    found = {
        f"worn_volume_{body}_mm3": FittedParameter.of_repeats([*own.values()], "mm3")
        for body, own in volumes.items()
        if own
    }
    if known:
        found["accumulated_energy_J"] = FittedParameter.of_repeats([*known.values()], "J")
    seen = {repeat: energy for repeat, energy in known.items() if repeat not in unseen}
    fitted, notes = _worn(record.tables, volumes, seen)
    if given is not None:
        fitted, notes = _given(given, record.tables, fitted, found)
        return fitted, found, notes
    return fitted, found, [*unseen.values(), *notes]


def _unseen(record: AnyRecord) -> Iterator[tuple[int, str]]:
    """Repeats whose worn volume, that of all measured scars together, may be none, and a sentence on each."""
    for repeat in record.repeats if record.tables.worn.name == SCARS.name else ():
        scars = [scar for scar in record.scars if scar.repeat == repeat]
        volume, doubt = sum(scar.volume_mm3 for scar in scars), sum(scar.doubt_mm3 for scar in scars)
        if scars and volume <= doubt:
            known = f"{volume:.2g} mm³ are known within ±{doubt:.2g} mm³"
            yield repeat, f"the scars of repeat {repeat} may be noise, and show no wear coefficient: {known}"


def _worn(tables: AnyTables, volumes: Mapping[str, Mapping[int, float]], energies_J: Mapping[int, float]) -> Worn:
    fitted: dict[str, FittedParameter] = {}
    notes, name = [], tables.worn.name
    for key, bodies in tables.wear.items():
        known = {body: repeats for body in bodies if (repeats := sorted({*energies_J} & {*volumes[body]}))}
        if both := sorted(set(energies_J).intersection(*(volumes[body] for body in bodies))):
            own = np.array([[volumes[body][repeat] for repeat in both] for body in bodies])
            total = own.sum(axis=0)
            per_J = total / np.array([energies_J[repeat] for repeat in both])
            fitted[key] = FittedParameter.of_repeats(per_J, "mm3_per_J")
            if len(bodies) > 1:
                fitted["moving_share"] = FittedParameter.of_repeats(own[0] / total, "1")
        elif known:
            alone, repeats = next(iter(known.items()))
            share = tables.shares[alone]
            per_J = np.array([volumes[alone][repeat] / energies_J[repeat] for repeat in repeats])
            fitted[key] = FittedParameter.of_repeats(per_J / share, "mm3_per_J")
            notes.append(
                f"only the {called(alone)}'s {name} is known: the wear coefficient of both takes its share of "
                f"{share:g} for granted; measure the other {name}, too"
            )
    missing = [body for key, bodies in tables.wear.items() if key not in fitted for body in bodies]
    if fitted and missing:
        (body,) = missing
        wears = "wears as stated" if body in (stated_wear(tables) or "") else "does not wear in the study"
        notes.append(f"no {name} of the {body} is known, which {wears}; measure it, too")
    return fitted, notes


def parted(tables: AnyTables, total: FittedParameter) -> Worn:
    """Wear parameters by key from the coefficient of both bodies together, and a list with a sentence on the
    proportion. If each body has its own coefficient they are in the stated proportion; else the list is empty.
    """
    shares = {key: sum(tables.shares[body] for body in bodies) for key, bodies in tables.wear.items()}
    low, high = total.interval95
    parts = {
        key: FittedParameter(share * total.value, (share * low, share * high), total.unit, total.repeats)
        for key, share in shares.items()
    }
    if len(parts) == 1:
        return parts, []
    proportion = " to ".join(f"{share:.2g}" for share in shares.values())
    return parts, [f"it is parted between {' and '.join(tables.body_names)} as {proportion}"]


def total_of(tables: AnyTables, parameters: Mapping[str, FittedParameter]) -> float | None:
    """Wear coefficient of both bodies together in the parameters' unit, from those fitted; None if none was fitted."""
    known = [parameters[key].value for key in tables.wear if key in parameters]
    return sum(known) if known else None


def stated_wear(tables: AnyTables) -> str | None:
    """Wear that the record states, as a part of a sentence; None if it states none."""
    words = []
    for key in type(tables.stated).WEAR:
        law, found, unit = key.partition("_wear_coefficient_")
        if found and (value := getattr(tables.stated, key)) is not None:
            body = law.rpartition("_")[0]
            words.append(f"{value:.3g} {_UNITS[unit]}" + (f" of the {body}" if body else ""))
    return " and ".join(words) or None


def where_volumes(tables: AnyTables) -> str:
    """Advice on how worn volumes get into the record, as a part of a sentence."""
    names = f"{tables.worn.name}s"
    return f"measure both {names} ({' and '.join(f'[{names}.{body}]' for body in tables.body_names)} of the mapping)"


def _given(
    given: GivenWear, tables: AnyTables, worn: dict[str, FittedParameter], found: dict[str, FittedParameter]
) -> Worn:
    """Wear parameters by name as the user gives them, and sentences on their source. worn, found: what the record
    shows.
    """
    energy = found.get("accumulated_energy_J")
    if given.coefficient_mm3_per_J is not None:
        value = given.coefficient_mm3_per_J
        coefficient = FittedParameter(value, (value, value), "mm3_per_J", 0)
        source = "the wear coefficient is the given one, not a fitted one"
    elif given.volume_mm3 is not None and energy is not None:
        # The volume is one number; only the energies of the tests differ.
        low, high = (given.volume_mm3 / end for end in reversed(energy.interval95))
        coefficient = FittedParameter(given.volume_mm3 / energy.value, (low, high), "mm3_per_J", energy.repeats)
        source = f"the wear coefficient is the given volume of {given.volume_mm3:g} mm³ over the tests' energy"
    else:
        raise RecordError("a worn volume is given, but neither loops nor an evolution show the energy that wore it.")
    measured = total_of(tables, worn)
    beside = "" if measured is None else f"; the scars of the record say {measured:.3g} mm³/J"
    parts, notes = parted(tables, coefficient)
    return worn | parts, [source + beside, *notes]
