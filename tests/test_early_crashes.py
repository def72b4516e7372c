"""Crashes, lost runs and work without end of version 8318817."""

import ast
import shutil
import subprocess
import sys
from pathlib import Path
from random import Random

import h5py
import numpy as np
import pytest

from tests import early_faults
from tests.early_faults import (
    EXAM,
    GB,
    PROGRAM,
    ROOT,
    changed,
    command,
    held,
    limited,
    refused,
    refused_at_once,
    run,
)
from wirewear import ResultError, read_result

folder, ran, result = early_faults.folder, early_faults.ran, early_faults.result

SMALL_DISK = ("unshare", "-rm", "sh", "-c", 'mount -t tmpfs -o size=64k none "$1" && shift && "$@"', "sh")

SCARS = '[scars.moving]\nfiles = "more.csv"\ncolumns = { x_um = "x", y_um = "y", depth_um = "d", repeat = "n" }\n'

EVOLUTION = '[evolution]\nfiles = "more.csv"\ncolumns = { cycle = "cycle", repeat = "n" }\n'


@pytest.mark.parametrize("old", ["friction = 0.62", "normal_load_N = 2.0"])
def test_a_number_of_hundreds_of_digits_is_refused(folder: Path, old: str) -> None:
    changed(folder / "study.toml", old, f"{old.partition(' ')[0]} = {'9' * 309}")
    assert len(refused_at_once("run", folder / "study.toml", "--output", folder / "o")) < 400


@pytest.mark.parametrize("encoding", ["zlib", "hex", "rot13", "base64"])
def test_an_encoding_that_is_none_of_text_is_refused(folder: Path, encoding: str) -> None:
    changed(folder / "mapping.toml", '"utf-8"', f'"{encoding}"')
    assert "encoding" in refused_at_once("import", folder / "mapping.toml", "--output", folder / "r")


@pytest.mark.parametrize(
    ("table", "rows"),
    [
        (SCARS, "x,y,d,n\n0,0,1,nan\n"),
        (EVOLUTION, "cycle,n\n1,inf\n"),
        (EVOLUTION, "cycle,n\n1,1e300\n"),
        (EVOLUTION, f"cycle,n\n{'9' * 200},1\n"),
    ],
)
def test_a_repeat_or_cycle_that_is_no_number_is_refused(folder: Path, table: str, rows: str) -> None:
    changed(folder / "mapping.toml", "[loops]", f"{table}[loops]")
    (folder / "more.csv").write_text(rows)
    assert "whole number" in refused_at_once("import", folder / "mapping.toml", "--output", folder / "r")


@pytest.mark.slow
def test_sixty_thousand_points_at_random_are_refused(folder: Path) -> None:
    changed(folder / "mapping.toml", "[loops]", f"{SCARS}[loops]")
    random = Random(1)
    rows = (f"{random.random()},{random.random()},1,1" for _ in range(60_000))
    (folder / "more.csv").write_text("\n".join(("x,y,d,n", *rows, "")))
    ended = command(folder, "import", "mapping.toml", "--output", "r", before=limited(4 * GB))
    assert "which is no grid" in refused(ended)


@pytest.mark.slow
def test_a_pattern_that_would_need_for_ever_ends(folder: Path) -> None:
    name = f"cycle_{'1' * 60}.csv"
    (folder / "cycle_1.csv").rename(folder / name)
    pattern = r"name_pattern = '(cycle)_(?P<cycle>(\d+)+)x'"
    changed(folder / "mapping.toml", 'files = "cycle_1.csv"', f'files = "cycle_*.csv"\n{pattern}')
    changed(folder / "mapping.toml", 'cycle = "n"\n', "")
    assert "takes too long" in refused(command(folder, "import", "mapping.toml", "--output", "r"))


@pytest.mark.slow
def test_a_study_may_have_a_name_like_markup(folder: Path) -> None:
    changed(folder / "study.toml", "two coarse wires", "wires [/] [b]")
    ended = run(folder)
    assert ended.returncode == 0, ended.stderr


@pytest.mark.slow
def test_a_package_whose_effect_cannot_be_loaded_is_named(folder: Path) -> None:
    (folder / "gremlin.py").write_text("1 / 0\n")
    facts = folder / "gremlin-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: gremlin\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[wirewear.effects]\ngremlin = gremlin:Gremlin\n")
    assert "gremlin" in refused(command(folder, "effects"))


@pytest.mark.slow
def test_a_link_out_of_a_result_is_not_followed(result: Path, tmp_path: Path) -> None:
    moved = result.rename(tmp_path / "moved.h5")
    with h5py.File(moved) as source, h5py.File(result, "w") as file:
        file.attrs.update(source.attrs)
        for name in source:
            file[name] = h5py.ExternalLink(str(moved), f"/{name}")
    with pytest.raises(ResultError):
        read_result(result)


def test_a_mapping_quotes_no_file_of_the_system(folder: Path) -> None:
    changed(folder / "mapping.toml", '"cycle_1.csv"', '"/etc/passwd"')
    assert "root:" not in refused_at_once("import", folder / "mapping.toml", "--output", folder / "r")


@pytest.mark.slow
def test_the_same_numbers_come_out_in_another_folder_and_locale_and_with_two_threads(ran: Path, folder: Path) -> None:
    elsewhere = {"LC_ALL": "C", "PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo"}
    threads = {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"}
    for variables, to in ((elsewhere, 0.0), (threads, 1e-12)):
        ended = command(folder, "run", "study.toml", "--fidelity", "quick", "--output", str(to), variables=variables)
        assert ended.returncode == 0, ended.stderr
        one, other = (read_result(path / "result.h5").evolution for path in (ran / "o", folder / str(to)))
        for name in one:
            np.testing.assert_allclose(other[name], one[name], rtol=to, err_msg=name)


@pytest.mark.slow
def test_no_code_comes_from_data() -> None:
    found = []
    for package in ("geometry", "solvers", "wirewear"):
        # Machine code that the program itself compiled is kept as numba keeps it, in folders of the user's own.
        for file in {*(ROOT / package).rglob("*.py")} - {ROOT / "solvers" / "kept_code.py"}:
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                names = {alias.name for alias in node.names} if isinstance(node, ast.Import) else set()
                names |= {str(node.module)} if isinstance(node, ast.ImportFrom) else set()
                names |= {node.func.id} if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else set()
                names |= {str(node.arg)} if isinstance(node, ast.keyword) else set()
                found += [
                    f"{file}: {name}"
                    for name in names & {"pickle", "marshal", "shelve", "eval", "exec", "allow_pickle"}
                ]
    assert found == []


@pytest.mark.slow
def test_a_result_that_is_cut_off_says_how_much_is_left(ran: Path, folder: Path) -> None:
    shutil.copytree(ran / "o", folder / "o")
    result = folder / "o" / "result.h5"
    result.write_bytes(result.read_bytes()[:20_000])
    sentence = refused(command(folder, "show", "o"))
    assert "is cut off: 20\u2009000 of" in sentence
    assert "base_addr" not in sentence


def test_a_file_that_may_not_be_read_is_told_as_all_else(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("click.types.os.access", lambda *_: False)
    assert refused_at_once("check", folder).endswith(f"'{folder}' is not readable.\n")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is full")
@pytest.mark.slow
@pytest.mark.parametrize("arguments", [["effects"], ["effects", "--json"]])
def test_output_that_is_full_is_one_sentence(arguments: list[str]) -> None:
    command = [sys.executable, "-c", "from wirewear.faces import main; main()", *arguments]
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 2, ended.stderr
    assert ended.stderr.strip() == "wirewear: the output can be neither read nor written: no space left on device."


@pytest.mark.slow
@pytest.mark.parametrize(
    ("loading", "said"),
    [("wirewear.faces.group", "nothing was written"), ("wirewear.effects", "no file is left half written")],
)
def test_an_interruption_while_the_program_or_a_command_loads_is_one_sentence(loading: str, said: str) -> None:
    code = f"""
import sys

class Interrupting:
    def find_spec(self, name, *_):
        if name == "{loading}":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupting())
from wirewear.faces import main
main()
"""
    ended = subprocess.run([sys.executable, "-c", code, "effects"], capture_output=True, text=True, check=False)
    assert ended.returncode == 130
    assert ended.stderr == f"wirewear: interrupted; {said}.\n"


def test_a_link_out_of_a_record_is_not_followed(tmp_path: Path) -> None:
    record = shutil.copytree(ROOT / "studies" / "steel_wires" / "example_records" / "no_gap", tmp_path / "record")
    loops = (record / "loops.csv").rename(tmp_path / "elsewhere.csv")
    refused_at_once("check", record)
    (record / "loops.csv").symlink_to(loops)
    assert "leads out of the folder" in refused_at_once("check", record)


@pytest.mark.slow
def test_a_disk_that_is_full_at_a_checkpoint_is_one_sentence_and_no_crash(folder: Path) -> None:
    (folder / "o").mkdir()
    if (
        shutil.which("unshare") is None
        or subprocess.run([*SMALL_DISK, "o", "true"], cwd=folder, check=False).returncode
    ):
        pytest.skip("this user cannot mount a small disk")
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 30\n")
    arguments = (*PROGRAM, "run", "study.toml", "--fidelity", "quick", "--output", "o/o")
    ended = subprocess.run([*SMALL_DISK, "o", *arguments], cwd=folder, capture_output=True, text=True, check=False)
    sentence = refused(ended)
    assert "cannot write the checkpoint" in sentence
    assert "--resume goes on" in sentence


@pytest.mark.slow
def test_a_run_that_was_killed_before_its_first_result_can_be_resumed(folder: Path) -> None:
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 30\n")
    with held(folder, "checkpoint.h5"):
        pass
    (folder / "o" / "result.h5").unlink(missing_ok=True)
    ended = run(folder, "--resume")
    assert ended.returncode == 0, ended.stderr
    assert read_result(folder / "o" / "result.h5").status == "complete"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"contact_mesh_um = 28.0": "contact_mesh_um = 0.1"}, "give contact_mesh_um = "),
        (
            {
                "cycles = 3\n": "cycles = 1000000000\n",
                "[wear]\n": '[wear]\nupdate = "explicit"\nexplicit_jump_cycles = 0.01\n',
                "3.0e-5": "1e-10",
            },
            "cycle jumps",
        ),
    ],
)
def test_a_study_that_no_machine_holds_is_not_begun(folder: Path, changes: dict[str, str], words: str) -> None:
    for old, new in changes.items():
        changed(folder / "study.toml", old, new)
    assert words in refused(run(folder, before=limited(4 * GB)))


@pytest.mark.slow
def test_an_export_and_a_batch_that_no_machine_holds_are_not_begun(result: Path, tmp_path: Path) -> None:
    samples = ("--repeats", "1000", "--samples", "100000")
    export = command(tmp_path, "export", result.name, "--as-record", "r", *samples, before=limited(4 * GB))
    assert "samples, which take" in refused(export)
    cases = ("make", "b", "--cases", "1000000000", "--seed", "1")
    batch = command(tmp_path, *cases, before=limited(4 * GB), program=EXAM)
    assert "of disk" in refused(batch)
