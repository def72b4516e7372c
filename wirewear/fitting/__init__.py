"""Parameters of a test fitted to its record: friction, rig stiffness, play and wear, each with an interval."""

from wirewear.fitting.checking import CheckedRun, check_by_run
from wirewear.fitting.fit import fit_record
from wirewear.fitting.values import FittedTest, Parameter
from wirewear.fitting.wear import GivenWear

__all__ = ["CheckedRun", "FittedTest", "GivenWear", "Parameter", "check_by_run", "fit_record"]
