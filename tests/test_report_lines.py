"""The page of a line contact's run: what the result holds, and a browser that moves through its cycles."""

from dataclasses import replace

import numpy as np

from tests.synthetic_results import loop, profile
from wirewear.results import Evolution, RunResult
from wirewear.views.run_page import line_page

CYCLES = (1, 100, 10_000)


def result(variant: str = "", depth_um: float = 4.0) -> RunResult:
    """A made-up run: Coulomb loops, parabolic scars whose depth grows with the root of the cycles."""
    x = np.linspace(-500.0, 500.0, 41)
    growth = np.sqrt(np.array(CYCLES) / CYCLES[-1])
    bowl = np.maximum(1.0 - (x / 300.0) ** 2, 0.0)
    n, cycles = len(CYCLES), np.array(CYCLES, dtype=float)
    scars = tuple(
        profile(body, x, share * depth_um * g * bowl, cycle, pressure_MPa=200.0 * bowl, slip_distance_um=80.0 * bowl)
        for cycle, g in zip(CYCLES, growth, strict=True)
        for body, share in (("pad", 0.5), ("specimen", 1.0))
    )
    evolution = {
        "cycle": cycles,
        "displacement_amplitude_um": np.full(n, 60.0),
        "slip_amplitude_um": 50.0 - 2.0 * growth,
        "max_tangential_force_N": np.full(n, 1.24),
        "dissipated_energy_mJ": np.full(n, 0.25),
        "accumulated_energy_J": 0.25e-3 * cycles,
        "max_pressure_MPa": 300.0 - 100.0 * growth,
        "mid_stroke_pressure_MPa": 290.0 - 100.0 * growth,
        "worn_volume_pad_mm3": 0.5e-6 * depth_um * growth * 400.0,
        "worn_volume_specimen_mm3": 1e-6 * depth_um * growth * 400.0,
        "normal_force_N": np.full(n, 2.0),
        "contact_half_width_um": 300.0 * growth,
        "jump_cycles": np.zeros(n),
        "max_depth_pad_um": 0.5 * depth_um * growth,
        "max_depth_specimen_um": depth_um * growth,
    }
    study = {"name": "a cylinder", "kind": "line-contact"}
    quality = {"force_balance": 1e-15}
    return RunResult(
        "a cylinder", variant, "quick", "complete", "", study, tuple(loop(cycle, 2000.0) for cycle in CYCLES),
        Evolution(evolution), scars, {"contact_mesh_um": 10.0}, quality, {}, {},
        contact_kind="line-contact", bodies=("specimen", "pad"), length_mm=1.0,
    )  # fmt: skip


def test_pressures_are_means_over_a_length_or_those_of_nodes_and_say_so() -> None:
    older = result()
    assert "at a node at mid-stroke" in line_page([older])
    means = {"max_mean_pressure_MPa": 0.9, "mid_stroke_mean_pressure_MPa": 0.8}
    largest = older.evolution["max_pressure_MPa"]
    evolution = {**older.evolution, **{name: share * largest for name, share in means.items()}}
    page = line_page(
        [replace(older, evolution=Evolution(evolution), settings={**older.settings, "pressure_length_um": 35.86})]
    )
    assert "mean over 35.9 µm at mid-stroke" in page
    assert "at a node" not in page
