"""A motion line that is not parallel to the plane of contact."""

from dataclasses import replace
from math import pi, tan

from solvers.contact import ContactProblem
from solvers.errors import SolverError


def misaligned(problem: ContactProblem, angle_rad: float) -> ContactProblem:
    """The problem with the motion tilted out of the contact plane; a positive angle lifts the holder as x grows.

    Forces stay those along the motion (x) and the load's axis at right angles to it (z), in which the plane of contact
    descends by tan(angle) along x: both surfaces are sheared by it, which is exact for the contact's geometry and
    leaves the bodies' compliance as it was, an error of the order of the angle in the elastic displacements alone.
    Sliding under a dead weight takes Q = P tan(angle + phi) on the way out and P tan(angle - phi) on the way back, with
    tan(phi) the friction coefficient: their mean is P tan(angle) (1 + mu^2) to first order, P tan(angle) without
    friction. A loading spring adds a ripple of its stiffness times tan(angle) times the drive.
    Raises SolverError if the angle is not between -30 and 30 degrees.
    """
    if not abs(angle_rad) < pi / 6.0:
        raise SolverError(f"the misalignment must lie between -30 and 30 degrees, but is {angle_rad} rad")
    descent = -tan(angle_rad)
    return replace(
        problem, upper=replace(problem.upper, incline=descent), lower=replace(problem.lower, incline=descent)
    )
