"""The tables that set CalculiX beside wirewear."""

from studies.benchmarks.calculix_results import read_forces
from studies.benchmarks.calculix_run import SlidingCost
from studies.benchmarks.comparison_tables import StudyCost, WirewearSide, agreement, costs
from studies.benchmarks.measured_process import ProcessCost
from tests.calculix_cases import DAT

OWN = WirewearSide(8.0, 0.1, [0.1] * 10, [0.2] * 10, 4700.0, 0.9, [1.0] * 10, [0.01] * 10)


def test_the_table_says_what_calculix_did_not_reach() -> None:
    rows = agreement(OWN, read_forces(DAT), {2.0: 4600.0})
    assert "2.17%" in rows[1]
    assert "not reached" in rows[-1]


def test_the_table_has_calculix_forces_and_rise_where_it_came() -> None:
    later = DAT.replace("0.2000000E+01", "0.2250000E+01").replace("-9.200000E-04", "-9.100000E-04")
    rows = agreement(OWN, read_forces(DAT + later), {})
    assert rows[5].split() == ["5.00", "1.0000", "1.2400", "-19.35%", "0.0100", "0.0100", "2.0000"]
    assert "not reached" in rows[1]
    assert "not reached" in rows[6]


def test_ratios_are_those_of_cpu_time_and_memory() -> None:
    peer = ProcessCost(-9, 999.0, 700.0, 2000.0, stopped=True)
    rows = costs(OWN, 500.0, peer, SlidingCost(7, 30.0, 50.0), StudyCost("quick", 120.0, 200.0))
    table = {row.split("  ")[0]: row for row in rows}
    assert "stopped after 700 s" in rows[0]
    assert "7 of 10 sliding increments" in rows[0]
    assert " 300   reached" in table["CPU s / sliding increment"]
    assert " 250" in table["wall s / sliding increment"]
    assert " 4.00   reached" in table["peak memory [MB]"]
    assert rows[-1].endswith("study / cycle = 0.100   reached: less than 0.2")


def test_an_aim_that_was_missed_is_said_to_be() -> None:
    peer = ProcessCost(0, 99.0, 70.0, 400.0)
    rows = costs(OWN, 500.0, peer, SlidingCost(10, 3.0, 5.0), StudyCost("quick", 120.0, 200.0))
    assert sum("NOT reached" in row for row in rows) == 3


def test_costs_without_a_finished_increment_claim_no_ratio() -> None:
    (row,) = costs(OWN, 500.0, ProcessCost(-9, 9.0, 9.0, 2000.0, stopped=True), None, StudyCost("quick", 1.0, 1.0))
    assert "no sliding increment" in row
