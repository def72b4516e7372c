"""The state of an unfinished run on disk, beside its result: enough to go on as if nothing had happened."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np
from numpy.typing import NDArray

from solvers import ContactProblem, ContactState, Guide, WearState
from wirewear.base.errors import ResultError
from wirewear.base.hdf5 import hdf5_image, opened_hdf5
from wirewear.base.writing import write_bytes, writing

Array = NDArray[np.float64]

#: Told what is being prepared.
Report = Callable[[str], None]

CHECKPOINT_FILE_NAME = "checkpoint.h5"
_FORMAT = 4


@dataclass(frozen=True)
class MeshHistory:
    """Which meshes a run has.

    stage: index of the stage of the scar's growth.  moved: depth in mm by which the surface nodes of the lower and the
    upper body have been moved, None while they are where they were when fresh.  changes: what was changed when.
    """

    stage: int = 0
    moved: tuple[Array, Array] | None = None
    changes: tuple[dict[str, float], ...] = ()


class Meshes(Protocol):
    """The meshes that a run goes through, and when it takes the next."""

    def first(self) -> MeshHistory:
        """The meshes of the fresh contact."""

    def problem(self, history: MeshHistory, report: Report, /) -> ContactProblem:
        """The contact problem on a run's meshes."""

    def next_stage(self, history: MeshHistory, cycle: float, /) -> MeshHistory | None:
        """The history with the meshes for a larger scar begun; None where there are none."""

    def outgrown(self, history: MeshHistory, state: ContactState, cycle: float, /) -> MeshHistory | None:
        """The next stage, if there is one and the scar has grown beyond what the meshes of now are for."""

    def moved_nodes(
        self, history: MeshHistory, problem: ContactProblem, state: ContactState, cycle: float, report: Report, /
    ) -> tuple[MeshHistory, ContactProblem]:
        """History and problem with the nodes moved into the worn surface where that is due, else as they are."""


@dataclass(frozen=True)
class OneMesh:
    """Meshes that serve a whole run; `build` makes the problem on them."""

    build: Callable[[], ContactProblem]

    def first(self) -> MeshHistory:
        """The only one."""
        return MeshHistory()

    def problem(self, _history: MeshHistory, report: Report) -> ContactProblem:
        """The contact problem."""
        report("meshing and condensing")
        return self.build()

    def next_stage(self, _history: MeshHistory, _cycle: float) -> MeshHistory | None:
        """There is none."""
        return None

    def outgrown(self, _history: MeshHistory, _state: ContactState, _cycle: float) -> MeshHistory | None:
        """The scar never outgrows them; where the contact leaves them, the run has failed."""
        return None

    def moved_nodes(
        self, history: MeshHistory, problem: ContactProblem, _state: ContactState, _cycle: float, _report: Report
    ) -> tuple[MeshHistory, ContactProblem]:
        """Nodes stay."""
        return history, problem


@dataclass(frozen=True)
class Checkpoint:
    """A run after `done` cycles.

    next_jump: size of the cycle jump to try next.  guide: first guesses for the next cycle.  counters: what the run has
    counted so far (increments, iterations, seconds).  meshes: which meshes the wires have.  identity: what the run was
    asked to do; a run goes on only with the same.
    """

    done: float
    next_jump: float
    state: ContactState
    guide: Guide | None
    counters: dict[str, float]
    meshes: MeshHistory
    identity: str


def write_checkpoint(folder: Path, checkpoint: Checkpoint) -> None:
    """Write or replace the checkpoint of a run's folder in one step.

    Raises:
        ResultError: the file cannot be written.
    """
    path = folder / CHECKPOINT_FILE_NAME
    image = hdf5_image(lambda file: _fill(file, checkpoint))
    with writing(ResultError, f"cannot write the checkpoint {path}", "--resume goes on once it can be written"):
        write_bytes(path, image)


def _fill(file: h5py.File, checkpoint: Checkpoint) -> None:
    file.attrs["format"] = _FORMAT
    file.attrs["identity"] = checkpoint.identity
    file.attrs["counters"] = json.dumps(checkpoint.counters)
    file.attrs["done"] = checkpoint.done
    file.attrs["next_jump"] = checkpoint.next_jump
    file.attrs["meshes"] = json.dumps({"stage": checkpoint.meshes.stage, "changes": checkpoint.meshes.changes})
    if checkpoint.meshes.moved is not None:
        for name, depth in zip(("moved_on_moving", "moved_on_fixed"), checkpoint.meshes.moved, strict=True):
            file.create_dataset(name, data=depth)
    _write(file.create_group("state"), checkpoint.state, skip="wear")
    _write(file.create_group("wear"), checkpoint.state.wear)
    if checkpoint.guide is not None:
        _write(file.create_group("guide"), checkpoint.guide)


def read_checkpoint(folder: Path) -> Checkpoint | None:
    """The checkpoint of a run's folder, or None when there is none.

    Raises:
        ResultError: the file is damaged or of another version.
    """
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
            meshes=MeshHistory(meshes["stage"], (moved[0], moved[1]) if moved else None, tuple(meshes["changes"])),
            identity=str(file.attrs["identity"]),
        )


def _write(group: Any, values: WearState | ContactState | Guide, skip: str = "") -> None:
    for field in fields(values):
        if field.name != skip:
            group.create_dataset(field.name, data=getattr(values, field.name))


def _read(group: Any) -> dict[str, Any]:
    return {name: (float(item[()]) if item.shape == () else np.asarray(item[()])) for name, item in group.items()}
