"""Files as a German laboratory has them of a line contact: a logger's, per millimetre, and a stylus's heights."""

from pathlib import Path

import numpy as np

from tests.synthetic_loops import Recipe, SyntheticLoop
from wirewear.records import LineRecord, MeasuredLoop, MeasuredProfile
from wirewear.records.line_tables import LineRecordTables

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


def write_german(record: LineRecord, folder: Path, noise_um: float = 0.02) -> list[Path]:
    """Loops: Latin-1, decimal commas, mm and N/mm, a force that drives the motion. Heights: askew, off their middle."""
    length, random = record.tables.contact.length_mm, np.random.default_rng(1)
    written = []
    for loop in record.loops:
        assert loop.normal_force_N is not None
        columns = (1e-3 * loop.displacement_um, -loop.tangential_force_N / length, loop.normal_force_N / length)
        head = "Prüfstand;7\n\nZeit;Weg;Reibkraft;Normalkraft\ns;mm;N/mm;N/mm\n"
        path = folder / f"Versuch{loop.repeat}_Zyklus{loop.cycle}.txt"
        path.write_bytes((head + _rows(loop.time_s, *columns)).encode("latin-1"))
        written.append(path)
    for profile in record.scars:
        x = profile.x_um
        height = 4.0 + 0.003 * x - profile.depth_um + noise_um * random.standard_normal(x.size)
        if profile.body == "pad":
            face = record.tables.pad.profile
            height += 1e3 * face.height(np.column_stack([1e-3 * (x - 9.0), 0.0 * x]))
        path = folder / f"Profil_{'Zylinder' if profile.body == 'pad' else 'Probe'}_{profile.repeat}.csv"
        path.write_bytes(("X [mm];Z [µm]\n" + _rows(1e-3 * x + 12.0, height)).encode("latin-1"))
        written.append(path)
    return written


def _rows(*columns: np.ndarray) -> str:
    lines = (";".join(f"{value:.7g}" for value in row) for row in zip(*columns, strict=True))
    return "\n".join(lines).replace(".", ",") + "\n"
