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


def kind_of(one: OfAKind) -> Kind:
    """The kind of contact of a study, a record or a result."""
    return KINDS[one.contact_kind]


def load_any_study(path: str | Path, *, varied: bool = False) -> Any:
    """Read a study of any kind from a TOML file.

    varied: whether other values will stand in place of its own, beside which any key may act.
    Raises StudyError, in one sentence, if the file cannot be read, is no valid study of its kind, or states a key that
    acts in none of its runs.
    """
    from wirewear.test.study import read_study

    return any_study(read_study(path), str(path), varied=varied)


def any_study(tables: Mapping[str, Any], where: str, *, varied: bool = False) -> Any:
    """A study of whatever kind its tables say, with its surfaces levelled; `where` names their origin in messages.
    Raises StudyError, in one sentence, as `load_any_study` does.
    """
    from wirewear.test import study_from_tables
    from wirewear.test.consistency import require_no_idle_key
    from wirewear.test.surfaces import surfaces_in

    if any(surfaces_in(tables)):
        from wirewear.kinds.surfaces import with_levelled

        tables = with_levelled(tables, where)
    study = study_from_tables(tables, where)
    if not varied:
        require_no_idle_key(study.runs, where)
    return study
