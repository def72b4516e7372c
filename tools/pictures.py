"""Every picture of the documentation, drawn again by the commands that stand here or beside it in the gallery.

    python -m tools.pictures [PICTURE]...

Runs go to runs/pictures and runs/gallery and are used again. All pictures take an hour of one core.
"""

import re
import shlex
import subprocess
import sys
from pathlib import Path

from PIL import Image

from tests.browser import browser

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
_WIDE, _HIGH, _COLOURS = 1275, 790, 255

_ACCURACY = "runs/pictures/accuracy"
_RECORD = "studies/steel_wires/example_records/rigid_stated_compliant_rig"
_MESH = "wirewear mesh studies/steel_wires/study.toml --output runs/pictures/mesh"
_STEEL = (
    "wirewear run studies/steel_wires/study.toml --variant compliant --fidelity standard --output runs/pictures/steel"
)

#: Commands of the pictures outside the gallery, the last with the file that it leaves; of a page, its top is shown.
_WARM = ("runs/pictures/heat/steel", "runs/pictures/heat/titanium")

DRAWN = {
    **{
        f"accuracy_{name}.png": (f"python -m studies.benchmarks.accuracy --output {_ACCURACY}  # accuracy_{name}.png",)
        for name in ("fresh", "levels", "partial_slip")
    },
    "boundary_conditions.png": (f"{_MESH}  # boundary_conditions.png",),
    "coats.png": (
        "wirewear run studies/coat/study.toml --fidelity quick --output runs/pictures/coat",
        "python -m studies.coat.draw runs/pictures/coat --output runs/drawn  # coats.png",
    ),
    "compared.png": (
        f"wirewear fit {_RECORD} --output runs/pictures/fit",
        f"wirewear compare runs/pictures/fit/run {_RECORD} --output runs/pictures/compared  # loops.png",
    ),
    "diagnosed.png": (f"wirewear diagnose {_RECORD} --output runs/pictures/diagnosis  # report.html",),
    "debris.png": (
        "wirewear run studies/debris/study.toml --fidelity quick --output runs/pictures/debris",
        "python -m studies.debris.draw runs/pictures/debris --output runs/drawn  # debris.png",
    ),
    "effects.png": ("python -m studies.effects.gallery --output runs/pictures/effects  # effects.png",),
    "first_loop.png": (
        f"install -D --mode 644 {_RECORD}/loops.csv runs/pictures/log/loops.csv",
        "rm -f runs/pictures/log/mapping.toml",
        "wirewear new --mapping runs/pictures/log/loops.csv --diameter 0.45",
        "wirewear import runs/pictures/log/mapping.toml --dry-run --output runs/pictures/log/a  # ../a_first_loop.png",
    ),
    "heat.png": (
        _STEEL,
        "wirewear heat runs/pictures/steel --conductivity 46 --heat-capacity 3.6 --cycle 1000  # heat/heat.png",
    ),
    "heat_cycles.png": (
        *(f"wirewear run studies/heat/{of.rpartition('/')[2]}.toml --fidelity quick --output {of}" for of in _WARM),
        f"python -m studies.heat.draw {' '.join(_WARM)} --output runs/drawn  # heat_cycles.png",
    ),
    "inside.png": (_STEEL, "wirewear fields runs/pictures/steel --cycle 100  # fields/section_0000100_016.png"),
    "mechanism.png": ("python -m studies.rope_wires.mechanism --output runs/pictures/mechanism  # mechanism.png",),
    "mesh.png": (f"{_MESH}  # mesh.png",),
    "own_bodies.png": (
        "wirewear mesh studies/own_body/study.toml --output runs/pictures/own_body  # upper_of_file.png",
    ),
    "partial_slip.png": (
        "python -m studies.benchmarks.partial_slip --output runs/pictures/partial_slip  # partial_slip.png",
    ),
    "scars_3d.png": (_STEEL, "wirewear show runs/pictures/steel  # pictures/scars_3d.png"),
    "yielding_wires.png": (
        "wirewear run studies/yielding_wires/study.toml --fidelity quick --output runs/pictures/yielding",
        "python -m studies.yielding_wires.draw runs/pictures/yielding --output runs/drawn  # yielding_wires.png",
    ),
    "tribometers.png": ("python -m studies.tribometers.article --output runs/pictures/tribometers  # tribometers.png",),
}


def commands_of(picture: str) -> tuple[str, ...]:
    """The lines that draw a picture of docs/. Raises KeyError if there are none."""
    return DRAWN[picture] if picture in DRAWN else _gallery()[picture]


def _gallery() -> dict[str, tuple[str, ...]]:
    """The lines of each picture of the gallery, which stand before it."""
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    found = re.findall(r"^```\n(.*?)^```\n+!\[[^\]]*\]\(([^)]+)\)", text, re.DOTALL | re.MULTILINE)
    return {picture: tuple(lines.splitlines()) for lines, picture in found}


def every_picture() -> list[str]:
    """All pictures that a line draws."""
    return [*DRAWN, *_gallery()]


def draw(picture: str) -> None:
    """Run a picture's commands and keep what they leave, in few colours."""
    for line in commands_of(picture):
        command, _, left = map(str.strip, line.partition("  #"))
        program, *words = shlex.split(command)
        python = {"wirewear": [sys.executable, "-m", "wirewear"], "python": [sys.executable]}.get(program, [program])
        again = ["--resume"] if words[0] == "run" else []  # A run of that name is finished, or is gone on with.
        subprocess.run([*python, *words, *again], cwd=ROOT, check=True)
    folder = words[words.index("--output") + 1] if "--output" in words else words[1]
    made = (ROOT / folder / left).resolve()
    target = DOCS / picture
    if made.suffix == ".html":
        with browser() as page:
            page.open(made, _WIDE, _HIGH)
            made = page.picture(target)
    image = Image.open(made).convert("RGB")
    image.thumbnail((_WIDE, _WIDE))
    target.parent.mkdir(exist_ok=True)
    image.quantize(_COLOURS, dither=Image.Dither.NONE).save(target, optimize=True)


if __name__ == "__main__":
    for name in sys.argv[1:] or every_picture():
        draw(name)
