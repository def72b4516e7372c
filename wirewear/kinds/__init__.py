"""Studies of any kind of test from files, and the drawings, meshes and fields of any kind of result."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from wirewear.base import kinds
from wirewear.base.errors import StudyError
from wirewear.kinds.contacts import AlongALine, AtAPoint, Contacts

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wirewear.test.kinds import OfAKind


__all__ = ["Contacts", "any_study", "contacts_of", "load_any_study"]

_CONTACTS: dict[str, Contacts] = dict.fromkeys(kinds.AT_A_POINT, AtAPoint()) | {kinds.LINE_CONTACT: AlongALine()}


def contacts_of(one: OfAKind) -> Contacts:
    """Drawings, meshes and fields for the kind of contact of a study or a result.

    Raises StudyError for a kind that is not simulated.
    """
    if one.contact_kind not in _CONTACTS:
        raise StudyError(f"a {one.contact_kind} has no bodies, which this command needs.")
    return _CONTACTS[one.contact_kind]


def load_any_study(path: str | Path, *, varied: bool = False) -> Any:
    """Read a study of any kind from a TOML file.

    varied: True if its values will be replaced by others, under which keys without effect now may have one.

    Raises StudyError, in one sentence, if the file cannot be read, is not a valid study of its kind, or states a key
    that has no effect in any of its runs.
    """
    from wirewear.test.study import read_study

    return any_study(read_study(path), str(path), varied=varied)


def any_study(tables: Mapping[str, object], where: str, *, varied: bool = False) -> Any:
    """A study of the kind that its nested tables state, with measured surfaces levelled; `where` names their origin in
    messages. varied: as in `load_any_study`, which says what is raised.
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
