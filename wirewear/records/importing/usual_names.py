"""Usual names of a logger's columns, in English and German, and their units."""

import re
from collections.abc import Sequence

from wirewear.quantity import FIELD_UNITS, UNITS_PER_LENGTH

#: Usual names of a channel, without their unit, in order of preference.
USUAL_NAMES: dict[str, tuple[str, ...]] = {
    "displacement": ("displacement", "relative_displacement", "disp", "delta", "position", "stroke", "lvdt", "x")
    + ("weg", "verschiebung", "auslenkung", "hub", "position_x", "wegsensor"),
    "force": ("tangential_force", "friction_force", "tangential", "friction", "force", "ft", "q", "fx", "load_cell")
    + ("reibkraft", "tangentialkraft", "querkraft", "reibungskraft", "kraft", "kraft_x", "f_t", "f_x"),
    "normal load": ("normal_force", "normal_load", "fn", "p", "fz", "load")
    + ("normalkraft", "anpresskraft", "last", "kraft_z", "f_n", "f_z"),
    "time": ("time", "t", "elapsed_time", "zeit", "messzeit"),
    "cycle": ("cycle", "cycles", "n", "cycle_number", "zyklus", "zyklen", "zyklusnummer", "lastspiel", "lastspiele"),
    "repeat": ("repeat", "test", "specimen", "run", "wiederholung", "versuch", "prüfling"),
    "x": ("x", "x_position", "pos_x", "position", "distance", "strecke", "messstrecke"),
    "y": ("y", "y_position", "pos_y"),
    "height": ("height", "z", "topography", "hoehe", "höhe", "z_position", "profile", "profil"),
    "depth": ("depth", "wear_depth", "tiefe", "verschleisstiefe", "verschleißtiefe"),
}

#: Unit of the record in which each channel is kept.
UNIT_OF = {
    **dict.fromkeys(("displacement", "x", "y", "height", "depth"), "um"),
    **dict.fromkeys(("force", "normal load"), "N"),
    "time": "s",
}


def recognised(names: Sequence[str], channel: str) -> list[str]:
    """Columns of a channel's usual names, the most usual first."""
    known = units_of(channel)
    stems = [stem_and_unit(name, known)[0] for name in names]
    return [names[stems.index(usual)] for usual in USUAL_NAMES[channel] if usual in stems]


def units_of(channel: str) -> dict[str, float]:
    """Units in which loggers write a channel, those per length of a line contact among them."""
    unit = UNIT_OF.get(channel, "")
    return FIELD_UNITS.get(unit, {}) | UNITS_PER_LENGTH.get(unit, {})


def stem_and_unit(name: str, known: dict[str, float]) -> tuple[str, str | None]:
    """``"Tangential force [N]"`` and ``"tangential_force_N"`` as ``("tangential_force", "N")``."""
    bracketed = re.fullmatch(r"(.+?)[\s_]*[\[(]\s*([^\[\]()]+?)\s*[\])]", name)
    match = bracketed or re.fullmatch(r"(.+?)[\s_/]*[_\[(\s/]\s*([^\s_\[\]()/]+)\s*[\])]?", name)
    stem, unit = (match[1], match[2]) if match and match[2] in known else (name, None)
    return re.sub(r"[\s_]+", "_", stem.strip().lower()), unit
