"""What a run has left in its folder: the whole result, or the checkpoint at which it goes on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from wirewear.errors import RunError
from wirewear.results import RESULT_FILE_NAME, RunResult, read_result, write_result
from wirewear.simulation.checkpoint import CHECKPOINT_FILE_NAME, Checkpoint, read_checkpoint


@dataclass(frozen=True)
class RunFolder:
    """The folder of the run of an identity (see `RunPlan.identity`)."""

    path: Path
    identity: str

    def complete_result(self) -> RunResult | None:
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

    def interrupted(self) -> tuple[Checkpoint, RunResult] | None:
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

    def result(self) -> RunResult:
        """The result as it is on disk."""
        return read_result(self.path / RESULT_FILE_NAME)

    def write(self, result: RunResult) -> None:
        """Write or replace the result."""
        write_result(self.path / RESULT_FILE_NAME, result)

    def drop_checkpoint(self) -> None:
        """Delete the checkpoint, if there is one."""
        (self.path / CHECKPOINT_FILE_NAME).unlink(missing_ok=True)

    def _require_same(self, identity: object) -> None:
        if identity != self.identity:
            raise RunError(
                f"{self.path} holds a run of another study, fidelity or version of wirewear, which cannot be "
                "resumed; choose another --output, or run without --resume to replace it"
            )
