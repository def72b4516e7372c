"""Numbers that are not finite, lines that do not ascend, texts that inflate: one sentence that names key and value."""

import re
import tracemalloc
import zlib
from base64 import b64encode
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.studies import minimal
from tests.test.pads import BALL, study
from wirewear import StudyError
from wirewear.base.errors import RecordError
from wirewear.diagnosis.fit.sensor_calibration import calibrate
from wirewear.kinds import any_study
from wirewear.test import load_study
from wirewear.test.surfaces import depths_of_table, kept_map

STEEL_WIRES = Path(__file__).parents[2] / "studies" / "steel_wires" / "study.toml"
WEAR: dict[str, Any] = {"energy_wear_coefficient_mm3_per_J": 3e-5, "variation": "cycles"}


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf"), 10**400])
@pytest.mark.parametrize(
    ("table", "key", "stated"),
    [
        ("wear", "variation_points", lambda number: [[0, 1.0], [3, number]]),
        ("wear", "variation_points", lambda number: [[0, 1.0], [number, 1.0]]),
        ("conditions", "load_cycle", lambda number: {"points": [[0, 1], [0.5, number], [1, 1]]}),
        ("conditions", "motion", lambda number: {"points": [[0, 1], [number, -1], [1, 1]]}),
        ("contact", "friction_law", lambda number: {"name": "shear-limited", "shear_strength_MPa": number}),
        ("wear", "law", lambda number: {"name": "energy-threshold", "threshold_mJ_per_mm2": number}),
    ],
)
def test_numbers_of_pairs_and_laws_must_be_finite(table: str, key: str, stated: Any, number: float) -> None:
    tables = minimal() | {"wear": WEAR | {"variation_points": [[0, 1.0]]}}
    tables[table] = tables[table] | {key: stated(number)}
    with pytest.raises(StudyError, match=rf"^{key} in \[{table}\] of s.toml .*(must be a|which must).*") as found:
        any_study(tables, "s.toml")
    if number != -float("inf"):
        assert "must be a finite number" in str(found.value)
    assert "\n" not in str(found.value)


def test_numbers_of_a_programmes_blocks_must_be_finite() -> None:
    block = {"cycles": 3, "wear": {"variation_points": [[0, float("nan")]]}}
    with pytest.raises(StudyError, match=r"^variation_points in \[wear\] of block 1 .* must be a finite number\.$"):
        any_study(minimal() | {"wear": WEAR | {"variation_points": [[0, 1.0]]}, "programme": [block]}, "s.toml")


def with_surface(x_um: list[float], y_um: list[float], depth: Any) -> dict[str, Any]:
    """A study of a ball with that surface."""
    stated = kept_map(np.arange(float(len(x_um))), np.arange(float(len(y_um))), np.asarray(depth, dtype=float))
    tables: dict[str, Any] = deepcopy(study(BALL).resolved())
    tables["bodies"]["ball"]["surface"] = stated | {"x_um": x_um, "y_um": y_um}
    return tables


@pytest.mark.parametrize(
    ("x_um", "sentence"),
    [
        ([1.0, 0.0], "holds 0 after 1, but its lines must be strictly ascending"),
        ([0.0, 0.0], "holds 0 after 0, but its lines must be strictly ascending"),
        ([float("nan"), 1.0], "holds a line that is nan, but must be a finite number"),
        ([float("-inf"), 1.0], "holds a line that is -inf, but must be a finite number"),
        ([-1e300, 1e300], "holds a line that is -1e+300, but must lie between"),
    ],
)
@pytest.mark.parametrize("key", ["x_um", "y_um"])
def test_lines_of_a_surface_must_be_finite_and_ascend(key: str, x_um: list[float], sentence: str) -> None:
    lines = {"x_um": [-1.0, 1.0], "y_um": [-1.0, 1.0]} | {key: x_um}
    with pytest.raises(StudyError, match=rf"^{key} in \[bodies\.ball\.surface\] of s\.toml {re.escape(sentence)}"):
        any_study(with_surface(**lines, depth=np.zeros((2, 2))), "s.toml")


def test_depths_of_a_surface_must_be_finite() -> None:
    tables = with_surface([-1.0, 1.0], [-1.0, 1.0], np.zeros((2, 2)))
    depths = np.array([0.0, np.inf, 0.0, 0.0], dtype="<f4")
    tables["bodies"]["ball"]["surface"]["depths"] = b64encode(zlib.compress(depths.tobytes())).decode()
    with pytest.raises(StudyError, match=r"gives depths, one of which is inf, but must be a finite number"):
        any_study(tables, "s.toml")


def test_no_more_depths_are_inflated_than_lines_have_room_for() -> None:
    tables = with_surface([-1.0, 1.0], [-1.0, 1.0], np.zeros((2, 2)))
    tables["bodies"]["ball"]["surface"]["depths"] = b64encode(zlib.compress(bytes(100_000_000), 1)).decode()
    tracemalloc.start()
    try:
        with pytest.raises(StudyError, match="depths that are not those of its lines"):
            any_study(tables, "s.toml")
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ("nan,0,1\n1,0,1\n0,1,1\n1,1,1\n", "a value of x_um is missing or infinite, but must be a finite number"),
        ("0,0,1\n1,0,1\n0,0,1\n1,1,1\n", "4 points lie on 2 × 2 lines, which is no whole grid"),
    ],
)
def test_points_of_a_surfaces_file_must_be_finite_and_there_once(tmp_path: Path, rows: str, sentence: str) -> None:
    (tmp_path / "scar.csv").write_text(f"x_um,y_um,depth_um\n{rows}", encoding="utf-8")
    with pytest.raises(RecordError, match=sentence):
        depths_of_table(tmp_path / "scar.csv")


def test_a_load_of_a_calibration_that_is_not_finite_is_the_one_that_is_named() -> None:
    with pytest.raises(StudyError, match="must be positive, finite numbers, not inf N"):
        calibrate(load_study(STEEL_WIRES).variant("rigid"), normal_loads_N=(1.0, float("inf")))
