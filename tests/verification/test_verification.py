"""The verification table judges rightly, and its reference problems are met."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from geometry import ContactPatch, Cylinder
from solvers import CondensedBody
from tests.bodies import LOAD_N, RADIUS_mm, condensed_wire, crossed_wires
from wirewear import reference
from wirewear.app.cli import cli
from wirewear.loops.sensor import enclosed_area
from wirewear.verification import QUICK, Family, Level, Row
from wirewear.verification.conforming import pin_rows, taper_rows
from wirewear.verification.hertz import STEEL, bulk_compliance, crossed_bulk_compliance, ellipse_rows, hertz_rows
from wirewear.verification.interior import line_rows, surface_rows, wire_rows
from wirewear.verification.line_contact import line_contact_rows, line_surface_rows, stuck_line_rows
from wirewear.verification.metals import metal_rows
from wirewear.verification.partial_slip import (
    partial_slip_rows,
    partial_slip_wear_rows,
    sliding_rows,
    worn_pressure_rows,
)
from wirewear.verification.partial_slip_run import block_rows, held_force_rows, partial_slip_run_rows
from wirewear.verification.rows import compared, observed_order
from wirewear.verification.sliding import book_keeping_rows, half_width_at_zero_force, limit_rows, rig_loop_rows

GOOD = compared("Hertz", "p0 [MPa]", 1010.0, 1000.0, 0.02, raw=1030.0, order=1.9)
BAD = compared("Hertz", "approach [mm]", 1.1, 1.0, 0.02)


def test_the_observed_order_is_that_of_a_power_law() -> None:
    assert observed_order(-0.16, 0.01, 4.0) == pytest.approx(2.0)
    assert np.isnan(observed_order(0.1, 0.0, 2.0))


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


def family(*rows: Row) -> tuple[Family, ...]:
    def solve(level: Level) -> tuple[Row, ...]:
        return rows

    return (("a family", solve), ("another family", solve))


@pytest.mark.parametrize(("rows", "code"), [((GOOD,), 0), ((GOOD, BAD), 1)])
def test_the_command_fails_with_a_row(
    rows: tuple[Row, ...], code: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("wirewear.verification.FAMILIES", family(*rows))
    result = CliRunner().invoke(cli, ["verify", "--quick", "--json", str(tmp_path / "table.json")])
    assert result.exit_code == code
    assert "checks passed" in result.stdout
    assert json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))["passed"] is (code == 0)


def test_on_a_coarse_mesh_too_partial_slip_is_nearly_mindlins() -> None:
    modulus = reference.contact_modulus(STEEL, STEEL)
    radius = reference.hertz_point(LOAD_N, RADIUS_mm, modulus).contact_radius_mm
    exact = reference.partial_slip_point(LOAD_N, 0.6, radius, reference.tangential_contact_modulus(STEEL, STEEL))
    body, problem = condensed_wire(0.01), crossed_wires(0.01, friction=0.6)
    bulk = crossed_bulk_compliance(body, normal=False, contact_radius_mm=radius)
    rows = sliding_rows(problem, exact, bulk, body, QUICK, shares=(0.9,))
    assert max(abs(row.error) for row in rows) < 0.15


#: Of the reference problems those in plane strain are solved in less than a second.
PLANE = (line_contact_rows, stuck_line_rows, line_surface_rows, line_rows, pin_rows, taper_rows, metal_rows)
SOLID = (
    hertz_rows, ellipse_rows, block_rows, partial_slip_rows, partial_slip_wear_rows, partial_slip_run_rows,
    held_force_rows, rig_loop_rows, book_keeping_rows, worn_pressure_rows, limit_rows, wire_rows, surface_rows,
)  # fmt: skip


@pytest.mark.parametrize("rows_of", [*PLANE, *(pytest.param(rows_of, marks=pytest.mark.slow) for rows_of in SOLID)])
def test_the_reference_problems_are_met_at_the_quick_level(rows_of: Callable[[Level], tuple[Row, ...]]) -> None:
    rows = rows_of(QUICK)
    assert rows
    assert [row for row in rows if not row.passed] == []
