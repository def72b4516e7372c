"""How delimited texts may be spelled: what they are asked for by, before any is read."""

import codecs

#: Delimiters by name; None is any white space.
DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "whitespace": None}

_NO_TEXTS = ("idna", "punycode", "unicode-escape", "raw-unicode-escape", "undefined")


def is_encoding_of_text(name: str) -> bool:
    """Whether texts are encoded so; Python calls encodings, too, what packs bytes, or spells hosts or its literals."""
    try:
        return "1,5".encode(name).decode(name) == "1,5" and codecs.lookup(name).name not in _NO_TEXTS
    except (LookupError, ValueError):
        return False
