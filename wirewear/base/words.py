"""Values and names as messages write them."""

from collections.abc import Iterable
from datetime import date, time
from difflib import get_close_matches


def counted(number: float) -> str:
    """A number rounded to a whole one, as text such as 9999; from 10 000 on with thin spaces between thousands."""
    whole = round(number)
    return f"{whole:,}".replace(",", "\u2009") if abs(whole) >= 10_000 else str(whole)


def shown(value: object) -> str:
    """Value as text for a message, shortened to 60 characters."""
    try:
        text = value.isoformat() if isinstance(value, date | time) else repr(value)
    except ValueError:  # an integer of thousands of digits
        return "a number of thousands of digits"
    if isinstance(value, int) and len(text) > 60:
        return f"a number of {len(text.lstrip('-'))} digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def as_sentence(text: str) -> str:
    """Text with a full stop added, unless it already ends with a full stop, question mark or exclamation mark."""
    return text if text.endswith((".", "?", "!")) else f"{text}."


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Known name that is most similar to `name`, ignoring capitals; None if none is similar."""
    by_small = {own.casefold(): own for own in known}
    found = get_close_matches(name.casefold(), by_small, n=1, cutoff=0.6)
    return by_small[found[0]] if found else None
