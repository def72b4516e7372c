"""`wirewear loops`: any source, columns by name and unit, JSON of fixed keys."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from tests import synthetic_results
from tests.synthetic_loops import Recipe, SyntheticLoop
from wirewear.faces import cli
from wirewear.results import write_result
from wirewear.views.loops_sources import read_loops

KEYS = (
    "displacement_amplitude_um", "slip_amplitude_um", "measured_stiffness_N_per_um", "friction_max", "friction_energy",
    "friction_geometry_independent", "dissipated_energy_mJ", "regime",
)  # fmt: skip
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


@pytest.mark.seconds
@given(st.sampled_from(["_", " [", " ("]), st.sampled_from([("um", 1.0), ("mm", 1e-3), ("nm", 1e3)]))
def test_usual_names_are_recognised_however_the_unit_is_written(
    tmp_path_factory: pytest.TempPathFactory, mark: str, unit: tuple[str, float]
) -> None:
    end = {"_": "", " [": "]", " (": ")"}[mark]
    names = {f"Displacement{mark}{unit[0]}{end}": unit[1] * DISPLACEMENT_um, f"Tangential force{mark}N{end}": FORCE_N}
    (loop,) = read_loops(csv(tmp_path_factory.mktemp("names") / "a.csv", **names))
    np.testing.assert_allclose(loop.displacement_um, DISPLACEMENT_um, rtol=1e-9)
    np.testing.assert_allclose(loop.tangential_force_N, FORCE_N, rtol=1e-9)


@pytest.mark.first_case
@pytest.mark.seconds
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


@pytest.mark.seconds
def test_a_result_gives_its_loops_a_table_and_a_picture(tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    write_result(path, synthetic_results.result("compliant", 167.0))
    result = wirewear("loops", path, "--output", tmp_path / "loops.png")
    assert result.exit_code == 0, result.output
    assert "gross" in result.stdout
    assert (tmp_path / "loops.png").read_bytes().startswith(b"\x89PNG")


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
