"""The report of a test for print: items that the standards name, budgets after the GUM, a template of one's own."""

import hashlib
import json
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest

from tests.browser import page_faults
from tests.commands import wirewear
from tests.records.joint_records import joint
from tests.records.point_records import run_of, run_of_wires
from wirewear import read_record, record_of_result, write_record, write_result
from wirewear.comparison.budget import Budget, Contribution, of_repeats
from wirewear.comparison.laboratory_report import NOT_STATED, LaboratoryReport, laboratory_report
from wirewear.records.common_tables import Metadata

pytestmark = pytest.mark.seconds

#: What can be read of both standards asks for these (docs of the report say what could not be read).
E2789 = (
    "materials", "contact", "normal load", "displacement amplitude", "tangential force", "finish", "environment",
    "hardness", "frequency", "cycles", "compliance of the test system", "analytical procedures", "cracks",
)  # fmt: skip
G204 = ("contact", "normal load", "environment", "lubricant", "volume loss of each body", "regime of slip")


@pytest.fixture(scope="module")
def record_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    record = record_of_result(run_of_wires(), depth_noise_um=0.05, repeats=3, seed=2)
    return write_record(tmp_path_factory.mktemp("report") / "record", record)


@pytest.fixture(scope="module")
def report(record_path: Path) -> LaboratoryReport:
    known = {"displacement": 0.005, "tangential_force": 0.003, "normal_force": 0.004, "depth": 0.01, "lateral": 0.002}
    return laboratory_report(read_record(record_path), record_path, known)


def test_the_guides_own_example_of_a_budget_comes_out() -> None:
    """GUM, example of G.4.1: y = b x1 x2 x3, relative uncertainties of means of 10, 5 and 15 observations."""
    parts = [Contribution("x", "A", 1.0, "1", "t", u, 1.0, count - 1.0) for u, count in
             ((0.25, 10), (0.57, 5), (0.82, 15))]  # fmt: skip
    budget = Budget("y", "y", 100.0, "%", tuple(parts))
    assert budget.combined == pytest.approx(1.03, abs=0.005)
    assert budget.freedom == pytest.approx(19.0, abs=0.05)
    assert budget.coverage == pytest.approx(2.09, abs=0.005)
    assert budget.expanded == pytest.approx(2.2, abs=0.05)


def test_one_test_alone_has_the_scatter_of_others_and_known_infinitely_well() -> None:
    one, three = of_repeats([2.0], "J", 0.02, "by experience"), of_repeats([1.0, 2.0, 3.0], "J", 0.02, "")
    assert (one.kind, one.freedom, three.kind, three.freedom) == ("B", inf, "A", 2.0)
    assert (one.uncertainty, three.uncertainty) == pytest.approx((0.04, 1.0 / np.sqrt(3.0)))


@pytest.mark.first_case
@pytest.mark.parametrize("asked", [E2789, G204])
def test_every_item_that_a_standard_names_stands_in_the_report(
    report: LaboratoryReport, asked: tuple[str, ...], tmp_path: Path, record_path: Path
) -> None:
    wirewear("report", record_path, "--output", tmp_path)
    page = (tmp_path / "test_report.html").read_text(encoding="utf-8")
    assert not set(asked) - {item.name for item in report.items}
    for name in asked:
        assert f"<td>{name}</td>" in page
    assert page_faults(tmp_path / "test_report.html") == []
    assert "@page { size: A4" in page


def test_figures_are_those_of_the_test_within_their_uncertainty(report: LaboratoryReport) -> None:
    run, found = run_of_wires(), {one.name: one for one in report.budgets}
    for name, body in (("worn volume, moving wire", "moving"), ("worn volume, fixed wire", "fixed")):
        assert abs(found[name].value - run.scar(100_000, body).volume_mm3) < found[name].expanded
    both = found["worn volume, both bodies"]
    assert both.value == pytest.approx(found["worn volume, moving wire"].value + found["worn volume, fixed wire"].value)
    alpha = found["energy wear coefficient"]
    assert alpha.value == pytest.approx(both.value / found["friction energy of the test"].value)
    first, second = (found[name].combined / found[name].value for name in (both.name, "friction energy of the test"))
    assert alpha.combined / alpha.value == pytest.approx(np.hypot(first, second))


def test_a_gain_moves_a_figure_as_its_sensitivity_says(report: LaboratoryReport, record_path: Path) -> None:
    record = read_record(record_path)
    stronger = replace(
        record, loops=tuple(replace(one, tangential_force_N=1.01 * one.tangential_force_N) for one in record.loops),
        evolution=(),
    )  # fmt: skip
    plain = laboratory_report(replace(record, evolution=()), record_path)
    for before, after in zip(plain.budgets, laboratory_report(stronger, record_path).budgets, strict=True):
        if before.name in ("coefficient of friction", "friction energy of the test"):
            (gain,) = (one for one in before.contributions if one.source == "calibration, tangential force")
            assert after.value - before.value == pytest.approx(0.01 * gain.sensitivity, rel=0.01)


def test_the_noise_of_depths_moves_volumes_by_what_the_budget_says(report: LaboratoryReport, record_path: Path) -> None:
    record, random = read_record(record_path), np.random.default_rng(4)
    (scar,) = (one for one in record.scars_of("moving") if one.repeat == 1)
    noisy = [scar.of_field(scar.depth_um + 0.05 * random.standard_normal(scar.depth_um.shape)) for _ in range(24)]
    spread = float(np.std([one.volume_mm3 for one in noisy], ddof=1))
    alone = replace(record, scars=(scar,), loops=tuple(one for one in record.loops if one.repeat == 1))
    (volume,) = (one for one in laboratory_report(alone, record_path).budgets if one.name == "worn volume, moving wire")
    (noise,) = (one for one in volume.contributions if one.source == "noise of depths")
    assert 0.5 < noise.uncertainty / spread < 2.0


def test_deviations_and_hashes_are_those_of_the_record(report: LaboratoryReport, record_path: Path) -> None:
    assert any("hemispherical" in text for text in report.deviations)
    assert report.hashes["loops.csv"] == hashlib.sha256((record_path / "loops.csv").read_bytes()).hexdigest()
    assert set(report.hashes) == {one.name for one in record_path.iterdir() if one.is_file()}
    (place,) = (item for item in report.items if item.name == "environment")
    assert place.text == NOT_STATED
    assert not place.known


def test_a_ball_on_a_flat_in_a_rooms_air_deviates_in_nothing(tmp_path: Path) -> None:
    record = record_of_result(run_of("ball-on-flat"), repeats=2)
    facts = Metadata(temperature_C=22.0, atmosphere="laboratory air", lubricant="none")
    stated = replace(record, tables=record.tables.model_copy(update={"metadata": facts}))
    path = write_record(tmp_path / "record", stated)
    assert laboratory_report(read_record(path), path).deviations == ()


def test_a_template_of_ones_own_is_filled_and_a_wrong_placeholder_named(record_path: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.html"
    own.write_text("<h1>${title}</h1>${figures}<p>Institut</p>${deviations}", encoding="utf-8")
    wirewear("report", record_path, "--output", tmp_path / "out", "--template", own, "--rationale", "wires <only>")
    page = (tmp_path / "out" / "test_report.html").read_text(encoding="utf-8")
    assert page.startswith("<h1>Fretting test:")
    assert "coefficient of friction" in page
    assert "wires &lt;only&gt;" in page
    own.write_text("${nonsense}", encoding="utf-8")
    answer = wirewear("report", record_path, "--output", tmp_path / "other", "--template", own, code=2)
    assert "nonsense" in answer.output
    assert not (tmp_path / "other" / "test_report.html").exists()


def test_a_simulation_and_a_joint_without_scars_are_reported_too(tmp_path: Path) -> None:
    run = write_result(tmp_path / "run" / "result.h5", run_of_wires())
    wirewear("report", run.path, "--print")
    numbers = json.loads((tmp_path / "run" / "test_report.json").read_text(encoding="utf-8"))
    assert {"coefficient of friction", "worn volume, both bodies"} <= {one["name"] for one in numbers["figures"]}
    assert [*numbers["inputs_sha256"]] == ["result.h5"]
    path = joint(tmp_path / "joint")
    wirewear("report", path, "--output", tmp_path / "of_joint")
    assert (tmp_path / "of_joint" / "test_report.html").exists()
    assert "--output" in wirewear("report", path, code=2).output
