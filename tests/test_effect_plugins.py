"""Effects of installed packages are simulated and diagnosed; the worked example of the docs among them."""

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from studies.effects.gallery import rows
from tests.diagnosis_cases import nominal
from tests.effect_studies import COARSE, WEARING, coarse, result_with
from tests.picture_pixels import shows
from tests.synthetic_results import result
from wirewear import ExperimentRecord, Sensor, SensorNoise, Study, StudyError, record_of_result, run_study
from wirewear.diagnosis.diagnose import diagnose
from wirewear.diagnosis.infer.sets import next_measurement
from wirewear.diagnosis.model.candidates import library, unforeseen
from wirewear.effects import Age, ContactLaw, Effect, Seam, all_effects, all_measurements, applied, effect_named
from wirewear.effects import registry as registry_module
from wirewear.faces import cli
from wirewear.loops import analyse_loop
from wirewear.pictures.colours import VARIANT_COLOURS
from wirewear.results import read_loops
from wirewear.sweeps.signature import Signature, draw_signature, signature_of, signature_study
from wirewear.views.diagnosis_values import Diagnosis, Estimate
from wirewear.views.diagnosis_wording import with_unit

SHORT = COARSE.replace("cycles = 1", "cycles = 2").replace("increments_per_cycle = 40", "increments_per_cycle = 24")

ROOT = Path(__file__).resolve().parent.parent
EXAMPLE = ROOT / "studies" / "effects" / "plugin_example"
LOGGED = (1, 10, 100, 300, 1000, 3000)
BY_ENERGY = {"final": 0.5, "energy_J": 0.1}

UNFORESEEN = '''
from dataclasses import dataclass, replace

from solvers import RoughLayer
from wirewear.effects import Effect, Seam


@dataclass(frozen=True)
class Paint(Effect):
    """A coat of paint."""

    name = "paint"
    seam = Seam.CONTACT
    signature = "a soft stick branch"
    confused_with = ()

    def changed(self, described, age):
        return replace(described, layers=(*described.layers, RoughLayer(1e-4)))
'''


WARMING = '''
from dataclasses import dataclass, replace

from wirewear.effects import Effect, Seam


@dataclass(frozen=True)
class Warming(Effect):
    """A displacement sensor whose gain creeps up by a per cent a cycle."""

    name = "warming"
    seam = Seam.SENSOR
    signature = "loops are stretched ever more"
    confused_with = ("displacement_gain",)

    def changed(self, described, age):
        return replace(described, displacement_gain=described.displacement_gain * (1.0 + 0.01 * age.cycles))
'''


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


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Make a package's modules, named by paths, importable, with its entry points."""

    def install(entry_points: str, **modules: str) -> None:
        for name, code in modules.items():
            path = tmp_path.joinpath(*name.split("__")).with_suffix(".py")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(code)
        metadata = tmp_path / "plugin-1.0.dist-info"
        metadata.mkdir()
        (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: plugin\nVersion: 1.0\n")
        (metadata / "entry_points.txt").write_text(f"[wirewear.effects]\n{entry_points}\n")
        monkeypatch.syspath_prepend(str(tmp_path))
        registry_module._all_effects.cache_clear()

    yield install
    registry_module._all_effects.cache_clear()


@pytest.fixture
def clamp(installed: Any) -> str:
    """The docs' effect, installed as they say; the table of a study that has it."""
    section = next(
        part for part in (ROOT / "docs" / "extending.md").read_text().split("\n## ") if part.startswith("An effect\n")
    )
    (code,) = re.findall(r"```python\n(.*?)```", section, re.DOTALL)
    registration, table = re.findall(r"```toml\n(.*?)```", section, re.DOTALL)
    header, point = registration.strip().split("\n")
    assert header == '[project.entry-points."wirewear.effects"]'
    installed(point.replace('"', ""), my_effects__loosening_clamp=code)
    return str(table)


@pytest.fixture
def by_energy(installed: Any) -> None:
    """The package of studies/effects/plugin_example, installed."""
    point = re.findall(r"^friction_by_energy = .*$", (EXAMPLE / "pyproject.toml").read_text(), re.MULTILINE)[0]
    code = (EXAMPLE / "friction_by_energy.py").read_text()
    installed(point.replace('"', ""), friction_by_energy=code)


def record_with(folder: Path, *effects: Effect[Any]) -> ExperimentRecord:
    """What noisy sensors read of a full simulation, in another formulation and finer than the one that is diagnosed."""
    study = signature_study().changed(
        {
            "conditions": {"cycles": LOGGED[-1]},
            "contact": {"formulation": "penalty"},
            "log": {"loop_cycles": LOGGED},
            "fidelity": {"quick": {"increments_per_cycle": 64}},
        }
    )
    (result,) = run_study(study.with_effects(*effects), fidelity="quick", output=folder)
    return record_of_result(result, sensor=Sensor(noise=SensorNoise(0.1, 0.006, 0.006)), repeats=3, samples=400)


def diagnosed(record: ExperimentRecord) -> Diagnosis:
    return diagnose(record).diagnosis


@pytest.mark.usefixtures("by_energy")
def test_an_installed_package_adds_an_effect() -> None:
    study = coarse(COARSE + '[[effects]]\nname = "friction_by_energy"\nfinal = 0.4\nenergy_J = 1.0\n')
    law = applied(study.effects, Seam.CONTACT, ContactLaw(0.6), Age(0.0, 1.0))
    assert law.friction == pytest.approx(0.6 - 0.2 * (1.0 - np.exp(-1.0)))
    neutral = effect_named("friction_by_energy").neutral(study.stated)
    assert neutral.changed(ContactLaw(0.62), Age(5.0, 3.0)) == ContactLaw(0.62)


@pytest.mark.parametrize(
    ("entry_point", "message"),
    [
        ("lost = no_such_module:Effect", "cannot be loaded from no_such_module:Effect"),
        ("list = builtins:list", "must be a subclass of wirewear.effects.Effect"),
        ("twice = wirewear.effects.friction_offset:FrictionOffset", "there is one of that name already"),
        ("nameless = nameless:Nameless", "lacks name, seam, signature, confused_with"),
    ],
)
def test_a_broken_plugin_is_named_in_one_sentence(installed: Any, entry_point: str, message: str) -> None:
    nameless = "from wirewear.effects import Effect\n\nclass Nameless(Effect):\n    def changed(self, one, age): ...\n"
    installed(entry_point, nameless=nameless)
    with pytest.raises(StudyError, match=message):
        all_effects()


def test_a_measurement_that_a_package_brings_is_one_to_be_asked_for(installed: Any) -> None:
    code = UNFORESEEN.replace(
        "    confused_with = ()\n", '    confused_with = ("paint",)\n    answers = (SCRATCH.shows("paint"),)\n'
    )
    code = code.replace(
        "\n\n@dataclass", '\n\nSCRATCH = Measurement("a scratch", "paint shows", 0.1, "steel")\n\n\n@dataclass'
    )
    installed("paint = paint:Paint", paint=code.replace("Effect, Seam", "Effect, Measurement, Seam"))
    (scratch,) = (one for one in all_measurements() if one.what == "a scratch")
    assert next_measurement({"paint": 0.5, "none": 0.5}, (), frozenset()) == (scratch, ("none", "paint"))


@pytest.mark.slow
def test_the_docs_effect_stands_in_a_study_and_softens_its_stick_branch(clamp: str) -> None:
    (effect,) = coarse(COARSE + clamp).effects
    late = type(effect)(final_stiffness_N_per_mm=200.0, cycles=1.0)  # type: ignore[call-arg]
    loops = [result_with(*effects).loops[0] for effects in ((), (late,))]
    rigid, loose = (analyse_loop(x.displacement_um, x.tangential_force_N).dissipated_energy_mJ for x in loops)
    # The loop of cycle 1, when 1 - 1/e of the compliance has come, loses 4 (µP)² C of its energy.
    assert rigid is not None
    assert loose is not None
    assert rigid.value - loose.value == pytest.approx(4.0 * 1.24**2 * (1.0 - np.exp(-1.0)) / 200.0, rel=0.02)


def test_the_docs_effect_is_described_and_a_candidate(clamp: str) -> None:
    assert clamp
    shown = CliRunner().invoke(cli, ["effects", "loosening_clamp"])
    assert shown.exit_code == 0
    assert "loops every half decade from the first cycle on (the stick branch is as modelled at first" in shown.stdout
    assert "loosening_clamp" in {candidate.name for candidate in library(nominal())}


@pytest.mark.slow
def test_the_docs_effect_is_named_on_a_record_of_a_full_simulation_with_it(clamp: str, tmp_path: Path) -> None:
    effects = coarse(COARSE + clamp).effects
    found = diagnosed(record_with(tmp_path / "run", *effects))
    assert found.verdict == "explained"
    assert found.causes[0].effect == "loosening_clamp"
    assert found.causes[0].probability > 0.8
    stiffness = found.causes[0].parameters["final_stiffness_N_per_mm"]
    assert stiffness.value == pytest.approx(200.0, rel=0.03)
    assert stiffness.interval95[0] < 200.0 < stiffness.interval95[1]
    assert "loosening clamp" in found.sentence


@pytest.mark.slow
@pytest.mark.usefixtures("by_energy")
def test_an_installed_effect_is_named_with_what_one_test_cannot_tell_from_it(tmp_path: Path) -> None:
    found = diagnosed(record_with(tmp_path / "run", effect_named("friction_by_energy")(**BY_ENERGY)))
    assert found.verdict == "explained"
    assert found.causes[0].effect == "friction_by_energy"
    assert found.causes[0].parameters["final"].value == pytest.approx(0.5, abs=0.01)
    assert found.causes[0].parameters["energy_J"].value == pytest.approx(0.1, rel=0.1)
    # Under one stroke and load, energy goes with the cycles; a measurement that the package knows splits them.
    assert found.equivalent == (("friction_by_energy", "friction_evolution"),)
    assert found.next_measurement is not None
    assert found.next_measurement["what"] == "the same test at half the stroke"
    assert found.next_measurement["splits"] == ["friction_by_energy", "friction_evolution"]


def test_a_sensor_that_ages_reads_each_loop_at_its_age(installed: Any) -> None:
    installed("warming = warming:Warming", warming=WARMING)
    (warming,) = (kind() for name, kind in all_effects().items() if name == "warming")
    text = COARSE.replace("cycles = 1\n", "cycles = 2\n")
    true, read = result_with(text=text), result_with(warming, text=text)
    pairs = zip(true.loops, read_loops(read), strict=True)
    gains = [np.ptp(misread.displacement_um) / np.ptp(loop.displacement_um) for loop, misread in pairs]
    assert gains == pytest.approx([1.01, 1.02])
    exported = record_of_result(read).loops
    assert [np.ptp(loop.displacement_um) / 40.0 for loop in exported] == pytest.approx([1.01, 1.02], rel=1e-3)


def test_parameters_of_packages_are_written_with_their_units() -> None:
    assert with_unit("energy_J", Estimate(0.1, (0.09, 0.11))) == "energy 0.1 J (0.09 to 0.11)"
    assert with_unit("wear_mm3_per_J", Estimate(3e-5, (2e-5, 4e-5))) == "wear 3·10⁻⁵ mm³/J (2·10⁻⁵ to 4·10⁻⁵)"


def test_an_effect_that_the_fast_model_cannot_foresee_is_no_candidate_and_is_named(installed: Any) -> None:
    installed("paint = paint:Paint", paint=UNFORESEEN)
    assert unforeseen(nominal()) == ("paint",)
    assert "paint" not in {candidate.name for candidate in library(nominal())}
