"""A study of whatever kind `wirewear run` takes, from one reading of its file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from wirewear.planar import PlanarStudy, planar_study_from_tables
from wirewear.planar.tables import KINDS
from wirewear.planar.template import LINE_CONTACT
from wirewear.study import Study, study_from_tables
from wirewear.study.reading import read_study
from wirewear.study.template import CROSSED_WIRES

#: What `wirewear new` begins with, by the kind of study.
TEMPLATES = {template.kind: template for template in (CROSSED_WIRES, LINE_CONTACT)}

AnyStudy = Study | PlanarStudy

_READERS: dict[str, Callable[[Mapping[str, Any], str], AnyStudy]] = dict.fromkeys(KINDS, planar_study_from_tables)


def load_any_study(path: str | Path) -> AnyStudy:
    """Read a study from a TOML file; its `kind` says what it is, and one without or unknown is told so.

    Raises:
        StudyError: the file cannot be read, or is no valid study of its kind; the message is one sentence.
    """
    return any_study(read_study(path), str(path))


def any_study(tables: Mapping[str, Any], where: str) -> AnyStudy:
    """A study of whatever kind its tables say; `where` names their origin in messages.

    Raises:
        StudyError: the tables are no valid study of their kind; the message is one sentence.
    """
    return _READERS.get(str(tables.get("kind")), study_from_tables)(tables, where)
