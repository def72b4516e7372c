"""Standard streams as they may be: closed, or unable to show the signs of the field."""

import codecs
import io
import os
import sys
import unicodedata

#: Signs that Unicode itself has no plain spelling of.
_PLAIN = {
    "–": "-",
    "—": "-",
    "−": "-",
    "±": "+-",
    "·": "*",
    "×": "x",
    "→": "->",
    "≤": "<=",
    "≥": ">=",
    "≈": "~",
    "µ": "u",
    "°": " deg",
}


def prepare_streams() -> None:
    """Open what is closed to nowhere, and spell plainly what standard output and error cannot show."""
    codecs.register_error("wirewear.plain", _plainly)
    for descriptor, name in enumerate(("stdin", "stdout", "stderr")):
        stream = getattr(sys, name)
        if stream is None:
            # Else the next file that is opened takes the number, and whatever libraries print goes into it.
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != descriptor:
                os.dup2(opened, descriptor)
                os.close(opened)
            os.set_inheritable(descriptor, True)
            setattr(sys, name, open(descriptor, "w" if descriptor else "r", encoding="utf-8", closefd=False))  # noqa: SIM115 - as long as the program
        elif descriptor and isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="wirewear.plain")


def _plainly(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_plain(sign) for sign in error.object[error.start : error.end]), error.end


def _plain(sign: str) -> str:
    """A sign in ASCII: what stands for it, its letter without accents, a Greek letter's name, or a question mark."""
    if sign in _PLAIN:
        return _PLAIN[sign]
    simple = unicodedata.normalize("NFKD", sign).encode("ascii", "ignore").decode()
    name = unicodedata.name(sign, "")
    return simple or (name.rpartition(" ")[2].lower() if name.startswith("GREEK") else "?")
