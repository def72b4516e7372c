"""JSON files that studies read, with one sentence for whatever prevents that."""

import json
from pathlib import Path
from typing import Any

from wirewear.base.errors import WirewearError
from wirewear.base.files import read_text


def read_json(path: Path, kind: type[WirewearError], what: str = "JSON file") -> Any:
    """What a JSON file holds. Raises WirewearError, of the given kind, if it cannot be read, or is no JSON."""
    return parsed_json(read_text(path, kind, what), str(path), kind)


def parsed_json(text: str | bytes, where: str, kind: type[WirewearError]) -> Any:
    """What a JSON text holds; `where` names its origin in messages.
    Raises WirewearError, of the given kind, if the text is no JSON.
    """
    try:
        return json.loads(text)
    except RecursionError:
        raise kind(f"{where} cannot be read as JSON (it is nested too deep).") from None
    except ValueError as problem:
        raise kind(f"{where} cannot be read as JSON ({problem}).") from None
