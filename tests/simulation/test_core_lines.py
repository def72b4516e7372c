"""Mesh lines that fit a core which sticks, so that its nodes have its area."""

import pickle
from math import pi

import numpy as np
import pytest

from geometry import RimGradedAxis
from tests.studies import WEARING, steel_wires
from wirewear.simulation.core_lines import fitted_to_core
from wirewear.simulation.discretisation import discretise
from wirewear.simulation.expected_contact import Ellipse
from wirewear.simulation.plan import core_stages
from wirewear.test import parse_study


@pytest.mark.parametrize("elements", [8, 12, 18])
@pytest.mark.parametrize("share", [0.3, 0.5, 0.6, 0.8])
@pytest.mark.parametrize("longer", [1.0, 1.5])
def test_the_nodes_within_a_core_have_its_area(elements: int, share: float, longer: float) -> None:
    stuck = (1.0 - share) ** (1.0 / 3.0)
    core = Ellipse(longer * stuck, stuck, 0.0)
    lines = RimGradedAxis(longer, elements, 1.6 * longer), RimGradedAxis(1.0, elements, 1.6)
    axial, transverse = fitted_to_core(lines, core, 0.0)
    x, y = axial.lines()[:, None], transverse.lines()
    areas = np.outer(np.gradient(axial.lines()), np.gradient(transverse.lines()))
    within = np.hypot(x / core.major_mm, y / core.minor_mm) < 1.0
    assert areas[within].sum() == pytest.approx(pi * core.major_mm * core.minor_mm, rel=0.01)
    assert axial.half_extent_mm == lines[0].half_extent_mm
    assert axial.rim_mm / lines[0].rim_mm == pytest.approx(transverse.rim_mm, abs=1e-12)


def test_meshes_for_a_core_go_with_the_plan_of_a_run_to_other_processes() -> None:
    study = parse_study(steel_wires("wires", amplitude_um=1.0, cycles=10) + WEARING, "study.toml")
    cores = core_stages(study, "quick", discretise(study, "quick"))
    assert cores is not None
    assert pickle.loads(pickle.dumps(cores))(0.5) == cores(0.5)
