"""Every tuned constant of the diagnosis stands in one file, with what set it, and is read from there."""

import ast
import re
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import wirewear.diagnosis
from wirewear.diagnosis import calibration
from wirewear.diagnosis.calibration import FILE_NAME, all_constants, digest, sources
from wirewear.effects import all_effects, registry
from wirewear.effects.holder import FreePlay, RotationalCompliance

FOLDER = Path(wirewear.diagnosis.__file__).parent
#: Modules whose numbers are resolutions of the surrogate, or of effects; and colours. Those of `fit/` decide no answer.
ELSEWHERE = {
    "forward.py", "control.py", "sensed_loops.py", "line_wear.py", "layered_wires.py", "worn_wires.py", "candidates.py",
    "diagnosis_page.py",
}  # fmt: skip

#: Constants of the code: formats, seeds, unit factors, exponents, closed forms, resolutions of sums, and round-off.
OF_THE_CODE = {
    "_GENERATION", "FORMAT", "UM3_PER_MJ", "ODD_POWERS", "EVEN_POWERS", "LIFT_POWERS", "FULL_SLIP", "_DIRECTIONS",
    "DIRECTIONS", "PLACES", "WITHIN", "_TOGETHER", "_CONFORMAL_GROWTH",
}  # fmt: skip

#: Tuned numbers; there may be fewer, never more.
TUNED = 60


class Foreign(FreePlay):
    """An effect of a package that is installed, which believes what one of the library does."""

    name = "foreign"


def code() -> list[Path]:
    shown = FOLDER.parent.joinpath("views").glob("diagnos*.py")
    return [
        file
        for file in sorted([*FOLDER.rglob("*.py"), *shown])
        if file.name not in ELSEWHERE and file.parent.name != "fit"
    ]


def numbers_of_modules(file: Path) -> Iterator[str]:
    """Names that a module and its classes give numbers spelled out there."""
    module = ast.parse(file.read_text(encoding="utf-8"))
    classes = [statement for node in module.body if isinstance(node, ast.ClassDef) for statement in node.body]
    for node in [*module.body, *classes]:
        if isinstance(node, ast.Assign) and any(_is_number(part) for part in ast.walk(node.value)):
            for target in node.targets:
                yield from (name.id for name in ast.walk(target) if isinstance(name, ast.Name))


def _is_number(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


def test_every_constant_names_its_unit_commit_and_source_and_no_more_are_tuned_than_were() -> None:
    known = sources()
    for one in all_constants():
        assert one.unit, one.name
        assert one.source in known, one.name
        assert len(one.commit) == 7, one.name
    assert all(source["what"].strip() and source["command"].strip() for source in known.values())
    assert {one.source for one in all_constants()} == set(known)
    assert sum([np.size(one.value) for one in all_constants() if one.tuned]) <= TUNED


@pytest.mark.parametrize("file", code(), ids=lambda file: file.name)
def test_no_module_holds_tuned_numbers_of_its_own(file: Path) -> None:
    assert not (set(numbers_of_modules(file)) - OF_THE_CODE)


@pytest.mark.parametrize("file", sorted(FOLDER.rglob("*.py")), ids=lambda file: file.name)
def test_a_module_reads_the_constants_of_its_own_name(file: Path) -> None:
    name = ".".join(file.relative_to(FOLDER).with_suffix("").parts)
    read = (
        re.findall(r'constants\("([\w.]+)"\)', file.read_text(encoding="utf-8")) if file.stem != "calibration" else []
    )
    assert [table for table in read if table != name and not table.startswith(f"{name}.")] == []


def test_the_hash_changes_with_the_file_and_whatever_is_stated_of_an_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    known, before = all_effects(), digest()
    assert digest() == before
    found = {before}
    with monkeypatch.context() as changed:
        changed.setattr(calibration, "_content", lambda: (FOLDER / FILE_NAME).read_bytes() + b"\n")
        found.add(digest())
    for name, value in (("prior_weight", 0.4), ("model_error", 0.01)):
        with monkeypatch.context() as changed:
            changed.setattr(RotationalCompliance, name, value)
            found.add(digest())
    with monkeypatch.context() as changed:
        narrow = {"gap_um": replace(FreePlay.parameters()["gap_um"], interest=(0.5, 5.0))}
        changed.setattr(FreePlay, "parameters", classmethod(lambda _: narrow))
        found.add(digest())
    with monkeypatch.context() as changed:
        changed.setattr(registry, "_all_effects", lambda: {**known, "foreign": Foreign})
        found.add(digest())
    assert len(found) == 6
    assert digest() == before


def test_a_scaled_count_stays_whole_and_a_correlation_below_one(monkeypatch: pytest.MonkeyPatch) -> None:
    tables = deepcopy(calibration._tables())
    monkeypatch.setattr(calibration, "_tables", lambda: tables)
    before = {one.name: np.atleast_1d(one.value) for one in all_constants()}
    for name in ("observe.observable.reach", "infer.covariance.smooth.turned", "observe.channels.evolution.fewest"):
        calibration.scale(name, 2.0)
    after = {one.name: np.atleast_1d(one.value) for one in all_constants()}
    assert after["observe.observable.reach"] == 2.0 * before["observe.observable.reach"]
    assert 0.99 < after["infer.covariance.smooth.turned"] < 1.0
    assert after["observe.channels.evolution.fewest"] == 16
    assert sum(not np.array_equal(before[name], after[name]) for name in before) == 3
