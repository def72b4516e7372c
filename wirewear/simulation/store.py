"""Where a run keeps its result and its checkpoint: in a folder, or nowhere.

The checkpoint is the state of an unfinished run, enough to go on as if it had not been interrupted.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np

from solvers import ContactState, Guide, WearState
from wirewear.base.cache import Identity, digest
from wirewear.base.errors import ResultError, RunError
from wirewear.base.hdf5 import GrowingImage, hdf5_image, opened_hdf5, write_arrays
from wirewear.base.locks import clear_abandoned, last_noted, occupied
from wirewear.base.writing import write_bytes, writing
from wirewear.results import RESULT_FILE_NAME, RunResult, read_result, write_result
from wirewear.simulation.meshes import MeshHistory

CHECKPOINT_FILE_NAME = "checkpoint.h5"
_FORMAT = 5

T = TypeVar("T")


@dataclass(frozen=True)
class Checkpoint:
    """The state of a run after `done` cycles, from which only a run of the same identity can go on. next_jump: size in
    cycles of the jump to try next. guide: first guesses for the next cycle, None for none. counters: as from
    `Tally.for_checkpoint`.
    """

    done: float
    next_jump: float
    state: ContactState
    guide: Guide | None
    counters: dict[str, float]
    meshes: MeshHistory
    identity: str


def _fill(file: h5py.File, checkpoint: Checkpoint) -> None:
    file.attrs["format"] = _FORMAT
    file.attrs["identity"] = checkpoint.identity
    file.attrs["counters"] = json.dumps(checkpoint.counters)
    file.attrs["done"] = checkpoint.done
    file.attrs["next_jump"] = checkpoint.next_jump
    file.attrs["meshes"] = json.dumps({name: getattr(checkpoint.meshes, name) for name in ("stage", "changes", "core")})
    if checkpoint.meshes.moved is not None:
        write_arrays(file, dict(zip(("moved_on_moving", "moved_on_fixed"), checkpoint.meshes.moved, strict=True)))
    _write(file.create_group("state"), checkpoint.state, skip="wear")
    _write(file.create_group("wear"), checkpoint.state.wear)
    if checkpoint.guide is not None:
        _write(file.create_group("guide"), checkpoint.guide)


def read_checkpoint(folder: Path) -> Checkpoint | None:
    """The checkpoint in a run's folder, None without one; ResultError if it is damaged or of another version."""
    path = folder / CHECKPOINT_FILE_NAME
    if not path.exists():
        return None
    with opened_hdf5(path, ResultError, "checkpoint") as file:
        if int(file.attrs["format"]) != _FORMAT:
            raise ResultError(f"{path} is a checkpoint of another version of wirewear.")
        wear = WearState(**_read(file["wear"]))
        meshes = json.loads(file.attrs["meshes"])
        moved = tuple(np.asarray(file[name]) for name in ("moved_on_moving", "moved_on_fixed") if name in file)
        return Checkpoint(
            done=float(file.attrs["done"]),
            next_jump=float(file.attrs["next_jump"]),
            state=ContactState(wear=wear, **_read(file["state"])),
            guide=Guide(**_read(file["guide"])) if "guide" in file else None,
            counters=json.loads(file.attrs["counters"]),
            meshes=MeshHistory(
                meshes["stage"], (moved[0], moved[1]) if moved else None, tuple(meshes["changes"]), meshes.get("core")
            ),
            identity=str(file.attrs["identity"]),
        )


def _write(group: Any, values: WearState | ContactState | Guide, skip: str = "") -> None:
    every = {one.name: getattr(values, one.name) for one in fields(values) if one.name != skip}
    write_arrays(group, {name: value for name, value in every.items() if value is not None})


def _read(group: Any) -> dict[str, Any]:
    return {name: (float(item[()]) if item.shape == () else np.asarray(item[()])) for name, item in group.items()}


@dataclass(frozen=True)
class RunStore:
    """Keeps a run's result and checkpoint; this class keeps neither. identity: equal for runs of equal results."""

    identity: Identity

    def write(self, result: RunResult, /) -> RunResult:
        """Keep the result in place of the one before; return it as it would be read again."""
        return result

    def interrupted(self) -> tuple[Checkpoint, RunResult] | None:
        """(last checkpoint, result so far) of this run; None if there is no checkpoint of it."""
        return None

    def write_checkpoint(self, _checkpoint: Checkpoint, /) -> None:
        """Keep the checkpoint in place of the one before."""
        return

    def begin(self) -> None:
        """Remove what an earlier run has left."""
        return

    def drop_checkpoint(self) -> None:
        """Delete the checkpoint, if there is one."""
        return


@dataclass(frozen=True)
class Found:
    """The remains of a run to be resumed: its result, None if not complete, and a sentence for the user."""

    complete: RunResult | None = None
    note: str = ""


@dataclass(frozen=True)
class RunFolder(RunStore):
    """Result and checkpoint of a run in the folder `path`. derived: patterns of files made from a result."""

    path: Path
    derived: tuple[str, ...] = ()

    @cached_property
    def _so_far(self) -> GrowingImage:
        return GrowingImage()

    def found(self, *, unfinished: bool) -> Found:
        """The remains of the run. unfinished: True if the last command that wrote to the folder asked for this run and
        did not end.
        Raises ResultError if the result is damaged, and RunError if the folder holds another run.
        """
        stopped = f"{self.path} was interrupted before its first result: it is run again."
        if not (self.path / RESULT_FILE_NAME).exists():
            return Found(note=stopped if (self.path / CHECKPOINT_FILE_NAME).exists() else "")
        result = self._left(self.result)
        own = Identity.of_text(result.settings.get("identity"))
        if own == self.identity:
            return Found(result if result.status == "complete" else None)
        if own.asked == self.identity.asked:
            return Found(note=f"{self.path} holds this run as another version of the program made it: it is run again.")
        if unfinished:
            return Found(note=stopped)
        raise RunError(
            f"{self.path} holds a run of another study or fidelity, or of an early version of wirewear, which cannot "
            "be resumed: choose another --output, or run with --overwrite instead of --resume."
        )

    def interrupted(self) -> tuple[Checkpoint, RunResult] | None:
        """(last checkpoint, result so far); None without a checkpoint of this run. ResultError for a damaged file."""
        if not (self.path / RESULT_FILE_NAME).exists():
            return None
        checkpoint = self._left(lambda: read_checkpoint(self.path))
        if checkpoint is None or checkpoint.identity != str(self.identity):
            return None
        result = self._left(self.result)
        return (checkpoint, result) if result.settings.get("identity") == str(self.identity) else None

    def _left(self, read: Callable[[], T]) -> T:
        try:
            return read()
        except ResultError as problem:
            raise ResultError(
                f"{str(problem).removesuffix('.')}; run with --overwrite instead of --resume."
            ) from problem

    def begin(self) -> None:
        for pattern in (CHECKPOINT_FILE_NAME, *self.derived):
            for path in self.path.glob(pattern):
                path.unlink(missing_ok=True)

    def result(self) -> RunResult:
        """The result in the folder. Raises ResultError if there is none or it is damaged."""
        return read_result(self.path / RESULT_FILE_NAME)

    def write(self, result: RunResult) -> RunResult:
        return write_result(self.path / RESULT_FILE_NAME, result, self._so_far if result.status == "running" else None)

    def write_checkpoint(self, checkpoint: Checkpoint) -> None:
        path = self.path / CHECKPOINT_FILE_NAME
        image = hdf5_image(lambda file: _fill(file, checkpoint))
        with writing(ResultError, f"cannot write the checkpoint {path}", "--resume goes on once it can be written"):
            write_bytes(path, image)

    def drop_checkpoint(self) -> None:
        (self.path / CHECKPOINT_FILE_NAME).unlink(missing_ok=True)


@contextmanager
def occupied_by_runs(
    output: Path, name: str, folders: Sequence[RunFolder], *, resume: bool
) -> Iterator[tuple[Found, ...]]:
    """Occupy an output folder for runs while the `with` block runs; yields what is left of each, all empty unless they
    are to be resumed.

    name: the study's, for messages to other commands. A folder in which all runs are complete is not written to, except
    to remove the mark of a killed command. Raises ResultError if a result is damaged, and RunError if another command
    is writing to the folder, or it holds other runs, or cannot be written to.
    """
    asked = digest({"runs": [folder.identity.asked for folder in folders]})

    def found(noted: Mapping[str, object]) -> tuple[Found, ...]:
        return tuple(folder.found(unfinished=noted.get("asked") == asked) if resume else Found() for folder in folders)

    before = found(last_noted(output))
    if all(one.complete is not None for one in before):
        clear_abandoned(output)
        yield before
        return
    _refuse_other_runs(output, {folder.path for folder in folders})
    with occupied(output, name, asked=asked) as noted:
        yield found(noted)


def _refuse_other_runs(output: Path, own: set[Path]) -> None:
    """Raise RunError if folders in `output` hold other runs, which reading it would take for variants of this study."""
    others = [path.parent for path in sorted(output.glob(f"*/{RESULT_FILE_NAME}")) if path.parent not in own]
    if others:
        names = ", ".join(path.name for path in others)
        raise RunError(
            f"{output} holds other runs in folders of its own ({names}), with which these results would be mixed up: "
            "choose another --output, or delete them."
        )
