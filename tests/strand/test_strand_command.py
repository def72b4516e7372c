"""`wirewear strand`: what it leaves, what it refuses, the studies that it writes and their runs."""

import tomllib
from collections.abc import Callable, Iterator, Sequence
from math import inf
from pathlib import Path
from time import process_time
from typing import Any

import polars as pl
import pytest

from tests.commands import wirewear
from tests.strand.ropes import rope, seven_wires, strands_of_seven
from wirewear import StudyError, strand_contacts
from wirewear.base.engine import Done, Engine, Result
from wirewear.kinds import load_any_study
from wirewear.strand.runs import run_contacts, with_figures_of_runs
from wirewear.strand.studies import write_studies
from wirewear.sweeps.sweep import SweepRow
from wirewear.test import LineStudy, Study

EXAMPLES = Path(__file__).parents[2] / "studies" / "strand"
STEEL = {"wires": {"material": "steel", "yield_stress_MPa": 1700.0}}
WEARS: dict[str, Any] = {"wear": {"energy_wear_coefficient_mm3_per_J": 3e-5}, "life": {"averaging_length_um": 20.0}}


@pytest.mark.seconds
@pytest.mark.first_case
@pytest.mark.parametrize("example", ["rope_7x7", "seven_wires", "conductor", "rope_6x7"])
def test_a_rope_leaves_a_table_a_picture_a_page_and_studies_ready_to_run(example: str, tmp_path: Path) -> None:
    began = process_time()
    printed = wirewear("strand", EXAMPLES / f"{example}.toml", "--output", tmp_path).output
    assert process_time() - began < 3.0
    table = pl.read_csv(tmp_path / "contacts.csv")
    assert (tmp_path / "section.png").stat().st_size > 10_000
    page = (tmp_path / "strand.html").read_text(encoding="utf-8")
    for row in table.to_dicts():
        assert row["contact"] in page
        assert row["contact"] in printed
        assert row["normal_load_N"] > 0.0
        if row["study"]:
            study = load_any_study(tmp_path / "studies" / row["study"])
            assert study.conditions.normal_load_N == pytest.approx(row["normal_load_N"], rel=1e-5)
            assert study.conditions.displacement_amplitude_um >= row["slip_amplitude_um"]
    assert len(list((tmp_path / "studies").iterdir())) == table["study"].count() > 0
    lives = table["life_upper_cycles"].drop_nulls()
    assert lives[0] == min(lives, default=inf) if len(lives) else example == "conductor"


def test_a_study_of_crossing_wires_has_their_angle_direction_of_slip_and_bulk_stress(tmp_path: Path) -> None:
    found = strand_contacts(strands_of_seven("left", **WEARS) | STEEL)
    row = next(one for one in found.rows if one["kind"] == "crown")
    path = write_studies(found.contacts, found.tables, tmp_path)[row["contact"]]
    text, study = path.read_text(encoding="utf-8"), load_any_study(path)
    assert min(study.crossing_angle_deg, 180.0 - study.crossing_angle_deg) == pytest.approx(row["angle_deg"], abs=1e-3)
    lower, upper = study.bodies
    assert (lower.diameter_mm, upper.diameter_mm) == (1.06, 1.0)
    bulk = upper.bulk
    assert bulk.axial_stress_MPa + bulk.bending_stress_MPa == pytest.approx(row["mean_stress_MPa"], rel=1e-5)
    assert bulk.axial_stress_amplitude_MPa == pytest.approx(row["axial_stress_amplitude_MPa"], rel=1e-5)
    assert bulk.bending_stress_amplitude_MPa == pytest.approx(row["bending_stress_amplitude_MPa"], rel=1e-5)
    # Far beyond yield: the study says so, and its wires yield.
    assert "far beyond yield" in text.partition("format")[0]
    assert {body.yield_stress_MPa for body in study.bodies} == {1700.0}
    assert tomllib.loads(text)["life"] == WEARS["life"]


def test_a_rope_of_the_other_hand_is_its_mirror_image() -> None:
    def turned(lay: str, other: str) -> Any:
        tables = strands_of_seven(other, other) | STEEL
        tables["outer_strands"] |= {"lay": lay}
        (study,) = (own for name, own in strand_contacts(tables).studies().items() if "on core strand" in name)
        return study

    right, left = turned("right", "left"), turned("left", "right")
    assert right.crossing_angle_deg == pytest.approx(180.0 - left.crossing_angle_deg, abs=1e-3)
    assert right.motion_angle_deg == pytest.approx(-left.motion_angle_deg, abs=1e-3)
    assert right.conditions.normal_load_N == left.conditions.normal_load_N


def test_a_line_is_a_line_contact_of_one_millimetre() -> None:
    found = strand_contacts(seven_wires(3.12, 60, **WEARS) | STEEL)
    name, study = next(iter(found.studies().items()))
    assert isinstance(study, LineStudy)
    assert name == "layer 1 on core"
    assert study.tables.contact.length_mm == 1.0
    assert study.pad.radius_mm == pytest.approx(1.0 / (2.0 / 3.12 + 2.0 / 2.9), rel=1e-5)
    assert study.conditions.normal_load_N == pytest.approx(85.87, rel=2e-3)


def test_without_friction_all_slips_freely_and_nothing_wears() -> None:
    found = strand_contacts(seven_wires(3.12, 60, **WEARS, friction=0.0) | STEEL)
    (one,) = found.contacts
    assert one.contact.slip_amplitude_mm == pytest.approx(one.contact.free_slip_mm, rel=1e-6)
    assert (one.energy_mJ, one.worn_depth_mm) == (0.0, 0.0)


def test_a_straight_rope_sticks_and_has_no_study() -> None:
    tables = seven_wires(3.12, 60, **WEARS) | STEEL
    tables["conditions"]["bending_radius_mm"] = 1e6
    found = strand_contacts(tables)
    assert found.contacts[0].regime == "partial slip"
    assert found.contacts[0].contact.slip_amplitude_mm == 0.0
    assert found.studies() == {}
    assert found.rows[0]["study"] is None


def test_energy_and_slip_of_a_cycle_over_a_sheave_are_those_of_half_the_curvature() -> None:
    def found(**conditions: Any) -> Any:
        tables = seven_wires(3.12, 60) | STEEL
        tables["conditions"] |= conditions
        return strand_contacts(tables).contacts[0]

    over, swung = found(bending="pulsating"), found(bending_radius_mm=1000.0)
    assert over.contact.slip_amplitude_mm == swung.contact.slip_amplitude_mm
    assert over.energy_mJ == swung.energy_mJ
    assert over.contact.upper.bending_MPa == over.contact.upper.bending_amplitude_MPa == pytest.approx(304.5)
    assert swung.contact.upper.bending_MPa == 0.0


def test_a_line_that_slides_as_a_whole_dissipates_four_times_limit_and_slip() -> None:
    one = strand_contacts(seven_wires(3.12, 60) | STEEL).contacts[0]
    sliding = 4.0 * 0.15 * one.contact.load_N * one.contact.slip_amplitude_mm
    assert sliding < one.energy_mJ < 1.01 * sliding


def _layer(**changes: Any) -> dict[str, Any]:
    tables = seven_wires(3.12, 60)
    tables["layers"][0] |= changes
    return tables


def _with(table: str, **changes: Any) -> dict[str, Any]:
    tables = strands_of_seven("left")
    return tables | {table: tables[table] | changes}


@pytest.mark.parametrize(
    ("tables", "sentence"),
    [
        (_layer(lay_length_mm=-60), "is -60, but a lay length is positive: its direction is lay ="),
        (_layer(wires=8), "cannot hold 8 wires of 2.9 mm around 3.12 mm: they would lie 1.07 mm off what is"),
        (_layer(lay_length_mm=9), "at a lay length of 9 mm they have no room at any radius"),
        (_layer(wires=3, lay_length_mm=15), "has a lay angle of "),
        (_layer(radius_mm=2.9), "interpenetrates what lies below: its wires of 2.9 mm touch 3.12 mm from a"),
        (seven_wires(3.0, 60)["layers"], "radius_mm is 2.95"),
        (_layer(radius_mm=3.6), "give a radius_mm of 3.01, or none"),
        (_layer(lay_lenght_mm=60), "unknown key 'lay_lenght_mm' in [[layers]] number 1 of the rope: did you mean "),
        (_layer(lay="S"), """lay in [[layers]] number 1 of the rope is 'S', but must be "right" or "left"."""),
        (rope(1e3, core={"wire_diameter_mm": 3.0}), "has neither [[layers]] nor [outer_strands]"),
        (rope(1e3, core={"fibre_diameter_mm": 3.0}, layers=seven_wires(3.0, 90)["layers"]), "only [outer_strands]"),
        (rope(1e3, core={}, layers=seven_wires(3.0, 90)["layers"]), "must give wire_diameter_mm, or fibre_diameter_mm"),
        (_with("outer_strands", strands=8), "cannot hold 8 strands of 3.06 mm around 3.24 mm"),
        (_with("conditions", tension_amplitude_N=2e4), "the rope stays taut only if it is below tension_N, 10000."),
        (_with("conditions", tension_kN=10), "the tension of the rope is given as tension_N, in newtons."),
        (_with("conditions", bending_radius_mm=2.0), "which no wire does: look at tension_N and bending_radius_mm"),
        (
            strands_of_seven("left", sheave={"groove_radius_mm": 1.0, "material": "steel"}),
            "the rope needs more than its own radius, 4.68 mm.",
        ),
    ],
)  # fmt: skip
def test_a_rope_that_cannot_be_is_refused_in_one_sentence(tables: Any, sentence: str) -> None:
    if isinstance(tables, list):
        tables = rope(2e4, core={"wire_diameter_mm": 3.0}, layers=[tables[0] | {"radius_mm": 2.95}])
        sentence = "interpenetrate one another: at a lay length of 60 mm they have room from a radius of 3.008 mm on"
    with pytest.raises(StudyError) as caught:
        strand_contacts(tables)
    assert sentence in str(caught.value)
    assert str(caught.value).count("\n") == 0


@pytest.mark.parametrize(
    ("command", "file", "sentence"),
    [
        ("run", EXAMPLES / "seven_wires.toml", "is a rope's construction, and no study: `wirewear strand "),
        (
            "strand",
            EXAMPLES.parent / "steel_wires" / "study.toml",
            "is a study, and no rope's construction: `wirewear run ",
        ),
        ("strand", "nowhere.toml", "there is no TOML file nowhere.toml."),
    ],
)
def test_a_file_of_another_kind_is_named_with_its_command(
    command: str, file: str | Path, sentence: str, tmp_path: Path
) -> None:
    assert sentence in wirewear(command, file, "--output", tmp_path / "out", code=2).stderr


class InPlace(Engine):
    """Does its tasks here, one after another."""

    words = "this process"
    workers = 1

    def done(self, tasks: Sequence[Callable[[], Result]], until: float = inf) -> Iterator[Done[Result]]:
        del until
        for place, task in enumerate(tasks):
            yield Done(place, task())


def test_runs_of_contacts_go_through_the_engine_of_sweeps_once_and_stand_in_the_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []

    def short(
        study: Study | LineStudy, values: dict[str, float], fidelity: str, number: int, results: Path
    ) -> SweepRow:
        assert (values, fidelity, results.name) == ({}, "quick", "runs")
        made.append(study.name)
        return SweepRow(number, {"cycles_to_initiation": 100.0 * number}, cpu_s=1.0)

    monkeypatch.setattr("wirewear.sweeps.running.run_case", short)
    monkeypatch.setattr("wirewear.simulation.needed_memory", lambda *_: 1e6)
    found = strand_contacts(strands_of_seven("left", **WEARS) | STEEL)
    studies = found.studies()
    for worst, expected in ((1, 1), (None, len(studies)), (1, len(studies))):
        runs = run_contacts(found.name, studies, "quick", tmp_path, InPlace(), worst=worst)
        assert len(made) == expected
    assert made[0] == f"rope: {found.contacts[0].contact.name}"
    assert sorted(made) == sorted(f"rope: {name}" for name in studies)
    rows = with_figures_of_runs(found.rows, runs)
    numbers = {name: 100.0 * number for number, name in enumerate(studies, 1)}
    assert {row["contact"]: row["run_life_cycles"] for row in rows if row["study"]} == numbers
