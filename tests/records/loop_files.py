"""Loggers' files of a loop, and mappings that read them."""

from pathlib import Path
from typing import Any

from tests.studies import wires_in_test

SAMPLES, FREQUENCY_Hz = 128, 4.0
HEAD = wires_in_test("test 3", cycles=1000, frequency_Hz=FREQUENCY_Hz)


def mapped(folder: Path, loops: str) -> Path:
    path = folder / "mapping.toml"
    path.write_text(HEAD + loops, encoding="utf-8")
    return path


def german(time: Any, displacement: Any, force: Any) -> str:
    """A logger's file: header, units, semicolons, decimal commas, mm and mN, the force's sign reversed."""
    rows = [
        f"{t:.6f};{1e-3 * x:.7f};{-1e3 * q:.4f}".replace(".", ",")
        for t, x, q in zip(time, displacement, force, strict=True)
    ]
    return "\r\n".join(["Prüfstand 2", "a", "b", "c", "d", "Zeit;Weg;Kraft", "s;mm;mN", *rows, ""])


GERMAN = """
[loops]
files = "cycle_*.txt"
name_pattern = 'cycle_(?P<cycle>\\d+)_rep(?P<repeat>\\d+)'
encoding = "latin-1"
delimiter = "semicolon"
decimal = ","
header_lines = 5
lines_after_names = 1
[loops.columns]
time_s = "Zeit"
displacement_um = { column = "Weg", unit = "mm" }
tangential_force_N = { column = "Kraft", unit = "mN", factor = -1.0 }
"""

STEEL = {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3}
