"""A logger's file that grows: followed line by line, warned of in time, taken up again, diagnosed as in one piece."""

import csv
import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from tests.browser import page_faults
from tests.records.joint_records import FORCE_N, Rig
from wirewear.app.cli import cli
from wirewear.diagnosis.watch import looks_among, threshold
from wirewear.records.values import MeasuredLoop

pytestmark = pytest.mark.seconds
CYCLES, OPENS, SAMPLES = (1, 14, 15, 30), 15, 120
MAPPING = f"""format = 1
name = "friction damper"
[contact]
kind = "joint"
contact_stiffness_N_per_mm = 4500.0
[conditions]
displacement_amplitude_um = 500.0
frequency_Hz = 0.25
cycles = {CYCLES[-1]}
[stated]
friction_force_N = {FORCE_N}
tangential_stiffness_N_per_mm = 900.0
[loops]
files = "run.csv"
columns = {{ cycle = "n", displacement_um = "x", tangential_force_N = "Q" }}
"""


def logged(play_um: float) -> str:
    """A logger's file of a test of 30 cycles, in whose joint a play opens at the 15th."""
    random, lines = np.random.default_rng(3), ["n,x,Q"]
    for cycle in CYCLES:
        x, force = Rig(play_um=play_um if cycle >= OPENS else 0.0).loop(cycle, SAMPLES)
        lines += [f"{cycle},{a:.4f},{q:.4f}" for a, q in zip(x, force + random.normal(0.0, 0.1, SAMPLES), strict=True)]
    return "\n".join(lines) + "\n"


@pytest.fixture
def home(tmp_path: Path) -> Path:
    (tmp_path / "mapping.toml").write_text(MAPPING, encoding="utf-8")
    return tmp_path


class Logger:
    """Writes the next part of a file, cut off anywhere, whenever the command rests."""

    def __init__(self, path: Path, text: str, parts: int, killed_after: int | None = None) -> None:
        """killed_after: parts after which the command is interrupted."""
        ends = np.linspace(0, len(text), parts + 1).astype(int)
        self.path, self.killed_after, self.rests = path, killed_after, 0
        self.parts: Iterator[str] = iter([text[a:b] for a, b in pairwise(ends)])

    def sleep(self, _seconds: float) -> None:
        """Stands in for the command's rest."""
        self.rests += 1
        if self.rests == self.killed_after:
            raise KeyboardInterrupt
        with self.path.open("a", encoding="utf-8") as file:
            file.write(next(self.parts, ""))


def followed(home: Path, logger: Logger, monkeypatch: pytest.MonkeyPatch, *words: str) -> Result:
    monkeypatch.setattr("wirewear.app.cli.follow.time.sleep", logger.sleep)
    return CliRunner().invoke(cli, ["follow", str(home / "mapping.toml"), "--output", str(home / "out"), *words])


def of(home: Path, *names: str) -> list[Any]:
    return [json.loads((home / "out" / name).read_text(encoding="utf-8")) for name in names]


@pytest.mark.slow
def test_a_test_as_stated_is_not_warned_of_and_is_diagnosed_as_its_record_alone(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer = followed(home, Logger(home / "run.csv", logged(0.0), 3), monkeypatch)
    assert answer.exit_code == 0, answer.output
    assert "WARNING" not in answer.output
    assert "no gap" in answer.output.lower()
    words = ["diagnose", str(home / "out/record"), "--output", str(home / "alone")]
    assert CliRunner().invoke(cli, words).exit_code == 0
    assert (home / "out/diagnosis/diagnosis.json").read_bytes() == (home / "alone/diagnosis.json").read_bytes()


def test_a_play_that_opens_is_warned_of_and_a_killed_command_ends_as_in_one_piece(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = logged(25.0)
    killed = followed(home, Logger(home / "run.csv", text, 6, killed_after=4), monkeypatch)
    assert killed.exit_code != 0
    before, written = of(home, "follow.json")[0], (home / "run.csv").stat().st_size
    again = followed(home, Logger(home / "run.csv", text[written:], 2), monkeypatch)
    assert again.exit_code == 0, again.output

    lines = [line for out in (killed, again) for line in out.stdout.splitlines()]
    assert [int(line.split()[1]) for line in lines if line.startswith("cycle ")] == [*CYCLES]
    warnings = [line for line in lines if line.startswith("WARNING")]
    assert warnings[0].startswith(f"WARNING at cycle {OPENS}, 0:01:00 of the test, 20")
    with (home / "out" / "follow.csv").open(encoding="utf-8") as file:
        rows = [*csv.DictReader(file)]
    energies = [1e-3 * float(row["dissipated_energy_mJ"]) for row in rows]
    assert float(rows[-1]["energy_J"]) == pytest.approx(np.trapezoid(energies, CYCLES) + energies[0], rel=0.02)
    assert page_faults(home / "out" / "follow.html") == []
    (after,) = of(home, "follow.json")
    assert before["looks"].items() <= after["looks"].items()

    # The same file in one piece.
    whole = home / "whole"
    assert CliRunner().invoke(cli, ["import", str(home / "mapping.toml"), "--output", str(whole)]).exit_code == 0
    assert (home / "out/record/loops.csv").read_bytes() == (whole / "loops.csv").read_bytes()


def test_files_that_are_not_there_or_not_whole_yet_are_waited_for(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answer = followed(home, Logger(home / "run.csv", "n,x,Q\n1,0.0,1.0\n", 2), monkeypatch, "--quiet", "0.2")
    assert answer.exit_code == 2
    assert "there is no file" in answer.stderr
    assert "Traceback" not in answer.output


def test_the_rate_of_alarms_is_spent_over_all_looks_however_many() -> None:
    spent = [float(np.exp(-threshold(number, 0.01))) for number in range(1, 5000)]
    assert 0.0099 < sum(spent) <= 0.01


def test_looks_come_with_every_fiftieth_of_a_test() -> None:
    one = np.zeros(4)
    loops = [MeasuredLoop(1, cycle, one, one, one, None) for cycle in range(31)]
    assert [loops[place].cycle for place in looks_among(loops, 200)] == [1, 2, 4, 8, 12, 16, 20, 24, 28]
