"""Titanium scars at two frequencies: how the script judges, and that its study says what its README says."""

from pathlib import Path

import numpy as np
import pytest

from studies.titanium_oxygenation.compare import (
    VARIANTS,
    Scar,
    findings_of,
    oxygenation_explains_the_w,
    predicts_the_low_frequency_depth,
    scar_in,
    without_it_the_middle_is_deepest,
)
from wirewear.kinds import load_any_study
from wirewear.planar import run_planar_study
from wirewear.planar.tables import PlanarStudy

STUDY = Path(__file__).resolve().parent.parent / "studies" / "titanium_oxygenation" / "study.toml"


def bowl(deepest_um: float, half_width_um: float = 2000.0) -> Scar:
    x = np.linspace(-3000.0, 3000.0, 601)
    return Scar(x, np.maximum(deepest_um * (1.0 - (x / half_width_um) ** 2), 0.0))


def test_the_measured_scars_are_a_u_and_a_w_of_the_volumes_that_are_published() -> None:
    slow, fast = scar_in("measured_0p1Hz"), scar_in("measured_2Hz")
    assert slow.place_um == 0.0
    assert fast.place_um == pytest.approx(800.0)
    assert fast.middle_um < 0.7 * fast.deepest_um
    assert [8.0 * scar.area_mm2 for scar in (slow, fast)] == pytest.approx([2.81, 1.39], rel=0.02)


def test_the_measured_scars_themselves_would_be_explained_and_bowls_are_not() -> None:
    fast, slow = scar_in("measured_2Hz"), scar_in("measured_0p1Hz")
    perfect = {"2Hz": fast, "2Hz_oxygenated": bowl(60.0), "2Hz_plain": bowl(50.0, 2900.0), "0p1Hz": slow}
    judged = findings_of(perfect)
    assert [finding.holds for finding in judged] == [True, True, True, True, False]
    assert not oxygenation_explains_the_w({**perfect, "2Hz": bowl(65.0)}, fast).holds
    assert not without_it_the_middle_is_deepest({**perfect, "2Hz_oxygenated": fast}, fast).holds
    assert not predicts_the_low_frequency_depth({**perfect, "0p1Hz": bowl(100.0)}, slow).holds


@pytest.mark.slow
def test_contact_oxygenation_makes_the_measured_w() -> None:
    """Quick fidelity: depth within 10 %, shape within 8 % of it, deepest on the flanks; both stay so at standard."""
    study = load_any_study(STUDY)
    assert isinstance(study, PlanarStudy)
    assert set(study.variant_names) == set(VARIANTS)
    result = run_planar_study(study.variant("2Hz"), fidelity="quick")
    flat, measured = result.scar(5000, "specimen"), scar_in("measured_2Hz")
    found = Scar(*flat.section_along_motion())
    assert found.deepest_um == pytest.approx(measured.deepest_um, rel=0.10)
    assert found.error(measured) < 0.08
    assert 400.0 < found.place_um < 1000.0
    assert result.quality["volume_against_energy"] < 1e-9
    assert result.quality["energy_against_loops"] < 0.02
