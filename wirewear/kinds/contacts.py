"""Pictures, fields and meshes of results: those of contacts at a point, and those of line contacts.

All results given together are of one kind of contact. File names are without ending.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from wirewear.base.errors import ResultError, StudyError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from wirewear.records.exporting import Surface
    from wirewear.results import RunResult
    from wirewear.simulation import RefinedSubject
    from wirewear.stress.state import Inside

Drawings = Mapping[str, Callable[[], "Figure"]]  #: Functions that draw a picture, by file name.


class Contacts(ABC):
    """Drawings, meshes and fields for studies and results of some kinds of contact; modules are imported on use."""

    inside_options: ClassVar[frozenset[str]]  #: Options of `wirewear fields` and `strength` that not all know.

    @property
    @abstractmethod
    def refined(self) -> RefinedSubject:
        """What `wirewear converge` refines of such studies, and which figures it compares."""

    @property
    @abstractmethod
    def inside(self) -> Inside[Any]:
        """Functions that solve stresses inside the bodies and make grids of them."""

    @abstractmethod
    def write_meshes(self, study: Any, fidelity: str, folder: Path, ending: str) -> list[Path]:
        """Write the meshes of both bodies, and pictures of them, to a folder; return the files. ending: the mesh
        files', such as "vtu".
        """

    @abstractmethod
    def write_beside(self, results: Sequence[RunResult], folder: Path) -> None:
        """Write further files, such as tables, pictures or VTK series, to the folders of a study's runs."""

    @abstractmethod
    def write_fields(self, result: RunResult, folder: Path, **asked: Any) -> list[Path]:
        """Write the stresses inside both bodies to a folder and return the files. asked: keyword arguments of
        `stress.writing.write_fields`.
        """

    def write_deck(self, _result: RunResult, _path: Path, _cycle: float, _dialect: str, /) -> Path:
        """Write a run as another program's input to a file, which is returned; see `stress.deck.write_deck`."""
        raise ResultError("decks are of contacts at a point: wirewear mesh writes the meshes of line contacts.")

    @abstractmethod
    def surfaces(self, result: RunResult, noise_um: float, seed: int) -> Mapping[str, Surface]:
        """Worn surfaces by file name, as a profilometer with this noise (standard deviation) measures them. seed: of
        the noise.
        """

    @abstractmethod
    def drawings(self, results: Sequence[RunResult]) -> Drawings:
        """Functions that draw the pictures of results, by file name."""

    @abstractmethod
    def overview(self, results: Sequence[RunResult]) -> Callable[[], Figure]:
        """A function that draws the one picture that shows the most of results."""


class AtAPoint(Contacts):
    """Contacts at a point, whose scar is about as wide as it is long."""

    inside_options = frozenset(("--integration-points", "--no-pictures", "--animate"))

    @property
    def refined(self) -> RefinedSubject:
        from wirewear.simulation import POINTS

        return POINTS

    @property
    def inside(self) -> Inside[Any]:
        from wirewear.stress.bodies import INSIDE_POINTS

        return INSIDE_POINTS

    def write_meshes(self, study: Any, fidelity: str, folder: Path, ending: str) -> list[Path]:
        from wirewear.simulation import write_meshes

        return write_meshes(study, fidelity, folder, ending)

    def write_beside(self, results: Sequence[RunResult], folder: Path) -> None:
        from wirewear.results.export import FOLDER_NAME, write_time_series

        for result in results:
            write_time_series(result, (folder if result.path is None else result.path.parent) / FOLDER_NAME)

    def write_fields(self, result: RunResult, folder: Path, **asked: Any) -> list[Path]:
        from wirewear.stress.writing import write_fields

        return write_fields(result, folder, **asked)

    def write_deck(self, result: RunResult, path: Path, cycle: float, dialect: str, /) -> Path:
        from wirewear.stress.deck import write_deck

        return write_deck(result, path, cycle, dialect)

    def surfaces(self, result: RunResult, noise_um: float, seed: int) -> Mapping[str, Surface]:
        from wirewear.records.exporting import scar_surfaces

        return scar_surfaces(result, noise_um, seed)

    def drawings(self, results: Sequence[RunResult]) -> Drawings:
        from wirewear.pictures import drawings

        return drawings(results)

    def overview(self, results: Sequence[RunResult]) -> Callable[[], Figure]:
        from wirewear.pictures.gallery import overview

        return lambda: overview(results)


class AlongALine(Contacts):
    """Line contacts: results are of the whole length, meshes of one millimetre in plane strain."""

    inside_options = frozenset()

    @property
    def refined(self) -> RefinedSubject:
        from wirewear.simulation import LINES

        return LINES

    @property
    def inside(self) -> Inside[Any]:
        from wirewear.stress.line_contacts import INSIDE_LINES

        return INSIDE_LINES

    def write_meshes(self, study: Any, fidelity: str, folder: Path, ending: str) -> list[Path]:
        if ending != "vtu":
            raise StudyError("meshes of line contacts are written as .vtu alone: leave --format out.")
        from wirewear.simulation import write_line_meshes

        return write_line_meshes(study, fidelity, folder)

    def write_beside(self, results: Sequence[RunResult], folder: Path) -> None:
        from wirewear.pictures.line_contacts import line_variants
        from wirewear.pictures.style import save
        from wirewear.results.export import write_flat_tables

        for result in results:
            own = folder if result.path is None else result.path.parent
            write_flat_tables(result, own, "csv")
            for name, draw in self.drawings([result]).items():
                save(draw, own / f"{name}.png")
        if len(results) > 1:
            save(lambda: line_variants(results), folder / "variants.png")

    def write_fields(self, result: RunResult, folder: Path, **asked: Any) -> list[Path]:
        from wirewear.stress.line_contacts import write_line_fields

        return write_line_fields(result, folder, **asked)

    def surfaces(self, result: RunResult, noise_um: float, seed: int) -> Mapping[str, Surface]:
        from wirewear.records.exporting import profile_surfaces

        return profile_surfaces(result, noise_um, seed)

    def drawings(self, results: Sequence[RunResult]) -> Drawings:
        from wirewear.pictures.line_contacts import line_drawings

        return line_drawings(results)

    def overview(self, results: Sequence[RunResult]) -> Callable[[], Figure]:
        return next(iter(self.drawings(results).values()))
