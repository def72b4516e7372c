"""Semismooth Newton method for the contact conditions of one pairing of two surfaces."""

from solvers.newton.iteration import LOST_CONTACT, NewtonOutcome, nothing_pressed, solve_contact
from solvers.newton.terms import Linearisation

__all__ = ["LOST_CONTACT", "Linearisation", "NewtonOutcome", "nothing_pressed", "solve_contact"]
