"""What a kind of contact answers: the one seam between commands and tests of wires, of line contacts, of others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import RenderableType

    from wirewear.interior.strength import Strength, StrengthAsked
    from wirewear.records.as_heights import Surface
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.study.template import Template


@dataclass(frozen=True, eq=False)
class Compared:
    """A run beside a record: `unlike` says where they are of different tests, `shown` is for a terminal."""

    unlike: str | None
    shown: Sequence[RenderableType]
    write: Callable[[Path], list[Path]]


class Kind(Protocol):
    """A kind of contact. Its studies, records and results are its own; whoever has one asks its kind.

    Attributes:
        name: as `kind` in a study and `contact_kind` of studies, records and results say it.
        names: all that `kind` in a study may be, older names too.
        inside_options: options of `wirewear fields` and `strength` that not all kinds know.
        scatters: whether studies state the scatter of their inputs.
        options: keys of its records alone that `wirewear new --mapping` takes as options.
    """

    name: ClassVar[str]
    names: ClassVar[tuple[str, ...]]
    inside_options: ClassVar[frozenset[str]]
    scatters: ClassVar[bool]
    options: ClassVar[frozenset[str]]

    @property
    def template(self) -> Template:
        """What a new study begins with."""

    def study_from_tables(self, tables: Mapping[str, Any], where: str) -> Any:
        """A study from nested tables; StudyError in one sentence that names `where`."""

    def run(self, study: Any, **asked: Any) -> list[Any]:
        """Results of a study's variants, each with what belongs into its folder; arguments as of `run_study`."""

    def write_meshes(self, study: Any, fidelity: str, folder: Path) -> list[Path]:
        """Write and draw the meshes of both bodies."""

    @property
    def refined(self) -> Any:
        """What a study of convergence refines and watches."""

    def tables_of(self, record: Any) -> dict[str, Any]:
        """A record's test as the tables of a study; RecordError where it tells no friction."""

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """A mapping guessed from files, what is known of the test, and the elastic constants of the bodies."""

    def surfaces(self, result: Any, noise_um: float, seed: int) -> Mapping[str, Surface]:
        """Worn bodies as a profilometer sees them, by names of files."""

    def comparison(self, result: Any, record: Any) -> Any:
        """A run beside a record, for those who go on with it."""

    def compared(self, result: Any, record: Any) -> Compared:
        """A run beside a record."""

    def write_fields(self, result: Any, folder: Path, shown: Mapping[str, Any], **asked: Any) -> list[Path]:
        """Stresses inside both bodies; `shown` is what `inside_options` say, the rest as of `write_fields`."""

    def assessable(self, result: Any, body: str, cycle: float, asked: StrengthAsked) -> int:
        """The recorded cycle nearest to one; ResultError where it does not allow what is asked of a body."""

    def strength(self, result: Any, body: str, cycle: int, asked: StrengthAsked) -> Strength:
        """The strength of a body at a recorded cycle."""

    def drawings(self, results: Sequence[Any]) -> Mapping[str, Callable[[], Figure]]:
        """What can be drawn of results, by file name."""
