"""The places along a cycle at which surfaces wear: ends, order, and both strokes between one another."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from solvers.wear_path import Stroke, wear_path

amplitudes = st.floats(1e-4, 10.0)
#: Share of the amplitude by which the contact has carried its holder along.
carried = st.floats(-0.2, 1.2)
counts = st.integers(2, 200)


@given(amplitudes, carried, counts)
def test_a_stroke_ends_at_the_other_end_and_never_turns_back(amplitude: float, share: float, count: int) -> None:
    places = wear_path(amplitude, share * amplitude, count)
    assert places.shape == (count,)
    assert places[-1] == -amplitude
    assert (np.diff(places, prepend=amplitude) < 0.0).all()


@given(amplitudes, st.floats(0.0, 0.7), st.integers(6, 200))
def test_places_of_one_stroke_lie_between_those_of_the_other(amplitude: float, share: float, count: int) -> None:
    holder = share * amplitude
    places = wear_path(amplitude, holder, count)
    # Where the bodies meet: the drive less the holder's place, which is carried along to either side in turn.
    there = places[1:-1] + holder
    back = -there[::-1]
    both = np.sort(np.concatenate([there, back]))
    slides = amplitude - holder
    spacing = 2.0 * slides / (count - 2)
    assert np.allclose(np.diff(both), 0.5 * spacing, rtol=1e-9, atol=1e-12 * amplitude)
    assert np.abs(both).max() <= slides


@given(amplitudes, st.floats(0.76, 1.2), counts)
def test_a_contact_that_hardly_slides_is_followed_as_the_drive_goes(amplitude: float, share: float, count: int) -> None:
    assume(count >= 4)
    places = wear_path(amplitude, share * amplitude, count)
    assert np.allclose(places, amplitude * np.cos(np.pi * np.arange(1, count + 1) / count))


@given(amplitudes, st.floats(0.05, 0.6), st.floats(0.2, 1.0), st.integers(6, 200))
def test_a_stroke_before_tells_where_the_bodies_slide(
    amplitude: float, share: float, sprung: float, count: int
) -> None:
    """The holder springs back by less than it was carried along, and is carried on as the force grows."""
    carried = share * amplitude
    stands = -sprung * carried
    onset = amplitude - (carried - stands)
    drive = np.concatenate([np.linspace(amplitude, onset, 20), np.linspace(onset, -amplitude, 200)[1:]])
    holder = np.where(
        drive >= onset,
        carried - (amplitude - drive),
        stands - (carried + stands) * (onset - drive) / (onset + amplitude),
    )
    places = wear_path(amplitude, carried, count, Stroke(drive[1:], holder[1:]))
    assert places[-1] == -amplitude
    assert (np.diff(places, prepend=amplitude) < 0.0).all()
    assert onset - 0.01 * amplitude < places[0] + 2.0 * (amplitude - carried) / (count - 2)
    # Where the bodies meet, strokes lie between one another as before.
    there = places[1:-1] - np.interp(-places[1:-1], -drive, holder)
    both = np.sort(np.concatenate([there, -there]))
    half = (amplitude - carried) / (count - 2)
    assert np.allclose(np.diff(both), half, rtol=0.02, atol=1e-6 * amplitude)


@given(amplitudes, st.floats(0.0, 0.7), st.integers(6, 200))
def test_a_holder_that_stands_still_asks_for_the_same_places_known_or_not(
    amplitude: float, share: float, count: int
) -> None:
    carried = share * amplitude
    onset = amplitude - 2.0 * carried
    drive = np.array([onset, -amplitude])
    known = wear_path(amplitude, carried, count, Stroke(drive, np.full(2, -carried)))
    assert np.allclose(known[1:], wear_path(amplitude, carried, count)[1:], rtol=1e-9, atol=1e-9 * amplitude)
