"""Fretting maps of sweeps over load and stroke, of runs whose loops have a closed form."""

from pathlib import Path

import pytest

from wirewear.comparison.mapped_tests import MappedTest
from wirewear.comparison.maps import fresh_contact, transition
from wirewear.reference import cattaneo_mindlin as mindlin
from wirewear.sweeps import Sweep, load_sweep
from wirewear.sweeps.running import SweepResult
from wirewear.sweeps.sweep import FIRST, SweepRow, figures_named
from wirewear.views.fretting_map import draw_fretting_map, regime_of_run
from wirewear.views.sweep_page import page

STUDY = """
format = 1
name = "ball"
kind = "ball-on-flat"
[bodies.ball]
diameter_mm = 12.7
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[bodies.flat]
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 50.0
displacement_amplitude_um = 2.0
frequency_Hz = 10.0
cycles = 100
[contact]
friction = 0.6
[wear]
energy_wear_coefficient_mm3_per_J = 2.0e-5
"""
SWEEP = """
format = 1
name = "map"
study = "study.toml"
design = "grid"
[[vary]]
key = "conditions.normal_load_N"
values = [15.0, 60.0]
[[vary]]
key = "conditions.displacement_amplitude_um"
values = [0.5, 1.0, 3.0]
"""


def figures_at(sweep: Sweep, load_N: float, amplitude_um: float) -> dict[str, float | None]:
    """The closed form's loop, first and last alike."""
    fresh = fresh_contact(sweep.study.resolved())
    assert fresh is not None
    contact, _ = fresh.at(load_N)
    loop = {
        "dissipated_energy_mJ": mindlin.dissipated_energy(contact, 1e-3 * amplitude_um),
        "slip_amplitude_um": 1e3 * mindlin.slip_amplitude(contact, 1e-3 * amplitude_um),
        "max_tangential_force_N": mindlin.force_amplitude(contact, 1e-3 * amplitude_um),
    }
    return dict.fromkeys(figures_named(sweep.study.body_names)) | loop | {FIRST + k: one for k, one in loop.items()}


@pytest.fixture
def mapped(tmp_path: Path) -> SweepResult:
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "sweep.toml").write_text(SWEEP)
    sweep = load_sweep(tmp_path / "sweep.toml")
    points = sweep.design.points.tolist()
    return SweepResult(sweep, {n: SweepRow(n, figures_at(sweep, *at)) for n, at in enumerate(points, 1)})


def test_regimes_of_runs_lie_on_either_side_of_the_closed_form(mapped: SweepResult) -> None:
    contact = fresh_contact(mapped.sweep.study.resolved())
    assert contact is not None
    for number, (load, amplitude) in enumerate(mapped.sweep.design.points.tolist(), 1):
        (slides_from,) = transition(contact, [load]).test_um
        figures = mapped.rows[number].figures
        assert figures is not None
        assert regime_of_run(figures, amplitude) == ("gross slip" if amplitude > slides_from else "partial slip")


def test_a_run_that_begins_to_slide_is_mixed_and_one_without_slip_sticks(mapped: SweepResult) -> None:
    slow, wide = (figures_at(mapped.sweep, 60.0, amplitude) for amplitude in (1.0, 3.0))
    begins = wide | {name: value for name, value in slow.items() if name.startswith(FIRST)}
    assert regime_of_run(begins, 3.0) == "mixed"
    assert regime_of_run(wide | {"slip_amplitude_um": 0.0, "first_slip_amplitude_um": 0.0}, 3.0) == "stick"


def test_a_sweep_over_load_and_stroke_has_a_map_with_measured_tests(mapped: SweepResult) -> None:
    measured = MappedTest("a test", "measured", "", 40.0, 1.5, (), regime="mixed")
    labels = {text.get_text() for text in draw_fretting_map(mapped, [measured]).legends[0].get_texts()}
    assert labels == {"partial slip", "gross slip", "fresh contact, closed form", "measured: mixed"}
    assert "Fretting map" in page(mapped, [measured])
