"""Materials by name: constants with sources, wherever a study asks for them."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.studies import MINIMAL
from wirewear import StudyError
from wirewear.study import parse_study, study_from_tables
from wirewear.study.materials import material_named, materials, names

ROOT = Path(__file__).resolve().parent.parent

NAMED = re.sub(r"youngs_modulus.*\npoissons_ratio.*\n", 'material = "Ti6Al4V"\n', MINIMAL)


def import_wirewear(first_on_path: Path, before: str = "") -> subprocess.CompletedProcess[str]:
    code = f"import sys; sys.path[:0] = [{str(first_on_path)!r}, {str(ROOT)!r}]\n{before}\nimport wirewear"
    return subprocess.run([sys.executable, "-c", code], cwd=first_on_path, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", ["geometry", "solvers"])
@pytest.mark.parametrize("form", ["{name}.py", "{name}/__init__.py"])
def test_a_shadowing_module_is_named_with_what_to_do(tmp_path: Path, name: str, form: str) -> None:
    stranger = tmp_path / form.format(name=name)
    stranger.parent.mkdir(exist_ok=True)
    stranger.write_text("", encoding="utf-8")
    run = import_wirewear(tmp_path)
    last_line = run.stderr.strip().splitlines()[-1]
    assert run.returncode != 0
    assert last_line.startswith(f"ImportError: wirewear needs its own package '{name}'")
    assert str(stranger) in last_line
    assert "rename or remove" in last_line


@pytest.mark.seconds
def test_everything_offered_is_there_and_nothing_is_loaded_before_it_is_asked_for() -> None:
    code = (
        "import sys, wirewear\n"
        "assert not {'numpy', 'h5py', 'wirewear.study'} & set(sys.modules)\n"
        "assert all(getattr(wirewear, name) is not None for name in wirewear.__all__)\n"
        "assert set(wirewear.__all__) <= set(dir(wirewear))\n"
        "assert not hasattr(wirewear, 'gremlins')\n"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")


def test_every_material_has_a_source_and_constants_of_a_solid() -> None:
    spelled = [name.casefold() for item in materials() for name in (item.name, *item.also)]
    assert len(spelled) == len(set(spelled))
    assert {"Ti-6Al-4V", "Inconel 600", "Inconel 690", "Zircaloy-4", "alumina", "En31", "En24"} <= set(names())
    for item in materials():
        assert len(item.source) > 10
        assert 5e4 < item.elastic.youngs_modulus_MPa < 5e5
        assert 0.2 < item.elastic.poissons_ratio < 0.4


def test_a_study_takes_a_material_by_any_of_its_names_and_reads_back_the_same() -> None:
    study, titanium = parse_study(NAMED, "study.toml"), material_named("Ti-6Al-4V").elastic
    assert [body.material for body in study.bodies] == [titanium, titanium]
    assert study.wires.material == "Ti-6Al-4V"
    assert study_from_tables(study.resolved(), "again").resolved() == study.resolved()


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (NAMED.replace("Ti6Al4V", "brass"), r"material in \[wires\] of study.toml is 'brass', which is in no table"),
        (NAMED.replace("Ti6Al4V", "Ti-6Al-4W"), r"did you mean 'Ti-6Al-4V'\?$"),
        (NAMED.replace("material", "poissons_ratio = 0.2\nmaterial"), r"poissons_ratio = 0.2 beside the material"),
        (MINIMAL + "[variants.a.wires]\nmaterial = 'alumina'\n", r"beside the material 'alumina', which has 416000"),
    ],
)
def test_an_unknown_material_and_one_beside_other_constants_are_refused(text: str, complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        parse_study(text, "study.toml")
