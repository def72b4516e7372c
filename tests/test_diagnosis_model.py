"""The fast forward model against closed forms."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from solvers import plugins
from studies.blind.generators.independent.friction import LAWS
from tests.diagnosis_cases import diagnosed, nominal, record, states, tables, with_effect
from tests.test_diagnosis_covariance import SITES, layout
from wirewear import RecordError, read_record, write_record
from wirewear.base.errors import WirewearError
from wirewear.diagnosis.infer.covariance import SCATTER, estimate
from wirewear.diagnosis.model.candidates import effect_of, library, nominal_setup
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.loop_states import FULL_SLIP, fitted_load
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.diagnosis.model.readings import KNEE, MIDDLE
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe import registry
from wirewear.diagnosis.observe.amplitude import Amplitude
from wirewear.diagnosis.observe.differences import ModelLoops, Scale
from wirewear.diagnosis.observe.evolution import loop_area
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.local_lines import ObservedBranch, force_at
from wirewear.diagnosis.observe.observable import Observable
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.observe.registry import all_observables, row_labels
from wirewear.diagnosis.observe.sites import Site, Sites
from wirewear.effects import all_effects
from wirewear.records import ExperimentRecord
from wirewear.records.tables import RecordTables
from wirewear.views.diagnosis_notes import of_scatter
from wirewear.views.diagnosis_values import estimates

RUNNING_IN = {"initial": 0.5, "final": 0.62, "cycles": 3000.0}

#: µP of the first loops, before the scar lends them slopes.
FORCE_N = 1.24

FIRST = np.array([2.0])

Install = Callable[[str], None]


class Unsized(Amplitude):
    """Says nothing of how far solvers differ."""

    solver_error = Observable.solver_error


class Again(Amplitude):
    """Takes a name that is taken."""


@pytest.fixture
def packages(monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Has a package install an observable by its entry point's value."""

    def install(value: str) -> None:
        points = [EntryPoint(value, value, registry.ENTRY_POINT_GROUP)]
        monkeypatch.setattr(plugins, "entry_points", lambda **_: points)
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


def stating(one: ExperimentRecord, **changes: object) -> ExperimentRecord:
    """The record with other entries in its tables; those of `stated` are added."""
    data = one.tables.model_dump(exclude_none=True, exclude_unset=True)
    for key, value in changes.items():
        data[key] = {**data.get(key, {}), **value} if isinstance(value, dict) else value
    return replace(one, tables=RecordTables.model_validate(data))


@pytest.mark.slow
def test_running_in_that_is_stated_is_part_of_the_model_and_no_gap() -> None:
    one = record({"friction_evolution": RUNNING_IN})
    assert diagnosed(stating(one, stated={"friction_evolution": RUNNING_IN})).diagnosis.verdict == "no_gap"


def test_the_final_friction_stands_in_for_the_coefficient() -> None:
    data = tables().model_dump(exclude_none=True)
    del data["stated"]["friction"]
    data["stated"]["friction_evolution"] = RUNNING_IN
    study = nominal_study(ExperimentRecord(RecordTables.model_validate(data), ()))
    assert study.contact.friction == RUNNING_IN["final"]
    (effect,) = study.effects
    assert effect.values == RUNNING_IN


def test_friction_that_is_stated_twice_and_differently_is_refused() -> None:
    wrong = stating(record(repeats=1), stated={"friction_evolution": {**RUNNING_IN, "final": 0.7}})
    with pytest.raises(RecordError, match=r"gives friction = 0\.62, but final = 0\.7"):
        nominal_study(wrong)


def test_a_record_with_all_that_may_be_stated_is_read_as_it_was_written(tmp_path: Path) -> None:
    wear = {"initial_factor": 2.0, "final_factor": 1.0, "cycles": 1e4}
    one = stating(
        record(repeats=1, evolution=False),
        stated={"friction_evolution": RUNNING_IN, "wear_rate_evolution": wear},
        scatter={"friction": 0.05, "force_zero_N": 0.02},
    )
    write_record(tmp_path / "record", one)
    again = read_record(tmp_path / "record").tables
    assert again.stated == one.tables.stated
    assert again.scatter == one.tables.scatter


def scatter_of(one: ExperimentRecord) -> tuple[dict[str, float], tuple[str, ...]]:
    found = estimate(states(), nominal_setup(nominal_study(one), "sensor"), reduce(one))
    return dict(found.scatter), found.contradicted


def test_scatter_that_is_stated_replaces_the_expectation() -> None:
    one = record(repeats=1)
    plain, _ = scatter_of(one)
    assert plain == pytest.approx(SCATTER)
    stated, _ = scatter_of(stating(one, scatter={"friction": 0.07, "normal_load": 0.02, "force_zero_N": 0.03}))
    assert stated["friction"] == pytest.approx(0.07)
    assert stated["load"] == pytest.approx(0.02)
    assert stated["force_offset"] == pytest.approx(0.015)
    assert stated["wear"] == pytest.approx(SCATTER["wear"])


def test_repeats_that_scatter_more_than_stated_say_so() -> None:
    one = record(scatter=4.0, seed=3)
    _, contradicted = scatter_of(stating(one, scatter={"friction": 0.002}))
    assert any("scatter more in friction than [scatter] states" in note for note in of_scatter(contradicted))
    _, honest = scatter_of(stating(one, scatter={"friction": 0.05}))
    assert of_scatter(honest) == ()


@pytest.mark.slow
def test_a_wide_scatter_that_is_stated_makes_a_difference_of_its_size_no_gap() -> None:
    """A friction 6 % off is a gap to a laboratory that repeats within 1 %, and none to one that scatters by 5 %."""
    one = record({"friction_offset": {"friction": 0.66}}, repeats=1, seed=2)
    close = diagnosed(stating(one, scatter={"friction": 0.01})).diagnosis
    wide = diagnosed(stating(one, scatter={"friction": 0.06})).diagnosis
    assert close.verdict != "no_gap"
    assert wide.verdict == "no_gap"
    assert np.isfinite(close.shrink.before)


def areas(setup: Setup, cycles: Array = FIRST) -> Array:
    course = simulate(states(), setup, cycles)
    return loop_area(course.displacement_um, course.tangential_force_N)


def test_a_spring_takes_its_share_of_the_energy() -> None:
    one, other = nominal(), replace(nominal(), compliance_um_per_N=nominal().compliance_um_per_N + 5.0)
    assert areas(one)[0] - areas(other)[0] == pytest.approx(4e-3 * 5.0 * FORCE_N**2, rel=0.02)


@pytest.mark.parametrize("softer", [0.0, 0.5, 1.0])
def test_a_softer_knee_encloses_what_the_books_say(softer: float) -> None:
    setup = replace(nominal(), compliance_um_per_N=0.0, micro_slip=softer)
    course = simulate(states(), setup, FIRST)
    assert areas(setup)[0] == pytest.approx(course.energy_mJ[0], rel=2e-3)


def test_micro_slip_of_another_order_is_that_of_iwans_spread_thresholds() -> None:
    setup = replace(nominal(), compliance_um_per_N=0.0, micro_slip=float(np.log(2.5 / FULL_SLIP)))
    course = simulate(states(), setup, FIRST)
    x, q = course.displacement_um[0, 0, : KNEE + 1], course.tangential_force_N[0, 0, : KNEE + 1]
    share, travel = (q - q[0]) / (q[-1] - q[0]), (x - x[0]) / (x[-1] - x[0])
    assert share == pytest.approx(LAWS["iwan"].share(2.5 * travel), abs=1e-6)


def test_walls_lift_the_wires_against_the_spring_that_presses_them() -> None:
    """The load at a place is that in mid-stroke and the spring's; forces follow it, both branches alike."""
    lifted = replace(states(), lift_N=np.outer(states().load_drop_N, [0.3, 0.1]))
    flat, raised = (simulate(one, nominal(), np.array([1e5])) for one in (states(), lifted))
    end = float(raised.normal_force_N[0, 0, -1] - raised.normal_force_N[0, 0, MIDDLE])
    drop = nominal().load_N - float(raised.normal_force_N[0, 0, MIDDLE])
    assert end == pytest.approx(0.4 * drop, rel=0.01)
    assert raised.normal_force_N[0, 0] == pytest.approx(raised.normal_force_N[0, 1])
    ratio = raised.normal_force_N[0, 0, KNEE:] / flat.normal_force_N[0, 0, KNEE:]
    forces = raised.tangential_force_N[0, 0, KNEE:] / flat.tangential_force_N[0, 0, KNEE:]
    assert forces == pytest.approx(ratio, rel=1e-3)


def test_a_load_along_the_stroke_is_parted_into_mid_stroke_and_lift() -> None:
    place = np.sin(np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False))
    middle, lift = fitted_load(place, 1.8 + 0.03 * place**2 - 0.01 * place**4 + 0.02 * place)
    assert middle == pytest.approx(1.8)
    assert lift == pytest.approx([0.03, -0.01])


def test_play_takes_twice_its_width_times_the_force() -> None:
    one, other = nominal(), with_effect(nominal(), "free_play", {"gap_um": 4.0})
    assert areas(one)[0] - areas(other)[0] == pytest.approx(2e-3 * 4.0 * FORCE_N, rel=0.03)


@pytest.mark.parametrize(
    "changed",
    [
        with_effect(nominal(), "displacement_load_coupling", {"linear_um_per_N": 4.0, "quadratic_um_per_N2": 0.0}),
        with_effect(nominal(), "displacement_load_coupling", {"linear_um_per_N": 0.0, "quadratic_um_per_N2": 1.0}),
        replace(nominal(), force_offset_N=0.05),
    ],
)
def test_a_reading_that_depends_on_the_force_leaves_the_area(changed: Setup) -> None:
    cycles = np.array([100.0, 1e4])
    assert areas(changed, cycles) == pytest.approx(areas(nominal(), cycles), rel=2e-3)


def test_the_worn_volume_is_the_coefficient_times_the_energy() -> None:
    cycles = np.geomspace(1.0, 1e5, 60)
    course = simulate(states(), nominal(), cycles)
    energy = np.trapezoid(np.append(course.energy_mJ[0], course.energy_mJ), np.append(0.0, cycles))
    assert course.volume_um3[-1] == pytest.approx(30.0 * energy, rel=0.01)


def test_computed_loops_are_centred_between_their_tips_as_measured_ones_are() -> None:
    leaning = {"linear_um_per_N": 0.0, "quadratic_um_per_N2": 1.0}
    misread = with_effect(nominal(), "displacement_load_coupling", leaning)
    course = simulate(states(), misread, np.array([100.0, 1e4]))
    tips = course.displacement_um.max(axis=(1, 2)), course.displacement_um.min(axis=(1, 2))
    assert tips[0] == pytest.approx(-tips[1])


def test_few_samples_are_read_beyond_the_knee_only() -> None:
    at = np.array([-60.0, -52.0, -44.0, -33.0, -22.0, -11.0, 0.0, 11.0, 22.0, 33.0])
    force = np.array([-1.2, -0.2, 1.0, 1.25, 1.25, 1.25, 1.25, 1.25, 1.25, 1.25])
    branch = ObservedBranch(1, at, force, 2)
    line = force_at(branch, -30.0, 4.0)
    assert line is not None
    assert line.value == pytest.approx(1.25)
    assert force_at(branch, -40.0, 4.0) is None


def test_the_drive_holds_the_reading_or_the_true_stroke() -> None:
    gained = with_effect(nominal("sensor"), "displacement_gain", {"gain": 1.05})
    read = simulate(states(), gained, FIRST).displacement_um
    assert 0.5 * np.ptp(read) == pytest.approx(60.0, rel=1e-3)
    read = simulate(states(), replace(gained, drive="stroke"), FIRST).displacement_um
    assert 0.5 * np.ptp(read) == pytest.approx(63.0, rel=1e-3)


def test_every_effect_of_the_library_is_known_to_the_fast_model() -> None:
    assert {effect_of(candidate.name) for candidate in library(nominal())} == {
        name for name, kind in all_effects().items() if kind.considered_for("crossed-wires")
    }


@pytest.mark.parametrize("name", ["friction_evolution", "wear_rate_evolution"])
def test_a_search_for_a_change_in_time_begins_at_small_ones_early_and_late_too(name: str) -> None:
    (candidate,) = (one for one in library(nominal()) if one.name == name)
    starts = [candidate.values(start) for start in candidate.starts()]
    first = next(iter(candidate.parameters))
    neutral = candidate.parameters[first].neutral
    assert neutral is not None
    small = [values["cycles"] for values in starts if abs(values[first] / neutral - 1.0) < 0.15]
    assert min(small) < 100.0
    assert max(small) > 10_000.0


def test_every_effect_that_loops_show_moves_an_observable() -> None:
    layout = reduce(record()).layout
    before = layout.observed(simulate(states(), nominal(), layout.cycles))
    for candidate in library(nominal()):
        changed = candidate.applied(nominal(), np.full(len(candidate.unknowns), 1.0))
        after = layout.observed(simulate(states(), changed, layout.cycles))
        moved = float(np.nanmax(np.abs(after - before)))
        assert (moved > 1e-4) == (candidate.name != "crossing_angle_error"), candidate.name


def test_the_moment_stiffness_is_as_unknown_as_the_arm_of_a_rotation() -> None:
    (rotation,) = (one for one in library(nominal()) if one.name == "rotational_compliance")
    found = estimates(rotation, np.zeros(1), np.array([0.01]), 1.0)
    stiffness, arm = (found[name].interval95 for name in ("stiffness_N_mm_per_rad", "arm_mm"))
    assert stiffness[1] / stiffness[0] == pytest.approx((arm[1] / arm[0]) ** 2, rel=0.01)
