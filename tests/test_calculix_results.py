"""Forces, pressures and completed increments read from CalculiX's files."""

from pathlib import Path

import pytest

from studies.benchmarks.calculix_results import increment_near, read_completed, read_forces, read_peak_pressures
from studies.benchmarks.calculix_run import Completed, Completions, SlidingCost, sliding_cost
from studies.benchmarks.comparison_tables import PRESSED, SLIDING
from studies.benchmarks.measured_process import Usage
from tests.calculix_cases import DAT, STA


def test_forces_are_read_with_their_times() -> None:
    (increment,) = read_forces(DAT)
    assert increment.time == 2.0
    assert increment.grip_force_N == pytest.approx([1.24, 0.0, 2.0])
    assert increment_near((increment,), 2.25) is None


def test_the_largest_contact_pressure_is_read_at_each_time() -> None:
    names = ("COPEN", "CSLIP1", "CSLIP2", "CPRESS", "CSHEAR1", "CSHEAR2")
    values = [0.0, 0.0, 0.0, 4600.0, 1.0, 9999.0]
    lines = [f"  100CL  101{2.0:12.5E}         625", " -4  CONTACT     6    1"]
    lines += [f" -5  {name:8}    1    4    1    0" for name in names]
    lines += [f" -1{7:10d}" + "".join(f"{v:12.5E}" for v in values), f" -1{8:10d}" + f"{1.0:12.5E}" * 6, " -3"]
    other = [" -4  DISP        1    1", " -5  D1          1    2    1    0", f" -1{7:10d}{9e9:12.5E}", " -3"]
    assert read_peak_pressures("\n".join(lines + other)) == {2.0: 4600.0}


def test_an_increment_cut_off_in_writing_is_left_out() -> None:
    assert read_forces(DAT.split(" total force", maxsplit=1)[0]) == ()


def test_exponents_of_three_digits_are_read() -> None:
    (increment,) = read_forces(DAT.replace(" 0.000000E+00  2.000000E+00", "-1.234567-101  2.000000E+00"))
    assert increment.grip_force_N[1] == -1.234567e-101


def test_negative_numbers_without_a_blank_between_are_read_from_frd() -> None:
    lines = ["  100CL  101" + f"{1.0:12.5E}", " -4  CONTACT     6    1", " -5  COPEN", " -5  CPRESS"]
    lines += [f" -1{7:10d}{-1.25e-2:12.5E}{-3.5:12.5E}", f" -1{8:10d}{-1.25e-2:12.5E}{4.5:12.5E}", " -3"]
    assert read_peak_pressures("\n".join(lines)) == {1.0: 4.5}


def test_empty_files_hold_nothing() -> None:
    assert (read_forces(""), read_completed(""), read_peak_pressures("")) == ((), (), {})


def test_a_broken_row_is_named() -> None:
    with pytest.raises(ValueError, match="line 4"):
        read_forces(DAT.replace("-9.200000E-04", "oops"))


def test_only_converged_increments_count_as_completed() -> None:
    assert read_completed(STA) == (1.0, 2.0, 2.0625)
    assert read_completed(STA + "     3          2     1     3  0.2250") == (1.0, 2.0, 2.0625)


def test_each_increment_is_given_what_was_used_when_it_was_reported(tmp_path: Path) -> None:
    announced = list[Completed]()
    watch = Completions(tmp_path / "wires.sta", announced.append)
    watch(Usage(1.0, 0.5, 10.0))
    lines = STA.splitlines(keepends=True)
    (tmp_path / "wires.sta").write_text("".join(lines[:3]))
    watch(Usage(9.0, 8.0, 10.0))
    (tmp_path / "wires.sta").write_text(STA)
    watch(Usage(20.0, 15.0, 10.0))
    assert watch.completed == (Completed(1.0, 9.0, 8.0), Completed(2.0, 20.0, 15.0), Completed(2.0625, 20.0, 15.0))
    assert announced == list(watch.completed)


def test_the_approach_the_load_and_the_unfinished_increment_are_not_counted() -> None:
    completed = (
        Completed(1.0, 80.0, 60.0),
        Completed(2.0, 130.0, 100.0),
        Completed(2.0625, 150.0, 120.0),
        Completed(2.25, 170.0, 140.0),
        Completed(2.5, 230.0, 160.0),
        Completed(2.6, 999.0, 900.0),
    )
    assert sliding_cost(completed, PRESSED, SLIDING) == SlidingCost(2, 30.0, 50.0)
    assert sliding_cost(completed[:3], PRESSED, SLIDING) is None
