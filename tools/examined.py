"""Which state of the diagnosis has passed its exam: the blind records, their making and their scores.

    python -m tools.examined        note that the present state has passed; `make test-all` does

The exam takes longer than all other tests together, so `make test` leaves it out while neither the diagnosis nor the
exam is other than in the state that is noted in tests/examined.txt. Frozen scores and all else of it that is slow wait
for `make test-all`, and every session of tests says that they do.
"""

from hashlib import sha256
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
NOTE = ROOT / "tests" / "examined.txt"

#: What the exam examines, and the exam.
EXAMINED = ("wirewear/diagnosis", "studies/blind")
_CODE = (".py", ".toml", ".json")


def state() -> str:
    """A digest of all code that counts."""
    found = sha256()
    for folder in EXAMINED:
        for file in sorted((ROOT / folder).rglob("*")):
            if file.suffix in _CODE:
                found.update(f"{file.relative_to(ROOT)}\n".encode() + file.read_bytes())
    return found.hexdigest()


def is_examined() -> bool:
    """Whether the present state has passed."""
    return NOTE.is_file() and NOTE.read_text(encoding="utf-8").strip() == state()


if __name__ == "__main__":
    NOTE.write_text(f"{state()}\n", encoding="utf-8")
