"""Increments that are their own mirror image are solved for the nodes on one side, with the answers of all nodes."""

import gc
from dataclasses import replace

import numpy as np
import pytest

import solvers
from solvers.contact import mirrored
from solvers.contact_conditions import ContactGuess, ContactOutcome, Linearisation
from solvers.elasticity.compliance import MirroredCompliance, PairedCompliance
from solvers.newton import SemismoothNewton
from tests.bodies import ELEMENTS_THAT_MEET_HERTZ_mm, RIG_N_per_mm, crossed_wires, driven, pressed

DRIVES_mm = np.array([2e-4, 3.5e-4, -1e-4])


class Counting(SemismoothNewton):
    """Newton's method that counts nodes."""

    def __init__(self) -> None:
        self.nodes: list[int] = []

    def solve_contact(self, system: Linearisation, guess: ContactGuess, /) -> ContactOutcome:
        self.nodes.append(len(system.pairing.nodes))
        return super().solve_contact(system, guess)


@pytest.mark.seconds
@pytest.mark.parametrize("primary_is_upper", [True, False])
def test_a_contact_that_sticks_in_its_middle_is_solved_on_one_side_of_its_mirror(
    primary_is_upper: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = crossed_wires(
        ELEMENTS_THAT_MEET_HERTZ_mm, rig_N_per_mm=100.0 * RIG_N_per_mm, primary_is_upper=primary_is_upper
    )
    found = {}
    for fewest in (1, 10**9):
        monkeypatch.setattr(mirrored, "_FEWEST", fewest)
        counting = Counting()
        own = replace(problem, algorithm=counting)
        states, reports = driven(own, pressed(own)[0], DRIVES_mm)
        found[fewest] = states, [sum(part.friction_work for part in parts) for parts in reports], counting.nodes
    (halved, half_works, few), (whole, works, many) = found.values()
    assert max(few) < 0.6 * max(many)
    assert 0 < np.count_nonzero(whole[-1].core) < np.count_nonzero(whole[-1].traction[:, 2])
    for one, other in zip(halved, whole, strict=True):
        assert np.abs(one.traction - other.traction).max() < 1e-5 * np.abs(other.traction).max()
        np.testing.assert_array_equal(one.core, other.core)
        assert one.holder_x == pytest.approx(other.holder_x, rel=1e-6)
    assert half_works == pytest.approx(works, rel=1e-4, abs=1e-12)


def test_what_is_not_its_own_mirror_image_is_solved_as_a_whole() -> None:
    problem = crossed_wires(ELEMENTS_THAT_MEET_HERTZ_mm)
    state = pressed(problem)[0]
    assert mirrored.images_across(problem, state) is not None
    uneven, images = state.traction.copy(), solvers.symmetry_of(problem).across
    assert images is not None
    uneven[np.argmax(images.primary != np.arange(len(uneven)))] += 1.0
    depth = np.zeros(problem.primary.patch.shape)
    depth[:3, :3] = 1e-4
    for other in (
        replace(state, traction=uneven),
        replace(state, wear=replace(state.wear, primary_depth=depth)),
        replace(state, core=np.zeros_like(state.core)),  # nothing that sticks
        replace(state, bulk=np.full((2, 2, 2), 1e-4)),
    ):
        assert mirrored.images_across(problem, other) is None


@pytest.mark.seconds
def test_increments_that_stick_give_back_their_matrices_without_waiting_for_garbage(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mirrored, "_FEWEST", 1)
    problem = crossed_wires(ELEMENTS_THAT_MEET_HERTZ_mm, rig_N_per_mm=100.0 * RIG_N_per_mm)
    state = pressed(problem)[0]

    def held() -> int:
        return sum(type(one) in (PairedCompliance, MirroredCompliance) for one in gc.get_objects())

    gc.disable()
    try:
        before = held()
        driven(problem, state, np.linspace(1e-5, 1e-4, 10))
        assert held() - before < 10
    finally:
        gc.enable()
