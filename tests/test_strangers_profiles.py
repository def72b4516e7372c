"""Lines of stylus instruments in two languages, guessed or answered with a mapping to fill in; none read wrongly."""

from pathlib import Path

import pytest

from tests.strangers_files import ENGLISH, GERMAN, SPANISH
from tests.strangers_profiles import POINTS, PROFILES, AREA_um2, DEPTH_um
from tests.test_strangers_files import filled_in
from wirewear.records.importing import import_record
from wirewear.records.importing.guessing import guessed_mapping, mapping_text
from wirewear.records.importing.line_guessing import line_contact
from wirewear.records.importing.reader import open_lines

STEEL = {"material": "steel"}
KNOWN = {
    "length_mm": 10.0,
    "radius_mm": 6.0,
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
    text = mapping_text(guessed_mapping([tmp_path / "specimen.csv"], KNOWN, line_contact(KNOWN, STEEL, STEEL)))
    mapping = tmp_path / "mapping.toml"
    assert {key for _, key in open_lines(text)} == written.answers.keys()
    mapping.write_text(filled_in(text, written.answers), encoding="utf-8")
    (profile,) = import_record(mapping).scars
    assert profile.x_um.size == POINTS
    assert profile.area_um2 == pytest.approx(AREA_um2, rel=0.01)
    assert profile.smooth_um.max() == pytest.approx(DEPTH_um, rel=0.01)
