"""What is installed: examples by their names, in a checkout and in a wheel, system libraries, and one version."""

import ast
import os
import re
import subprocess
import sys
import tomllib
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from shutil import copytree, ignore_patterns
from types import SimpleNamespace
from typing import Any

import pytest

from geometry import GeometryError
from geometry.body import SYSTEM_PACKAGES, gmsh_session
from tests.commands import wirewear
from tests.house.project import imported_modules
from wirewear import load_study, read_record
from wirewear.base.recognising import RECORDS, STUDIES, example
from wirewear.kinds import load_any_study

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", [*STUDIES, *RECORDS])
def test_every_example_is_read_by_its_name(name: str) -> None:
    place = example(name)
    assert place is not None
    assert (load_any_study(place) if name in STUDIES else read_record(place)).name


def test_a_name_that_is_none_of_theirs_has_no_example() -> None:
    assert example("no_such_test") is None


def test_a_command_takes_an_example_where_no_file_has_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "no_gap" in wirewear("check", "no_gap").output
    Path("no_gap").mkdir()
    assert "experiment.toml" in wirewear("check", "no_gap", code=2).output


@pytest.mark.slow
def test_the_built_package_is_the_only_one_to_import_and_holds_what_the_program_looks_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: dict[str, Any] = {}
    monkeypatch.setattr("setuptools.setup", lambda **given: asked.update(given["cmdclass"]))

    def modules_copied(command: Any) -> None:
        for package in ("geometry", "solvers", "wirewear"):
            copytree(ROOT / package, Path(command.build_lib) / package, ignore=ignore_patterns("__pycache__"))

    monkeypatch.setattr("setuptools.command.build_py.build_py.run", modules_copied)
    monkeypatch.chdir(ROOT)
    spec = spec_from_file_location("build_of_wirewear", ROOT / "setup.py")
    assert spec is not None
    assert spec.loader is not None
    spec.loader.exec_module(module_from_spec(spec))
    command = asked["build_py"].__new__(asked["build_py"])
    command.__dict__.update(build_lib=str(tmp_path), editable_mode=False)
    command.run()
    assert [place.name for place in tmp_path.iterdir()] == ["wirewear"]
    monkeypatch.setattr("wirewear.base.recognising._FOLDERS", (tmp_path / "wirewear" / "examples",))
    assert all(example(name) for name in (*STUDIES, *RECORDS))
    assert load_study(tmp_path / "wirewear/examples/steel_wires/study.toml").variant("compliant").name
    trees = [ast.parse(file.read_text(encoding="utf-8")) for file in tmp_path.rglob("*.py")]
    imported = {name.partition(".")[0] for tree in trees for _, name in imported_modules(ast.walk(tree))}
    assert not {"geometry", "solvers"} & imported
    (tmp_path / "geometry.py").write_text("raise ImportError('of somebody else')", encoding="utf-8")
    code = (
        "import sys, wirewear\n"
        "from wirewear.base.cache import ALL_CODE, CONDENSATION_CODE, RUN_CODE, code_hash\n"
        "assert wirewear.run_study and wirewear.FrictionLaw\n"
        "assert not {'geometry', 'solvers'} & set(sys.modules)\n"
        "assert wirewear.__file__.startswith(sys.path[0])\n"
        "assert len({code_hash(code) for code in (CONDENSATION_CODE, RUN_CODE, ALL_CODE)}) == 3\n"
    )
    place = {"PYTHONPATH": str(tmp_path)}
    run = subprocess.run(
        [sys.executable, "-P", "-c", code],
        cwd=tmp_path,
        env=os.environ | place,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")


def test_the_sentence_on_a_missing_library_names_packages_that_make_installs(monkeypatch: pytest.MonkeyPatch) -> None:
    script = (ROOT / "tools" / "prepare_machine.sh").read_text(encoding="utf-8")
    assert f'packages="{SYSTEM_PACKAGES}"' in script

    def unfound(name: str, *_: Any) -> None:
        if name == "gmsh":
            raise OSError("libGLU.so.1: cannot open shared object file: No such file or directory")

    monkeypatch.delitem(sys.modules, "gmsh", raising=False)
    monkeypatch.setattr(sys, "meta_path", [SimpleNamespace(find_spec=unfound), *sys.meta_path])
    with pytest.raises(GeometryError, match=r"libGLU\.so\.1.*apt-get install libgl1"), gmsh_session():
        pass


def test_one_version_stands_everywhere() -> None:
    own = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    expected_texts = {
        "CITATION.cff": f"\nversion: {own['version']}\n",
        "codemeta.json": f'"version": "{own["version"]}"',
        "tools/conda/meta.yaml": f'version: "{own["version"]}"',
    }
    assert [
        name for name, text in expected_texts.items() if text not in (ROOT / name).read_text(encoding="utf-8")
    ] == []


def test_the_recipe_asks_for_every_package_that_the_program_needs() -> None:
    own = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["dependencies"]
    recipe = (ROOT / "tools" / "conda" / "meta.yaml").read_text(encoding="utf-8")
    wanted = [re.sub(r"(>=.*)", r" \1", one).lower() for one in own]
    assert [
        one
        for one in wanted
        if one not in recipe.replace("python-gmsh", "gmsh").replace("matplotlib-base", "matplotlib")
    ] == []


#: Stands for the interpreter of a virtual environment whose pip has an index set, and goes on to write after that line.
_PIP_WITH_AN_INDEX = """#!/bin/sh
trap '' PIPE
case "$*" in
*config*) echo "global.index-url='https://packages.example'"; sleep 0.1; echo "global.timeout='60'" ;;
*) echo "$*" >> "$0.log" ;;
esac
"""


def test_where_an_index_is_set_pip_installs_without_a_word_of_a_broken_pipe(tmp_path: Path) -> None:
    python = tmp_path / "python"
    python.write_text(_PIP_WITH_AN_INDEX, encoding="utf-8")
    python.chmod(0o755)
    ran = subprocess.run(["sh", ROOT / "tools" / "install.sh", python, "."], capture_output=True, text=True, check=True)
    assert (ran.stdout, ran.stderr) == ("", "")
    assert "-m pip install" in (log := Path(f"{python}.log").read_text(encoding="utf-8"))
    assert "uv" not in log
