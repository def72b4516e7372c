"""Heights of worn bodies: the unworn surface is found however much is worn, or it is said that it cannot be found."""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from geometry.arrays import Array
from tests.comparison.worn_maps import PROFILE_HEIGHTS, SCAR_HEIGHTS, mapping, points
from tests.test.pads import BALL as BALL_STUDY
from tests.test.pads import study
from wirewear import read_record, write_record
from wirewear.base.errors import StudyError
from wirewear.diagnosis.observe.observable import Sites
from wirewear.diagnosis.observe.scars import ScarFigures
from wirewear.kinds import any_study
from wirewear.records import AnyRecord, check_record
from wirewear.records.importing import import_record
from wirewear.records.scars import MeasuredScar

RADIUS_um = 3000.0
NOISE_um = 0.03


@dataclass(frozen=True)
class Worn:
    """A worn body over a map: which, how wide the map, its lines, what share the scar covers, and what form is left."""

    kind: str
    body: str
    width_um: float
    share: float
    scar: str = "floor"
    form: float = 1.0  #: Of the radius.
    depth_um: float = 5.0
    lines: int = 81
    steep: float = 5.0
    bow_um: float = 0.0  #: Along x, at the map's ends.

    @property
    def flat(self) -> bool:
        return self.body in ("flat", "specimen")

    def depth(self, x: Array, y: Array) -> Array:
        """Depths (n_x, n_y) of a scar beside the middle; of a ball a cap that is cut off, of a wire a box."""
        if self.scar == "across":
            return np.asarray(self.depth_um * (1.0 - (2.0 * x[:, None] / (self.share * self.width_um)) ** 2) + 0.0 * y)
        aside = x - 0.04 * (1.0 - self.share) * self.width_um
        if self.scar == "box":
            side = np.maximum(np.abs(aside)[:, None], np.abs(y)) / (0.5 * np.sqrt(self.share) * self.width_um)
            return np.asarray(self.depth_um * np.clip(6.0 * (1.0 - side), 0.0, 1.0))
        squared = (aside[:, None] ** 2 + y**2) * np.pi / (self.share * self.width_um**2)
        if self.scar == "cap":
            return np.asarray(self.share * self.width_um**2 / np.pi / (2.0 * RADIUS_um) * (1.0 - squared))
        return np.asarray(self.depth_um * np.clip(self.steep * (1.0 - np.sqrt(squared)), 0.0, 1.0))

    def written(self, folder: Path, spikes: int = 0, missing: float = 0.0) -> tuple[Path, float]:
        """A mapping of its heights, and the worn volume in mm³, or of a profile the area in µm²."""
        random = np.random.default_rng(3)
        x = np.linspace(-0.5 * self.width_um, 0.5 * self.width_um, self.lines)
        line = self.body == "specimen"
        y = np.zeros(1) if line else x[10:-10] if self.kind == "crossed-wires" else x
        depth = np.maximum(self.depth(x, y), 0.0)
        radius = self.form * RADIUS_um
        square = y**2 if self.kind == "crossed-wires" else x[:, None] ** 2 + y**2
        shape = 0.0 * depth if self.flat else np.sqrt(radius**2 - square) - radius
        tilted = 12.0 + 0.01 * x[:, None] * (self.kind != "ball-on-flat" or self.flat)
        bow = self.bow_um * (2.0 * x[:, None] / self.width_um) ** 2
        height = shape + tilted + bow - depth + NOISE_um * random.standard_normal(depth.shape)
        wild = random.permutation(height.size)[:spikes]
        height.flat[wild] += np.resize([60.0, -40.0, 104.0], spikes)
        height[random.random(height.shape) < missing] = np.nan
        sections = depth[:, 0] if line else np.trapezoid(depth, y, axis=1)
        points(folder / "map.csv", (x,) if line else (x, y), height[:, 0] if line else height)
        source = PROFILE_HEIGHTS if line else SCAR_HEIGHTS
        worn = float(np.trapezoid(sections, x)) * (1.0 if line else 1e-9)
        return mapping(folder, self.kind, self.body, source, diameter_mm=2e-3 * RADIUS_um), worn


def imported(path: Path) -> tuple[AnyRecord, float, list[str]]:
    """The record, its worn volume or area, and what was said of the map."""
    record = import_record(path)
    (surface,) = record.scars
    notes = [note for note in record.notes if "map" in note]
    return record, surface.area_um2 if hasattr(surface, "area_um2") else surface.volume_mm3, notes


BALL = Worn("ball-on-flat", "ball", 900.0, 0.62, "cap")
FLAT = Worn("ball-on-flat", "flat", 800.0, 0.66)
WIRE = Worn("crossed-wires", "moving", 900.0, 0.5, "box")
PROFILE = Worn("cylinder-on-flat", "specimen", 1000.0, 0.8, "box", lines=401)


@pytest.mark.parametrize(
    ("worn", "spikes", "missing"),
    [
        (BALL, 0, 0.0),
        (BALL, 12, 0.2),
        (FLAT, 0, 0.0),
        (Worn("ball-on-flat", "flat", 800.0, 0.85, "box"), 12, 0.2),
        (Worn("ball-on-flat", "flat", 800.0, 0.7, "across"), 0, 0.0),
        (Worn("ball-on-flat", "ball", 900.0, 0.5, "box", depth_um=1.5, bow_um=0.1), 0, 0.0),
        (Worn("ball-on-flat", "ball", 900.0, 0.65, "across", depth_um=1.5, bow_um=-0.1), 0, 0.0),
        (WIRE, 6, 0.0),
        (PROFILE, 0, 0.0),
        (Worn("cylinder-on-flat", "specimen", 1000.0, 0.85, "box", lines=401), 5, 0.0),
    ],
)
def test_the_unworn_surface_is_found_under_large_scars_with_spikes_and_gaps(
    tmp_path: Path, worn: Worn, spikes: int, missing: float
) -> None:
    path, volume = worn.written(tmp_path, spikes, missing)
    _, found, _ = imported(path)
    assert found == pytest.approx(volume, rel=0.03)


def test_it_is_said_where_a_large_part_of_the_volume_lies_in_gaps(tmp_path: Path) -> None:
    path, _ = FLAT.written(tmp_path)
    rows = np.loadtxt(tmp_path / "map.csv", delimiter=",", skiprows=1)
    left = rows[np.hypot(rows[:, 0] - 60.0, rows[:, 1]) > 90.0]
    np.savetxt(tmp_path / "map.csv", left, delimiter=",", header="x_um,y_um,height_um", comments="")
    record, _, _ = imported(path)
    assert any("of the worn volume of the flat, repeat 1, lie in wider gaps" in note for note in record.notes)
    assert any("lie in wider gaps" in one.text for one in check_record(record).remarks)


def test_it_is_said_where_hardly_any_of_a_map_is_unworn(tmp_path: Path) -> None:
    path, volume = Worn("ball-on-flat", "flat", 800.0, 1.2, steep=20.0).written(tmp_path)
    _, found, notes = imported(path)
    assert abs(found / volume - 1.0) > 0.03
    assert any("map that reaches farther" in note for note in notes)


def test_form_that_is_likely_but_not_certain_counts_in_how_well_a_volume_is_known(tmp_path: Path) -> None:
    worn = Worn("ball-on-flat", "flat", 900.0, 0.75, "across", depth_um=1.5, bow_um=0.1)
    _, _, notes = imported(worn.written(tmp_path)[0])
    assert any("shows the worn volume within" in note for note in notes)


@pytest.mark.parametrize(
    "worn",
    [
        Worn("ball-on-flat", "ball", 900.0, 0.2, form=1.005),
        WIRE,
        Worn("crossed-wires", "moving", 3800.0, 0.1, depth_um=2.0),
    ],
    ids=["ball", "wire", "form as large as the scar"],
)
def test_form_that_is_left_is_taken_off_and_its_radius_offered(tmp_path: Path, worn: Worn) -> None:
    path, volume = replace(worn, form=1.005).written(tmp_path)
    _, found, notes = imported(path)
    assert found == pytest.approx(volume, rel=0.03)
    (note,) = notes
    assert "not of 3 mm as stated (diameter_mm = 6.0" in note
    offered = float(note.partition("diameter_mm = ")[2].partition(")")[0])
    assert offered == pytest.approx(6.03, rel=1e-3)


def test_single_points_that_stand_out_count_for_nothing_and_are_counted_by_import_and_check(tmp_path: Path) -> None:
    path, volume = Worn("ball-on-flat", "flat", 800.0, 0.1).written(tmp_path, spikes=4)
    record, found, _ = imported(path)
    assert found == pytest.approx(volume, rel=0.02)
    said = "4 single points of the flat's scar of repeat 1 stand out by up to 10"
    assert any(note.startswith(said) for note in record.notes)
    again = read_record(write_record(tmp_path / "record", record))
    assert any(remark.text.startswith(said) for remark in check_record(again).remarks)
    assert again.scars[0].sizes == record.scars[0].sizes
    np.testing.assert_allclose(again.scars[0].points["depth_um"], record.scars[0].points["depth_um"])


def test_a_depth_that_few_points_leave_uncertain_is_given_with_that_of_the_deepest_point() -> None:
    few, many = (np.linspace(-200.0, 200.0, n) for n in (21, 401))

    def sizes(line: Array) -> str:
        x, y = (one.ravel() for one in np.meshgrid(line, line, indexing="ij"))
        return MeasuredScar.from_points(1, "flat", x, y, np.maximum(6.0 - (x**2 + y**2) / 4e3, 0.0)).sizes

    assert sizes(few).startswith("5.9 µm deep (6 at the deepest point), ")
    assert sizes(many).startswith("6 µm deep, ")


def test_a_tiny_scar_without_noise_is_no_spike() -> None:
    from wirewear.records.spikes import without_spikes

    depth = np.zeros((41, 41))
    depth[19:22, 19:22] = 3.0
    assert not without_spikes(depth)[1].any()
    depth[5, 5] = depth[30, 31] = -3.0
    assert np.argwhere(without_spikes(depth)[1]).tolist() == [[5, 5], [30, 31]]


@pytest.mark.parametrize("off_um", [0.0, 0.4])
def test_a_scar_has_one_volume_and_length_in_import_check_and_diagnosis(tmp_path: Path, off_um: float) -> None:
    """Also of depths whose zero is off, as others evaluate them."""
    path, volume = Worn("ball-on-flat", "ball", 900.0, 0.2, form=1.005).written(tmp_path, spikes=3, missing=0.1)
    record, _, _ = imported(path)
    (scar,) = record.scars
    moved = type(scar)(1, "ball", scar.x_um, scar.y_um, scar.depth_um + off_um, levelling_notes=scar.levelling_notes)
    reading: Any = SimpleNamespace(scars=[moved], body_names=("flat", "ball"), last_cycle=1)
    sites = Sites.of(figures := ScarFigures().sites(reading))
    values, _ = ScarFigures().measure(reading, 1, sites)
    seen = {site.figure: np.exp(value) for site, value in zip(figures, values, strict=True)}
    assert seen == pytest.approx(moved.figures)
    assert 1e-9 * seen["volume"] == pytest.approx(moved.volume_mm3) == pytest.approx(volume, rel=0.03)
    assert seen["length"] == pytest.approx(scar.figures["length"], rel=0.01)


def test_heights_that_a_study_begins_with_are_levelled_likewise_or_refused(tmp_path: Path) -> None:
    tables = study(BALL_STUDY).resolved()
    tables["bodies"]["ball"]["surface"] = {"file": str(tmp_path / "map.csv")}
    tables["bodies"]["ball"]["diameter_mm"] = 2e-3 * RADIUS_um
    _, volume = BALL.written(tmp_path)
    read: Any = any_study(tables, "s.toml")
    assert read.bodies[1].surface.volume_mm3 == pytest.approx(volume, rel=0.03)
    Worn("ball-on-flat", "ball", 900.0, 1.3, steep=20.0).written(tmp_path)
    with pytest.raises(StudyError, match=r"surface of ball in s\.toml cannot be taken: map\.csv: .* reaches farther"):
        any_study(tables, "s.toml")


def heights_of(tmp_path: Path, height: Array, step_um: float) -> Path:
    """A mapping of heights (n, n) of a ball of 6 mm or, where they are flat, of its counterpart."""
    x = np.asarray(step_um * (np.arange(len(height)) - 0.5 * (len(height) - 1)), dtype=np.float64)
    points(tmp_path / "map.csv", (x, x), height)
    body = "ball" if np.ptp(height) > 50.0 else "flat"
    return mapping(tmp_path, "ball-on-flat", body, SCAR_HEIGHTS, diameter_mm=2e-3 * RADIUS_um)


def scar_with_rim(lines: int) -> Array:
    """Depths (n, n) of a deep scar over half of a map, with a smooth rim piled up around it."""
    place = np.linspace(-1.0, 1.0, lines)
    out = np.hypot(place[:, None], place) / 0.8
    return np.asarray(15.0 * np.maximum(1.0 - out**2, 0.0) - 1.8 * np.exp(-(((out - 1.06) / 0.06) ** 2)))


def test_a_rim_piled_up_around_a_scar_does_not_raise_what_is_taken_to_be_unworn(tmp_path: Path) -> None:
    depth, random = scar_with_rim(71), np.random.default_rng(5)
    height = np.round(0.05 * random.standard_normal(depth.shape) - depth, 1)
    record, found, _ = imported(heights_of(tmp_path, height, 10.0))
    assert found == pytest.approx(1e-7 * float(depth.sum()), rel=0.03)
    assert abs(record.scars[0].ground_um) < 0.01


def test_outermost_lines_that_are_off_are_named_by_import_and_check(tmp_path: Path) -> None:
    height = -np.maximum(scar_with_rim(81), 0.0) + 0.02 * np.random.default_rng(5).standard_normal((81, 81))
    for step, what in ((0.0, ""), (-8.0, "% of what is worn lies"), (6.0, "% of what is worn is piled up")):
        record, _, _ = imported(heights_of(tmp_path, np.where(np.arange(81) > 78, height + step, height), 10.0))
        checked = [remark.text for remark in check_record(record).remarks]
        for notes in (record.notes, checked):
            assert any("along the border" in one and what in one for one in notes) == bool(what)


def test_a_ball_whose_map_is_a_paraboloid_is_offered_the_radius_that_comes_nearest(tmp_path: Path) -> None:
    place = 15.0 * (np.arange(61) - 30.0)
    squared = place[:, None] ** 2 + place**2
    worn = 8.0 * np.maximum(1.0 - squared / 200.0**2, 0.0)
    noise = NOISE_um * np.random.default_rng(3).standard_normal(worn.shape)
    _, found, (note,) = imported(heights_of(tmp_path, noise - squared / (2.0 * RADIUS_um) - worn, 15.0))
    assert found == pytest.approx(225e-9 * float(worn.sum()), rel=0.03)
    offered = 500.0 * float(note.partition("diameter_mm = ")[2].partition(")")[0])
    sphere = np.sqrt(offered**2 - squared) - offered + squared / (2.0 * RADIUS_um)
    stated = np.sqrt(RADIUS_um**2 - squared) - RADIUS_um + squared / (2.0 * RADIUS_um)
    assert np.ptp(sphere) < 0.5 * np.ptp(stated)


@pytest.mark.parametrize(("bow_um", "noise_um", "rim_um"), [(0.0, 0.15, 0.5), (0.0, 0.3, 0.5), (0.5, 0.05, 1.5)])
def test_a_volume_that_rims_and_a_bow_put_off_is_said_to_be_uncertain(
    tmp_path: Path, bow_um: float, noise_um: float, rim_um: float
) -> None:
    place = np.linspace(-1.0, 1.0, 81)
    out = np.hypot(place[:, None], place) / 0.78
    depth = 8.0 * np.maximum(1.0 - out**2, 0.0) - rim_um * np.exp(-(((out - 1.08) / 0.08) ** 2))
    noise = noise_um * np.random.default_rng(5).standard_normal(depth.shape)
    record, found, _ = imported(heights_of(tmp_path, noise + bow_um * place[:, None] ** 2 - depth, 10.0))
    off = found / (1e-7 * float(depth.sum())) - 1.0
    assert abs(off) < 0.03 or any("unworn" in note for note in record.notes)
