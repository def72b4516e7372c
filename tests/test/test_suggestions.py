"""What a message suggests does not change the physics: the likeliest key, the true range, words of the kind."""

from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from tests.studies import minimal
from wirewear import StudyError
from wirewear.kinds import any_study
from wirewear.records.importing.guessed_scars import Touching, along_motion, along_x, laid
from wirewear.test.bodies import BodiesByOptions

STEEL = {"youngs_modulus_MPa": 210_000.0, "poissons_ratio": 0.3}


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("amplitude_um", "displacement_amplitude_um"),
        ("amplitude_mm", "displacement_amplitude_um"),
        ("load_N", "normal_load_N"),
        ("held_slip_um", "held_slip_amplitude_um"),
    ],
)
def test_a_key_that_lacks_words_is_taken_for_the_one_that_must_be_given(key: str, meant: str) -> None:
    tables = minimal()
    tables["conditions"] = {**tables["conditions"], key: 60.0}
    tables["conditions"].pop(meant, None)
    with pytest.raises(StudyError, match=rf"unknown key '{key}' in \[conditions\] of s.toml: did you mean '{meant}'"):
        any_study(tables, "s.toml")


@pytest.mark.parametrize("angle", [1, 2, 2.5, 3, 4, 1.0])
def test_a_small_angle_is_answered_by_the_range_and_is_not_taken_for_radians(angle: float) -> None:
    tables = minimal()
    tables["wires"]["crossing_angle_deg"] = angle
    with pytest.raises(StudyError, match=r"must lie between 5 and 175 degrees\.$"):
        any_study(tables, "s.toml")


@pytest.mark.parametrize("angle", [1.57, 1.5708, 0.7854, 0.5236])
def test_an_angle_in_radians_still_looks_like_them(angle: float) -> None:
    tables = minimal()
    tables["wires"]["crossing_angle_deg"] = angle
    with pytest.raises(StudyError, match="it looks like radians"):
        any_study(tables, "s.toml")


def groove(angle_deg: float) -> tuple[Array, Array, Array]:
    """Heights of a wire that lies at that angle in its map."""
    x = np.linspace(-100.0, 100.0, 41)
    angle = np.radians(angle_deg)
    across = -np.sin(angle) * x[:, None] + np.cos(angle) * x[None, :]
    return x, x, np.sqrt(225.0**2 - across**2)


@pytest.mark.parametrize("name", ["moving", "fixed"])
@pytest.mark.parametrize("stated", [None, 60.0])
def test_a_wire_that_lies_askew_is_answered_by_the_crossing_angle(name: str, stated: float | None) -> None:
    known = {"diameter_mm": 0.45} | ({} if stated is None else {"crossing_angle_deg": stated})
    _, remark = laid(Path("scar.xyz"), name, Touching.of("crossed-wires", known, STEEL, {}), groove(30.0))
    assert f"nor at the crossing angle, {stated or 90:g}°: give crossing_angle_deg" in remark


@pytest.mark.parametrize("name", ["ball", "flat"])
@pytest.mark.parametrize("known", [{}, {"diameter_mm": 10.0}])
def test_a_body_without_an_axis_runs_along_nothing(name: str, known: dict[str, float]) -> None:
    touching = Touching.of("ball-on-flat", known, STEEL, STEEL)
    bare = Touching(touching.names, BodiesByOptions({}))
    for one in (touching, bare):
        for found in (
            along_motion(Path("a.xyz"), name, one),
            along_motion(Path("a.xyz"), name, one, depths=True),
            along_x(Path("a.xyz"), name, one, "later"),
        ):
            assert found[0] == {"frame": "test"}
            assert "along the motion; where y does" in found[1]
            assert name not in found[1]
