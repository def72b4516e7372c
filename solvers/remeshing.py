"""A run that goes on with other meshes of its bodies: the worn surfaces are carried over, the contact is found anew."""

from __future__ import annotations

from dataclasses import replace

from solvers.contact import ContactProblem, press, unloaded_state
from solvers.contact_state import ContactState, IncrementReport
from solvers.transfer import transferred_wear


def remeshed(
    problem: ContactProblem, state: ContactState, onto: ContactProblem
) -> tuple[ContactState, IncrementReport]:
    """The state on the patches of another problem's bodies, pressed together without friction where the drive is.

    The worn volume is conserved (see `transfer`), the height to which the loading spring refers is kept. What friction
    had built up is lost: half a cycle of sliding with the wear frozen builds it up again.

    Raises:
        SolverError: a worn place lies beside its new patch, or the contact was not found.
    """
    old, new = ((of.primary.patch, of.secondary.patch) for of in (problem, onto))
    blank = unloaded_state(onto)
    carried = replace(blank, wear=transferred_wear(state.wear, old, new), drive=state.drive)
    pressed, report = press(onto, carried)
    return replace(pressed, pressed_z=state.pressed_z), report
