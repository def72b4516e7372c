"""A test that CalculiX is given, and files that it leaves."""

from studies.benchmarks.calculix_deck import CalculixTest


def sliding(rig: float | str = 167.0) -> CalculixTest:
    return CalculixTest(2.0, 9e-4, 0.02, 4, 6, 0.62, "rigid" if rig == "rigid" else float(rig), 210_000.0, 0.3)
