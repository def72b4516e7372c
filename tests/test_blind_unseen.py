"""Causes of no library that were written without a look at a diagnosis: limits, parity, energy, both tiers."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from studies.blind.generators.ageing import Film
from studies.blind.generators.cases import TrueEffect
from studies.blind.generators.finite_element.changes import OUTSIDE_SETS as OF_RUNS
from studies.blind.generators.finite_element.changes import changes_of, instruments_of
from studies.blind.generators.finite_element.readings import read_test
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.loop import TrueLoop
from studies.blind.generators.independent.sensing import Reading, read
from studies.blind.generators.independent.unknown_causes import OUTSIDE, SEALED, UNSEEN
from studies.blind.generators.independent.wear_test import Snapshot, snapshots
from studies.blind.generators.independent.worlds import believed_world
from studies.blind.generators.instruments import Signals, read_by
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import SpecimenDraw
from studies.blind.generators.sizes import drawn_parameters
from studies.blind.scoring.seams import OUTSIDE_SEAMS
from tests.test_blind_finite_element import a_loop, plain_nuisances
from wirewear.effects import Seam

Named = dict[str, float]
STEEL = believed_world(Nominal(), "dahl", held_on_sensor=False)
QUIET = SpecimenDraw()
TURN = np.asarray(2.0 * np.pi * np.arange(1440) / 1440, dtype=np.float64)

#: A sine of 60 µm at 3 Hz, and a force that is odd over half a cycle.
LOOP = Signals(
    np.asarray(TURN / (6.0 * np.pi)),
    1.0 / 3.0,
    np.asarray(60.0 * np.sin(TURN)),
    np.asarray(1.2 * np.tanh(8.0 * np.cos(TURN - 0.3))),
    np.full(1440, 2.0),
)

#: Each cause at a size that changes nothing.
NOTHING: dict[str, Named] = {
    "leaking_charge": {"time_s": 1e9},
    "ringing_force_cell": {"natural_frequency_Hz": 1e9, "damping": 0.05},
    "hysteretic_displacement": {"share": 0.0},
    "fading_supply": {"change": 0.0, "cycles": 1e3},
    "creeping_joint": {"um_per_N": 0.0, "time_s": 0.1},
    "dragging_guide": {"force_N": 0.0, "over_um": 3.0},
    "sticking_lever": {"share": 0.0, "over_um": 3.0},
    "bouncing_weight": {"share": 0.0, "phase_rad": 1.0},
    "hooked_friction": {"rise": 0.0},
    "film_breakthrough": {"share": 0.0, "cycle": 1e3, "abruptness": 4.0},
    "relaxing_load": {"loss": 0.0, "cycles": 1e3},
    "unequal_wear": {"moving_share": 0.5},
    "pressure_dependent_wear": {"exponent": 0.0, "pressure_MPa": 40.0},
    "one_sided_holder": {"um_per_N": 0.0},
    "other_gauge": {"diameter_factor": 1.0},
}

#: Those that are read of a loop, and leave it as it is.
READ = [effect for effect in UNSEEN if instruments_of([TrueEffect(effect, NOTHING[effect])], Nominal())]


def seen(effect: str, signals: Signals = LOOP, cycle: float = 100.0, **parameters: float) -> Signals:
    return read_by(instruments_of([TrueEffect(effect, parameters)], Nominal()), signals, cycle)


def area_mJ(signals: Signals) -> float:
    x, q = signals.displacement_um, signals.tangential_force_N
    return -1e-3 * float(np.sum(0.5 * (x + np.roll(x, -1)) * (np.roll(q, -1) - q)))


@cache
def worn(effect: str = "", **parameters: float) -> tuple[Snapshot, Reading]:
    """Two thousand cycles on a coarse grid."""
    world = changed(STEEL, effect, parameters) if effect else STEEL
    *_, last = snapshots(world, [2000], 10)
    return last, read(world, last.loop, 2000)


def test_there_are_ten_kinds_and_more_and_all_seams_have_one() -> None:
    assert len(UNSEEN) >= 10
    assert len(OF_RUNS["unseen"]) >= 6
    assert set(OUTSIDE_SEAMS) >= set(OUTSIDE)
    assert {OUTSIDE_SEAMS[effect] for effect in UNSEEN} == set(Seam)
    assert set(NOTHING) == set(UNSEEN)
    assert not set(UNSEEN) & set(LIBRARY_EFFECTS)


@pytest.mark.parametrize("effect", UNSEEN)
def test_a_cause_of_no_size_leaves_the_test_as_it_is(effect: str) -> None:
    (snapshot, found), (plain, expected) = worn(effect, **NOTHING[effect]), worn()
    assert found.displacement_mm == pytest.approx(expected.displacement_mm, abs=1e-9)
    # A leaking charge holds no mean force, however slowly it leaks.
    mean = float(np.mean(expected.tangential_force_N)) if effect == "leaking_charge" else 0.0
    assert found.tangential_force_N == pytest.approx(expected.tangential_force_N - mean, abs=1e-6)
    assert found.normal_force_N == pytest.approx(expected.normal_force_N, abs=1e-9)
    assert snapshot.shapes.fixed == pytest.approx(plain.shapes.fixed, abs=1e-12)
    assert snapshot.shapes.moving == pytest.approx(plain.shapes.moving, abs=1e-12)


@pytest.mark.parametrize("effect", READ)
def test_a_loop_stays_odd_over_half_a_cycle_but_where_one_way_is_loaded_more(effect: str) -> None:
    found = seen(effect, LOOP, 100.0, **drawn_parameters(effect, "easy", Nominal(), np.random.default_rng(1)))
    for values in (found.displacement_um, found.tangential_force_N):
        rest = np.abs(values + np.roll(values, values.size // 2)).max() / np.abs(values).max()
        one_way = effect == "sticking_lever" and values is found.tangential_force_N
        assert (rest > 0.01) if one_way else (rest < 1e-9)


def test_a_leaking_charge_holds_no_force() -> None:
    lasting = replace(LOOP, tangential_force_N=LOOP.tangential_force_N + 0.5)
    assert seen("leaking_charge", lasting, time_s=0.5).tangential_force_N.mean() == pytest.approx(0.0, abs=1e-9)
    square = replace(LOOP, tangential_force_N=np.asarray(np.sign(np.cos(TURN + 1e-3))))
    force = seen("leaking_charge", square, time_s=0.5).tangential_force_N
    # From 90° to 270° a plateau decays exponentially; the ends ring on a grid of samples.
    assert force[1040] / force[400] == pytest.approx(np.exp(-640 / 1440 / 3.0 / 0.5), rel=0.01)


def test_a_heavy_holder_rings_at_its_own_frequency() -> None:
    rung = seen("ringing_force_cell", natural_frequency_Hz=45.0, damping=0.05).tangential_force_N
    true = np.abs(np.fft.rfft(LOOP.tangential_force_N))
    gained = np.abs(np.fft.rfft(rung))[[1, 15]] / true[[1, 15]]
    assert gained == pytest.approx([1.0 / (1.0 - 1.0 / 225.0), 10.0], rel=1e-3)


def test_hysteresis_of_the_displacement_is_widest_in_mid_stroke_and_nothing_at_the_ends() -> None:
    found = seen("hysteretic_displacement", share=0.1).displacement_um
    lag = LOOP.displacement_um - found
    assert lag[[0, 720]] == pytest.approx([6.0, -6.0])
    assert lag[[360, 1080]] == pytest.approx(0.0, abs=1e-9)


def test_a_creeping_joint_takes_work_and_an_elastic_one_none() -> None:
    plain = area_mJ(LOOP)
    elastic = seen("creeping_joint", um_per_N=3.0, time_s=1e-9)
    assert elastic.displacement_um == pytest.approx(LOOP.displacement_um + 3.0 * LOOP.tangential_force_N, abs=1e-4)
    assert area_mJ(elastic) == pytest.approx(plain, rel=1e-6)
    assert area_mJ(seen("creeping_joint", um_per_N=3.0, time_s=0.05)) > 1.01 * plain


def test_a_guide_drags_with_its_force_and_takes_its_work() -> None:
    dragged = seen("dragging_guide", force_N=0.1, over_um=4.0)
    # A spring that turns within 4 µm from end to end, then sliding: 4 F (A − d/2).
    assert area_mJ(dragged) - area_mJ(LOOP) == pytest.approx(4e-3 * 0.1 * (60.0 - 2.0), rel=1e-3)
    assert (dragged.normal_force_N == LOOP.normal_force_N).all()


def test_a_lever_that_sticks_loads_one_way_more_than_the_other_and_takes_no_work() -> None:
    stuck = seen("sticking_lever", share=0.1, over_um=6.0)
    assert stuck.normal_force_N[[0, 720]] == pytest.approx([2.2, 1.8])
    assert area_mJ(stuck) == pytest.approx(area_mJ(LOOP), rel=1e-6)


def test_weights_bounce_twice_a_cycle() -> None:
    load = np.abs(np.fft.rfft(seen("bouncing_weight", share=0.2, phase_rad=1.0).normal_force_N)) / 720
    assert load[1:5] == pytest.approx([0.0, 0.4, 0.0, 0.0], abs=1e-9)


def test_a_supply_that_fades_takes_both_forces_and_leaves_their_ratio() -> None:
    late = seen("fading_supply", cycle=1e6, change=-0.1, cycles=1e3)
    assert late.tangential_force_N == pytest.approx(0.9 * LOOP.tangential_force_N)
    assert late.normal_force_N == pytest.approx(0.9 * LOOP.normal_force_N)


def test_hooks_rise_towards_the_end_of_either_stroke_and_take_nearly_no_work() -> None:
    block = replace(LOOP, tangential_force_N=np.asarray(1.2 * np.sign(np.cos(TURN + 1e-9))))
    hooked = seen("hooked_friction", block, rise=0.2)
    gained = np.abs(hooked.tangential_force_N) - 1.2
    forth, back = np.cos(TURN) > 0.05, np.cos(TURN) < -0.05
    assert gained[forth] == pytest.approx(0.24 * np.sin(TURN[forth]) ** 3)
    assert gained[back] == pytest.approx(-0.24 * np.sin(TURN[back]) ** 3)
    assert area_mJ(hooked) == pytest.approx(area_mJ(block), rel=2e-3)


def test_a_film_is_half_gone_at_its_cycle_and_gone_in_the_end() -> None:
    film = Film(0.3, 1e3, 5.0)
    assert [film.at(cycle) for cycle in (0.0, 1e3, 1e6)] == pytest.approx([0.7, 0.85, 1.0])


def test_unequal_wear_moves_volume_from_one_wire_to_the_other() -> None:
    (plain, _), (unequal, _) = worn(), worn("unequal_wear", moving_share=0.8)
    assert unequal.shapes.moving.sum() == pytest.approx(1.6 * plain.shapes.moving.sum(), rel=0.05)
    assert unequal.shapes.fixed.sum() == pytest.approx(0.4 * plain.shapes.fixed.sum(), rel=0.05)


@pytest.mark.parametrize("exponent", [-0.3, 0.3])
def test_wear_that_follows_the_pressure_is_another_in_a_small_scar(exponent: float) -> None:
    other, _ = worn("pressure_dependent_wear", exponent=exponent, pressure_MPa=40.0)
    assert np.sign(exponent) * (other.worn_mm3 / worn()[0].worn_mm3 - 1.0) > 0.1


def test_a_one_sided_holder_shortens_one_side_of_the_loop_alone() -> None:
    low, high = worn()[0].loop.reach_mm
    for size, sides in ((4.0, (0.0, -4e-3)), (-4.0, (4e-3, 0.0))):
        found = worn("one_sided_holder", um_per_N=size)[0].loop.reach_mm
        assert (found[0] - low, found[1] - high) == pytest.approx(sides, abs=2e-3)


def test_thicker_wires_wear_shallower() -> None:
    thick, _ = worn("other_gauge", diameter_factor=1.4)
    assert thick.shapes.fixed.max() < 0.95 * worn()[0].shapes.fixed.max()


def require_read_alike(effect: str, parameters: Named) -> None:
    """See that both tiers read the same of the same loop."""
    loops = [a_loop(n, increments=400) for n in (1, 100, 100000)]
    effects = [TrueEffect(effect, parameters)]
    found = dict(
        read_test(loops, changes_of(effects, QUIET), effects, Nominal(), plain_nuisances(), QUIET, loops[0].time_s)
    )
    true = TrueLoop(1e-3 * loops[0].displacement_um, loops[0].tangential_force_N, loops[0].normal_force_N, (0.0, 0.0))
    world = changed(STEEL, effect, parameters)
    for cycle in (100, 100000):
        displacement, force, normal = found[cycle]
        there = read(world, true, cycle)
        assert displacement == pytest.approx(1e3 * there.displacement_mm, abs=1e-9)
        assert force == pytest.approx(there.tangential_force_N, abs=1e-9)
        assert normal == pytest.approx(there.normal_force_N, abs=1e-9)


@pytest.mark.parametrize("effect", [*READ, *list(SEALED)[:3]])
def test_both_tiers_read_the_same_of_the_same_loop(effect: str) -> None:
    parameters = drawn_parameters(effect, "easy", Nominal(), np.random.default_rng(1))
    require_read_alike(effect, parameters)
