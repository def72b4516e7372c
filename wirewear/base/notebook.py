"""HTML in which notebooks show values."""

import base64
from collections.abc import Mapping, Sequence
from html import escape


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
