"""What a kind of contact answers: the one seam between commands and tests of wires, of line contacts, of others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from wirewear.records.exporting import Surface
    from wirewear.records.importing.guessed_conditions import Touching
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.stress.state import Inside
    from wirewear.test.template import Template


class _Elsewhere:
    """An attribute that another room has, which is loaded when the attribute is asked for."""

    def __init__(self, place: str) -> None:
        self.module, _, self.name = place.partition(":")

    def __get__(self, _kind: object, _type: type) -> Any:
        return getattr(import_module(self.module), self.name)


def elsewhere(place: str) -> Any:
    """What stands at a place, such as `wirewear.simulation:write_meshes`, as an attribute of a kind."""
    return _Elsewhere(place)


class Kind:
    """A kind of contact. Its studies, records and results are its own; whoever has one asks its kind."""

    name: ClassVar[str]  #: As `kind` in a study and `contact_kind` of studies, records and results say it.
    inside_options: ClassVar[frozenset[str]]  #: Options of `wirewear fields` and `strength` that not all kinds know.
    scatters: ClassVar[bool]  #: Whether studies state the scatter of their inputs.
    options: ClassVar[frozenset[str]]  #: Keys of its records alone that `wirewear new --mapping` takes as options.
    rigid_N_per_mm: ClassVar[float]  #: A rig as stiff as this takes nothing of any stroke.
    template: Template  #: What a new study begins with.
    refined: Any  #: What a study of convergence refines and watches.
    inside: Inside[Any]  #: How its bodies are looked into.
    #: Writes and draws the meshes of both bodies of a study at a fidelity.
    write_meshes: Callable[[Any, str, Path], list[Path]]
    #: Writes what the folder of a study's runs holds beside their results.
    write_beside: Callable[[Sequence[Any], Path], None]
    #: The bodies of a mapping by what is known of the test, and the elastic constants of both.
    touching: Callable[[Mapping[str, Any], Mapping[str, float], Mapping[str, float]], Touching]
    #: Worn bodies as a profilometer with noise in µm and a seed sees them, by names of files.
    surfaces: Callable[[Any, float, int], Mapping[str, Surface]]
    write_fields: Callable[..., list[Path]]  #: Stresses inside both bodies; knows what `inside_options` say as well.
    #: What can be drawn of results, by file name.
    drawings: Callable[[Sequence[Any]], Mapping[str, Callable[[], Figure]]]

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """A mapping guessed from files, what is known of the test, and the elastic constants of the bodies."""
        from wirewear.records.importing.guessing import guessed_mapping

        return guessed_mapping(files, dict(known), self.touching(known, own, pad))
