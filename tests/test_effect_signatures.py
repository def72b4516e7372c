"""Signatures of effects: pairs of runs, what they tell, and their pictures."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from studies.effects.gallery import rows
from tests.effect_studies import COARSE, WEARING, coarse
from tests.picture_pixels import shows
from tests.synthetic_results import result
from wirewear import Study
from wirewear.effects import effect_named
from wirewear.faces import cli
from wirewear.pictures.colours import VARIANT_COLOURS
from wirewear.sweeps.signature import Signature, signature_of, signature_study
from wirewear.sweeps.signature_picture import draw_signature

SHORT = COARSE.replace("cycles = 1", "cycles = 2").replace("increments_per_cycle = 40", "increments_per_cycle = 24")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("effects")


def short() -> Study:
    return coarse(SHORT + WEARING)


@pytest.mark.slow
def test_a_signature_sets_a_run_with_the_effect_beside_a_nominal_one_and_is_drawn(folder: Path) -> None:
    signature = signature_of(effect_named("tangential_compliance").sized("easy", short().stated), folder, study=short())
    assert signature.cycles == (1, 2)
    assert signature.changed.study["effects"] == [{"name": "tangential_compliance", "stiffness_N_per_mm": 150.0}]
    assert max(signature.changes()["dissipated_energy_mJ"]) < -0.05
    assert shows(draw_signature(signature, folder / "compliance.png"), *VARIANT_COLOURS[:3])
    table = rows(signature)
    assert table["effect"].to_list() == ["tangential_compliance", "tangential_compliance"]
    np.testing.assert_allclose(table["dissipated_energy_change"], signature.changes()["dissipated_energy_mJ"])


@pytest.mark.slow
def test_finished_runs_are_used_again_and_sensors_need_no_run(folder: Path) -> None:
    first = signature_of(effect_named("tangential_compliance").sized("easy", short().stated), folder, study=short())
    before = {path: path.read_bytes() for path in folder.glob("*/result.h5")}
    stretched = signature_of(effect_named("displacement_gain").sized("easy", short().stated), folder, study=short())
    assert {path: path.read_bytes() for path in folder.glob("*/result.h5")} == before
    np.testing.assert_allclose(stretched.changes()["dissipated_energy_mJ"], 0.05, rtol=1e-6)
    assert first.nominal.path == stretched.nominal.path


@pytest.mark.slow
def test_runs_of_another_study_in_the_folder_are_replaced(folder: Path) -> None:
    signature_of(effect_named("displacement_gain").sized("easy", short().stated), folder, study=short())
    other = coarse((SHORT + WEARING).replace("friction = 0.62", "friction = 0.5"))
    signature = signature_of(effect_named("displacement_gain").sized("easy", other.stated), folder, study=other)
    assert signature.nominal.study["contact"]["friction"] == 0.5


def test_loops_of_different_increments_are_compared_at_equal_phases() -> None:
    nominal, changed = result("", 167.0, samples=200), result("", 167.0, samples=333)
    frequency = {"conditions": {"frequency_Hz": 3.0}}
    signature = Signature(
        effect_named("displacement_gain").neutral(signature_study().stated),
        dataclasses.replace(nominal, study=frequency),
        dataclasses.replace(changed, study=frequency),
    )
    phase, first, second = signature.on_one_phase(-1)
    assert phase.size > 400
    # The same loop, sampled otherwise.
    np.testing.assert_allclose(first[0], second[0], atol=0.05)
    assert np.abs(first[1] - second[1]).mean() < 0.01
    assert np.ptp(first[1]) > 2.0


def test_the_default_study_is_the_steel_wire_test() -> None:
    study = signature_study()
    assert study.conditions.cycles == 100_000
    assert study.holder.tangential_stiffness_N_per_mm == 167.0
    assert study.effects == ()


@pytest.mark.slow
def test_the_command_draws_a_signature_and_says_where_it_is(tmp_path: Path, folder: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(SHORT + WEARING)
    arguments = ["effects", "sensor_lag", "--plot", "--study", str(study), "--output", str(tmp_path / "out")]
    drawn = CliRunner().invoke(cli, arguments)
    assert drawn.exit_code == 0
    assert drawn.stdout.strip() == str(tmp_path / "out" / "sensor_lag.png")
    assert (tmp_path / "out" / "sensor_lag.png").exists()


def test_a_plot_needs_a_name_and_a_study_without_variants(tmp_path: Path) -> None:
    nameless = CliRunner().invoke(cli, ["effects", "--plot"])
    assert nameless.exit_code == 2
    assert "--plot needs the name of an effect" in nameless.stderr
    study = tmp_path / "study.toml"
    study.write_text(COARSE + "[variants.one.holder]\n")
    varied = CliRunner().invoke(cli, ["effects", "free_play", "--plot", "--study", str(study)])
    assert varied.exit_code == 2
    assert "has variants" in varied.stderr
