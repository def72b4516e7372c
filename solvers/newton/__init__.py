"""Semismooth Newton method for the contact conditions of one pairing of two surfaces."""

from solvers.newton.iteration import solve_contact
from solvers.newton.outcome import LOST_CONTACT, NewtonOutcome
from solvers.newton.terms import Linearisation

__all__ = ["LOST_CONTACT", "Linearisation", "NewtonOutcome", "solve_contact"]
