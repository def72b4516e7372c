"""Scars guessed from a laboratory's files: points in texts, with names or without, and profilometers' maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wirewear.records.importing.guessed_files import FEWEST, GuessedFile, mapped_columns
from wirewear.records.importing.mapping import PROFILOMETER
from wirewear.records.importing.mistaken import OPEN

#: Words in a file's name that tell whose scar it holds.
WIRE_WORDS = {
    "moving": ("moving", "upper", "oben", "oberer", "beweg", "mobile"),
    "fixed": ("fixed", "lower", "unten", "unterer", "fest", "ruhend", "static"),
}


def scars_of(points: Sequence[GuessedFile], maps: Sequence[Path]) -> tuple[dict[str, Any], list[str]]:
    """The tables `[scars.*]` of texts of points and of maps, and what was assumed."""
    scars: dict[str, Any] = {}
    remarks = []
    for text in points:
        if not {"x_um", "y_um"} <= text.columns.keys() or not {"depth_um", "height_um"} & text.columns.keys():
            remarks.append(f"{text.path.name} was left out: neither loops nor a scar were recognised in it")
            continue
        wire = _wire(text.path, scars, remarks)
        columns, told = mapped_columns(text)
        remarks += told
        if not text.named:
            units = ", ".join(unit.replace("um", "µm") for _, unit in text.columns.values())
            remarks.append(f"{text.path.name} names no columns: they are taken for x, y and height in {units}")
        if wire in scars:
            scars[wire]["files"] = [*listed(scars[wire]["files"]), text.path.name]
            continue
        scars[wire] = {"files": text.path.name, **text.spelling, "columns": columns}
        if "height_um" in columns and not any(OPEN in own.values() for own in columns.values()):
            scars[wire]["axis"] = _axis(text, columns)
    for path in maps:
        wire = _wire(path, scars, remarks)
        if wire in scars:
            scars[wire]["files"] = [*listed(scars[wire]["files"]), path.name]
        else:
            scars[wire] = {"files": path.name, "kind": PROFILOMETER, "axis": "x"}
            remarks.append(f'{path.name}: axis = "x" says that the wire runs along the map\'s x; see the dry run')
    return scars, remarks


def listed(files: str | list[str]) -> list[str]:
    """One name or several as a list."""
    return [files] if isinstance(files, str) else files


def _wire(path: Path, scars: dict[str, Any], remarks: list[str]) -> str:
    name = path.stem.lower()
    for wire, words in WIRE_WORDS.items():
        if any(word in name for word in words):
            return wire
    wire = "moving" if "moving" not in scars else "fixed"
    remarks.append(f"{path.name}: nothing in its name tells whose scar it is; it is taken for the {wire} wire's")
    return wire


def _axis(text: GuessedFile, columns: dict[str, Any]) -> str:
    """Along which axis of the map the wire runs: that in which its surface is the straighter."""
    found = text.read(columns)
    x, y, z = (found[key] for key in ("x_um", "y_um", "height_um"))
    known = np.isfinite(x + y + z)
    if np.count_nonzero(known) < FEWEST or min(np.ptp(values[known]) for values in (x, y, z)) <= 0.0:
        return "x"
    x, y, z = ((values[known] - values[known].mean()) / np.ptp(values[known]) for values in (x, y, z))
    bends = np.linalg.lstsq(np.column_stack([x**0, x, y, x * x, x * y, y * y]), z, rcond=None)[0]
    width = {"x": float(np.ptp(found["x_um"][known])), "y": float(np.ptp(found["y_um"][known]))}
    return "x" if abs(bends[3]) / width["x"] ** 2 < abs(bends[5]) / width["y"] ** 2 else "y"
