"""Friction of contacts that stick in their middle, read from loops that another principle than the reading's makes."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from geometry.arrays import Array
from tests.commands import wirewear
from tests.synthetic_loops import Recipe, SyntheticLoop, bristle_loop, partial_slip_loop
from wirewear.loops import LoopFigures, analyse_loop
from wirewear.loops.figures import regime_of

LOAD_N = 40.0


def measured(friction: float, share: float, seed: int, rig_um_per_N: float) -> LoopFigures:
    time, displacement, force = bristle_loop(friction * LOAD_N, share, seed, 1.0 / 8.0, rig_um_per_N)
    return analyse_loop(displacement, force, LOAD_N, time_s=time)


@pytest.mark.parametrize("share", [0.5, 0.7, 0.85, 0.95])
@pytest.mark.parametrize("rig_um_per_N", [0.0, 0.1])
def test_energy_stiffness_and_shape_together_hold_friction_in_partial_slip(share: float, rig_um_per_N: float) -> None:
    found = measured(0.6, share, int(100 * share), rig_um_per_N)
    friction, used = found.friction_partial_slip, found.used_share
    assert found.regime == "partial slip"
    assert friction is not None
    assert used is not None
    assert friction.interval95[0] < 0.6 < friction.interval95[1]
    assert used.interval95[0] < share < used.interval95[1]
    if share >= 0.85:
        assert friction.interval95[1] < 1.5 * friction.interval95[0]


def test_a_loop_too_thin_bounds_friction_below_alone_and_may_stick() -> None:
    found = measured(0.6, 0.06, 3, 0.5)
    friction = found.friction_partial_slip
    assert friction is not None
    assert math.isnan(friction.value)
    assert friction.interval95 == pytest.approx((0.036, math.inf), rel=0.05)
    assert found.regimes == ("stick", "partial slip")


def test_the_regime_of_a_loop_at_its_boundary_is_in_doubt() -> None:
    time, displacement, force = partial_slip_loop(0.9999, 200)
    random = np.random.default_rng(2)
    force = force + 0.005 * random.standard_normal(force.size)
    assert set(analyse_loop(displacement, force, 2.0, time_s=time).regimes) == {"partial slip", "gross slip"}


@pytest.mark.parametrize("excess", [1.02, 1.1])
def test_sliding_by_less_than_a_plateau_needs_is_gross_slip_with_its_friction(excess: float) -> None:
    threshold_um = 1240.0 / 167.0 + 1.5 * 1240.0 / 2718.0
    _, displacement, force = SyntheticLoop(Recipe(amplitude_um=excess * threshold_um)).sampled(256)
    found = analyse_loop(displacement, force, 2.0)
    assert found.regime == "gross slip"
    assert found.friction_partial_slip is not None
    assert found.friction_partial_slip.value == pytest.approx(0.62, rel=0.01)


def worn_loop(share: float, worn: float, noise: float, seed: int) -> tuple[Array, Array]:
    """Displacement (µm) and force (N) of a sphere's loop at Q*/µP = share and µ = 0.6, whose profile beyond what sticks
    (radius 1) has come nearer to the approach b² by the share `worn`, by the method of dimensionality reduction (Popov
    2014), in lengths and moduli of one, and Jäger's law.
    """

    def at_radius(radius: Array, outer: float) -> tuple[Array, Array]:
        approach = worn * outer**2 + (1.0 - worn) * radius**2
        beside = (1.0 - worn) * (2.0 * radius**3 / 3.0 - radius**2 + 1.0 / 3.0)
        return approach, approach - 1.0 / 3.0 + beside

    def load_of(outer: float) -> float:
        return float(at_radius(np.array([outer]), outer)[1][0])

    outer = float(brentq(lambda b: load_of(b) - 2.0 / 3.0 / (1.0 - share), 1.0, 30.0))
    approach, load = at_radius(np.linspace(outer, 1.0, 400), outer)
    own = np.append(approach[0] - approach, approach[0] - 1.0)
    force = 0.6 * LOAD_N * np.append(load[0] - load, load[0] - 2.0 / 3.0) / load[0]
    random, angle = np.random.default_rng(seed), 2.0 * math.pi * np.arange(240) / 240 + 0.3
    x = own[-1] * np.sin(angle)
    up, down = (2.0 * np.interp(0.5 * (own[-1] + one), own, force) - force[-1] for one in (x, -x))
    displacement = 0.5 * own[-1] * noise * random.standard_normal(x.size) + x
    return displacement, np.where(np.cos(angle) > 0.0, up, -down) + noise * force[-1] * random.standard_normal(x.size)


@pytest.mark.parametrize("share", [0.5, 0.7, 0.9, 0.98])
@pytest.mark.parametrize("worn", [0.1, 0.3, 0.6, 0.9])
def test_friction_of_a_loop_whose_annulus_may_have_worn_is_bounded_by_what_holds_it(share: float, worn: float) -> None:
    found = analyse_loop(*worn_loop(share, worn, 0.002, int(100 * share + worn)), LOAD_N, cycle=10_000)
    friction, used = found.friction_partial_slip, found.used_share
    assert "partial slip" in found.regimes
    assert friction is not None
    assert used is not None
    assert math.isnan(friction.value)
    assert friction.interval95[0] < 0.6 < friction.interval95[1]
    assert used.interval95[0] < share < used.interval95[1]
    assert found.friction_geometry_independent is found.friction_energy is None


def test_an_unworn_annulus_has_a_value_and_its_lower_bound_is_nearer() -> None:
    loop = worn_loop(0.9, 0.0, 0.002, 1)
    fresh, unknown = (analyse_loop(*loop, LOAD_N, cycle=cycle).friction_partial_slip for cycle in (1, None))
    assert fresh is not None
    assert unknown is not None
    assert fresh.value == pytest.approx(0.6, rel=0.03)
    assert unknown.interval95[0] < 0.54 < fresh.interval95[0] < 0.6 < unknown.interval95[1] == fresh.interval95[1]


def test_partial_and_gross_slip_make_a_mixed_test() -> None:
    _, displacement, force = SyntheticLoop(Recipe()).sampled(200)
    sliding = analyse_loop(displacement, force, 2.0)
    assert regime_of([measured(0.6, 0.7, 1, 0.0), sliding]) == "mixed"


@pytest.mark.seconds
def test_the_command_prints_the_interval_or_the_bound_and_null_for_what_is_not_known(tmp_path: Path) -> None:
    found = {}
    for share in (0.06, 0.9):
        _, displacement, force = bristle_loop(0.6 * LOAD_N, share, 4, 0.125, 0.5)
        path = tmp_path / f"{share}.csv"
        rows = (f"{x},{q}" for x, q in zip(displacement, force, strict=True))
        path.write_text("\n".join(["displacement_um,tangential_force_N", *rows]))
        found[share] = json.loads(wirewear("loops", path, "--normal-load", str(LOAD_N), "--json").stdout)
    bounded, measured = (one["loops"][0] for one in found.values())
    assert bounded["friction_partial_slip"]["value"] is bounded["friction_partial_slip"]["interval95"][1] is None
    assert bounded["possible_regimes"] == ["stick", "partial slip"]
    assert measured["friction_partial_slip"]["interval95"][0] < 0.6 < measured["friction_partial_slip"]["interval95"][1]
    assert found[0.9]["regime"] == "partial slip"
    text = wirewear("loops", path, "--normal-load", str(LOAD_N), "--output", tmp_path / "loops.png").stdout
    assert "Without a plateau" in text
