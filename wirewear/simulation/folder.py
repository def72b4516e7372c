"""Where a run keeps what it leaves: a folder, with the result and the checkpoint at which it goes on, or memory."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from wirewear.errors import RunError
from wirewear.results import RESULT_FILE_NAME
from wirewear.simulation.checkpoint import CHECKPOINT_FILE_NAME, Checkpoint, read_checkpoint, write_checkpoint


class StoredResult(Protocol):
    """What is asked of a run's result."""

    @property
    def status(self) -> str:
        """Running, complete or failed."""

    @property
    def settings(self) -> Mapping[str, Any]:
        """How it was made, with the run's identity."""


Result = TypeVar("Result", bound=StoredResult)


class RunStore(Protocol[Result]):
    """Where a run keeps its result and its checkpoint."""

    @property
    def identity(self) -> str:
        """Equal for runs that give the same result."""

    def interrupted(self) -> tuple[Checkpoint, Result] | None:
        """The last checkpoint and the result so far, if the run has come that far."""

    def result(self) -> Result:
        """The result as it was written last."""

    def write(self, result: Result, /) -> None:
        """Keep the result in place of the one before."""

    def write_checkpoint(self, checkpoint: Checkpoint, /) -> None:
        """Keep the checkpoint in place of the one before."""

    def drop_checkpoint(self) -> None:
        """Delete the checkpoint, if there is one."""


@dataclass(frozen=True)
class RunFolder(Generic[Result]):
    """The folder of the run of an identity; `read` and `write_into` are those of its kind of result."""

    path: Path
    identity: str
    read: Callable[[Path], Result]
    write_into: Callable[[Path, Result], object]

    def complete_result(self) -> Result | None:
        """The result of the run if it has come to its end; no mesh is loaded for it.

        Raises:
            ResultError: the file is damaged.
            RunError: the folder holds another run.
        """
        if not (self.path / RESULT_FILE_NAME).exists():
            return None
        result = self.result()
        self._require_same(result.settings.get("identity"))
        return result if result.status == "complete" else None

    def interrupted(self) -> tuple[Checkpoint, Result] | None:
        """The last checkpoint and the result so far, if the run has come that far.

        Raises:
            ResultError: a file is damaged.
            RunError: the folder holds another run.
        """
        checkpoint = read_checkpoint(self.path)
        if checkpoint is None:
            return None
        self._require_same(checkpoint.identity)
        return checkpoint, self.result()

    def result(self) -> Result:
        """The result as it is on disk."""
        return self.read(self.path / RESULT_FILE_NAME)

    def write(self, result: Result) -> None:
        """Write or replace the result."""
        self.write_into(self.path, result)

    def write_checkpoint(self, checkpoint: Checkpoint) -> None:
        """Write or replace the checkpoint."""
        write_checkpoint(self.path, checkpoint)

    def drop_checkpoint(self) -> None:
        """Delete the checkpoint, if there is one."""
        (self.path / CHECKPOINT_FILE_NAME).unlink(missing_ok=True)

    def _require_same(self, identity: object) -> None:
        if identity != self.identity:
            raise RunError(
                f"{self.path} holds a run of another study, fidelity or version of wirewear, which cannot be "
                "resumed; choose another --output, or run without --resume to replace it"
            )


@dataclass
class InMemory(Generic[Result]):
    """Keeps the last result of a run that leaves no files; such a run cannot be resumed."""

    identity: str
    _kept: list[Result] = field(default_factory=list)

    def interrupted(self) -> tuple[Checkpoint, Result] | None:
        """There is no checkpoint."""
        return None

    def result(self) -> Result:
        """The last result."""
        return self._kept[-1]

    def write(self, result: Result) -> None:
        """Keep the result."""
        self._kept[:] = [result]

    def write_checkpoint(self, _checkpoint: Checkpoint) -> None:
        """Keep nothing: the run cannot be resumed."""

    def drop_checkpoint(self) -> None:
        """There is none."""


def identity_of(parts: Mapping[str, Any]) -> str:
    """The identity of a run that these parts determine."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()
