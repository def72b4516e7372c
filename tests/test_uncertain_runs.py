"""Runs whose inputs scatter: polynomials with their error, intervals and bands against closed forms."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tests.effect_studies import COARSE, WEARING, coarse
from tests.test_sweeps import InPlace
from wirewear.base.errors import StudyError
from wirewear.faces import cli
from wirewear.study import Study
from wirewear.sweeps import uncertainty
from wirewear.sweeps.sweep import FIGURES, SweepRow
from wirewear.sweeps.uncertainty import fitted, inputs_of, run_uncertain, sweep_of
from wirewear.sweeps.uncertainty_report import page, sentence

HOLDER = "[holder]\ntangential_stiffness_N_per_mm = 300.0\n"
SCATTER = "[scatter]\nfriction = 0.05\nnormal_load = 0.03\n"


def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def scattering(text: str = SCATTER) -> Study:
    return coarse(COARSE + WEARING + HOLDER + text)


def test_a_polynomial_of_the_second_degree_is_found_exactly() -> None:
    points = rng().standard_normal((30, 3))
    at = rng().standard_normal((5, 3))

    def curve(x: np.ndarray) -> np.ndarray:
        value: np.ndarray = 1.0 + 2.0 * x[:, 0] - x[:, 1] * x[:, 2] + 0.5 * x[:, 2] ** 2
        return value

    model = fitted(points, curve(points))
    assert model.error < 1e-12
    np.testing.assert_allclose(model.at(at), curve(at), atol=1e-12)


def test_its_error_is_what_it_misses_at_points_that_are_left_out() -> None:
    points = rng().standard_normal((30, 2))
    values = np.sin(2.0 * points[:, 0]) + points[:, 1]
    left_out = []
    for place in range(30):
        rest = np.arange(30) != place
        # The degree is that of the whole.
        terms = fitted(points, values).terms
        columns = np.prod(points[:, None, :] ** terms, axis=2)
        found = np.linalg.lstsq(columns[rest], values[rest], rcond=None)[0]
        left_out.append(values[place] - columns[place] @ found)
    assert fitted(points, values).error == pytest.approx(np.sqrt(np.mean(np.square(left_out))), rel=1e-8)


def test_noise_is_not_taken_for_curvature() -> None:
    points = rng().standard_normal((30, 4))
    values = points[:, 0] + 0.1 * np.random.default_rng(8).standard_normal(30)
    assert len(fitted(points, values).terms) == 5


def test_too_few_points_are_refused() -> None:
    with pytest.raises(ValueError, match="3 points are too few for 4 factors"):
        fitted(np.zeros((3, 4)), np.zeros(3))


def test_inputs_scatter_as_the_study_states_and_angles_stay_below_a_right_one() -> None:
    study = scattering("[scatter]\nfriction = 0.05\nwear = 0.2\ncrossing_angle_deg = 2.0\n")
    assert [(one.key, round(one.deviation, 9)) for one in inputs_of(study)] == [
        ("contact.friction", 0.031),
        ("wear.energy_wear_coefficient_mm3_per_J", 6e-6),
        ("wires.crossing_angle_deg", 2.0),
    ]
    sweep, deviations = sweep_of(study, "quick", runs=40)
    assert sweep.design.points[0].tolist() == [0.62, 3e-5, 90.0]
    assert np.all(sweep.design.points[:, 2] <= 90.0)
    np.testing.assert_allclose(90.0 - sweep.design.points[:, 2], 2.0 * np.abs(deviations[:, 2]), atol=1e-9)
    np.testing.assert_allclose(deviations[1:].std(axis=0), 1.0, atol=0.06)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "states no scatter: give standard deviations in [scatter]"),
        ("[scatter]\ntangential_stiffness = 0.1\n", "which is no number there"),
        ("[scatter]\nfriction = 0.9\n", "but must lie between 0 and 0.3"),
        ("[scatter]\nfricton = 0.1\n", "did you mean 'friction'"),
    ],
)
def test_what_scatters_nothing_or_nonsense_is_refused(text: str, says: str) -> None:
    with pytest.raises(StudyError) as refused:
        inputs_of(coarse(COARSE + WEARING + text))
    assert says in str(refused.value)


def test_intervals_are_those_of_the_closed_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """µP with 5 % and 3 %: its logarithm scatters by the root of both squares."""

    def sliding(study: Study, values: dict[str, float], fidelity: str, number: int, results: Path | None) -> SweepRow:
        force = values["contact.friction"] * values["conditions.normal_load_N"]
        figures = {name: force if name == "max_tangential_force_N" else None for name in FIGURES}
        return SweepRow(number, figures, "", 1.0, 1)

    monkeypatch.setattr("wirewear.sweeps.running.run_case", sliding)
    monkeypatch.setattr(uncertainty, "_bands", lambda *_: ())
    found = run_uncertain(scattering(), tmp_path, InPlace())
    (one,) = found.intervals
    size = 1.96 * float(np.hypot(0.05, 0.03)) * 1.24
    assert one.nominal == pytest.approx(1.24)
    assert (one.low, one.high) == pytest.approx((1.24 - size, 1.24 + size), abs=0.08 * size)
    assert one.error < 1e-9
    assert "contact.friction ± 0.031" in sentence(found)
    assert "tangential force" in page(found)


def test_the_band_of_loops_that_scatter_in_one_shape_is_that_shape() -> None:
    phase = 2.0 * np.pi * np.arange(uncertainty.PHASES) / uncertainty.PHASES
    at = np.vstack([np.zeros(2), rng().standard_normal((30, 2))])
    forces = np.sin(phase) + 0.1 * at[:, :1] * np.cos(phase)
    drawn = rng().standard_normal((4000, 2))
    band = uncertainty._band(10, 60.0 * np.sin(phase), forces, at, drawn, 1)
    np.testing.assert_allclose(band.high_N - band.low_N, 0.1 * 3.92 * np.abs(np.cos(phase)), atol=0.02)
    np.testing.assert_array_equal(band.nominal_N, np.sin(phase))


@pytest.mark.slow
def test_the_command_prints_and_writes_intervals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wirewear.base.cluster.engine_of", lambda *_: InPlace())
    monkeypatch.setattr(run_uncertain, "__kwdefaults__", {**(run_uncertain.__kwdefaults__ or {}), "runs": 6})
    path = tmp_path / "study.toml"
    path.write_text(COARSE + HOLDER + SCATTER)
    ended = CliRunner().invoke(cli, ["run", str(path), "--uncertain", "--output", str(tmp_path / "out")])
    assert ended.exit_code == 0, ended.output
    assert "max tangential force [N]" in ended.stdout
    written = (tmp_path / "out" / "uncertain" / "uncertain.html").read_text(encoding="utf-8")
    assert "95 % of tests" in written
    assert "<svg" in written
