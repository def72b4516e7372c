"""The rig stiffness study: what its rigs are, and what rotation in place of translation changes."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from studies.rig_stiffness_2d import article
from studies.rig_stiffness_2d.article import Case, cases, comparisons, findings
from studies.rig_stiffness_2d.rigs import Change, Rig, equally_stiff, rig_of, shipped
from wirewear.planar import PlanarStudy, run_planar_study

X_um = np.linspace(-2000.0, 2000.0, 801)


def rig(case: int, scenario: int, *, contact: str = "flat", centre_um: float = 0.0, stiffness: float = 7.0e3) -> Rig:
    """A made-up rig: an elliptic pressure 1 mm wide about a centre."""
    pressure = 100.0 * np.sqrt(np.maximum(1.0 - ((X_um - centre_um) / 500.0) ** 2, 0.0))
    angle = 2.0 * np.pi * np.arange(16) / 16
    return Rig(
        contact=contact,
        case=case,
        scenario=scenario,
        stiffness=stiffness,
        regime="partial slip",
        measured_stiffness_N_per_mm2=6.1e3,
        largest_tilt_deg=0.0 if scenario == 1 else 0.18,
        dissipated_energy_mJ_per_mm=0.1,
        displacement_um=35.0 * np.cos(angle),
        tangential_force_N_per_mm=200.0 * np.cos(angle - 0.1),
        x_um=X_um,
        pressure_MPa=pressure,
        shear_MPa=0.5 * pressure,
        slip_amplitude_um=np.where(pressure > 0.0, 2.0, 0.0),
    )


def coarse(contact: str, name: str, **mesh: float) -> PlanarStudy:
    """A shipped rig at another resolution."""
    study = shipped(contact, "quick").variant(name)
    return study.model_copy(update={"mesh": study.mesh.model_copy(update=mesh)}).named(name)


def test_slip_at_edges_and_where_a_pad_lifts_is_judged_by_the_rigs() -> None:
    row: dict[str, float | str | None] = {}
    one, two = rig(1, 1), rig(1, 2)
    edge = np.abs(X_um) > 400.0
    less = replace(two, slip_amplitude_um=np.where(edge, 0.5, 1.0) * two.slip_amplitude_um)
    assert article.slip_falls_at_the_edges([Case(row, one, less)]).holds
    assert not article.slip_falls_at_the_edges([Case(row, less, two)]).holds
    lifted = replace(less, pressure_MPa=np.where(X_um > 400.0, 0.0, less.pressure_MPa))
    assert article.slips_less_where_it_lifts([Case(row, one, lifted)]).holds
    assert not article.slips_less_where_it_lifts([Case(row, one, less)]).holds
    slow = replace(one, slip_amplitude_um=0.1 * X_um**0)
    assert not article.slips_less_where_it_lifts([Case(row, slow, lifted)]).holds


@pytest.mark.slow
def test_a_rotational_spring_is_found_with_which_the_loop_is_as_stiff() -> None:
    """Within 3 % of the article's spring for the same contact, and the same loop."""
    mesh: dict[str, Any] = {"contact_mesh_um": 30.0}
    one = rig_of(run_planar_study(coarse("cylinder", "translating_2", **mesh), fidelity="quick"), "cylinder")
    two = equally_stiff(one, coarse("cylinder", "rotating_2", **mesh), "quick")
    assert two.measured_stiffness_N_per_mm2 == pytest.approx(one.measured_stiffness_N_per_mm2, rel=2e-3)
    assert two.stiffness == pytest.approx(1.06e6, rel=0.03)
    change = Change.between(one, two)
    assert change.loop < 0.01
    assert change.pressure_reshaped < 0.01
    assert {one.regime, two.regime} == {"partial slip"}
    # In a cycle each point slides four times its amplitude against friction times pressure.
    work = 4e-6 * 0.9 * np.trapezoid(one.pressure_MPa * one.slip_amplitude_um, one.x_um)
    assert work == pytest.approx(one.dissipated_energy_mJ_per_mm, rel=0.05)


@pytest.mark.slow
def test_a_tilting_flat_presses_on_its_edge_and_is_as_stiff_as_the_article_says() -> None:
    one, two = (
        rig_of(run_planar_study(coarse("flat", name, contact_mesh_um=40.0), fidelity="quick"), "flat")
        for name in ("translating_1", "rotating_1")
    )
    found, change = cases([(one, two)]), Change.between(one, two)
    assert all(row.holds for row in comparisons(found))
    pressure, narrowing, *_ = findings(found, [change])
    assert narrowing.holds
    assert "share of the load" in pressure.evidence
    assert change.pressure_reshaped > 0.1
    assert change.pressure_centre_um < -500.0
    assert one.load_N_per_mm == pytest.approx(800.0, rel=1e-3)
