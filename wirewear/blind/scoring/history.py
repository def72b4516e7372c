"""The log of scored runs: who scores a batch again, after having seen its key, is counted."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from wirewear.errors import BlindError
from wirewear.files import write_text
from wirewear.files.identity import code_hash

LOG, SCORE_JSON = "scored_runs.jsonl", "score.json"


def answers_hash(folder: Path) -> str:
    """SHA-256 over all diagnoses in a folder; what scoring has written there does not count."""
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*.json") if path.name != SCORE_JSON):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def logged_run(batch: Path, diagnoses: Path, headline: Mapping[str, Any]) -> dict[str, Any]:
    """Append this run to the batch's log; returns its line with the run's number.

    Raises:
        BlindError: the log cannot be read or written.
    """
    path = batch / LOG
    try:
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        entry = {
            "run": len(lines) + 1,
            "time": datetime.now(UTC).isoformat(timespec="seconds"),
            "wirewear": version("wirewear"),
            "source_sha256": code_hash(),
            "diagnoses_sha256": answers_hash(diagnoses),
            **headline,
        }
        write_text(path, "\n".join([*lines, json.dumps(entry, sort_keys=True)]) + "\n")
    except OSError as problem:
        raise BlindError(f"the log {path} cannot be written ({problem.strerror or problem}).") from None
    entry["different_diagnoses_before"] = _different(lines, entry["diagnoses_sha256"])
    return entry


def _different(lines: list[str], own: str) -> int:
    """How many other sets of diagnoses were scored before."""
    hashes = set()
    for line in lines:
        try:
            hashes.add(json.loads(line)["diagnoses_sha256"])
        except (ValueError, KeyError, TypeError):
            raise BlindError(f"{LOG} was altered: one of its lines is no scored run.") from None
    return len(hashes - {own})
