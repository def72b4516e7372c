"""Materials by name: constants with sources, wherever a study asks for them."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.studies import MINIMAL
from wirewear import StudyError
from wirewear.faces import cli
from wirewear.study import parse_study, study_from_tables
from wirewear.study.materials import material_named, materials

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
    for item in materials():
        assert [material_named(name) for name in (item.name, *item.also)] == [item] * (1 + len(item.also))
        assert len(item.source) > 10
        assert 3e3 < item.elastic.youngs_modulus_MPa < 7e5
        assert 0.2 < item.elastic.poissons_ratio <= 0.4


@pytest.mark.parametrize(
    "names",
    [
        ("AISI 52100", "52100", "100Cr6", "suj2", "EN 31"),
        ("316L", "AISI 316L", "1.4404"),
        ("304", "AISI-304"),
        ("42CrMo4", "4140", "SCM 440"),
        ("35NCD16", "34NiCrMo16"),
        ("Inconel 600", "inconel-600", "Alloy 600"),
        ("Inconel 690",),
        ("Inconel718", "Alloy 718"),
        ("Zircaloy-4", "Zry-4", "zircaloy 4"),
        ("Ti-6Al-4V", "Ti6Al4V", "TA6V", "TiAl6V4"),
        ("Al 7075", "7075"),
        ("alumina", "Al2O3"),
        ("silicon nitride", "Si3N4"),
        ("WC-6Co", "WC", "tungsten carbide"),
        ("CuBe2", "CuBe", "C17200"),
        ("PEEK", "peek"),
    ],
)
def test_what_laboratories_rub_is_found_by_every_name_that_it_goes_by(names: tuple[str, ...]) -> None:
    assert len({material_named(name) for name in names}) == 1


def test_the_list_of_materials_says_of_which_the_source_was_not_read() -> None:
    listed = CliRunner().invoke(cli, ["materials"]).output
    assert listed.count("unverified:") == sum(not item.verified for item in materials()) > 0


def test_a_study_takes_a_material_by_any_of_its_names_and_reads_back_the_same() -> None:
    study, titanium = parse_study(NAMED, "study.toml"), material_named("Ti-6Al-4V").elastic
    assert [body.material for body in study.bodies] == [titanium, titanium]
    assert study.wires.material == "Ti-6Al-4V"
    assert study_from_tables(study.resolved(), "again").resolved() == study.resolved()


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (NAMED.replace("Ti6Al4V", "brass"), r"material in \[wires\] of study.toml is 'brass', which is in no table"),
        (NAMED.replace("Ti6Al4V", "Ti-6Al-4W"), r"did you mean 'Ti-6Al-4V'.*\?$"),
        (NAMED.replace("Ti6Al4V", "Inconel 609"), r"did you mean 'Inconel 690' or 'Inconel 600' or 'Inconel 718'\?$"),
        (NAMED.replace("material", "poissons_ratio = 0.2\nmaterial"), r"poissons_ratio = 0.2 beside the material"),
        (MINIMAL + "[variants.a.wires]\nmaterial = 'alumina'\n", r"beside the material 'alumina', which has 416000"),
    ],
)
def test_an_unknown_material_and_one_beside_other_constants_are_refused(text: str, complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        parse_study(text, "study.toml")
