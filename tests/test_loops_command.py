"""`wirewear loops`: any source, columns by name and unit, JSON of fixed keys."""

import json
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from tests import synthetic_results
from tests.synthetic_loops import Recipe, SyntheticLoop, partial_slip_loop
from wirewear.base.errors import RecordError
from wirewear.faces import cli
from wirewear.results import write_result
from wirewear.views.loops_sources import read_loops

KEYS = (
    "displacement_amplitude_um",
    "slip_amplitude_um",
    "measured_stiffness_N_per_um",
    "friction_max",
    "friction_energy",
    "friction_geometry_independent",
    "dissipated_energy_mJ",
    "regime",
)
LOOP = SyntheticLoop(Recipe(end_slope_rad=0.1, hook_power=3.0))
TIME, DISPLACEMENT_um, FORCE_N = LOOP.sampled(200, 0.3)


def wirewear(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


def csv(path: Path, **columns: np.ndarray) -> Path:
    np.savetxt(path, np.stack(list(columns.values()), axis=1), delimiter=",", header=",".join(columns), comments="")
    return path


def loops_of(*arguments: str | Path) -> list[dict[str, Any]]:
    result = wirewear("loops", *arguments, "--json")
    assert result.exit_code == 0, result.output
    loops: list[dict[str, Any]] = json.loads(result.stdout)["loops"]
    return loops


def test_json_has_the_fixed_keys_with_value_and_interval(tmp_path: Path) -> None:
    path = csv(tmp_path / "a.csv", displacement_um=DISPLACEMENT_um, tangential_force_N=FORCE_N)
    (loop,) = loops_of(path, "--normal-load", "2")
    assert all(set(loop[key]) == {"value", "interval95"} for key in KEYS)
    assert loop["regime"]["value"] == "gross slip"
    assert loop["slip_amplitude_um"]["value"] == pytest.approx(LOOP.slip_amplitude_um, rel=0.005)
    assert loop["friction_geometry_independent"]["value"] == pytest.approx(0.62, rel=0.005)


def test_columns_chosen_by_name_and_unit_give_the_same_figures(tmp_path: Path) -> None:
    plain = csv(
        tmp_path / "a.csv", displacement_um=DISPLACEMENT_um, tangential_force_N=FORCE_N, normal_force_N=0 * TIME + 2
    )
    other = csv(tmp_path / "b.csv", probe=1e-3 * DISPLACEMENT_um, cell=1e3 * FORCE_N, load=0 * TIME + 0.002)
    chosen = loops_of(other, "--displacement", "probe:mm", "--force", "cell:mN", "--normal-load", "load:kN")
    for key in KEYS[:-1]:
        assert chosen[0][key]["value"] == pytest.approx(loops_of(plain)[0][key]["value"], rel=1e-6)


@given(st.sampled_from(["_", " [", " ("]), st.sampled_from([("um", 1.0), ("mm", 1e-3), ("nm", 1e3)]))
def test_usual_names_are_recognised_however_the_unit_is_written(
    tmp_path_factory: pytest.TempPathFactory, mark: str, unit: tuple[str, float]
) -> None:
    end = {"_": "", " [": "]", " (": ")"}[mark]
    names = {f"Displacement{mark}{unit[0]}{end}": unit[1] * DISPLACEMENT_um, f"Tangential force{mark}N{end}": FORCE_N}
    (loop,) = read_loops(csv(tmp_path_factory.mktemp("names") / "a.csv", **names))
    np.testing.assert_allclose(loop.displacement_um, DISPLACEMENT_um, rtol=1e-9)
    np.testing.assert_allclose(loop.tangential_force_N, FORCE_N, rtol=1e-9)


@pytest.mark.parametrize("start", [0.0, 0.13, 0.25, 0.6, 0.75])
@pytest.mark.parametrize("named", [True, False])
def test_several_cycles_without_a_column_of_cycles_are_split_at_reversals(
    tmp_path: Path, start: float, named: bool
) -> None:
    time = np.arange(800) / 200
    _, displacement, force = LOOP.sampled(200, start, time)
    columns = {"displacement_um": displacement, "tangential_force_N": force}
    found = loops_of(csv(tmp_path / "a.csv", **columns, **({"time_s": time} if named else {})), "--normal-load", "2")
    assert [loop["cycle"] for loop in found] == [1, 2, 3, 4]
    assert any("split at the reversals" in note for note in found[0]["notes"])
    for loop in found:
        assert loop["dissipated_energy_mJ"]["value"] == pytest.approx(LOOP.energy_mJ, rel=0.005)
        assert loop["slip_amplitude_um"]["value"] == pytest.approx(LOOP.slip_amplitude_um, rel=0.005)


def test_a_protocol_of_growing_amplitude_is_split_into_cycles_of_their_own_amplitude(tmp_path: Path) -> None:
    amplitudes = [15.0, 20.0, 30.0, 50.0, 80.0]
    force, displacement = [], []
    held, last = 0.0, 0.0
    for amplitude in amplitudes:
        for x in amplitude * np.sin(2.0 * np.pi * np.arange(256) / 256):
            held, last = float(np.clip(held + 0.2 * (x - last), -1.2, 1.2)), x
            displacement.append(x)
            force.append(held)
    found = loops_of(
        csv(tmp_path / "a.csv", displacement_um=np.array(displacement), tangential_force_N=np.array(force))
    )
    assert [loop["displacement_amplitude_um"]["value"] for loop in found] == pytest.approx(amplitudes, rel=0.01)
    energies = [4e-3 * 1.2 * (amplitude - 6.0) for amplitude in amplitudes]
    # The first cycle begins in the middle of the virgin curve.
    assert [loop["dissipated_energy_mJ"]["value"] for loop in found][1:] == pytest.approx(energies[1:], rel=0.06)


def test_columns_are_chosen_by_number(tmp_path: Path) -> None:
    path = csv(tmp_path / "a.csv", cell=FORCE_N, probe=1e-4 * DISPLACEMENT_um)
    (loop,) = loops_of(path, "--displacement", "2:cm", "--force", "1:N", "--normal-load", "2")
    assert loop["slip_amplitude_um"]["value"] == pytest.approx(LOOP.slip_amplitude_um, rel=0.005)


def test_repeats_and_cycles_are_split_and_chosen(tmp_path: Path) -> None:
    columns = {"displacement_um": np.tile(DISPLACEMENT_um, 3), "tangential_force_N": np.tile(FORCE_N, 3)}
    path = csv(tmp_path / "a.csv", repeat=np.repeat([1, 1, 2], 200), cycle=np.repeat([5, 9, 5], 200), **columns)
    assert [(loop["repeat"], loop["cycle"]) for loop in loops_of(path)] == [(1, 5), (1, 9), (2, 5)]
    assert [loop["repeat"] for loop in loops_of(path, "--cycle", "5")] == [1, 2]
    assert "there are: 5, 9" in wirewear("loops", path, "--cycle", "7").stderr


def test_partial_slip_leaves_out_sliding_with_a_note(tmp_path: Path) -> None:
    time, displacement, force = partial_slip_loop(0.6, 200)
    path = csv(tmp_path / "a.csv", time_s=time, displacement_um=displacement, tangential_force_N=force)
    (loop,) = loops_of(path, "--normal-load", "2")
    assert loop["regime"]["value"] == "partial slip"
    assert loop["friction_geometry_independent"] is None
    assert any("partial slip" in note for note in loop["notes"])


def test_a_result_gives_its_loops_a_table_and_a_picture(tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    write_result(path, synthetic_results.result("compliant", 167.0))
    result = wirewear("loops", path, "--output", tmp_path / "loops.png")
    assert result.exit_code == 0, result.output
    assert "gross" in result.stdout
    assert (tmp_path / "loops.png").read_bytes().startswith(b"\x89PNG")


def test_a_result_whose_bytes_read_like_rows_is_a_result_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wirewear.views.loops_sources.guessed_layout", lambda _: Mock(plain=False))
    path = tmp_path / "result.h5"
    write_result(path, synthetic_results.result("compliant", 167.0))
    result = wirewear("loops", path)
    assert result.exit_code == 0, result.output
    assert "gross" in result.stdout


def test_loops_that_are_none_are_refused_one_by_one(tmp_path: Path) -> None:
    force = np.concatenate([FORCE_N, np.ones(200)])
    columns = {"displacement_um": np.tile(DISPLACEMENT_um, 2), "tangential_force_N": force}
    path = csv(tmp_path / "a.csv", cycle=np.repeat([1, 2], 200), **columns)
    first, second = loops_of(path)
    assert "refused" not in first
    assert "never changes" in second["refused"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--displacement", "nothing:mm"], "there is no column 'nothing'"),
        (["--displacement", "probe"], "has no unit in its name"),
        (["--displacement", "probe:furlong"], "cannot be in 'furlong'"),
        ([], "none of the columns 'probe, tangential_force_N' is known as the displacement"),
        (["--normal-load", "-2"], "must be a positive number"),
    ],
)
def test_a_wrong_choice_is_one_sentence_and_exit_code_2(tmp_path: Path, arguments: list[str], message: str) -> None:
    path = csv(tmp_path / "a.csv", probe=DISPLACEMENT_um, tangential_force_N=FORCE_N)
    result = wirewear("loops", path, *arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_a_missing_file_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="there is no file or folder"):
        read_loops(tmp_path / "none.csv")


GERMAN_LOG = "Messung;Rig 7\nZeit;Weg;Reibkraft\ns;mm;N\n"
ENGLISH_LOG = "Time (s)\tDisplacement (mil)\tFriction force (lbf)\n"


def logged(head: str, delimiter: str, decimal: str, length: float, force: float) -> str:
    rows = (TIME / 3.0, DISPLACEMENT_um * length, FORCE_N * force)
    lines = (delimiter.join(f"{value:.8g}" for value in row) for row in zip(*rows, strict=True))
    return head + "\n".join(lines).replace(".", decimal) + "\n"


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        (logged(GERMAN_LOG, ";", ",", 1e-3, 1.0), "latin-1"),
        (logged(GERMAN_LOG.replace("Rig", "Prüfstand"), ";", ",", 1e-3, 1.0), "cp1252"),
        (logged(ENGLISH_LOG, "\t", ".", 1.0 / 25.4, 1.0 / 4.4482216152605), "utf-16"),
        (logged("time_s displacement_um force_N\n", " ", ".", 1.0, 1.0), "utf-8-sig"),
    ],
    ids=["German", "German with umlauts", "English in mils and pounds", "white space"],
)
def test_a_loggers_layout_and_units_are_guessed(tmp_path: Path, text: str, encoding: str) -> None:
    path = tmp_path / "log.txt"
    path.write_bytes(text.encode(encoding))
    (loop,) = loops_of(path, "--normal-load", "2")
    assert loop["slip_amplitude_um"]["value"] == pytest.approx(LOOP.slip_amplitude_um, rel=0.005)
    assert loop["friction_geometry_independent"]["value"] == pytest.approx(0.62, rel=0.005)


@pytest.mark.parametrize("told", [[], ["--header-lines", "2"]], ids=["guessed", "told"])
@pytest.mark.parametrize(
    ("names", "options", "sentence"),
    [
        ("probe,drive", [], "line 3: none of the columns 'probe, drive' is known as the displacement;"),
        ("x,Q_N", ["--displacement", "y"], "line 3: there is no column 'y' among 'x, Q_N'"),
        ("probe,Q_N", ["--displacement", "probe"], "line 3: the column 'probe' has no unit in its name;"),
        ("x_um,x_um", [], "line 3: the column 'x_um' is named twice."),
        ("x_um,Q_N,a", [], "line 4, column 2: there are 2 fields where line 3 names 3 columns."),
    ],
)
def test_messages_count_the_lines_of_the_file(
    tmp_path: Path, told: list[str], names: str, options: list[str], sentence: str
) -> None:
    path = tmp_path / "log.csv"
    path.write_text(f"a logger\nof 1998\n{names}\n" + "1.0,2.0\n" * 40)
    refused = wirewear("loops", path, *told, *options)
    assert refused.exit_code == 2
    assert f"{path}, {sentence}" in refused.stderr


def test_a_header_longer_than_the_file_is_told(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("x_um,Q_N\n" + "1.0,2.0\n" * 40)
    refused = wirewear("loops", path, "--header-lines", "100")
    assert f"{path}, line 101: the file ends before it, where the names of the columns should stand." in refused.stderr
    refused = wirewear("loops", path, "--header-lines", "40")
    assert refused.exit_code == 2
    assert "line 41: " in refused.stderr


def test_what_is_told_of_a_text_overrides_the_guess(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    path.write_text("a line\n" + logged("Zeit [s];Weg [mm];Kraft [N]\n-;-;-\n", ";", ",", 1e-3, 1.0))
    told = ["--delimiter", "semicolon", "--decimal", ",", "--header-lines", "1", "--lines-after-names", "1"]
    assert loops_of(path, *told) == loops_of(path)
    refused = wirewear("loops", path, "--decimal", ".")
    assert refused.exit_code == 2
    assert "is no number" in refused.stderr
    assert "is no encoding" in wirewear("loops", path, "--encoding", "klingon").stderr
