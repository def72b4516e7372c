"""Causes of no library, all sets alike: at all seams, without a trace, of one size in both tiers, and how large."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from solvers import Holder, WearRates
from studies.blind.causes import SETS, all_causes, causes_of, seam_of
from studies.blind.generators.cases import Case, TrueEffect, planned_cases
from studies.blind.generators.files import write_traceless
from studies.blind.generators.finite_element.changes import changes_of, outside_of
from studies.blind.generators.finite_element.model import NUMERICS, nominal_study
from studies.blind.generators.finite_element.readings import read_test
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.loop import TrueLoop
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.independent.sensing import read
from studies.blind.generators.nominal import Nominal, drawn_nominals
from studies.blind.generators.nuisances import SpecimenDraw
from studies.blind.generators.sizes import drawn_parameters
from tests.exam import blind_causes
from tests.exam.finite_element_cases import a_loop, plain_nuisances
from wirewear.effects import Age, ContactLaw, Loading, Seam, applied

QUIET = SpecimenDraw()
WITHHELD, RESERVED = causes_of("withheld"), causes_of("reserved")


def test_there_are_sixteen_kinds_and_more_in_two_halves() -> None:
    first, development, sealed, unseen, withheld, reserved = (set(causes_of(name)) for name in SETS)
    assert len(development | sealed) >= 16
    assert not development & sealed
    assert not unseen & (development | sealed)
    assert first <= development | sealed
    assert set(all_causes()) == first | development | sealed | unseen | withheld | reserved
    assert not set(all_causes()) & set(LIBRARY_EFFECTS)
    assert set(blind_causes.NOTHING) == unseen | withheld | reserved
    assert len(outside_of("unseen")) >= 6


@pytest.mark.parametrize("name", SETS)
def test_a_set_says_in_which_order_its_causes_are_drawn(name: str) -> None:
    """A batch's seed gives its cases again only while it does."""
    assert sorted(dict(all_causes()[cause].sets)[name] for cause in causes_of(name)) == [*range(len(causes_of(name)))]


@pytest.mark.parametrize("name", all_causes())
def test_a_cause_is_named_as_its_file_and_drawn_with_the_parameters_that_its_law_has(name: str) -> None:
    cause = all_causes()[name]
    assert cause.__name__ == name.title().replace("_", "")
    assert set(blind_causes.drawn(name)) == {field.name for field in fields(cause)}


@pytest.mark.parametrize(
    ("name", "kinds", "twice"),
    [
        ("unseen", 10, ()),
        ("withheld", 12, ("sensor", "holder", "contact")),
        ("reserved", 14, ("sensor", "contact", "holder", "loading")),
    ],
)
def test_a_set_has_kinds_of_its_own_at_all_seams(name: str, kinds: int, twice: tuple[str, ...]) -> None:
    own = causes_of(name)
    seams = [seam_of(effect) for effect in own]
    assert len(own) >= kinds
    # What a test holds is stated by few records, and wrong in one way alone.
    assert set(seams) == set(Seam) - {Seam.DRIVE}
    assert all(seams.count(seam) >= 2 for seam in twice)
    assert not set(own) & {effect for other in SETS if other != name for effect in causes_of(other)}


@pytest.mark.parametrize("effect", blind_causes.NOTHING)
def test_a_cause_of_no_size_leaves_the_test_as_it_is(effect: str) -> None:
    (snapshot, found), (plain, expected) = (
        blind_causes.worn(effect, **blind_causes.NOTHING[effect]),
        blind_causes.worn(),
    )
    # A leaking charge holds no mean force, however slowly it leaks.
    mean = float(np.mean(expected.tangential_force_N)) if effect == "leaking_charge" else 0.0
    assert found.displacement_mm == pytest.approx(expected.displacement_mm, abs=1e-9)
    assert found.tangential_force_N == pytest.approx(expected.tangential_force_N - mean, abs=1e-6)
    assert found.normal_force_N == pytest.approx(expected.normal_force_N, abs=1e-9)
    assert snapshot.shapes.fixed == pytest.approx(plain.shapes.fixed, abs=1e-12)
    assert snapshot.shapes.moving == pytest.approx(plain.shapes.moving, abs=1e-12)


@pytest.mark.parametrize("effect", blind_causes.READ)
def test_a_loop_stays_odd_over_half_a_cycle_but_where_one_end_or_direction_differs(effect: str) -> None:
    parameters = blind_causes.drawn(effect)
    found = blind_causes.seen(
        effect, blind_causes.LOOP, parameters.get("cycle_1", 1e5 if effect in WITHHELD else 3e4), **parameters
    )
    for values, one_way in (
        (found.tangential_force_N, blind_causes.ONE_WAY_IN_FORCE),
        (found.displacement_um, blind_causes.ONE_WAY_IN_DISPLACEMENT),
    ):
        assert (
            (blind_causes.unevenness(values) > 1e-3) if effect in one_way else (blind_causes.unevenness(values) < 1e-9)
        )


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("effect", [*RESERVED, "crossover_distortion", "loose_plug", "opening_joint", "used_wire"])
def test_records_are_the_same_again_and_their_files_of_one_size_without_the_cause(effect: str, tmp_path: Path) -> None:
    model = IndependentModel(points=6, outside=RESERVED if effect in RESERVED else WITHHELD)
    case = planned_cases(20, 2, LIBRARY_EFFECTS, model.outside)[0]
    true = TrueEffect(effect, drawn_parameters(effect, "easy", case.nominal, np.random.default_rng(1)))
    case = replace(case, effects=(true,))
    made = {}
    for name, one in (("first", case), ("again", case), ("without", replace(case, effects=()))):
        written = write_traceless(tmp_path / name, model.make(one).record)
        made[name] = written, {path.name: path.stat().st_size for path in (tmp_path / name).iterdir()}
    assert made["first"] == made["again"]
    assert made["first"][0] != made["without"][0]
    assert made["first"][1] == made["without"][1]


@pytest.mark.parametrize("effect", [*blind_causes.READ, *causes_of("sealed")[:3]])
def test_both_tiers_read_the_same_of_the_same_loop(effect: str) -> None:
    parameters = blind_causes.drawn(effect)
    loops = [a_loop(n, increments=400) for n in (1, 100, 100000)]
    effects = [TrueEffect(effect, parameters)]
    found = dict(
        read_test(loops, changes_of(effects, QUIET), effects, Nominal(), plain_nuisances(), QUIET, loops[0].time_s)
    )
    true = TrueLoop(1e-3 * loops[0].displacement_um, loops[0].tangential_force_N, loops[0].normal_force_N, (0.0, 0.0))
    world = changed(blind_causes.STEEL, effect, parameters)
    for cycle in (100, 100000):
        displacement, force, normal = found[cycle]
        there = read(world, true, cycle)
        assert displacement == pytest.approx(1e3 * there.displacement_mm, abs=1e-9)
        assert force == pytest.approx(there.tangential_force_N, abs=1e-9)
        assert normal == pytest.approx(there.normal_force_N, abs=1e-9)


@pytest.mark.parametrize("effect", blind_causes.AT_SEAMS)
def test_both_tiers_have_the_same_holder_friction_load_and_wear_at_every_cycle(effect: str) -> None:
    parameters = blind_causes.drawn(effect, 2)
    world = changed(blind_causes.STEEL, effect, parameters)
    changes = changes_of([TrueEffect(effect, parameters)], QUIET)
    nominal_study(Nominal(), plain_nuisances(), NUMERICS["T1"]).with_effects(*changes)
    for cycle in (0.0, 10.0, 1000.0, 3e4, 1e5):
        age = Age(cycle, 0.0)
        holder = applied(changes, Seam.HOLDER, Holder(2.0, 1.0 / 167.0), age)
        assert holder.tangential_compliance_mm_per_N == pytest.approx(
            world.rig.series_mm_per_N + world.rig.loose_mm_per_N(cycle)
        )
        assert holder.play_mm == pytest.approx(world.rig.aged(cycle).play_mm)
        friction = applied(changes, Seam.CONTACT, ContactLaw(0.62), age).friction
        assert friction == pytest.approx(world.friction.at(cycle))
        load = applied(changes, Seam.LOADING, Loading(2.0), age).normal_load_N
        assert load == pytest.approx(world.loading.load_at(cycle))
        rates = applied(changes, Seam.WEAR, WearRates(0.5, 0.5), age)
        assert rates.lower_mm3_per_mJ == pytest.approx(0.5 * world.wear.factor_at(cycle))


def gaps_in_scatters(effect: str, points: int = 10) -> dict[str, float]:
    """Median size of a cause's gap over three tests, hard and easy."""
    model = IndependentModel("dahl", points=points)
    nuisances = replace(plain_nuisances(), drive="stroke", has_scars=True, has_normal_force=True)
    size: dict[str, list[float]] = {"hard": [], "easy": []}
    for ease, found in size.items():
        for place, test in enumerate(drawn_nominals(3, np.random.default_rng(77))):
            true = TrueEffect(effect, drawn_parameters(effect, ease, test, np.random.default_rng(place)))
            case = Case("a case", "outside", ease, (true,), (), test, nuisances, 1)
            found.append(max(model.sized(case)[0].values()))
    return {ease: float(np.median(found)) for ease, found in size.items()}


@pytest.mark.slow
@pytest.mark.parametrize("effect", [*WITHHELD, *RESERVED])
def test_sizes_of_gaps_lie_about_two_to_twenty_scatters(effect: str) -> None:
    size = gaps_in_scatters(effect, points=10 if effect in WITHHELD else 24)
    hardest, easy = (15.0, (4.0, 50.0)) if effect in WITHHELD else (8.0, (3.5, 40.0))
    assert size["hard"] < size["easy"]
    assert 0.5 < size["hard"] < hardest
    assert easy[0] < size["easy"] < easy[1]
