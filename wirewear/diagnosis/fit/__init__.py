"""Fit of a test's parameters to its record: friction, rig stiffness, play and wear, each with an interval."""

from wirewear.diagnosis.fit.fit import check_by_run, completed, fit_record
from wirewear.diagnosis.fit.values import CheckedRun, FittedParameter, FittedTest
from wirewear.diagnosis.fit.wear import GivenWear

__all__ = ["CheckedRun", "FittedParameter", "FittedTest", "GivenWear", "check_by_run", "completed", "fit_record"]
