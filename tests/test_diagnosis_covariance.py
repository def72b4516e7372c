"""What differs between tests and between solvers without any gap, as the diagnosis expects it."""

from dataclasses import replace

import numpy as np

from tests.diagnosis_cases import nominal, record, states
from wirewear.diagnosis.infer.covariance import Covariance, estimate, remainder
from wirewear.diagnosis.model.forward import MIDDLE, simulate
from wirewear.diagnosis.observe.layout import Array, Layout
from wirewear.diagnosis.observe.reduction import Observations, reduce


def wandering(observed: Observations, share: float) -> Observations:
    """The observations with strokes that grow by this share in one repeat and shrink in another."""
    values = observed.values.copy()
    at = np.flatnonzero(observed.layout.kind == "amplitude")
    rise = np.linspace(-1.0, 1.0, at.size)
    for repeat, sign in enumerate((1.0, -1.0)):
        values[repeat, at] += share * sign * rise * nominal("sensor").amplitude_um
    return replace(observed, values=values)


def covariance_of(observed: Observations) -> Covariance:
    return estimate(states(), nominal("sensor"), observed)


def test_strokes_that_wander_between_repeats_are_scatter_and_take_the_stick_branches_along() -> None:
    steady = reduce(record(repeats=2))
    calm, moved = covariance_of(steady), covariance_of(wandering(steady, 0.01))
    layout = steady.layout
    for kind in ("amplitude", "stick"):
        rows = np.flatnonzero(layout.kind == kind)
        assert (np.diag(moved.between)[rows] > 1.5 * np.diag(calm.between)[rows]).all()
    first, last = np.flatnonzero(layout.kind == "amplitude")[[0, -1]]
    both = np.ix_([first, last], [first, last])
    correlation = moved.between[both] / np.sqrt(np.outer(*[np.diag(moved.between)[[first, last]]] * 2))
    # The stroke of one test says little of the same test's stroke three decades later.
    assert correlation[0, 1] < 0.7


def test_one_repeat_is_expected_to_wander_too() -> None:
    one = covariance_of(reduce(record(repeats=1)))
    amplitude = reduce(record(repeats=1)).layout.kind == "amplitude"
    assert np.sqrt(np.diag(one.between)[amplitude]).min() > 0.002 * nominal().amplitude_um


def test_solvers_differ_where_hooks_have_grown_and_in_no_scar_for_their_sake() -> None:
    rows = [(kind, cycle, side, 40.0) for kind in ("plateau",) for cycle in (100, 100_000) for side in (1, -1)]
    layout = Layout.of_rows([*rows, ("scar", 100_000, 0, 0.0)])
    sizes = np.sqrt(np.diag(remainder(states(), nominal(), layout)))
    assert sizes[2:4].min() > 5.0 * sizes[:2].max()
    assert sizes[4] < 0.02


def test_knees_of_solvers_differ_by_a_share_of_low_walls_and_by_little_more_of_high_ones() -> None:
    cycles = (1, 3_000, 100_000)
    layout = Layout.of_rows([("knee", cycle, 1, 0.0) for cycle in cycles])
    sizes = np.sqrt(np.diag(remainder(states(), nominal(), layout)))
    force = simulate(states(), nominal(), layout.cycles).tangential_force_N
    walls = force[:, 0, -1] - force[:, 0, MIDDLE]
    plateau = nominal().friction.final * nominal().load_N
    assert sizes[0] < 0.006 * plateau
    assert 0.1 * walls[1] < sizes[1] < 0.5 * walls[1]
    assert sizes[1] < sizes[2] < 0.08 * plateau


def correlations(layout: Layout) -> Array:
    """Of solver differences of forces, both branches counted along their direction."""
    covariance = remainder(states(), nominal(), layout) * np.outer(layout.branch, layout.branch)
    sizes = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(sizes, sizes))


def test_ripples_may_make_the_wall_at_one_end_steeper_in_one_cycle_but_not_in_all() -> None:
    rows = [("plateau", cycle, side, side * 52.0) for cycle in (10_000, 100_000) for side in (1, -1)]
    both = correlations(Layout.of_rows(rows))
    ends = 0.5 * (both[0, 1] + both[2, 3])
    # What the ends differ by in one cycle is not what they differ by in another.
    contrast = np.array([1.0, -1.0])
    one, other = both[:2, :2], both[:2, 2:]
    assert ends < 0.6
    assert abs(contrast @ other @ contrast) < 0.3 * (contrast @ one @ contrast)
    middle = correlations(Layout.of_rows([("plateau", 100_000, side, side * 5.0) for side in (1, -1)]))
    assert middle[0, 1] > ends


def test_the_knees_of_both_branches_stand_at_walls_of_their_own() -> None:
    knees = correlations(Layout.of_rows([("knee", 100_000, side, 0.0) for side in (1, -1)]))
    assert abs(knees[0, 1]) < 0.2


def test_walls_are_less_smooth_than_what_lies_between_them() -> None:
    places = (0.0, 6.0, 46.0, 52.0)
    along = correlations(Layout.of_rows([("plateau", 100_000, 1, place) for place in places]))
    assert along[2, 3] < along[0, 1]
