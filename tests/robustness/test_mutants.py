"""Mutated inputs of every reader and command: each is read or refused in one sentence, soon, in little memory.

Bytes, words, numbers and lines of studies, mappings, logger files, records, loops, diagnoses, batches, logs, results
and checkpoints are changed, cut, doubled and moved. None ends in a traceback, takes more than 20 s, asks for more than
four gigabytes, writes outside of its output folder, or starts, loads or calls what it was not asked to.
"""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import ceil
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.robustness.changes import changed
from tests.robustness.mutants import all_readers
from tests.robustness.readers import Files, Reader
from tests.robustness.sandbox import FORBIDDEN, Ending
from tests.robustness.served import Served


@st.composite
def mutants(draw: st.DrawFn, reader: Reader) -> Files:
    """A reader's files, of which one to three mutations were made."""
    files = dict(reader.files)
    for _ in range(draw(st.integers(1, 3))):
        name = draw(st.sampled_from(reader.mutated))
        files[name] = draw(changed(files[name]))
    finish = reader.finish
    return {name: finish(data) if finish and name in reader.mutated else data for name, data in files.items()}


def put(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder."""
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)


def ended(sandbox: Served, name: str, reader: Reader, files: Files) -> Ending:
    """How a reader ended on files, and what is wrong with that."""
    with tempfile.TemporaryDirectory() as folder_name:
        folder = Path(folder_name)
        put(files, folder)
        ending = Ending(**sandbox.ask({"reader": name, "folder": folder_name}))
        found = _changed(files, folder, [folder / one for one in reader.writes])
    deeds = [*ending.deeds, *([] if found is None else [f"{found} is not as it was"])]
    unusual = [one for one in deeds if one not in reader.usual]
    wrong = f"not asked for: {unusual[0]}" if unusual else ending.wrong
    return replace(ending, deeds=tuple(deeds), wrong=wrong)


def _changed(files: Mapping[str, bytes], folder: Path, places: Sequence[Path]) -> str | None:
    """A file that came, went or changed where nothing may be written, also by libraries that no hook sees."""
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    differs = [name for name in found & set(files) if (folder / name).read_bytes() != files[name]]
    for name in sorted({*(found ^ set(files)), *differs}):
        if not any((folder / name).is_relative_to(place) for place in places):
            return name
    return None


def taking(sandbox: Served, name: str, reader: Reader) -> Reader:
    """A reader that takes its files as they are, with what it then starts and loads."""
    as_is = ended(sandbox, name, reader, reader.files)
    assert as_is.how == "read", f"{name}: {as_is.how} {as_is.wrong}"
    reader = replace(reader, usual=frozenset(one for one in as_is.deeds if one.startswith(FORBIDDEN)))
    if as_is.wrong is not None:
        # What else it did, such as keeping compiled functions, it does once.
        as_is = ended(sandbox, name, reader, reader.files)
        assert (as_is.how, as_is.wrong) == ("read", None)
    return reader


def endings(sandbox: Served, name: str, reader: Reader) -> list[str]:
    """How a reader ended on mutants, all as it must."""
    found = []

    @settings(max_examples=ceil(settings().max_examples * reader.share / 10))
    @given(mutants(reader))
    def is_read_or_refused(files: Files) -> None:
        ending = ended(sandbox, name, reader, files)
        found.append(ending.how)
        assert ending.wrong is None

    is_read_or_refused()
    return found


@pytest.mark.slow
def test_mutants_of_every_input_are_read_or_refused_in_a_sentence(tmp_path: Path, subtests: pytest.Subtests) -> None:
    # In children of a process of its own: threads of libraries do not survive forks.
    read = 0
    with Served("tests.robustness.mutants", str(tmp_path)) as sandbox:
        sandbox.ask({})
        known = all_readers(tmp_path)
        assert len(known) == 47
        for name, reader in known.items():
            with subtests.test(name):
                read += endings(sandbox, name, taking(sandbox, name, reader)).count("read")
    assert read > 30
