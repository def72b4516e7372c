"""Guard against a stranger's module named ``geometry`` or ``solvers``.

wirewear stands on two packages with these common names. Where another module of the same name comes first on
Python's path, the first symptom would be a puzzling AttributeError far away; this says at once which file it is.
"""

import sys
from importlib.util import find_spec
from pathlib import Path

SIBLINGS = ("geometry", "solvers")


def require_own_siblings() -> None:
    """Raise ImportError with one clear sentence unless ``geometry`` and ``solvers`` are those beside this package."""
    home = Path(__file__).resolve().parents[2]
    for name in SIBLINGS:
        own = home / name
        found = _location(name)
        if found is None:
            raise ImportError(
                f"wirewear needs its own package '{name}' in {own}, but there is none: install wirewear again."
            )
        if found.resolve() not in (own, own / "__init__.py"):
            raise ImportError(
                f"wirewear needs its own package '{name}' in {own}, but {found} comes first on Python's path: "
                f"rename or remove that one, or start Python from another folder."
            )


def _location(name: str) -> Path | None:
    """File (or, for a package without ``__init__.py``, folder) that ``import name`` would give, or has given."""
    if name in sys.modules:
        module = sys.modules[name]
        file, folders = getattr(module, "__file__", None), list(getattr(module, "__path__", []))
    else:
        spec = find_spec(name)
        if spec is None:
            return None
        file, folders = spec.origin, list(spec.submodule_search_locations or [])
    if file is not None:
        return Path(file)
    return Path(folders[0]) if folders else Path(f"<built-in module {name}>")
