"""The verification table judges rightly, and its reference problems are met."""

import json
from collections.abc import Callable
from dataclasses import replace
from math import inf, nan
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from rich.console import Console

from geometry import ContactPatch, Cylinder
from solvers import CondensedBody
from tests import bodies
from wirewear import reference
from wirewear.faces import cli
from wirewear.loops.area import enclosed_area
from wirewear.verification import FULL, QUICK, Level, Row, run, table, verify, write_json
from wirewear.verification.hertz import ellipse_rows, hertz_rows
from wirewear.verification.interior import interior_rows
from wirewear.verification.limits import limit_rows
from wirewear.verification.line_contact import line_contact_rows, stuck_line_rows
from wirewear.verification.partial_slip import partial_slip_rows
from wirewear.verification.partial_slip_run import partial_slip_run_rows
from wirewear.verification.partial_slip_wear import partial_slip_wear_rows, worn_pressure_rows
from wirewear.verification.rows import compared, falling, largest_growth, observed_order
from wirewear.verification.sliding import book_keeping_rows, half_width_at_zero_force, rig_loop_rows
from wirewear.verification.wires import STEEL, bulk_compliance, scaled, wire_geometry

GOOD = compared("Hertz", "p0 [MPa]", 1010.0, 1000.0, 0.02, raw=1030.0, order=1.9)
BAD = compared("Hertz", "approach [mm]", 1.1, 1.0, 0.02)


def test_errors_are_relative_to_the_exact_value_or_to_the_scale_that_is_named() -> None:
    assert GOOD.error == pytest.approx(0.01)
    assert GOOD.raw_error == pytest.approx(0.03)
    assert compared("", "", 1.5, 1.0, 1.0, scale=0.25).error == pytest.approx(2.0)


@pytest.mark.parametrize(("error", "passed"), [(0.02, True), (-0.02, True), (0.021, False), (nan, False), (inf, False)])
def test_a_row_passes_only_within_its_tolerance_and_never_without_a_number(error: float, passed: bool) -> None:
    assert replace(GOOD, error=error).passed is passed


def test_the_observed_order_is_that_of_a_power_law() -> None:
    assert observed_order(-0.16, 0.01, 4.0) == pytest.approx(2.0)
    assert np.isnan(observed_order(0.1, 0.0, 2.0))


def test_errors_fall_when_each_is_smaller_than_the_one_before_or_below_the_floor() -> None:
    assert largest_growth([0.1, -0.05, 0.04], 0.0) == pytest.approx(0.8)
    assert falling("", "", [0.1, -0.05, 0.04], 0.0).passed
    assert not falling("", "", [0.1, 0.02, 0.03], 0.0).passed
    assert falling("", "", [0.1, 0.0, 0.002], 0.003).passed
    assert not falling("", "", [0.1, 0.0, 0.2], 0.003).passed


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_bulk_compliance_is_what_a_body_has_beyond_a_half_space(axis: int) -> None:
    lines = np.linspace(-2.0, 2.0, 9)
    patch = ContactPatch(lines, lines, np.arange(81).reshape(9, 9), Cylinder(100.0))
    own = 3e-6
    compliance = np.full((81, 3, 81, 3), own)
    x, y = patch.grid().T
    r = np.where(np.hypot(x, y) > 0.0, np.hypot(x, y), 1.0)
    along = np.array([x, y, np.zeros(81)])[axis]
    shear, nu = STEEL.shear_modulus_MPa, STEEL.poissons_ratio
    # Johnson 1985, eqs. 3.19 and 3.75, written with the shear modulus.
    free = (1.0 - nu) / (2.0 * np.pi * shear * r) + (nu * along**2 / (2.0 * np.pi * shear * r**3) if axis < 2 else 0.0)
    compliance[:, axis, 40, axis] += free
    body = CondensedBody.whole(patch, compliance.reshape(243, 243))
    assert bulk_compliance(body, axis, 1.0) == pytest.approx(own, rel=1e-9)


def test_a_loop_has_the_area_and_the_width_of_its_closed_form() -> None:
    contact = reference.partial_slip_point(2.0, 0.6, 0.014, 95_000.0)
    loop = reference.closed_loop(contact, 0.03, 100.0, samples=20_000)
    energy = reference.dissipated_energy(contact, 0.03, 100.0)
    width = reference.slip_amplitude(contact, 0.03, 100.0)
    assert enclosed_area(loop.displacement_mm, loop.tangential_force_N) == pytest.approx(energy, rel=1e-5)
    assert half_width_at_zero_force(loop.displacement_mm, loop.tangential_force_N) == pytest.approx(width, rel=1e-5)


def test_a_mesh_in_other_units_is_the_same_mesh() -> None:
    meshed = bodies.wire(0.02)
    other = scaled(meshed, 1e-3)
    assert other.mesh.volume_mm3() == pytest.approx(1e-9 * meshed.mesh.volume_mm3(), rel=1e-12)
    assert np.allclose(other.mesh.points[other.patch.nodes, 0], other.patch.axial_mm[:, None], rtol=0.0, atol=1e-12)


def test_the_meshes_of_all_levels_resolve_the_contact_as_they_say() -> None:
    for level in (QUICK, FULL):
        assert list(level.hertz_resolutions) == sorted(level.hertz_resolutions)
        for resolution in level.hertz_resolutions:
            lines = wire_geometry(resolution).transverse.lines()
            middle = np.diff(lines)[len(lines) // 2]
            assert 0.015 / middle == pytest.approx(resolution, rel=0.12)


def family(*rows: Row) -> tuple[run.Family, ...]:
    def solve(level: Level) -> tuple[Row, ...]:
        return rows

    return (("a family", solve), ("another family", solve))


def test_all_families_are_run_and_announced() -> None:
    announced: list[tuple[str, int, int]] = []
    rows = verify(QUICK, lambda *what: announced.append(what), family(GOOD, BAD))
    assert rows == (GOOD, BAD, GOOD, BAD)
    assert announced == [("a family", 0, 2), ("another family", 1, 2)]


def test_the_table_shows_every_row_and_how_many_passed() -> None:
    console = Console(width=160)
    with console.capture() as capture:
        console.print(table([GOOD, BAD]))
    text = capture.get()
    assert "1 of 2 checks passed" in text
    for part in ("p0 [MPa]", "1010", "1.00 %", "3.00 %", "1.9", "pass", "approach [mm]", "10.00 %", "FAIL"):
        assert part in text


def test_the_json_file_holds_every_row_and_stays_valid_without_a_number(tmp_path: Path) -> None:
    write_json(tmp_path / "table.json", "quick", [GOOD, replace(BAD, error=nan)])
    document = json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))
    assert (document["level"], document["passed"]) == ("quick", False)
    assert document["rows"][0] == GOOD.as_dict()
    assert document["rows"][1]["error"] is None
    assert [path.name for path in tmp_path.iterdir()] == ["table.json"]


def test_figures_may_be_numbers_of_numpy(tmp_path: Path) -> None:
    rows = [replace(GOOD, computed=np.float64(1010.0), error=np.float64(0.01)), replace(BAD, error=np.float64(nan))]
    write_json(tmp_path / "table.json", "full", rows)
    passed = [row["passed"] for row in json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))["rows"]]
    assert passed == [True, False]


@pytest.mark.parametrize(("rows", "code"), [((GOOD,), 0), ((GOOD, BAD), 1)])
def test_the_command_fails_when_a_row_fails(
    rows: tuple[Row, ...], code: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(run, "FAMILIES", family(*rows))
    result = CliRunner().invoke(cli, ["verify", "--quick", "--json", str(tmp_path / "table.json")])
    assert result.exit_code == code
    assert "checks passed" in result.stdout
    assert json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))["passed"] is (code == 0)


def test_the_folder_of_the_table_is_made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(run, "FAMILIES", family(GOOD))
    result = CliRunner().invoke(cli, ["verify", "--json", str(tmp_path / "nowhere" / "table.json")])
    assert result.exit_code == 0
    assert json.loads((tmp_path / "nowhere" / "table.json").read_text(encoding="utf-8"))["passed"]


def failures(rows: tuple[Row, ...]) -> list[Row]:
    assert rows
    return [row for row in rows if not row.passed]


@pytest.mark.slow
@pytest.mark.parametrize(
    "rows_of",
    [
        hertz_rows,
        ellipse_rows,
        line_contact_rows,
        stuck_line_rows,
        partial_slip_rows,
        partial_slip_wear_rows,
        partial_slip_run_rows,
        rig_loop_rows,
        book_keeping_rows,
        worn_pressure_rows,
    ],
)
def test_the_reference_problems_are_met_at_the_quick_level(rows_of: Callable[[Level], tuple[Row, ...]]) -> None:
    assert failures(rows_of(QUICK)) == []


@pytest.mark.slow
def test_roles_signs_and_units_change_nothing() -> None:
    assert failures(limit_rows(QUICK)) == []


@pytest.mark.slow
def test_the_largest_stress_inside_the_bodies_and_its_depth_are_those_of_hertz_and_mcewen() -> None:
    assert [row for row in interior_rows(QUICK) if not row.passed] == []
