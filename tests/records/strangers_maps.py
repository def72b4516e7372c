"""Maps of a scar that is known, as profilometers export them in the words of two languages."""

from collections.abc import Callable

import numpy as np

from geometry.arrays import Array
from tests.records.strangers_files import ENGLISH, Language, Written, bracketed, line

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


def with_scar(name: str, contents: str, own: Language, encoding: str = "utf-8", **answers: str) -> Written:
    """A map beside loops."""
    log = bracketed(own)
    return Written({**log.files, name: contents.encode(encoding)}, log.known, answers, scars=True)


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
    values = ("Topography", *(size.replace(".", own.decimal) for size in sizes), "m")
    head = "".join(f"# {word}: {what}\n" for word, what in zip(words, values, strict=True))
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


def rows_of(heights: Array, own: Language, delimiter: str, digits: int = 4) -> str:
    """Lines of heights in the signs of a country."""
    rows = (delimiter.join(f"{z:.{digits}f}".replace(".", own.decimal) for z in row) for row in heights.T)
    return "\n".join(rows) + "\n"


def matrix(delimiter: str, head: str = "", unit: str = "nm", end: str = "") -> Callable[[Language], Written]:
    """Heights alone, as Olympus microscopes and scripts leave them: the scale is asked for."""

    def written(own: Language) -> Written:
        sign = ";" if own.decimal == delimiter else delimiter
        rows = rows_of({"nm": 1e3, "um": 1.0}[unit] * surface()[2], own, sign).replace("\n", f"{end and sign}\n")
        answers = {"step_um": f"{STEP_um}"} | ({} if "Unit" in head else {"height_unit": f'"{unit}"'})
        return with_scar("scar_fixed.csv", head.replace(",", sign) + rows, own, **answers)

    return written


def wyko(in_nm: bool) -> Callable[[Language], Written]:
    """Wyko's text: the pixel in mm, heights in nm, or in halves of a wave; intensities below."""

    def written(own: Language) -> Written:
        head = f"Wyko ASCII Data File Format\t0\t{int(in_nm)}\t1\nX Size\t{ROWS}\nY Size\t{COLUMNS}\n"
        head += "Block Name\tType\tLength\tValue\nWavelength\t7\t4\t632.800000\nAspect\t7\t4\t1.000000\n"
        head += f"Pixel_size\t7\t4\t{1e-3 * STEP_um:.6f}\nMult\t6\t2\t2\nTitle\t5\t20\t\nRAW_DATA\t3\t10004\t\n"
        heights = surface()[2] * (1e3 if in_nm else 2e3 / 632.8)
        rows = rows_of(heights, own, "\t", 6).split("\n")
        rows[3] = rows[3].replace(rows[3].split("\t")[2], "Bad")
        below = "Intensity\t6\t5004\t\n" + "\t".join(["17"] * COLUMNS) + "\n"
        return with_scar("scar_fixed.asc", head + "\n".join(rows) + below, own)

    return written


def places_beside(corner: str) -> Callable[[Language], Written]:
    """Places of rows and columns beside the heights, in a unit that is not stated."""

    def written(own: Language) -> Written:
        x, y, heights = surface()
        lines = [own.delimiter.join([corner, *(f"{1e-3 * one:.3f}".replace(".", own.decimal) for one in x - x[0])])]
        for place, row in zip(y - y[0], rows_of(heights, own, own.delimiter).splitlines(), strict=True):
            lines.append(f"{1e-3 * place:.3f}".replace(".", own.decimal) + own.delimiter + row)
        return with_scar("scar_fixed.csv", "\n".join(lines) + "\n", own, step_um=f"{STEP_um}", height_unit='"um"')

    return written


#: The kinds by their names.
MAPS: dict[str, Callable[[Language], Written]] = {
    "Keyence map": keyence, "Gwyddion map": gwyddion, "Zygo map": zygo, "points with stars": points("***"),
    "points with No Data": points("No Data"), "matrix with tabs": matrix("\t"),
    "matrix with blanks": matrix("  ", unit="um"), "matrix with commas at the ends": matrix(",", end=","),
    "Olympus matrix": matrix(",", "Data Information,,\nImage Data,Height\nUnit,um\n", "um"),
    "Wyko map in nm": wyko(in_nm=True), "Wyko map in waves": wyko(in_nm=False),
    "matrix beside its places": places_beside(""), "matrix below named places": places_beside("y\\x"),
}  # fmt: skip
