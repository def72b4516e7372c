"""Where a run keeps what it leaves: a folder, with the result and the checkpoint at which it goes on, or memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, TypeVar

from wirewear.base.errors import ResultError, RunError
from wirewear.base.identity import Identity, digest
from wirewear.base.locks import clear_abandoned, last_noted, occupied
from wirewear.results import RESULT_FILE_NAME, RunResult, read_result, write_result
from wirewear.simulation.checkpoint import CHECKPOINT_FILE_NAME, Checkpoint, read_checkpoint, write_checkpoint

T = TypeVar("T")


class RunStore(Protocol):
    """Where a run keeps its result and its checkpoint."""

    @property
    def identity(self) -> Identity:
        """Equal for runs that give the same result."""

    def interrupted(self) -> tuple[Checkpoint, RunResult] | None:
        """The last checkpoint and the result so far, if the run has come that far."""

    def result(self) -> RunResult:
        """The result as it was written last."""

    def write(self, result: RunResult, /) -> None:
        """Keep the result in place of the one before."""

    def write_checkpoint(self, checkpoint: Checkpoint, /) -> None:
        """Keep the checkpoint in place of the one before."""

    def begin(self) -> None:
        """The run starts from its beginning: nothing of an earlier one is to stay."""

    def drop_checkpoint(self) -> None:
        """Delete the checkpoint, if there is one."""


@dataclass(frozen=True)
class Found:
    """What a run that is to be resumed has left: its result if it is complete; and what its user should be told."""

    complete: RunResult | None = None
    note: str = ""


@dataclass(frozen=True)
class RunFolder:
    """The folder of the run of an identity.

    derived: patterns of the files that are made of a result.
    """

    path: Path
    identity: Identity
    derived: tuple[str, ...] = ()

    def found(self, *, begun: bool) -> Found:
        """What is left of the run; no mesh is loaded for it.

        `begun` says that this run was the last that was begun in the folder, and did not end.

        Raises:
            ResultError: the result is damaged.
            RunError: the folder holds another run.
        """
        stopped = f"{self.path} was interrupted before its first result: it is run anew."
        if not (self.path / RESULT_FILE_NAME).exists():
            return Found(note=stopped if (self.path / CHECKPOINT_FILE_NAME).exists() else "")
        result = self._left(self.result)
        own = Identity.of_text(result.settings.get("identity"))
        if own == self.identity:
            return Found(result if result.status == "complete" else None)
        if own.asked == self.identity.asked:
            return Found(note=f"{self.path} holds this run as another version of the program made it: it is run anew.")
        if begun:
            return Found(note=stopped)
        raise RunError(
            f"{self.path} holds a run of another study or fidelity, or of an early version of wirewear, which cannot "
            "be resumed: choose another --output, or run with --overwrite instead of --resume."
        )

    def interrupted(self) -> tuple[Checkpoint, RunResult] | None:
        """The last checkpoint and the result so far, if the run has come that far.

        Raises:
            ResultError: a file is damaged.
        """
        if not (self.path / RESULT_FILE_NAME).exists():
            return None
        checkpoint = self._left(lambda: read_checkpoint(self.path))
        if checkpoint is None or checkpoint.identity != str(self.identity):
            return None
        result = self._left(self.result)
        return (checkpoint, result) if result.settings.get("identity") == str(self.identity) else None

    def _left(self, read: Callable[[], T]) -> T:
        """What an earlier run has left."""
        try:
            return read()
        except ResultError as problem:
            raise ResultError(
                f"{str(problem).removesuffix('.')}; run with --overwrite instead of --resume."
            ) from problem

    def begin(self) -> None:
        """Nothing of an earlier run stays beside the results to come."""
        for pattern in (CHECKPOINT_FILE_NAME, *self.derived):
            for path in self.path.glob(pattern):
                path.unlink(missing_ok=True)

    def result(self) -> RunResult:
        """The result as it is on disk."""
        return read_result(self.path / RESULT_FILE_NAME)

    def write(self, result: RunResult) -> None:
        """Write or replace the result."""
        write_result(self.path / RESULT_FILE_NAME, result)

    def write_checkpoint(self, checkpoint: Checkpoint) -> None:
        """Write or replace the checkpoint."""
        write_checkpoint(self.path, checkpoint)

    def drop_checkpoint(self) -> None:
        """Delete the checkpoint, if there is one."""
        (self.path / CHECKPOINT_FILE_NAME).unlink(missing_ok=True)


@contextmanager
def occupied_by_runs(
    output: Path, name: str, folders: Sequence[RunFolder], *, resume: bool
) -> Iterator[tuple[Found, ...]]:
    """Hold an output folder for runs; yields what is left of each, nothing unless they are to be resumed.

    A folder in which all are complete is not written to; what a killed run has noted there goes where it may.

    Raises:
        ResultError: a result is damaged.
        RunError: another command is writing to the folder, or it holds other runs, or it cannot be written to.
    """
    asked = digest({"runs": [folder.identity.asked for folder in folders]})

    def found(noted: Mapping[str, Any]) -> tuple[Found, ...]:
        return tuple(folder.found(begun=noted.get("asked") == asked) if resume else Found() for folder in folders)

    before = found(last_noted(output))
    if all(one.complete is not None for one in before):
        clear_abandoned(output)
        yield before
        return
    _refuse_other_runs(output, {folder.path for folder in folders})
    with occupied(output, name, asked=asked) as noted:
        yield found(noted)


def _refuse_other_runs(output: Path, own: set[Path]) -> None:
    """Reading the folder would take the runs in folders of its own for variants of this one."""
    others = [path.parent for path in sorted(output.glob(f"*/{RESULT_FILE_NAME}")) if path.parent not in own]
    if others:
        names = ", ".join(path.name for path in others)
        raise RunError(
            f"{output} holds other runs in folders of its own ({names}), with which these results would be mixed up: "
            "choose another --output, or delete them."
        )


@dataclass
class InMemory:
    """Keeps the last result of a run that leaves no files; such a run cannot be resumed."""

    identity: Identity
    _kept: list[RunResult] = field(default_factory=list)

    def interrupted(self) -> tuple[Checkpoint, RunResult] | None:
        """There is no checkpoint."""
        return None

    def result(self) -> RunResult:
        """The last result."""
        return self._kept[-1]

    def write(self, result: RunResult) -> None:
        """Keep the result."""
        self._kept[:] = [result]

    def write_checkpoint(self, _checkpoint: Checkpoint) -> None:
        """Keep nothing: the run cannot be resumed."""

    def begin(self) -> None:
        """There is nothing of an earlier run."""

    def drop_checkpoint(self) -> None:
        """There is none."""
