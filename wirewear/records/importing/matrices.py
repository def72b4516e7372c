"""Matrices of heights in texts, and what the lines above them state of their scale, in the words of any language."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wirewear.base.delimited import DelimitedText, decoded, fields_of, read_delimited
from wirewear.base.errors import RecordError
from wirewear.base.guessing import GuessedLayout, guessed_layout
from wirewear.base.quantity import FIELD_UNITS
from wirewear.records.importing.map_scale import StatedMap, positive
from wirewear.records.values import Array

#: Tables with fewer columns are points or channels, and no matrix of heights.
NARROWEST = 8

#: Numbers that count lines are even to so many of their own steps.
EVEN = 0.02

_WYKO = "Wyko ASCII Data File"
_LENGTHS = FIELD_UNITS["um"]

Pair = tuple[float, float]


@dataclass(frozen=True)
class Matrix:
    """A text with a matrix: its layout, and what stands above: the size of all of it or of one point, and a unit."""

    guessed: GuessedLayout
    sizes_um: Pair | None = None
    step_um: Pair | None = None
    unit_um: float | None = None

    @property
    def states_scale(self) -> bool:
        """Whether the text says all that is needed to read heights."""
        return (self.sizes_um or self.step_um) is not None and self.unit_um is not None

    def read(self, file: Path) -> StatedMap:
        """The heights with what is stated of them.

        Raises:
            RecordError: a field is no number.
        """
        layout = (self.guessed.tables or (self.guessed.layout,))[0]
        text = read_delimited(file, layout)
        # Numbers need no quotation marks, and are read fast without.
        bare = DelimitedText(file, text.data.replace(b'"', b""), layout) if layout.decimal != layout.delimiter else text
        columns = bare.numbers({str(place): place for place in range(self.guessed.width)}, as_logged=True).columns
        heights = np.stack([columns[str(place)] for place in range(self.guessed.width)])
        heights, places = _without_places(heights, self.guessed.names)
        step = self.step_um
        if step is None and self.sizes_um is not None:
            step = self.sizes_um[0] / heights.shape[0], self.sizes_um[1] / heights.shape[1]
        told = f"; its first row and column count places, {places[0]:g} and {places[1]:g} apart" if places else ""
        return StatedMap(heights, step, self.unit_um, told)


def matrix_of(file: Path) -> Matrix | None:
    """The matrix that a text holds, None where it holds none.

    Raises:
        RecordError: the file cannot be read.
    """
    try:
        guessed = guessed_layout(file)
    except RecordError:
        return None
    if guessed.width < NARROWEST or not all(_is_number(name) for name in guessed.names[1:]):
        return None
    if guessed.names:
        # Places along x are no names.
        layout = replace(guessed.layout, names_line=False, header_lines=guessed.layout.lines_before_rows)
        guessed = replace(guessed, layout=layout, tables=())
    data, _ = decoded(file)
    text = data.decode(guessed.layout.encoding, errors="replace").splitlines()[: guessed.layout.header_lines]
    if text and text[0].startswith(_WYKO):
        return _of_wyko(guessed, text)
    pixel, unit = _of_pixels([fields_of(line, guessed.layout.delimiter) for line in text])
    sizes, unit_of_values = _of_sizes(text)
    return Matrix(guessed, sizes, pixel, unit if unit_of_values is None else unit_of_values)


def _is_number(text: str) -> bool:
    return re.fullmatch(r"[-+]?\d+(?:[.,]\d+)?", text) is not None


def _of_pixels(rows: Sequence[Sequence[str]]) -> tuple[Pair | None, float | None]:
    """Size of a point and unit of heights of a Keyence export: a calibration with its unit, and a unit."""
    pixel, unit = None, None
    for row in rows:
        if len(row) >= 3 and row[2] in _LENGTHS and (number := positive(row[1])) is not None:
            pixel = pixel or number * _LENGTHS[row[2]]
        elif len(row) >= 2 and row[1] in _LENGTHS:
            unit = _LENGTHS[row[1]]
    return None if pixel is None else (pixel, pixel), unit


def _of_sizes(lines: Sequence[str]) -> tuple[Pair | None, float | None]:
    """The same of a Gwyddion export: width, height and unit of the values, in this order in every language."""
    sizes, unit = [], None
    for line in (own for own in lines if own.startswith("#")):
        found = re.search(r"[:=：]\s*(?:([-+\d.,eE]+)\s*)?(\S+)\s*$", line)
        if found is None or found[2] not in _LENGTHS:
            continue
        if found[1] and (number := positive(found[1])) is not None:
            sizes.append(number * _LENGTHS[found[2]])
        elif not found[1]:
            unit = _LENGTHS[found[2]]
    return (sizes[0], sizes[1]) if len(sizes) >= 2 else None, unit


def _of_wyko(guessed: GuessedLayout, lines: Sequence[str]) -> Matrix:
    """Wyko's text: the pixel in mm, its shape, and heights in nm, or in waves where the first line's second flag is 0.

    As Gwyddion and SurfaceTopography read it; the latter does not divide by a whole number of waves (``Mult 6``).
    """
    words = [line.split() for line in lines]
    told = {own[0]: positive(own[-1]) for own in words if len(own) > 1}
    pixel, aspect, wave = (told.get(key) for key in ("Pixel_size", "Aspect", "Wavelength"))
    in_nm = words[0][len(_WYKO.split()) + 1 :][1:2] == ["1"]
    unit = 1e-3 if in_nm else None if wave is None else 1e-3 * wave / (told.get("Mult") or 1.0)
    step = None if pixel is None else (1e3 * pixel * (aspect or 1.0), 1e3 * pixel)
    if rows := told.get("X"):
        # Intensities may stand below.
        guessed = replace(guessed, layout=replace(guessed.layout, most_rows=int(rows)), tables=())
    return Matrix(guessed, step_um=step, unit_um=unit)


def _without_places(heights: Array, names: Sequence[str]) -> tuple[Array, Pair | None]:
    """Heights (n_x, n_y) without a first row and column that count places, and the steps in which they count."""
    if names:
        along = np.array([float(name.replace(",", ".")) for name in names[1:]])
        beside, inside = heights[0], heights[1:]
    else:
        along, beside, inside = heights[1:, 0], heights[0, 1:], heights[1:, 1:]
    steps = [_even_step(line) for line in (along, beside)]
    if None in steps:
        return heights, None
    return inside, (steps[0] or 0.0, steps[1] or 0.0)


def _even_step(places: Array) -> float | None:
    """From number to number, where they go up or down evenly; None of other numbers."""
    steps = np.diff(places)
    middle = float(np.median(steps)) if steps.size > 1 else 0.0
    even = middle != 0.0 and bool(np.all(np.abs(steps - middle) < EVEN * abs(middle)))
    return abs(middle) if even else None
