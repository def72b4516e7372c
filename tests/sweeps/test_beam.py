"""A wire as a beam on contacts, against closed forms and superposition."""

from math import inf, sqrt, tanh

import numpy as np
import pytest

from wirewear.base.errors import StudyError
from wirewear.sweeps.beam import Beam, Yielding, contact_forces

BENDING = 10_308.0


def on_springs(beam: Beam, places: list[float], spring: float) -> np.ndarray:
    stiffness, load = beam.at(np.array(places))
    return np.asarray(spring * np.linalg.solve(stiffness + spring * np.eye(len(places)), load))


@pytest.mark.parametrize("shear", [inf, 57_000.0])
def test_a_wire_over_three_springs_carries_as_the_closed_form_says(shear: float) -> None:
    load, spring, span = 6.0, 800.0, 8.0
    found = on_springs(Beam(BENDING, shear, load, (0.0,)), [-4.0, 0.0, 4.0], spring)
    flexibility = span**3 / (48.0 * BENDING) + span / (4.0 * shear)
    middle = load * (flexibility + 0.5 / spring) / (flexibility + 1.5 / spring)
    np.testing.assert_allclose(found, [(load - middle) / 2, middle, (load - middle) / 2], rtol=1e-9)
    assert found.sum() == pytest.approx(load, rel=1e-9)


def test_many_crossings_carry_as_superposed_deflections_of_an_endless_beam_say() -> None:
    """A free beam deflects by rigid motions and by |x − s|³/12EI of every force on it."""
    places, loads, spring = np.array([-9.0, -4.0, 0.0, 3.5, 8.0]), np.array([-2.0, 6.0]), 800.0
    bent, by_load = (np.abs(places[:, None] - at) ** 3 / (12.0 * BENDING) for at in (places, loads))
    rigid = np.stack([np.ones(5), places])
    matrix = np.block([[bent + np.eye(5) / spring, -rigid.T], [rigid, np.zeros((2, 2))]])
    expected = np.linalg.solve(matrix, [*(5.0 * by_load.sum(axis=1)), 10.0, 5.0 * loads.sum()])[:5]
    np.testing.assert_allclose(on_springs(Beam(BENDING, inf, 10.0, (-2.0, 6.0)), list(places), spring), expected, 1e-8)


def test_a_pulled_wire_sinks_as_a_tie_rod_does() -> None:
    """Timoshenko, Strength of Materials II: PL³/48EI · 3 (u − tanh u)/u³, with u² = TL²/4EI."""
    span, tension = 20.0, 600.0
    u = sqrt(tension * span**2 / (4.0 * BENDING))
    stiffness, _ = Beam(BENDING, inf, 1.0, (10.0,), tension).at(np.array([0.0, 10.0, 20.0]))
    expected = span**3 / (48.0 * BENDING) * 3.0 * (u - tanh(u)) / u**3
    assert 1.0 / stiffness[1, 1] == pytest.approx(expected, rel=1e-4)


def test_the_prop_of_a_clamped_wire_carries_what_its_lever_gives() -> None:
    """Load P at a beyond a rigid prop at L from the clamp: R = P (1 + 3a/2L)."""
    stiffness, load = Beam(BENDING, inf, 5.0, (15.0,), clamped_at_mm=(0.0,)).at(np.array([10.0]))
    assert load[0] == pytest.approx(5.0 * 1.75, rel=1e-9)
    assert stiffness[0, 0] == pytest.approx(3.0 * BENDING / 1e3, rel=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_contacts_press_or_gape_and_balance_the_load_to_a_billionth(seed: int) -> None:
    draw = np.random.default_rng(seed)
    count = int(draw.integers(3, 8))
    places = np.cumsum(draw.uniform(1.0, 6.0, count))
    loads = tuple(draw.uniform(places[0], places[-1], 2))
    beam = Beam(BENDING, 57_000.0, 10.0, loads, float(draw.choice([0.0, 300.0])))
    wear = np.full(count, 1e-5 * draw.integers(0, 2))
    contacts = Yielding(draw.uniform(0.0, 0.01, count), np.full(count, 1e-3), wear, np.full(count, 100.0), 1000.0)
    force = contact_forces(beam, places, contacts)
    assert force.sum() == pytest.approx(10.0, rel=1e-9)
    if not beam.tension_N:
        assert force @ places == pytest.approx(5.0 * sum(loads), rel=1e-9)
    assert (force >= 0.0).all()
    stiffness, load = beam.at(places)
    down = contacts.gap_mm + contacts.softness * force ** (2 / 3) + contacts.depth_mm(force)
    closed = force > 0.0
    # Of a free beam the sinking of open contacts follows from that of closed ones.
    free = np.linalg.lstsq(stiffness[:, ~closed], load - force - stiffness[:, closed] @ down[closed], rcond=None)[0]
    assert (free <= down[~closed] + 1e-9).all()


def test_a_wire_that_tips_over_is_refused() -> None:
    contacts = Yielding(np.zeros(2), np.full(2, 1e-3), np.zeros(2), np.zeros(2), 1.0)
    with pytest.raises(StudyError, match="tips over"):
        contact_forces(Beam(BENDING, inf, 5.0, (9.0,)), np.array([0.0, 4.0]), contacts)
