"""Lines across a worn flat as stylus instruments export them, in the words of two languages."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from geometry.arrays import Array
from tests.records.strangers_files import ENGLISH, Language, line, of_language, table

#: A flat, tilted, with a parabolic scar of known cross-section.
DEPTH_um, HALF_um, STEP_um, POINTS = 8.0, 200.0, 1.0, 2000
AREA_um2 = 4.0 / 3.0 * DEPTH_um * HALF_um
PLACE: Array = STEP_um * np.arange(POINTS, dtype=np.float64)
_SCAR: Array = np.asarray(DEPTH_um * np.maximum(1.0 - ((PLACE - 1000.0) / HALF_um) ** 2, 0.0))
HEIGHT: Array = np.asarray(3.0 + 2e-3 * PLACE - _SCAR + 0.01 * np.random.default_rng(3).standard_normal(POINTS))


@dataclass(frozen=True)
class Line:
    """A file's text and what is put in place of what it leaves open."""

    text: str
    answers: dict[str, str] = field(default_factory=dict)


def columns(head: str, place: Array | None, height: Array, own: Language, end: str = "") -> Line:
    """A head and rows of one or two numbers, which perhaps end in a delimiter."""
    rows = table([height] if place is None else [place, height], own).replace("\n", f"{end}\n")
    return Line(head + rows)


def headed(head: str, place: Array | None, height: Array, **answers: str) -> Callable[[Language], Line]:
    """A profile in each language's notation; "|" parts fields of the head."""
    return lambda own: Line(columns(head.replace("|", own.delimiter), place, height, own).text, answers)


def dektak(lateral: str, profile: str, unit: str, factor: float, end: str) -> Callable[[Language], Line]:
    """Settings in two columns, names with their units, rows that may end in a delimiter."""

    def written(own: Language) -> Line:
        head = line(own, "Meta Data") + line(own, "Scan Length", "2000") + line(own, "Stylus Force", "3") + "\n"
        if own is not ENGLISH:
            head = line(own, "Metadaten") + line(own, "Scanlänge", "2000") + "\n"
        names = line(own, f"{lateral}(mm)", f"{profile}({unit}){end and own.delimiter}")
        return columns(head + names, 1e-3 * PLACE, factor * HEIGHT, own, end and own.delimiter)

    return written


def units_below(own: Language) -> Line:
    """Names and units in lines of their own."""
    names = ("Lateral", "Vertical") if own is ENGLISH else ("Abstand", "Höhe")
    return columns(line(own, *names) + line(own, "(um)", "(Angstrom)"), PLACE, 1e4 * HEIGHT, own)


def heights_alone(named: str) -> Callable[[Language], Line]:
    """Heights one below another; the head states their distance."""

    def written(own: Language) -> Line:
        pitch = "Pitch" if own is ENGLISH else "Paso"
        head = line(own, "SJ-210") + line(own, pitch, f"1{own.decimal}0", "um") + (f"{named}\n" if named else "")
        made = columns(head, None, HEIGHT, own)
        return made if named else Line(made.text, {"height_um": '{ column = 1, unit = "um" }'})

    return written


def numbered(own: Language) -> Line:
    """The number of each point in place of its place."""
    name = "No." if own is ENGLISH else "Nr."
    head = line(own, name, f"{'Height' if own is ENGLISH else 'Höhe'} [um]")
    return Line(columns(head, PLACE / STEP_um + 1.0, HEIGHT, own).text, {"x_um": of_language(name, "um")})


def depths(own: Language) -> Line:
    """Worn depths."""
    names = ("Position (mm)", "Depth (um)") if own is ENGLISH else ("Posición (mm)", "Profundidad (um)")
    return columns(line(own, *names), 1e-3 * PLACE, _SCAR, own)


#: The kinds by their names.
PROFILES: dict[str, Callable[[Language], Line]] = {
    "Dektak, nm": dektak("Lateral", "Total Profile", "nm", 1e3, ","),
    "Dektak, Å": dektak("Lateral", "Raw", "Å", 1e4, ""),
    "units below": units_below,
    "SurfTest": headed("Device|SJ-410\nEvaluation length|2|mm\nX[mm]|Z[um]\n", 1e-3 * PLACE, HEIGHT),
    "heights alone": heights_alone(""),
    "heights alone, named": heights_alone("Profile (um)"),
    "heights without a pitch": headed("", None, HEIGHT, height_um='{ column = 1, unit = "um" }', step_um=f"{STEP_um}"),
    "two columns": headed(
        "", 1e-3 * PLACE, HEIGHT, x_um='{ column = 1, unit = "mm" }', height_um='{ column = 2, unit = "um" }'
    ),
    "numbered points": numbered,
    "graph curve": headed("Profile 1\nx|y\nm|m\n", 1e-6 * PLACE, 1e-6 * HEIGHT),
    "depths": depths,
}
