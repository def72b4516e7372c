"""Effects and readers of installed packages do as the library's own; the worked examples of the docs among them."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solvers import RoughLayer, ThirdBody
from tests.diagnosis.diagnosis_cases import nominal
from tests.records.loop_files import HEAD, SAMPLES, FREQUENCY_Hz
from tests.studies import COARSE, coarse
from tests.synthetic_loops import Recipe, SyntheticLoop
from tests.worked_examples import install_example
from wirewear import ExperimentRecord, Sensor, SensorNoise, StudyError, record_of_result, run_study
from wirewear.base.course import Course
from wirewear.diagnosis.answer import Diagnosis
from wirewear.diagnosis.record_diagnosis import diagnose
from wirewear.diagnosis.surrogate.candidates import library, unsupported
from wirewear.effects import Age, Ageing, Chain, ContactLaw, Effect, Seam, all_effects, applied, effect_named
from wirewear.effects import registry as registry_module
from wirewear.records.importing import import_record
from wirewear.records.importing.guessed_scars import Touching
from wirewear.records.importing.guessing import guessed_mapping
from wirewear.records.importing.loggers import readers
from wirewear.reference import kept_approach
from wirewear.sweeps.signature import signature_study

LOGGED = (1, 10, 100, 300, 1000, 3000)
UNSUPPORTED = '''
from dataclasses import dataclass, replace

from solvers import RoughLayer
from wirewear.effects import Effect, Seam
from wirewear.records.importing.guessed_scars import Touching


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


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("effects")


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
    """Another package's effect, installed; the table of a study that has it."""
    installed("loosening_clamp = tests.effects.loosening_clamp:LooseningClamp")
    return '[[effects]]\nname = "loosening_clamp"\nfinal_stiffness_N_per_mm = 200.0\ncycles = 300.0\n'


@pytest.fixture
def by_energy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The effect of studies/plugin_example, installed; the docs' table of a study that has it."""
    (tmp_path / "plugin").mkdir()
    (table,) = install_example("An effect", tmp_path / "plugin", monkeypatch).tables
    registry_module._all_effects.cache_clear()
    yield table
    registry_module._all_effects.cache_clear()


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


def test_an_installed_package_adds_an_effect(by_energy: str) -> None:
    study = coarse(COARSE + by_energy)
    law = applied(study.effects, Seam.CONTACT, ContactLaw(0.6), Age(0.0, 1.0))
    assert law.friction == pytest.approx(0.6 - 0.2 * (1.0 - np.exp(-1.0)))
    neutral = effect_named("friction_by_energy").neutral(study.stated)
    assert neutral.changed(ContactLaw(0.62), Age(5.0, 3.0)) == ContactLaw(0.62)


@pytest.mark.parametrize(
    ("entry_point", "message"),
    [
        ("lost = no_such_module:Effect", "cannot be loaded from no_such_module:Effect"),
        ("list = builtins:list", "must be a subclass of wirewear.effects.Effect"),
        ("twice = wirewear.effects.contact:FrictionOffset", "there is one of that name already"),
        ("nameless = nameless:Nameless", "lacks name, seam, signature, confused_with"),
    ],
)
def test_a_broken_plugin_is_named_in_one_sentence(installed: Any, entry_point: str, message: str) -> None:
    nameless = "from wirewear.effects import Effect\n\nclass Nameless(Effect):\n    def changed(self, one, age): ...\n"
    installed(entry_point, nameless=nameless)
    with pytest.raises(StudyError, match=message):
        all_effects()


@pytest.mark.slow
def test_an_effect_of_a_package_is_named_on_a_record_of_a_full_simulation_with_it(clamp: str, tmp_path: Path) -> None:
    found = diagnosed(record_with(tmp_path / "run", *coarse(COARSE + clamp).effects))
    assert found.verdict == "explained"
    assert found.causes[0].effect == "loosening_clamp"
    assert found.causes[0].probability > 0.8
    stiffness = found.causes[0].parameters["final_stiffness_N_per_mm"]
    assert stiffness.value == pytest.approx(200.0, rel=0.03)
    assert stiffness.interval95[0] < 200.0 < stiffness.interval95[1]
    assert "loosening clamp" in found.sentence.lower()


def test_an_effect_that_the_fast_model_cannot_cover_is_no_candidate_and_is_named(installed: Any) -> None:
    installed("paint = paint:Paint", paint=UNSUPPORTED)
    assert unsupported(nominal()) == ("paint",)
    assert "paint" not in {candidate.name for candidate in library(nominal())}


@pytest.fixture
def mapping(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A mapping that chooses the docs' reader, installed as they say."""
    (tmp_path / "plugin").mkdir()
    (loops,) = install_example("A logger's files", tmp_path / "plugin", monkeypatch).tables
    path = tmp_path / "mapping.toml"
    path.write_text(HEAD + loops, encoding="utf-8")
    readers.cache_clear()
    yield path
    monkeypatch.undo()
    readers.cache_clear()


def test_a_package_reads_another_loggers_files(mapping: Path) -> None:
    time, displacement, force = SyntheticLoop(Recipe()).sampled(SAMPLES)
    rows = zip(time / FREQUENCY_Hz, displacement, force, strict=True)
    text = "\n".join(json.dumps(dict(zip("txQ", row, strict=True))) for row in rows)
    for number in (1, 100):
        (mapping.parent / f"cycle_{number}.jsonl").write_text(text, encoding="utf-8")
    loops = import_record(mapping).loops
    assert [(loop.cycle, loop.time_s.size) for loop in loops] == [(1, SAMPLES), (100, SAMPLES)]
    assert loops[1].tangential_force_N.tolist() == pytest.approx(force.tolist())


def test_files_that_a_package_knows_are_guessed_without_their_kind_stated(mapping: Path) -> None:
    time, displacement, force = SyntheticLoop(Recipe()).sampled(SAMPLES)
    rows = zip(time / FREQUENCY_Hz, displacement, force, strict=True)
    path = mapping.parent / "log.jsonl"
    path.write_text("\n".join(json.dumps(dict(zip("txQ", row, strict=True))) for row in rows), encoding="utf-8")
    known = {"normal_load_N": 2.0}
    source = guessed_mapping([path], known, Touching.of("crossed-wires", known, {}, {})).tables["loops"]
    assert source["kind"] == "json-lines"
    assert {key: own["column"] for key, own in source["columns"].items()} == {
        "time_s": "t",
        "displacement_um": "x",
        "tangential_force_N": "Q",
    }


CYCLES = np.array([1.0, 100.0, 3000.0, 1e5])
FRESH_mm = 1e-3 * (640.0 / np.pi) ** 0.5  #: Radius of the fresh contact of `chain`.
everyone = pytest.mark.parametrize("kind", all_effects().values(), ids=list(all_effects()))


def chain() -> Chain:
    """Four moments of a test in which nothing but wear changes."""
    nothing = np.zeros(4)
    names = (
        "misalignment_rad retained_fraction bed_MPa oxygen_W free_play_um mass_kg flattening_um print_um rough_um "
        "bed_um crossing_error_rad linear_um_per_N quadratic_um_per_N2 crosstalk force_zero_N lag_s force_lag_s"
    )
    still: dict[str, Any] = dict.fromkeys(names.split(), nothing)
    return Chain(
        radius_um=225.0, fresh_area_um2=640.0, cycles=CYCLES, energy_J=2.5e-4 * CYCLES, worn_um3=7.5 * CYCLES,
        amplitude_um=nothing + 20.0, load_N=nothing + 2.0, friction=nothing + 0.62, wear_um3_per_mJ=nothing + 30.0,
        starved_factor=nothing + 1.0, compliance_um_per_N=nothing + 6.0, gain=nothing + 1.0,
        **still,
    )  # fmt: skip


def effect(name: str, **values: float) -> Effect[Any]:
    return effect_named(name)(**values)


def changes(one: Effect[Any]) -> dict[str, Any]:
    """What is another one in the chain with the effect, by name."""
    before, after = vars(chain()), vars(one.predicted(chain()))
    same = {name for name, value in after.items() if np.allclose(value, before[name], rtol=1e-12, atol=1e-15)}
    return {name: value for name, value in after.items() if name not in same}


@everyone
def test_an_effect_at_its_neutral_values_leaves_the_chain_as_it_is(kind: type[Effect[Any]]) -> None:
    assert changes(kind.neutral(coarse().stated)) == {}


@everyone
def test_an_effect_follows_over_a_test_what_it_says_it_does(kind: type[Effect[Any]]) -> None:
    one = kind.sized("easy", coarse().stated)
    worn = replace(chain(), energy_J=chain().energy_J[::-1], worn_um3=chain().worn_um3[::-1])
    early, late = vars(one.predicted(chain())), vars(one.predicted(worn))
    columns = changes(one)
    assert all(np.ptp(early[name]) == 0.0 for name in columns) is (kind.ages is Ageing.NEVER)
    assert all(np.array_equal(early[name], late[name]) for name in columns) is (kind.ages is not Ageing.BY_WEAR)


@pytest.mark.parametrize(
    ("name", "values", "column", "expected"),
    [
        ("tangential_compliance", {"stiffness_N_per_mm": 250.0}, "compliance_um_per_N", 6.0 + 1e3 / 250.0),
        (
            "rotational_compliance",
            {"stiffness_N_mm_per_rad": 9e4, "arm_mm": 30.0},
            "compliance_um_per_N",
            6.0 + 1e3 * 30.0**2 / 9e4,
        ),
        ("free_play", {"gap_um": 3.0}, "free_play_um", 3.0),
        ("friction_offset", {"friction": 0.5}, "friction", 0.5),
        (
            "friction_evolution",
            {"initial": 0.4, "final": 0.7, "cycles": 3000.0},
            "friction",
            Course(0.4, 0.7, 3000.0).at(CYCLES),
        ),
        ("plasticity", {"flattening_um": 1.5}, "flattening_um", 1.5),
        ("plasticity", {"yield_stress_MPa": 450.0}, "print_um", 1e3 * kept_approach(2.0, FRESH_mm, 0.225, 450.0)),
        ("crossing_angle_error", {"angle_deg": 4.0}, "crossing_error_rad", np.radians(4.0)),
        ("misalignment", {"angle_deg": -2.0}, "misalignment_rad", -np.radians(2.0)),
        ("normal_load_drift", {"fraction_per_100k_cycles": 0.3}, "load_N", 2.0 * (1.0 + 3e-6 * CYCLES)),
        ("wear_rate_offset", {"factor": 1.4}, "wear_um3_per_mJ", 42.0),
        (
            "wear_rate_evolution",
            {"initial_factor": 3.0, "final_factor": 0.5, "cycles": 1e4},
            "wear_um3_per_mJ",
            30.0 * Course(3.0, 0.5, 1e4).at(CYCLES),
        ),
        ("displacement_gain", {"gain": 1.05}, "gain", 1.05),
        ("force_crosstalk", {"coefficient": 0.03}, "crosstalk", 0.03),
        ("sensor_lag", {"time_s": 0.003}, "lag_s", 0.003),
    ],
)
def test_an_effect_changes_one_column_as_its_closed_form_says(
    name: str, values: dict[str, float], column: str, expected: float | np.ndarray
) -> None:
    (found,) = changes(effect(name, **values)).items()
    assert found[0] == column
    assert found[1] == pytest.approx(np.broadcast_to(expected, 4), rel=1e-12)


def test_debris_softens_the_contact_the_more_the_larger_the_scar_and_a_layer_is_worn_in() -> None:
    found = changes(effect("third_body", retained_fraction=0.4, modulus_MPa=500.0))
    added = found["compliance_um_per_N"] - 6.0
    assert np.all(np.diff(added) > 0.0)
    assert added[-1] == pytest.approx(0.5 * 0.4 / (np.pi * 225.0 * 0.286e-6 * 500.0), rel=1e-3)
    assert found["retained_fraction"] == pytest.approx(np.full(4, 0.4))
    (layer,) = effect("roughness_compliance", layer_um=5.0, cycles=3e3).changed(ContactLaw(0.62), Age(3e3, 0.0)).layers
    assert layer.decay_mm == pytest.approx(5e-3 * np.exp(-1.0))


def test_debris_spreads_pressure_as_a_rough_layer_of_equal_closure_does() -> None:
    found = changes(effect("third_body", retained_fraction=0.4, modulus_MPa=500.0))
    own = chain()
    area_um2 = np.sqrt(own.worn_area2_um4)
    pressure_MPa = 1e6 * own.load_N / (area_um2 + own.fresh_area_um2)
    for worn_um, pressure, height_um in zip(own.worn_um3 / area_um2, pressure_MPa, found["bed_um"], strict=True):
        bed, _ = ThirdBody(0.4, 500.0).closure(np.array([pressure]), np.array([1e-3 * worn_um]))
        layer, _ = RoughLayer(1e-3 * height_um).closure(np.array([pressure]), np.zeros(1))
        assert layer == pytest.approx(bed)
    assert set(changes(effect("third_body", retained_fraction=0.4, modulus_MPa=500.0, spreading=0.0))) == {
        "retained_fraction",
        "bed_MPa",
        "compliance_um_per_N",
    }
