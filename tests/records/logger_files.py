"""Files as German and English loggers, a profilometer and a stylus write them, of wires and of a line contact."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from geometry.arrays import Array
from tests.synthetic_loops import Recipe, SyntheticLoop
from wirewear.records import ExperimentRecord, LineRecord, MeasuredLoop, MeasuredProfile, MeasuredScar
from wirewear.records.contact_tables import LineRecordTables

LBF, MIL = 4.4482216152605, 25.4


def _rows(columns: Sequence[Array], delimiter: str, decimal: str) -> str:
    lines = (delimiter.join(f"{value:.7g}" for value in row) for row in zip(*columns, strict=True))
    return "\n".join(lines).replace(".", decimal) + "\n"


def _normal(loop: MeasuredLoop) -> Array:
    assert loop.normal_force_N is not None
    return loop.normal_force_N


def write_german(record: ExperimentRecord, folder: Path) -> list[Path]:
    """One file a cycle, Latin-1, semicolons and decimal commas, a line of units, a force that drives the motion."""
    written = []
    for loop in (one.complete for one in record.loops):
        path = folder / f"Versuch{loop.repeat}_Zyklus{loop.cycle}.txt"
        head = "Prüfstand;7\nPrüfer;Müller\n\nZeit;Weg;Reibkraft;Normalkraft\ns;mm;N;N\n"
        columns = (loop.time_s, 1e-3 * loop.displacement_um, -loop.tangential_force_N, _normal(loop))
        path.write_bytes((head + _rows(columns, ";", ",")).encode("latin-1"))
        written.append(path)
    return [*written, *_scars(record, folder, lambda text: text.replace(".", ","), ";")]


def write_english(record: ExperimentRecord, folder: Path) -> list[Path]:
    """One file a test, tabs, inches and pounds, the cycle in a column of its own."""
    written = []
    for repeat in record.repeats:
        loops = [loop.complete for loop in record.loops if loop.repeat == repeat]
        columns = (
            np.concatenate([loop.time_s + loop.cycle / 3.0 for loop in loops]),
            np.concatenate([np.full(loop.time_s.size, float(loop.cycle)) for loop in loops]),
            np.concatenate([loop.displacement_um for loop in loops]) / MIL,
            np.concatenate([loop.tangential_force_N for loop in loops]) / LBF,
            np.concatenate([_normal(loop) for loop in loops]) / LBF,
        )
        path = folder / f"test{repeat}.txt"
        head = "Time (s)\tCycle\tDisplacement (mil)\tFriction force (lbf)\tNormal load (lbf)\n"
        lines = ("\t".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True))
        path.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
        written.append(path)
    return [*written, *_scars(record, folder, lambda text: text, ",")]


def _scars(record: ExperimentRecord, folder: Path, spelled: Callable[[str], str], delimiter: str) -> list[Path]:
    written = []
    for scar in record.scars:
        path = folder / f"scar_{scar.body}_{scar.repeat}.xyz"
        x, y, height = height_points(scar, record.tables.wires.diameter_mm)
        rows = (spelled(f"{a:.6g}|{b:.6g}|{c:.7g}") for a, b, c in zip(x, y, height, strict=True))
        text = f"X [mm]{delimiter}Y [mm]{delimiter}Z [µm]\n" + "\n".join(rows).replace("|", delimiter) + "\n"
        path.write_text(text, encoding="utf-8")
        written.append(path)
    return written


def height_points(scar: MeasuredScar, diameter_mm: float) -> tuple[Array, Array, Array]:
    """A profilometer's points x, y [mm] and height [µm] of a worn wire that lies askew on the table."""
    radius = 500.0 * diameter_mm
    margin = 60.0
    depth, x, y = np.nan_to_num(scar.depth_um), scar.x_um, scar.y_um
    # The wire's unworn flanks are on the map, too.
    step_x, step_y = float(np.median(np.diff(x))), float(np.median(np.diff(y)))
    more_x, more_y = int(margin / step_x), int(margin / step_y)
    depth = np.pad(depth, ((more_x, more_x), (more_y, more_y)))
    x = x[0] + step_x * (np.arange(depth.shape[0]) - more_x)
    y = y[0] + step_y * (np.arange(depth.shape[1]) - more_y)
    grid_x, grid_y = np.meshgrid(x, y, indexing="ij")
    along, across = (grid_x, grid_y) if scar.body == "moving" else (grid_y, grid_x)
    crown = across - 4.0 - 0.004 * along
    height = 9.0 + 0.01 * along + np.sqrt(np.maximum(radius**2 - crown**2, 0.0)) - radius - depth
    height += 0.05 * np.random.default_rng(scar.repeat).standard_normal(height.shape)
    # On the profilometer's table both wires lie along the map's x.
    table = (grid_x, grid_y, height) if scar.body == "moving" else (grid_y, -grid_x, height)
    known = np.abs(across) < 0.9 * radius
    return 1e-3 * table[0][known] + 12.0, 1e-3 * table[1][known] + 30.0, table[2][known]


LENGTH_mm, LOAD_N, DEPTHS_um = 8.0, 160.0, {"pad": 1.5, "specimen": 2.5}
CYLINDER = {"radius_mm": 6.0}
FLAT = {"face_half_width_mm": 0.3, "edge_radius_mm": 3.0}


def line_record(face: dict[str, float], repeats: int = 2) -> LineRecord:
    """Loops in gross slip and scars that are parabolas, of a contact of 8 mm, without any noise."""
    steel = {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3}
    tables = LineRecordTables.model_validate(
        {
            "format": 1,
            "name": "line",
            "contact": {"kind": "line-contact", "length_mm": LENGTH_mm},
            "pad": face | steel,
            "specimen": steel,
            "conditions": {
                "normal_load_N": LOAD_N,
                "displacement_amplitude_um": 60.0,
                "frequency_Hz": 4.0,
                "cycles": 1000,
            },
            "files": {},
        }
    )
    time, displacement, force = SyntheticLoop(Recipe()).sampled(128)
    loops = [
        MeasuredLoop(repeat, cycle, time / 4.0, displacement, 80.0 * force, np.full(128, LOAD_N))
        for repeat in range(1, repeats + 1)
        for cycle in (1, 100, 1000)
    ]
    x = np.linspace(-700.0, 700.0, 701)
    profiles = [
        MeasuredProfile(repeat, body, x, depth * np.maximum(1.0 - (x / 300.0) ** 2, 0.0))
        for body, depth in DEPTHS_um.items()
        for repeat in range(1, repeats + 1)
    ]
    return LineRecord(tables, tuple(loops), (), tuple(profiles))


def write_line_german(record: LineRecord, folder: Path, noise_um: float = 0.02) -> list[Path]:
    """Loops: Latin-1, decimal commas, mm and N/mm, a force that drives the motion. Heights: askew, off their middle."""
    length, random = record.tables.contact.length_mm, np.random.default_rng(1)
    written = []
    for loop in record.loops:
        assert loop.normal_force_N is not None
        columns = (1e-3 * loop.displacement_um, -loop.tangential_force_N / length, loop.normal_force_N / length)
        head = "Prüfstand;7\n\nZeit;Weg;Reibkraft;Normalkraft\ns;mm;N/mm;N/mm\n"
        path = folder / f"Versuch{loop.repeat}_Zyklus{loop.cycle}.txt"
        path.write_bytes((head + _rows((loop.time_s, *columns), ";", ",")).encode("latin-1"))
        written.append(path)
    for profile in record.scars:
        x = profile.x_um
        height = 4.0 + 0.003 * x - profile.depth_um + noise_um * random.standard_normal(x.size)
        if profile.body == "pad":
            face = record.tables.pad.profile
            height += 1e3 * face.height(np.column_stack([1e-3 * (x - 9.0), 0.0 * x]))
        path = folder / f"Profil_{'Zylinder' if profile.body == 'pad' else 'Probe'}_{profile.repeat}.csv"
        path.write_bytes(("X [mm];Z [µm]\n" + _rows((1e-3 * x + 12.0, height), ";", ",")).encode("latin-1"))
        written.append(path)
    return written
