"""Common frame of all HTML pages, and tables for notebooks: one style, a sentence first, everything in one file."""

import base64
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from importlib.metadata import PackageNotFoundError, version
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from wirewear.base.words import counted

if TYPE_CHECKING:
    import jinja2

Filter = Callable[..., object]  #: What a template calls on a value.
HERE = Path(__file__).parent

#: Okabe and Ito's colour-blind safe palette, in the order in which variants take it.
VARIANT_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")

#: Depth in red, green and blue: matplotlib's magma, from the pale unworn surface to the dark bottom of the scar.
_MAGMA = bytes.fromhex(
    "fcf4b6fcecaefde3a5fdda9cfed194fec88cfebf84feb67cfeae77fea36ffd9b6bfd9266fc8961fa7f5ef8765cf66c5c"
    "f2645cee5b5ee95462e34e65de4968d5446dcf4070c53c74bf3a77b5367aae347ba6317d9e2f7f982d808e2a81882781"
    "7e24827822816e1e81681c815f187f59157e51127c491078400f7438106c2f116327125820114b19103f130d340e0b2b"
)
DEPTH_SHADES = tuple(zip(_MAGMA[::3], _MAGMA[1::3], _MAGMA[2::3], strict=True))

#: How the program is cited where a page says so; CITATION.cff says the same.
CITATION = (
    "wirewear: simulation of fretting tests, and diagnosis of why simulation and rig disagree, version {version}, "
    "GPL-3.0-or-later."
)


def rendered(template: Path, values: Mapping[str, object], filters: Mapping[str, Filter] | None = None) -> str:
    """HTML page from a Jinja template that extends frame.html, filled with these values. filters: by name, what
    templates may call besides; None: nothing.
    """
    own = _version()
    return environment(template.parent, filters).get_template(template.name).render(
        css=(HERE / "frame.css").read_text(encoding="utf-8"),
        version=own,
        citation=CITATION.format(version=own),
        **values,
    )  # fmt: skip


def environment(folder: Path, filters: Mapping[str, Filter] | None = None) -> "jinja2.Environment":
    """Jinja environment for templates in `folder` and beside this file; values are escaped unless marked as safe.
    filters: by name, what templates may call besides; None: nothing.
    """
    import jinja2

    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader([folder, HERE]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
    )
    made.filters |= {"counted": counted, "figure": figure, **(filters or {})}
    return made


def script(*paths: Path) -> str:
    """Contents of several script files joined, for one script element of a page."""
    return "\n".join(path.read_text(encoding="utf-8") for path in paths)


def embedded(data: object) -> str:
    """JSON of plain values that can stand safely inside a script element."""
    return json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")


def inline_svg(image: bytes, name: str) -> str:
    """SVG picture to embed in a page: without its prologue and metadata, all its ids prefixed with `name`."""
    text = image.decode("utf-8")
    text = text[text.index("<svg") :]
    for own in sorted(set(re.findall(r'\bid="([^"]+)"', text)), key=len, reverse=True):
        text = re.sub(rf'(id="|href="#|url\(#){re.escape(own)}(?=["\)])', rf"\g<1>{name}-{own}", text)
    return re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)


def number(value: float, digits: int = 5) -> float | None:
    """Value rounded to this number of significant digits; None if it is not finite."""
    return float(f"{value:.{digits}g}") if isfinite(value) else None


def numbers(values: Iterable[float], digits: int = 5) -> list[float | None]:
    """Values rounded to this number of significant digits, None in place of those that are not finite."""
    return [number(float(value), digits) for value in values]


def figure(value: float | None, digits: int = 3, sign: bool = False) -> str:
    """Number as text for readers, with this number of significant digits and powers of ten as 10ⁿ; a dash for None and
    NaN. sign: True to show a plus sign.
    """
    if value is None or value != value:  # noqa: PLR0124 (NaN)
        return "–"
    if value in (float("inf"), -float("inf")):
        return "∞" if value > 0 else "−∞"
    text = f"{value + 0.0:{'+' if sign else ''}.{digits}g}"
    if "e+0" in text and abs(value) < 1e6:
        text = f"{'+' if sign and value > 0 else ''}{counted(float(text))}"
    head, e, power = text.partition("e")
    if e:
        head += "·10" + "".join("⁰¹²³⁴⁵⁶⁷⁸⁹"[int(c)] if c.isdigit() else "⁻" for c in str(int(power)))
    return head.replace("-", "−")


def _version() -> str:
    try:
        return version("wirewear")
    except PackageNotFoundError:
        return "unknown"


def notebook_table(heading: str, rows: Mapping[str, str], *, note: str = "", pictures: Sequence[bytes] = ()) -> str:
    """HTML with a heading, a line for each row (name, value), a note, and PNG pictures (bytes) below; escapes texts."""
    lines = "".join(
        f"<tr><td style='text-align:left'>{escape(name)}</td><td style='text-align:left'>{escape(value)}</td></tr>"
        for name, value in rows.items()
    )
    images = "".join(
        f"<img alt='' style='max-width:100%' src='data:image/png;base64,{base64.b64encode(one).decode()}'>"
        for one in pictures
    )
    below = f"<p><small>{escape(note)}</small></p>" if note else ""
    return f"<p><strong>{escape(heading)}</strong></p><table>{lines}</table>{below}{images}"
