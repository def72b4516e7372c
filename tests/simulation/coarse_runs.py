"""Runs on a coarse mesh, and observers that interrupt them."""

from tests import studies
from wirewear import Study, parse_study
from wirewear.results import RunResult
from wirewear.simulation import Moment, Observer

_FIRST = studies.COARSE.replace("cycles = 1\n", "cycles = 300\n").replace("per_cycle = 40", "per_cycle = 16")
COARSE = f"""{_FIRST}{studies.WEARING}moving_share = 0.3
[holder]
tangential_stiffness_N_per_mm = 167.0
normal_spring_stiffness_N_per_mm = 1.0
[log]
loop_cycles = [1, 100, 300]
[mesh]
scar_half_width_um = 36.0
"""


class Recorder(Observer):
    """Counts what it is called with, and interrupts the run after a number of logged jumps."""

    def __init__(self, stop_after: int | None = None) -> None:
        self.moments: list[Moment] = []
        self.logged_runs = 0
        self.stop_after = stop_after

    def moved(self, moment: Moment) -> None:
        self.moments.append(moment)

    def note(self, sentence: str) -> None:
        raise AssertionError(sentence)

    def logged(self, result: RunResult) -> None:
        assert result.status in ("running", "complete")
        self.logged_runs += 1


class Killer(Recorder):
    """Interrupts in the middle of a cycle, some increments after a number of logged jumps."""

    def moved(self, moment: Moment) -> None:
        super().moved(moment)
        if self.logged_runs == self.stop_after:
            self.stop_after = None
            raise KeyboardInterrupt


def coarse(text: str = COARSE) -> Study:
    return parse_study(text, "coarse.toml")


VARIANTS = """
[variants.compliant.holder]
tangential_stiffness_N_per_mm = 167.0
[variants.rigid.holder]
tangential_stiffness_N_per_mm = "rigid"
"""
