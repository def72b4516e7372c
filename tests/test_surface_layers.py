"""Layers on a body's surface: how long one lasts, how it rubs, and what a run tells of it."""

from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
import pytest

import solvers
from solvers.layers import receded
from tests.bodies import FRICTION, driven
from tests.studies import line_study
from tests.test_simulate import coarse
from tests.wear_jumps import LINE_LOAD_N_per_mm, line_contact
from wirewear import run_study
from wirewear.base.errors import StudyError
from wirewear.pictures.scar_maps import scars_from_above
from wirewear.simulation import simulate
from wirewear.views.run_page import sentence

pytestmark = pytest.mark.seconds


def test_layers_wear_one_after_another_as_their_differential_equation_says() -> None:
    layers = (solvers.SurfaceLayer(2e-3, 0.25), solvers.SurfaceLayer(1e-3, 4.0))
    depth, bare, steps = np.array([0.0, 1e-3, 2.9e-3, 5e-3]), 1e-2, 20_000
    worn = depth.copy()
    for _ in range(steps):
        worn += bare / steps * np.select([worn < 2e-3, worn < 3e-3], [0.25, 4.0], 1.0)
    assert depth + receded(layers, depth, np.full(4, bare)) == pytest.approx(worn, abs=5e-6)
    halfway = depth + receded(layers, depth, np.full(4, 0.5 * bare))
    assert halfway + receded(layers, halfway, np.full(4, 0.5 * bare)) == pytest.approx(worn, abs=5e-6)


def test_a_coat_in_gross_slip_lasts_as_long_as_the_segment_of_the_cylinder_that_it_loses() -> None:
    """A cylinder that wears on a flat that does not becomes flat: A = 4/3 t √(2Rt) when it is worn by t."""
    radius_mm, thickness_mm, share = 6.0, 0.009, 0.5
    energy_mm3_per_J, friction, load, ends = 8e-4, 0.6, 30.0, [1, 1000, 10_000, 20_000]
    coat = {"thickness_um": 1e3 * thickness_mm, "wear_factor": share}
    wear = {"pad_energy_mm3_per_J": energy_mm3_per_J, "specimen_energy_mm3_per_J": 0.0}
    result = simulate(line_study(pad={"layers": [coat]}, wear=wear, log={"loop_cycles": ends}), fidelity="quick")
    area_mm2 = 4.0 / 3.0 * thickness_mm * sqrt(2.0 * radius_mm * thickness_mm)
    slip_mm = 1e-3 * float(result.evolution["slip_amplitude_um"][-2])
    per_cycle = 1e-3 * share * energy_mm3_per_J * 4.0 * friction * load * slip_mm
    (found,) = result.worn_through("pad")
    assert found == pytest.approx(area_mm2 / per_cycle, rel=0.02)
    assert result.worn_through("specimen") == ()
    # Wear goes on in the cylinder itself, twice as fast.
    volume, energy_J = result.evolution["worn_volume_pad_mm3"], result.evolution["accumulated_energy_J"]
    assert volume[2] / energy_J[2] == pytest.approx(share * energy_mm3_per_J, rel=1e-6)
    assert volume[-1] / energy_J[-1] > 1.05 * share * energy_mm3_per_J


def pulled(problem: solvers.ContactProblem, worn_mm: tuple[float, float] = (0.0, 0.0)) -> float:
    """Friction of a cylinder on a flat that slide, worn evenly by so much, over load and the coefficient."""
    fresh = solvers.unloaded_state(problem)
    depths = [depth + more for depth, more in zip(fresh.wear.depths, worn_mm, strict=True)]
    start = replace(fresh, wear=replace(fresh.wear, primary_depth=depths[0], secondary_depth=depths[1]))
    last = driven(problem, solvers.press(problem, start)[0], np.array([0.005, 0.01]))[1][-1][-1]
    assert last.sticking == 0
    return last.tangential_force / LINE_LOAD_N_per_mm / FRICTION


def test_a_layer_rubs_by_its_own_friction_until_it_is_worn_through() -> None:
    coat, skin = solvers.SurfaceLayer(3e-3, 1.0, 0.5), solvers.SurfaceLayer(5e-3, 1.0, 0.8)
    coated = line_contact(wear=solvers.WearRates(1e-9, 1e-9, upper_layers=(coat,)))
    assert pulled(coated) == pytest.approx(0.5, rel=5e-3)
    assert pulled(coated, (3e-3, 0.0)) == pytest.approx(1.0, rel=5e-3)
    assert pulled(coated, (2.85e-3, 0.0)) == pytest.approx(0.75, rel=5e-3)
    both = line_contact(wear=solvers.WearRates(1e-9, 1e-9, upper_layers=(coat,), lower_layers=(skin,)))
    assert pulled(both) == pytest.approx(0.65, rel=5e-3)
    assert pulled(both, (4e-3, 0.0)) == pytest.approx(0.8, rel=5e-3)


def test_a_run_of_wires_tells_when_a_layer_was_worn_through_and_shows_where(tmp_path: Path) -> None:
    bare = coarse()
    deepest = run_study(bare, fidelity="quick", output=tmp_path / "bare")[0].evolution["max_depth_fixed_um"]
    layers = [{"thickness_um": 0.5 * float(deepest[-1]), "wear_factor": 0.9, "friction": 0.5}]
    coated = bare.with_values({"wires.fixed.layers": layers})
    rates = coated.tables.wear_rates
    assert rates.lower_layers == ()
    assert rates.upper_layers[0].friction_factor == pytest.approx(0.5 / bare.contact.friction)
    result = run_study(coated, fidelity="quick", output=tmp_path / "coated")[0]
    (through,) = result.worn_through("fixed")
    assert through is not None
    cycles, depth = result.evolution["cycle"], result.evolution["max_depth_fixed_um"]
    assert depth[cycles < through].max() < layers[0]["thickness_um"] < depth[-1]
    assert f"layers, from the outermost, are worn through at cycle {round(through)}." in sentence(result)
    maps = scars_from_above([result]).axes[:2]
    assert [any("Contour" in type(one).__name__ for one in axes.collections) for axes in maps] == [False, True]


def test_a_layers_friction_needs_friction_in_the_contact() -> None:
    layers = {"layers": [{"thickness_um": 2.0, "friction": 0.2}]}
    with pytest.raises(StudyError, match=r"layers in study.toml give a friction of their own, which goes with"):
        line_study(pad=layers, contact={"friction": 0.0})
    with pytest.raises(StudyError, match=r"give a friction of their own, which goes with a friction above 0"):
        coarse().with_values({"contact.friction": 0.0, "wires.fixed.layers": layers["layers"]})
    with pytest.raises(StudyError, match="thickness_um"):
        line_study(pad={"layers": [{"thickness_um": -2.0}]})
