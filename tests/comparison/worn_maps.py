"""Mappings of worn surfaces on balls and flats beside one loop, and the points of their maps, as files."""

from pathlib import Path

import numpy as np

from geometry.arrays import Array

_HEAD = """
format = 1
name = "worn"
[contact]
kind = "{kind}"
{contact}
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 60.0
frequency_Hz = 3.0
cycles = 1
[loops]
files = "loops.csv"
columns = {{ time_s = "time_s", displacement_um = "displacement_um", tangential_force_N = "tangential_force_N" }}
[{surface}.{body}]
files = "{file}"
"""

STEEL = 'material = "steel"\n'
BALL = f"[bodies.ball]\ndiameter_mm = {{diameter_mm}}\n{STEEL}[bodies.flat]\n{STEEL}"
WIRES = f"[wires]\ndiameter_mm = {{diameter_mm}}\n{STEEL}"
CYLINDER = f'shape = "cylinder"\ndiameter_mm = {{diameter_mm}}\n{STEEL}'
CYLINDERS = f"[bodies.lower]\n{CYLINDER}[bodies.upper]\naxis_angle_deg = 90.0\n{CYLINDER}"
PAD = f"length_mm = 10.0\n[pad]\nradius_mm = 6.0\n{STEEL}[specimen]\n{STEEL}"
CONTACTS = {"ball-on-flat": BALL, "crossed-wires": WIRES, "point-contact": CYLINDERS, "cylinder-on-flat": PAD}


def mapping(folder: Path, kind: str, body: str, source: str, file: str = "map.csv", diameter_mm: float = 6.0) -> Path:
    """A mapping of one worn surface, beside a loop of gross slip; `source` are further lines of its table."""
    phase = 2.0 * np.pi * np.arange(64) / 64
    rows = zip(phase / (6.0 * np.pi), 60.0 * np.sin(phase), np.clip(6.0 * np.cos(phase - 0.2), -1.2, 1.2), strict=True)
    table = "\n".join(["time_s,displacement_um,tangential_force_N", *(f"{t:.6g},{x:.6g},{q:g}" for t, x, q in rows)])
    (folder / "loops.csv").write_text(table, encoding="utf-8")
    surface = "profiles" if kind == "cylinder-on-flat" else "scars"
    contact = CONTACTS[kind].format(diameter_mm=diameter_mm)
    text = _HEAD.format(kind=kind, contact=contact, surface=surface, body=body, file=file) + source
    (folder / "mapping.toml").write_text(text, encoding="utf-8")
    return folder / "mapping.toml"


def points(path: Path, lines: tuple[Array, ...], level: Array, name: str = "height_um") -> Path:
    """A table of places along lines x (n_x,) and y (n_y,) and levels (n_x, n_y); those that are NaN are left out."""
    places = [own.ravel() for own in np.meshgrid(*lines, indexing="ij")]
    known = np.isfinite(level.ravel())
    rows = np.column_stack([*places, level.ravel()])[known]
    head = ",".join([*("x_um", "y_um")[: len(lines)], name])
    np.savetxt(path, rows, fmt="%.6g", delimiter=",", header=head, comments="")
    return path


#: Further lines of a table of points, in the frame of the test.
SCAR_HEIGHTS = 'frame = "test"\ncolumns = { x_um = "x_um", y_um = "y_um", height_um = "height_um" }\n'
PROFILE_HEIGHTS = 'columns = { x_um = "x_um", height_um = "height_um" }\n'
