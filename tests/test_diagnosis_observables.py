"""Observables as objects: what each must say of itself, and those that packages add."""

from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from solvers import friction_laws
from tests.diagnosis_cases import nominal, record, states
from tests.test_diagnosis_covariance import SITES, layout
from wirewear.base.errors import WirewearError
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.observe import registry
from wirewear.diagnosis.observe.amplitude import Amplitude
from wirewear.diagnosis.observe.differences import ModelLoops, Scale
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.observable import Observable
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.observe.registry import all_observables, row_labels
from wirewear.diagnosis.observe.sites import Site, Sites


class Unsized(Amplitude):
    """Says nothing of how far solvers differ."""

    solver_error = Observable.solver_error


class Again(Amplitude):
    """Takes a name that is taken."""


Install = Callable[[str], None]


@pytest.fixture
def packages(monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Has a package install an observable by its entry point's value."""

    def install(value: str) -> None:
        points = [EntryPoint(value, value, registry.ENTRY_POINT_GROUP)]
        monkeypatch.setattr(friction_laws, "entry_points", lambda **_: points)
        registry._all_observables.cache_clear()

    yield install
    monkeypatch.undo()
    registry._all_observables.cache_clear()


def test_no_observable_can_be_made_that_does_not_say_how_far_solvers_differ() -> None:
    with pytest.raises(TypeError, match="solver_error"):
        Unsized()


def test_each_says_its_name_words_and_unit_and_its_zones_are_rows_of_the_map() -> None:
    known = all_observables()
    assert len({one.name for one in known}) == len(known)
    assert all(one.words and one.unit for one in known)
    assert list(row_labels()) == [zone.name for one in known for zone in one.zones]


def test_each_predicts_sizes_and_places_every_number_that_it_lists() -> None:
    whole = layout()
    course = simulate(states(), nominal(), whole.cycles)
    loops = ModelLoops(nominal(), course)
    for part in whole:
        one, count = part.observable, len(part.sites)
        predicted = one.predict(course, part.sites)
        assert predicted.shape == one.solver_error(loops, part.sites).size.shape == (count,)
        assert one.free_size(nominal(), predicted).shape == (count,)
        assert set(one.zone(part.sites, 60.0)) <= {zone.name for zone in one.zones}
        assert one.smoothness(part.sites, Scale(60.0, 1.24)).along.shape == (count,)


def test_solver_differences_of_plateaus_are_alike_over_a_shorter_way_at_the_walls() -> None:
    plateau = PlateauForce()
    places = [-60.0, -57.0, -3.0, 0.0, 3.0, 57.0, 60.0]
    sites = Layout.of_sites((plateau, [Site(1, 1, at) for at in places])).parts[0].sites
    along = plateau.smoothness(sites, Scale(60.0, 1.24)).along
    np.testing.assert_allclose(along, -along[::-1])
    steps = np.diff(along)
    np.testing.assert_allclose(steps, steps[::-1])
    assert steps[-1] > 2.0 * steps[3]
    assert np.all(steps > 0.0)


def test_what_is_measured_of_the_models_own_loops_is_what_it_predicts() -> None:
    observed = reduce(record(repeats=1, scatter=0.0, samples=400))
    predicted = observed.layout.observed(simulate(states(), nominal("sensor"), observed.layout.cycles))
    size = np.sqrt(observed.noise[0] ** 2 + (observed.common**2).sum(axis=1))
    for part in observed.layout:
        away = (observed.values[0] - predicted)[part.rows] / size[part.rows]
        assert np.sqrt(np.mean(away**2)) < 3.0, part.observable.name


def test_sites_are_read_back_as_they_were_listed() -> None:
    for listed in SITES.values():
        assert [*Sites.of(listed)] == listed


def test_a_part_of_a_layout_keeps_its_numbers_in_order() -> None:
    whole = layout()
    keep = np.random.default_rng(3).random(len(whole)) < 0.4
    course = simulate(states(), nominal(), whole.cycles)
    np.testing.assert_array_equal(whole.taken(keep).observed(course), whole.observed(course)[keep])


def test_nothing_is_predicted_of_an_empty_layout() -> None:
    assert len(Layout(())) == 0
    assert Layout(()).observed(simulate(states(), nominal(), np.array([1.0]))).size == 0


def test_an_observable_of_a_package_needs_a_name_of_its_own(packages: Install) -> None:
    packages(f"{__name__}:Again")
    with pytest.raises(WirewearError, match="its name or one of its zones is taken"):
        all_observables()


@pytest.mark.parametrize("value", [f"{__name__}:Unsized", "math:tau", f"{__name__}:nothing", "no_such_module:x"])
def test_an_entry_point_that_holds_no_observable_is_refused_in_a_sentence(packages: Install, value: str) -> None:
    packages(value)
    with pytest.raises(WirewearError, match=value.split(":", maxsplit=1)[1]):
        all_observables()
