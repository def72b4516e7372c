"""What a kind of contact answers: the one seam between commands and tests of wires, of line contacts, of others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from wirewear.diagnosis.model.nominal import ObserverOf
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.diagnosis.model.wear_states import WearStates
    from wirewear.interior.state import InnerState
    from wirewear.interior.strength import Strength, StrengthAsked
    from wirewear.records.exporting import Surface
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.study.template import Template


class Kind(Protocol):
    """A kind of contact. Its studies, records and results are its own; whoever has one asks its kind.

    Attributes:
        name: as `kind` in a study and `contact_kind` of studies, records and results say it.
        names: all that `kind` in a study may be, older names too.
        inside_options: options of `wirewear fields` and `strength` that not all kinds know.
        scatters: whether studies state the scatter of their inputs.
        options: keys of its records alone that `wirewear new --mapping` takes as options.
        foresees_scars: whether the fast model's worn bodies are as those of a run, so that both are compared.
        rigid_N_per_mm: a rig as stiff as this takes nothing of any stroke.
    """

    name: ClassVar[str]
    names: ClassVar[tuple[str, ...]]
    inside_options: ClassVar[frozenset[str]]
    scatters: ClassVar[bool]
    options: ClassVar[frozenset[str]]
    foresees_scars: ClassVar[bool]
    rigid_N_per_mm: ClassVar[float]

    @property
    def template(self) -> Template:
        """What a new study begins with."""

    def write_meshes(self, study: Any, fidelity: str, folder: Path) -> list[Path]:
        """Write and draw the meshes of both bodies."""

    @property
    def refined(self) -> Any:
        """What a study of convergence refines and watches."""

    def write_beside(self, results: Sequence[Any], folder: Path) -> None:
        """Write what the folder of a study's runs holds beside their results, for people and other programs."""

    def checked_model(self, record: Any, study: Any) -> Any:
        """A study that is to be diagnosed against a record; RecordError where it is of another test."""

    def states(self, study: Any, tables: Any, observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
        """Wear states of a finite element run of a record's test, and what that run says against them.
        Raises StudyError or SolverError if the study cannot be run, and RunError if no loop of the run slides as a
        whole.
        """

    def setup(self, study: Any, tables: Any) -> Setup:
        """The circumstances that a study states of a record's test, for the fast model."""

    def with_effects(
        self, study: Any, effects: Sequence[Any], length_mm: float, amplitude_um: float, increments: int
    ) -> Any:
        """A study with further effects of the whole contact and another amplitude, of loops of so many increments."""

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """A mapping guessed from files, what is known of the test, and the elastic constants of the bodies."""

    def surfaces(self, result: Any, noise_um: float, seed: int) -> Mapping[str, Surface]:
        """Worn bodies as a profilometer sees them, by names of files."""

    def write_fields(self, result: Any, folder: Path, shown: Mapping[str, Any], **asked: Any) -> list[Path]:
        """Stresses inside both bodies; `shown` is what `inside_options` say, the rest as of `write_fields`."""

    def assessable(self, result: Any, body: str, cycle: float, asked: StrengthAsked) -> int:
        """The recorded cycle nearest to one; ResultError where it does not allow what is asked of a body."""

    def inner_states(self, result: Any, body: str, cycle: int) -> Sequence[InnerState[Any]]:
        """A body at all recorded positions of a recorded cycle."""

    def strength(self, result: Any, body: str, cycle: int, asked: StrengthAsked) -> Strength:
        """The strength of a body at a recorded cycle."""

    def drawings(self, results: Sequence[Any]) -> Mapping[str, Callable[[], Figure]]:
        """What can be drawn of results, by file name."""
