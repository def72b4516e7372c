"""Maps of a scar that is known, as profilometers export them in the words of two languages."""

from collections.abc import Callable

import numpy as np

from tests.strangers_files import ENGLISH, Array, Language, Written, bracketed, line

#: A scar on a wire of 0.45 mm along x: an elliptic bowl of known volume.
DEPTH_um, HALF_um, STEP_um, COLUMNS, ROWS, DIAMETER_mm = 15.0, 80.0, 5.0, 61, 41, 0.45


def surface() -> tuple[Array, Array, Array]:
    """Places x (n_x,), y (n_y,) and heights (n_x, n_y) in µm of the worn wire."""
    x, y = (np.asarray(STEP_um * (np.arange(count) - (count - 1) / 2)) for count in (COLUMNS, ROWS))
    radius = 500.0 * DIAMETER_mm
    wire = np.sqrt(radius**2 - y**2)[None, :] - radius
    noise = 0.02 * np.random.default_rng(2).standard_normal((COLUMNS, ROWS))
    return x, y, wire - bowl(x, y) + noise


def bowl(x: Array, y: Array) -> Array:
    """Depth in µm."""
    return np.asarray(DEPTH_um * np.maximum(1.0 - (x[:, None] ** 2 + y[None, :] ** 2) / HALF_um**2, 0.0))


def volume_mm3() -> float:
    """Of a paraboloid."""
    return 1e-9 * 0.5 * np.pi * HALF_um**2 * DEPTH_um


def with_scar(name: str, contents: str, own: Language, encoding: str = "utf-8") -> Written:
    """A map beside loops."""
    log = bracketed(own)
    return Written({**log.files, name: contents.encode(encoding)}, log.known, scars=True)


def keyence(own: Language) -> Written:
    """A confocal microscope's export, all in quotation marks."""
    words = ("Unit", "Height", "XY Calibration") if own is ENGLISH else ("Einheit", "Höhe", "XY-Justierung")
    x, _, heights = surface()
    pixel = f"{1e3 * (x[1] - x[0]):.3f}".replace(".", own.decimal)
    rows = [["Messdatum", "2019-05-08 14:11:31"], ["Data type", "ImageDataCsv"], [words[2], pixel, "nm"]]
    rows += [["Horizontal", str(COLUMNS)], ["Vertikal", str(ROWS)], [words[0], "µm"], ["Reference data name", ""]]
    head = "".join(line(own, *(f'"{one}"' for one in row)) for row in rows) + f'\n"{words[1]}"\n'
    quoted = [[f'"{z:.3f}"'.replace(".", own.decimal) for z in row] for row in heights.T]
    text = head + "\n".join(own.delimiter.join(row) for row in quoted)
    return with_scar("scar_fixed.csv", text, own, "utf-8-sig" if own is ENGLISH else "cp1252")


def gwyddion(own: Language) -> Written:
    """Gwyddion's export with its header translated."""
    words = (
        ("Channel", "Width", "Height", "Value units") if own is ENGLISH else ("Kanal", "Breite", "Höhe", "Einheiten")
    )
    _, _, heights = surface()
    sizes = (f"{STEP_um * COLUMNS:.2f} µm", f"{STEP_um * ROWS:.2f} µm")
    told = ("Topography", *(size.replace(".", own.decimal) for size in sizes), "m")
    head = "".join(f"# {word}: {what}\n" for word, what in zip(words, told, strict=True))
    rows = ("\t".join(f"{1e-6 * z:.6e}".replace(".", own.decimal) for z in row) for row in heights.T)
    return with_scar("scar_fixed.txt", head + "\n".join(rows) + "\n", own)


def zygo(own: Language) -> Written:
    """An interferometer's points: pixels, µm, No Data, the pixel's size in metres in the eighth line."""
    head = ["Zygo XYZ Data File - Format 1", '0 3 0 0 "Tue"', f"0 0 {COLUMNS} {ROWS} 1 255", f"0 0 {COLUMNS} {ROWS}"]
    head += ["", "", "", f"0 0 6.328e-07 0.5 1 0 {1e-6 * STEP_um:g} 1787677163", '3 2 0 0 0 6 0 ""', "0 0 1 33", "0 1"]
    head += ['0 ""', "1 5 0", "#"]
    _, _, heights = surface()
    missing = np.random.default_rng(5).random(heights.shape) < 0.02
    rows = [
        f"{i} {j} {'No Data' if missing[i, j] else f'{heights[i, j]:.4f}'}" for j in range(ROWS) for i in range(COLUMNS)
    ]
    return with_scar("scar_fixed.xyz", "\n".join([*head, *rows, "#", ""]), own)


def points(missing_word: str) -> Callable[[Language], Written]:
    """Points without names, of which some were not measured."""

    def written(own: Language) -> Written:
        x, y, heights = surface()
        missing = np.random.default_rng(5).random(heights.shape) < 0.02
        rows = [
            "\t".join([f"{x[i]:.1f}", f"{y[j]:.1f}", missing_word if missing[i, j] else f"{heights[i, j]:.4f}"])
            for j in range(ROWS)
            for i in range(COLUMNS)
        ]
        return with_scar("scar_fixed.xyz", "\n".join(rows).replace(".", own.decimal), own)

    return written


#: The kinds by their names.
MAPS: dict[str, Callable[[Language], Written]] = {
    "Keyence map": keyence,
    "Gwyddion map": gwyddion,
    "Zygo map": zygo,
    "points with stars": points("***"),
    "points with No Data": points("No Data"),
}
