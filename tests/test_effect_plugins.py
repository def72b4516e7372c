"""Effects and readers of installed packages do as the library's own; the worked examples of the docs among them."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.diagnosis_cases import nominal
from tests.studies import COARSE, coarse
from tests.synthetic_loops import Recipe, SyntheticLoop
from tests.test_import import HEAD, SAMPLES, FREQUENCY_Hz
from tests.worked_examples import install_example
from wirewear import ExperimentRecord, Sensor, SensorNoise, StudyError, record_of_result, run_study
from wirewear.diagnosis.diagnose import diagnose
from wirewear.diagnosis.model.candidates import library, unforeseen
from wirewear.effects import Age, ContactLaw, Effect, Seam, all_effects, applied, effect_named
from wirewear.effects import registry as registry_module
from wirewear.records.importing import import_record
from wirewear.records.importing.guessing import crossed_wires, guessed_mapping
from wirewear.records.importing.registry import readers
from wirewear.sweeps.signature import signature_study
from wirewear.views.diagnosis_values import Diagnosis

ROOT = Path(__file__).resolve().parent.parent
EXAMPLE = ROOT / "studies" / "effects" / "plugin_example"
LOGGED = (1, 10, 100, 300, 1000, 3000)

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


def test_an_effect_that_the_fast_model_cannot_foresee_is_no_candidate_and_is_named(installed: Any) -> None:
    installed("paint = paint:Paint", paint=UNFORESEEN)
    assert unforeseen(nominal()) == ("paint",)
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


def test_files_that_a_package_knows_are_guessed_without_being_told_their_kind(mapping: Path) -> None:
    time, displacement, force = SyntheticLoop(Recipe()).sampled(SAMPLES)
    rows = zip(time / FREQUENCY_Hz, displacement, force, strict=True)
    path = mapping.parent / "log.jsonl"
    path.write_text("\n".join(json.dumps(dict(zip("txQ", row, strict=True))) for row in rows), encoding="utf-8")
    known = {"normal_load_N": 2.0}
    source = guessed_mapping([path], known, crossed_wires(known, {})).tables["loops"]
    assert source["kind"] == "json-lines"
    assert {key: own["column"] for key, own in source["columns"].items()} == {
        "time_s": "t",
        "displacement_um": "x",
        "tangential_force_N": "Q",
    }
