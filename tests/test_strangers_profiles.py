"""Lines of stylus instruments in two languages, guessed or answered with a mapping to fill in; none read wrongly."""

from pathlib import Path

import numpy as np
import pytest

from tests.strangers_files import ENGLISH, GERMAN, SPANISH, bracketed, write
from tests.strangers_profiles import POINTS, PROFILES, AREA_um2, DEPTH_um
from tests.test_strangers_files import filled_in
from wirewear.base.errors import RecordError
from wirewear.records.importing.guessing import mapping_text
from wirewear.records.importing.line_guessing import guessed_line_mapping
from wirewear.records.importing.line_importing import import_line_record
from wirewear.records.importing.mistaken import open_lines

KNOWN = {"length_mm": 10.0, "radius_mm": 6.0, "pad": {"material": "steel"}, "specimen": {"material": "steel"}} | {
    "normal_load_N": 20.0,
    "displacement_amplitude_um": 60.0,
    "frequency_Hz": 3.0,
    "cycles": 100,
}


@pytest.mark.parametrize("kind", PROFILES)
@pytest.mark.parametrize("foreign", [False, True], ids=["English", "foreign"])
def test_a_strangers_line_ends_in_the_right_profile(tmp_path: Path, kind: str, foreign: bool) -> None:
    language = (SPANISH if "alone" in kind or kind == "depths" else GERMAN) if foreign else ENGLISH
    written = PROFILES[kind](language)
    (tmp_path / "specimen.csv").write_text(written.text, encoding="utf-8")
    text = mapping_text(guessed_line_mapping([tmp_path / "specimen.csv"], KNOWN))
    mapping = tmp_path / "mapping.toml"
    assert {key for _, key in open_lines(text)} == written.answers.keys()
    mapping.write_text(filled_in(text, written.answers), encoding="utf-8")
    (profile,) = import_line_record(mapping).record.profiles
    assert profile.x_um.size == POINTS
    assert profile.area_um2 == pytest.approx(AREA_um2, rel=0.01)
    assert profile.smooth_um.max() == pytest.approx(DEPTH_um, rel=0.01)


def test_heights_without_positions_need_their_distance(tmp_path: Path) -> None:
    (tmp_path / "specimen.csv").write_text(PROFILES["heights alone, named"](ENGLISH).text, encoding="utf-8")
    text = mapping_text(guessed_line_mapping([tmp_path / "specimen.csv"], KNOWN))
    (tmp_path / "mapping.toml").write_text(text.replace("step_um = 1.0\n", ""), encoding="utf-8")
    with pytest.raises(RecordError, match=r"\[profiles.specimen\] must give x_um among its columns, or step_um"):
        import_line_record(tmp_path / "mapping.toml")


def test_a_matrix_beside_loops_is_a_map_whose_scale_is_asked_for(tmp_path: Path) -> None:
    """Its mean across the motion is the profile."""
    write(bracketed(ENGLISH), tmp_path)
    x = np.arange(-300.0, 300.0, 5.0)
    height = -2.0 * np.maximum(1.0 - (x / 100.0) ** 2, 0.0)
    rows = "\n".join("\t".join(f"{1e3 * z:.2f}" for z in height) for _ in range(12))
    (tmp_path / "specimen.txt").write_text(rows, encoding="utf-8")
    guess = guessed_line_mapping([tmp_path / "log.csv", tmp_path / "specimen.txt"], KNOWN)
    text = mapping_text(guess)
    assert [key for _, key in open_lines(text)] == ["step_um", "height_unit"]
    mapping = tmp_path / "mapping.toml"
    mapping.write_text(filled_in(text, {"step_um": "5.0", "height_unit": '"nm"'}), encoding="utf-8")
    (profile,) = import_line_record(mapping).record.profiles
    assert profile.area_um2 == pytest.approx(4.0 / 3.0 * 100.0 * 2.0, rel=0.01)
