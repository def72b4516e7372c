"""Making a batch: records one by one, each sealed as it is made, then the key and the manifest."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from studies.blind.errors import BlindError
from studies.blind.generators.cases import KINDS, KINDS_OF_OTHERS, NOMINALS, Case, TrueEffect, planned_cases
from studies.blind.generators.files import record_hash, write_traceless
from studies.blind.generators.generator import OTHERS, Generator, MadeRecord
from studies.blind.generators.sizes import drawn_parameters
from studies.blind.sealing import fingerprint, new_key_file, opened, read_key_file, salted, sealed
from wirewear.base.cache import RUN_CODE, code_hash
from wirewear.base.engine import Engine, LocalProcesses
from wirewear.base.errors import RunError
from wirewear.base.locks import occupied
from wirewear.base.memory import free_disk, size_text
from wirewear.base.words import counted
from wirewear.base.writing import json_text, write_bytes, writing

#: What records come from.
CODE = ("studies/blind/generators", "studies/blind/make.py", "studies/blind/sealing.py", *RUN_CODE)

MANIFEST, KEY, WORKSHOP = "manifest.json", "key.json.enc", ".sealed"
FORMAT = 2  #: Keys of format 1 did not bind the records.
LEAST_BYTES = 8_000  #: Of the smallest records.
DRAWS = 8  #: Specimens and sizes of effects are drawn so many times until the contact slips and converges.

Progress = Callable[[int, int], None]


def default_key_path(folder: Path) -> Path:
    """Where the means to open a batch's key is kept: beside the batch, not in it."""
    return folder.resolve().with_name(f"{folder.resolve().name}.key")


def make_batch(
    folder: str | Path,
    *,
    cases: int,
    seed: int,
    generator: Generator,
    tests: int = NOMINALS,
    key_path: Path | None = None,
    jobs: int = 1,
    engine: Engine | None = None,
    progress: Progress | None = None,
) -> Path:
    """Make the records of a batch, or go on with one that was interrupted; returns the manifest's path.

    `tests` is the number of different nominal tests among the cases, the article's being the first. A case that no draw
    of specimens and sizes can make has no record; the key names it, and the score shows how many there are.
    Records are made by `engine`, whose workers must see the folder, or else in up to `jobs` processes.
    Raises BlindError if the folder holds another batch, a file cannot be read or written, or no case can be made.
    """
    folder = Path(folder)
    key_path = key_path or default_key_path(folder)
    if folder.resolve() in key_path.resolve().parents:
        raise BlindError(f"the key file {key_path} would lie among the records: keep it elsewhere.")
    if folder.exists() and not folder.is_dir():
        raise BlindError(f"{folder} is a file: name a new folder for the records.")
    workshop = folder / WORKSHOP
    prepared, finished = workshop.is_dir(), (folder / MANIFEST).exists()
    if not prepared and not finished and folder.exists() and any(folder.iterdir()):
        raise BlindError(f"{folder} is not empty and holds no batch: name a new folder.")
    _require_room(folder, cases)
    arguments = {"cases": cases, "seed": seed, "tests": tests, "tier": generator.tier, "model": generator.description}
    if finished:
        sealed_key = opened((folder / KEY).read_bytes(), read_key_file(key_path), str(folder / KEY))
        _check_same(sealed_key, arguments, folder)
        # One that was killed at its very end has left it.
        shutil.rmtree(workshop, ignore_errors=True)
        return folder / MANIFEST
    with occupied(workshop, "blind make"):
        key = _key_of_prepared(workshop / "batch.enc", key_path, arguments, folder)
        planned = planned_cases(
            cases,
            seed,
            generator.library,
            generator.outside,
            tests,
            generator.nominals,
            shares=KINDS_OF_OTHERS if generator.tier == OTHERS else KINDS,
        )
        for done, _ in enumerate(_made(planned, folder, generator, key, engine or LocalProcesses(jobs))):
            if progress is not None:
                progress(done + 1, cases)
        return _seal(folder, planned, arguments, generator, key)


def _require_room(folder: Path, cases: int) -> None:
    """See that the records can be held. Raises BlindError if there is too little disk."""
    needed, free = LEAST_BYTES * cases, free_disk(folder)
    if needed > free:
        raise BlindError(
            f"{counted(cases)} records take {size_text(needed)} of disk at least, of which {size_text(free)} are free: "
            f"make at most {counted(int(free / LEAST_BYTES))}."
        )


def _key_of_prepared(batch: Path, key_path: Path, arguments: dict[str, Any], folder: Path) -> bytes:
    """The key of a batch that starts now, or was started before by the same code."""
    prepared_by = {**arguments, "code": code_hash(CODE)}
    if not batch.exists():
        key = new_key_file(key_path)
        _write(batch, sealed(prepared_by, key))
        return key
    key = read_key_file(key_path)
    known = opened(batch.read_bytes(), key, str(batch))
    _check_same(known, arguments, folder)
    if known.get("code") != prepared_by["code"]:
        raise BlindError(f"{folder} was started by another version of the program: name a new folder.")
    return key


def _check_same(known: dict[str, Any], arguments: dict[str, Any], folder: Path) -> None:
    for name, value in arguments.items():
        if known.get(name) != value:
            raise BlindError(f"{folder} holds a batch with other arguments ({name}): name a new folder.")


def _made(planned: Sequence[Case], folder: Path, generator: Generator, key: bytes, engine: Engine) -> Iterator[Case]:
    """Every case as soon as its record and its sealed truth are on disk."""
    there = [case for case in planned if _is_made(folder, case, key)]
    missing = [case for case in planned if case not in there]
    yield from there
    if isinstance(engine, LocalProcesses) and (engine.workers == 1 or len(missing) < 2):
        for case in missing:
            _make_one(case, folder, generator, key)
            yield case
        return
    tasks = [partial(_make_one, case, folder.resolve(), generator, key) for case in missing]
    for done in engine.done(tasks):
        done.value()
        yield missing[done.place]


def _is_made(folder: Path, case: Case, key: bytes) -> bool:
    """Whether a case is noted as unmade, or its record is as it was made."""
    if _sealed_at(_unmade(folder / WORKSHOP, case), key) is not None:
        return True
    made = _sealed_at(folder / WORKSHOP / case.name, key)
    return made is not None and (folder / case.name).is_dir() and record_hash(folder / case.name) == made["record"]


def _sealed_at(path: Path, key: bytes) -> dict[str, Any] | None:
    """What was sealed there; None where nothing was, or it is damaged, and so is made again."""
    with suppress(BlindError, OSError):
        return opened(path.read_bytes(), key, str(path))
    return None


def _unmade(workshop: Path, case: Case) -> Path:
    """Where it is noted that a case cannot be made."""
    return workshop / f"{case.name}.unmade"


def _make_one(case: Case, folder: Path, generator: Generator, key: bytes) -> None:
    try:
        case, made, redrawn = _slipping(case, generator)
    except RunError as problem:
        effects = [asdict(effect) for effect in case.effects]
        note = {"case": case.name, "kind": case.kind, "effects": effects, "reason": str(problem)}
        _write(_unmade(folder / WORKSHOP, case), sealed(note, key))
        return
    # One without its truth, or that is not as it was made, is replaced.
    shutil.rmtree(folder / case.name, ignore_errors=True)
    digest = write_traceless(folder / case.name, made.record)
    _write(folder / WORKSHOP / case.name, sealed({"truth": truth_of(case, made, redrawn), "record": digest}, key))


def _slipping(case: Case, generator: Generator) -> tuple[Case, MadeRecord, int]:
    """The case, its record, and how often specimens and sizes of its effects were drawn again.
    Raises RunError, with the last one's reason, if no draw could be made.
    """
    for attempt in range(DRAWS - 1):
        try:
            return case, generator.make(case), attempt
        except RunError:
            pass
        random = np.random.default_rng([case.seed, attempt])
        effects = tuple(
            TrueEffect(e.effect, drawn_parameters(e.effect, case.ease or "hard", case.nominal, random))
            for e in case.effects
        )
        case = replace(case, effects=effects, seed=int(random.integers(2**63)))
    return case, generator.make(case), DRAWS - 1


def truth_of(case: Case, made: MadeRecord, redrawn: int) -> dict[str, Any]:
    """What the key says of a case."""
    return {
        "case": case.name,
        "kind": case.kind,
        "ease": case.ease,
        "effects": [asdict(effect) for effect in case.effects],
        "redrawn": redrawn,
        "left_out": list(case.left_out),
        "gap_in_scatter": made.gap_in_scatter,
        "weaker_in_scatter": made.weaker_in_scatter,
        "differences": dict(made.differences),
        "nominal": asdict(case.nominal),
        "nuisances": asdict(made.nuisances),
    }


def _seal(folder: Path, planned: Sequence[Case], arguments: dict[str, Any], generator: Generator, key: bytes) -> Path:
    workshop = folder / WORKSHOP
    unmade = [note for case in planned if (note := _sealed_at(_unmade(workshop, case), key)) is not None]
    never = {note["case"] for note in unmade}
    planned = [case for case in planned if case.name not in never]
    if not planned:
        first = unmade[0]
        raise BlindError(f"no case can be made in {DRAWS} draws each; {first['case']}: {first['reason']}")
    for case in planned:
        if not _is_made(folder, case, key):
            raise BlindError(
                f"{folder / case.name} is not as it was made: it is damaged, or was changed; the same command makes it "
                "again."
            )
    made = [opened((workshop / case.name).read_bytes(), key, case.name) for case in planned]
    truths = [one["truth"] for one in made]
    hashes = {case.name: one["record"] for case, one in zip(planned, made, strict=True)}
    said = {"tier": generator.tier, "model": generator.description, "wirewear": version("wirewear")}
    truth = salted({"format": FORMAT, **arguments, **said, "records": hashes, "truths": truths, "unmade": unmade})
    manifest = {
        "format": FORMAT,
        **said,
        "key_sha256": fingerprint(truth),
        "cases": {case.name: {"left_out": list(case.left_out), "sha256": hashes[case.name]} for case in planned},
    }
    _write(folder / KEY, sealed(truth, key))
    _write(folder / MANIFEST, (json_text(manifest, indent=1) + "\n").encode())
    shutil.rmtree(workshop)
    return folder / MANIFEST


def _write(path: Path, data: bytes) -> None:
    with writing(BlindError, f"cannot write {path}"):
        write_bytes(path, data)
