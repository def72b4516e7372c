"""Kinds of contact: what commands ask of a test of crossed wires answers one of a line contact as well.

A study, a record and a result say of which kind they are (`contact_kind`); a file is asked for what it holds.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from wirewear.kinds.kind import Kind
from wirewear.kinds.lines import LineContacts
from wirewear.kinds.points import AnyBodies, BallOnFlat, CrossedWires

if TYPE_CHECKING:
    from collections.abc import Mapping


__all__ = ["KINDS", "Kind", "any_study", "kind_of", "load_any_study"]

#: The kinds by their names.
KINDS: dict[str, Kind] = {kind.name: kind for kind in (CrossedWires(), LineContacts(), BallOnFlat(), AnyBodies())}


class OfAKind(Protocol):
    """A study, a record or a result."""

    @property
    def contact_kind(self) -> str:
        """The name of its kind of contact."""


def kind_of(told: OfAKind) -> Kind:
    """The kind of contact of a study, a record or a result."""
    return KINDS[told.contact_kind]


def load_any_study(path: str | Path) -> Any:
    """Read a study from a TOML file; its `kind` says what it is, and one without or unknown is told so.
    Raises StudyError, in one sentence, if the file cannot be read, or is no valid study of its kind.
    """
    from wirewear.study.study import read_study

    return any_study(read_study(path), str(path))


def any_study(tables: Mapping[str, Any], where: str) -> Any:
    """A study of whatever kind its tables say, with its surfaces levelled; `where` names their origin in messages.
    Raises StudyError, in one sentence, if the tables are no valid study of their kind.
    """
    from wirewear.study import study_from_tables
    from wirewear.study.surfaces import surfaces_in

    if any(surfaces_in(tables)):
        from wirewear.kinds.surfaces import with_levelled

        tables = with_levelled(tables, where)
    return study_from_tables(tables, where)
