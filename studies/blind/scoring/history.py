"""The log of scored runs: who scores a batch again, after having seen its key, is counted."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from studies.blind.errors import BlindError
from studies.json_files import parsed_json
from wirewear.base.cache import code_hash
from wirewear.base.files import read_text
from wirewear.base.writing import write_text, writing

LOG, SCORE_JSON = "scored_runs.jsonl", "score.json"


def answers_hash(folder: Path) -> str:
    """SHA-256 over all diagnoses in a folder; what scoring has written there does not count."""
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*.json") if path.name != SCORE_JSON):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def logged_run(batch: Path, diagnoses: Path, headline: Mapping[str, Any], key_path: Path) -> dict[str, Any]:
    """Append this run to the batch's log and to its copy beside the key; returns its line with the run's number.

    Every line holds the SHA-256 of the one before it, and the copy shows when the log was shortened or deleted.
    Raises BlindError if the log was altered, or cannot be read or written.
    """
    path, copy = batch / LOG, key_path.with_name(f"{key_path.name}.scored")
    with writing(BlindError, f"the log {path} cannot be written"):
        lines, kept = (
            read_text(file, BlindError, "log").splitlines() if file.exists() else [] for file in (path, copy)
        )
        _require_whole(path, lines)
        if lines[: len(kept)] != kept:
            raise BlindError(f"{path} was altered or deleted: {copy} knows of {len(kept)} scored runs.")
        entry = {
            "run": len(lines) + 1,
            "time": datetime.now(UTC).isoformat(timespec="seconds"),
            "wirewear": version("wirewear"),
            "source_sha256": code_hash(),
            "diagnoses_sha256": answers_hash(diagnoses),
            "previous_sha256": _hash(lines[-1]) if lines else None,
            **headline,
        }
        text = "\n".join([*lines, json.dumps(entry, sort_keys=True)]) + "\n"
        write_text(path, text)
        # A key may be kept where nothing can be written.
        with suppress(OSError):
            write_text(copy, text)
    before = {json.loads(line)["diagnoses_sha256"] for line in lines}
    return {**entry, "different_diagnoses_before": len(before - {entry["diagnoses_sha256"]})}


def _require_whole(path: Path, lines: Sequence[str]) -> None:
    """See that each line is a scored run, and knows the one before it where it says so.
    Raises BlindError if one is none, or does not.
    """
    for place, line in enumerate(lines):
        entry = parsed_json(line, f"line {place + 1} of {path}", BlindError)
        if not isinstance(entry, dict) or not isinstance(entry.get("diagnoses_sha256"), str):
            raise BlindError(f"{path} was altered: line {place + 1} is no scored run.")
        # Earlier versions chained nothing.
        if place and entry.get("previous_sha256", _hash(lines[place - 1])) != _hash(lines[place - 1]):
            raise BlindError(f"{path} was altered: line {place + 1} does not follow the one before it.")


def _hash(line: str) -> str:
    return hashlib.sha256(line.encode()).hexdigest()
