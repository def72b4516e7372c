"""Code and files of others: packages that raise, data that reach beyond their folder, answers nested without end."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from solvers import SolverError, friction_laws, plugins
from tests.diagnosis_cases import record
from tests.test_import import GERMAN, mapped
from tests.test_import import cycle as cycle_of
from wirewear import RecordError, StudyError, read_record, write_record
from wirewear.base.errors import WirewearError
from wirewear.diagnosis.observe import reduction as observables
from wirewear.diagnosis.observe.reduction import all_observables
from wirewear.effects import all_effects, registry
from wirewear.records.importing import import_record
from wirewear.records.importing.registry import readers

cycle = cycle_of


class BadPoint:
    """An entry point whose module raises."""

    name, value, group = "gremlin", "gremlins:Gremlin", "any"

    def load(self) -> object:
        raise ZeroDivisionError("division by zero\nand more")


@pytest.mark.parametrize(
    ("found", "noun", "error"),
    [
        (all_effects, "effect", StudyError),
        (friction_laws, "friction law", SolverError),
        (all_observables, "observable", WirewearError),
        (readers, "reader", RecordError),
    ],
)
def test_a_plug_in_that_raises_when_it_is_loaded_is_named(
    monkeypatch: pytest.MonkeyPatch, found: Callable[[], object], noun: str, error: type[Exception]
) -> None:
    monkeypatch.setattr(plugins, "entry_points", lambda **_: [BadPoint()])
    caches = (registry._all_effects, friction_laws, observables._all_observables, readers)
    for cache in caches:
        cache.cache_clear()
    try:
        with pytest.raises(error) as refused:
            found()
    finally:
        monkeypatch.undo()
        for cache in caches:
            cache.cache_clear()
    assert str(refused.value).removesuffix(".") == (
        f"the {noun} 'gremlin' of an installed package cannot be loaded from gremlins:Gremlin (ZeroDivisionError: "
        "division by zero): mend or uninstall that package"
    )


def outside(tmp_path: Path) -> Path:
    """A file that no record and no mapping may quote."""
    secret = tmp_path / "secret.csv"
    secret.write_text("root:x:0:0:hidden words\n")
    return secret


@pytest.mark.parametrize("name", ["/etc/passwd", "../secret.csv", "a/../../secret.csv"])
def test_a_mapping_names_no_file_outside_its_folder(tmp_path: Path, name: str) -> None:
    outside(tmp_path)
    (tmp_path / "lab").mkdir()
    with pytest.raises(RecordError, match="must name files beside the mapping or in folders there") as refused:
        import_record(mapped(tmp_path / "lab", GERMAN.replace("cycle_*.txt", name)))
    assert "hidden" not in str(refused.value)


def test_links_out_of_a_folder_are_not_followed(tmp_path: Path, cycle: Any) -> None:
    secret, lab = outside(tmp_path), tmp_path / "lab"
    lab.mkdir()
    (lab / "cycle_1_rep1.txt").symlink_to(secret)
    with pytest.raises(RecordError, match=r"leads out of the folder .*lab, which is not followed\.$") as refused:
        import_record(mapped(lab, GERMAN))
    assert "hidden" not in str(refused.value)
    folder = write_record(tmp_path / "record", record(repeats=1, evolution=False, normal=False))
    (folder / "loops.csv").unlink()
    (folder / "loops.csv").symlink_to(secret)
    with pytest.raises(RecordError, match=r"loops in \[files\] .* leads out of the folder"):
        read_record(folder)
