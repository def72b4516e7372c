"""A strange module named geometry or solvers is reported at ``import wirewear``, with the file that is in the way."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


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


def test_a_stranger_imported_earlier_is_named(tmp_path: Path) -> None:
    (tmp_path / "geometry.py").write_text("", encoding="utf-8")
    run = import_wirewear(tmp_path, before="import geometry")
    assert "ImportError: wirewear needs its own package 'geometry'" in run.stderr


def test_without_a_stranger_the_import_is_silent(tmp_path: Path) -> None:
    run = import_wirewear(tmp_path)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


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
