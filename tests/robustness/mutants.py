"""Readers and commands given files in children of a process that has computed nothing: how each ended.

`python -m tests.robustness.mutants BASE` makes what they read in a folder, then answers requests.
"""

import contextlib
import multiprocessing
import os
import pkgutil
import sys
import tempfile
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tests.robustness.readers import Made, Reader, make, readers
from tests.robustness.reading_commands import commands
from tests.robustness.sandbox import MOST_BYTES, ended_in_child
from tests.robustness.served import load_everything, serve
from wirewear import WirewearError
from wirewear.base.memory import MOST_MEMORY_GB

REFUSALS = {"LoopError", "GeometryError", "SolverError", "PatchLeftError"}


def all_readers(base: Path) -> dict[str, Reader]:
    """Readers and commands by name, with the files that were made for them in a folder."""
    made = Made(base)
    return {**readers(made), **commands(made)}


def _outcome(reader: Reader, folder: Path) -> tuple[str, str | None]:
    """In the child: how reading ended, and what is wrong with that."""
    os.environ[MOST_MEMORY_GB] = str(0.5e-9 * MOST_BYTES)
    try:
        with warnings.catch_warnings(), stood_in_for(reader):
            warnings.simplefilter("error")
            reader.read(folder)
    except BaseException as error:  # noqa: BLE001 - any end but a refusal is what is looked for
        if isinstance(error, WirewearError) or type(error).__name__ in REFUSALS:
            message = str(error)
            return "refused", f"no sentence: {message[:200]!r}" if "\n" in message or not message else None
        return "traceback", f"{type(error).__name__}: {str(error)[:200]} ({_where(error)})"
    return "read", None


@contextlib.contextmanager
def stood_in_for(reader: Reader) -> Iterator[None]:
    """Something else stands in for the parts of the program that would simulate."""
    before = []
    for name, stand_in in reader.stand_ins.items():
        place, _, attribute = name.partition(":")
        *parents, last = attribute.split(".")
        owner = pkgutil.resolve_name(f"{place}:{'.'.join(parents)}" if parents else place)
        before.append((owner, last, getattr(owner, last)))
        setattr(owner, last, stand_in)
    try:
        yield
    finally:
        for owner, last, own in before:
            setattr(owner, last, own)


def _where(error: BaseException) -> str:
    """The place that raised an error."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{Path(last.filename).name} line {last.lineno}"


def main(base: Path) -> None:
    """Make the files, and answer requests of a reader's name and the folder that it is to read."""
    load_everything()
    making = multiprocessing.get_context("fork").Process(target=make, args=(base,))
    making.start()
    making.join()
    # Whether temporary files can be made is tried once, by making one.
    tempfile.gettempdir()
    known = all_readers(base)

    def answer(asked: dict[str, Any]) -> dict[str, Any]:
        if not asked:
            return {}
        reader, folder = known[asked["reader"]], Path(asked["folder"])
        return asdict(ended_in_child(lambda: _outcome(reader, folder), folder, [folder / one for one in reader.writes]))

    serve(answer)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
