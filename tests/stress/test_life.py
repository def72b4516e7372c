"""Criteria of life against closed forms, and damage that is carried and taken away as surfaces wear."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from geometry import Elastic
from geometry.arrays import Array
from tests.commands import wirewear
from tests.stress.fatigue_data import DUCTILITY, OWN, STRENGTH, B, C
from tests.studies import TABLES, line_study
from wirewear.base.errors import ResultError, StudyError
from wirewear.base.files import toml_text
from wirewear.stress.averaging import kernel_of
from wirewear.stress.criteria import LifeCurve, criterion_of
from wirewear.stress.damage import Ahead, Damage, Rates, Span
from wirewear.stress.life import require_life
from wirewear.test.life import CRITERIA, LifeTable
from wirewear.test.programme import BlockCourse, CycleBlock, Schedule

STEEL = Elastic(210000.0, 0.3)
TURN = 2.0 * np.pi * np.arange(24) / 24


def pulled(amplitude: float, mean: float = 0.0, wave: Array | None = None) -> Array:
    """A bar pulled along z, a cycle of one point."""
    history = np.zeros((len(TURN), 1, 6))
    history[:, 0, 2] = mean + amplitude * (np.cos(TURN) if wave is None else wave)
    return history


def life(criterion: str, history: Array) -> float:
    return float(1.0 / criterion_of(LifeTable(criterion=criterion, **OWN), STEEL).damage(history).share[0])


def test_a_curve_of_two_terms_is_inverted_from_half_a_cycle_to_far_beyond_any_test() -> None:
    curve = LifeCurve(((43.0, -0.18), (1350.0, -0.68)), endurance_cycles=1e12)
    cycles = np.array([0.5, 10.0, 1e3, 1e7, 1e11])
    assert curve.cycles(curve.parameter(cycles)) == pytest.approx(cycles, rel=1e-9)
    assert np.isinf(curve.cycles(np.append(curve.parameter(np.array([1e13])), 0.0))).all()


@pytest.mark.parametrize("criterion", ["crossland", "stress-life"])
def test_a_bar_pulled_to_and_fro_lasts_as_basquin_has_it(criterion: str) -> None:
    assert life(criterion, pulled(500.0)) == pytest.approx(0.5 * (500.0 / STRENGTH) ** (1.0 / B), rel=0.05)


def test_mean_stress_shortens_a_life_as_by_morrow_smith_watson_and_topper_and_fatemi_and_socie() -> None:
    reversed_MPa = 400.0 / (1.0 - 300.0 / STRENGTH)
    assert life("stress-life", pulled(400.0, 300.0)) == pytest.approx(life("stress-life", pulled(reversed_MPa)), 0.01)
    alike = life("smith-watson-topper", pulled(np.sqrt(400.0 * 700.0)))
    assert life("smith-watson-topper", pulled(400.0, 300.0)) == pytest.approx(alike, rel=0.01)
    angle = np.linspace(0.0, np.pi / 2.0, 20001)
    shear, normal = 0.5 * 500.0 * np.sin(2.0 * angle), 500.0 * np.cos(angle) ** 2
    parameter = (shear / STEEL.shear_modulus_MPa * (1.0 + normal / STRENGTH)).max()
    terms = ((STRENGTH / 3.0**0.5 / STEEL.shear_modulus_MPa, B), (3.0**0.5 * DUCTILITY, C))
    expected = LifeCurve(terms).cycles(np.array([parameter]))[0]
    assert life("fatemi-socie", pulled(500.0)) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("criterion", [one for one in CRITERIA if one != "crossland"])
def test_a_cycle_that_goes_to_and_fro_twice_takes_twice_the_life(criterion: str) -> None:
    once, twice = life(criterion, pulled(500.0)), life(criterion, pulled(500.0, wave=np.cos(2.0 * TURN)))
    assert once == pytest.approx(2.0 * twice, rel=1e-6)


def test_lacking_data_are_named_estimated_ones_scatter_more_and_others_follow_from_fatigue_limits() -> None:
    with pytest.raises(StudyError, match=r"needs fatigue_strength_coefficient_MPa, .* --material"):
        criterion_of(LifeTable(), STEEL)
    estimated = LifeTable().of_material("steel")
    assert estimated.fatigue_strength_coefficient_MPa == pytest.approx(1.5 * 1960.0)
    assert estimated.scatter > LifeTable().scatter
    assert LifeTable(**OWN, material="Ti-6Al-4V").of_material("steel").fatigue_strength_exponent == B
    table = LifeTable(fatigue_limit_MPa=500.0, torsion_fatigue_limit_MPa=350.0, threshold_MPa_sqrt_m=8.0)
    assert 500.0 / 3.0**0.5 + table.slope * 500.0 / 3.0 == pytest.approx(350.0)
    assert table.distance_um == pytest.approx(1e6 * (8.0 / 1000.0) ** 2 / np.pi)


@pytest.mark.parametrize("plane", [True, False])
def test_an_average_over_what_of_a_ball_lies_in_the_body_is_that_of_its_centroid(plane: bool) -> None:
    places, weights = kernel_of(LifeTable(averaging_length_um=20.0), plane=plane)(0.0)
    assert weights.sum() == pytest.approx(1.0)
    # Of half a disc 4 R / 3 π beneath its edge, of half a ball 3 R / 8.
    assert weights @ places == pytest.approx([0.0, 0.0, 0.01 * (4.0 / (3.0 * np.pi) if plane else 3.0 / 8.0)], rel=0.01)
    deep = kernel_of(LifeTable(critical_distance_um=10.0, averaging="line"), plane=plane)(0.0)
    assert deep[1] @ deep[0] == pytest.approx([0.0, 0.0, 0.01])


LAMBDA_mm, RATE, SPEED = 5e-3, 2e-4, 1e-6  #: A rate that decays with depth, under a surface that wears evenly.


def worn_evenly(states: int, end: float, *, speed: float = SPEED) -> Damage:
    """A line contact that wears evenly: rates RATE exp(−d / LAMBDA_mm) below a surface that recedes at a speed."""
    depths = LAMBDA_mm * np.linspace(0.0, 8.0, 33)
    rates = tuple(
        Rates(round(cycle), np.log10(RATE * np.exp(-depths / LAMBDA_mm))[None])
        for cycle in np.geomspace(1.0, end, states)
    )
    on = [Ahead(1.0, rates[-1], np.array([speed]))]
    return Damage(depths, [Span(0.0, end, rates)], lambda cycle: np.array([speed * cycle]), on)


@pytest.mark.parametrize("states", [2, 4, 8])
def test_damage_is_carried_and_taken_away_as_the_closed_form_has_it(states: int) -> None:
    damage = worn_evenly(states, 20000.0)
    now = damage.at(5000.0)
    level = damage.levels_mm
    there = (level > now.worn_mm[0]) & (level < 4.0 * LAMBDA_mm)
    scale = RATE * LAMBDA_mm / SPEED
    exact = scale * (np.exp(-(level - SPEED * 5000.0) / LAMBDA_mm) - np.exp(-level / LAMBDA_mm))
    assert now.damage[0][there] == pytest.approx(exact[there], rel=0.02)
    # At the surface the sum comes to `scale` at most: what would break soon without wear never does.
    half, never = damage.initiations([0.5 * scale, 1.2 * scale])
    assert half is not None
    assert half.cycles == pytest.approx(LAMBDA_mm / SPEED * np.log(2.0), rel=0.02)
    assert never is None
    still = worn_evenly(states, 20000.0, speed=0.0).initiations([0.5 * scale])[0]
    assert still is not None
    assert still.cycles == pytest.approx(0.5 * scale / RATE, rel=1e-6)


def test_a_run_that_ends_too_early_is_gone_on_with_as_it_wears() -> None:
    scale = RATE * LAMBDA_mm / SPEED
    later, never = worn_evenly(3, 2000.0).initiations([0.5 * scale, 1.2 * scale])
    assert later is not None
    assert later.beyond
    assert later.cycles == pytest.approx(LAMBDA_mm / SPEED * np.log(2.0), rel=0.03)
    assert never is None


@pytest.mark.parametrize("speed", [1e-30, 1e-24, 1e-15])
def test_a_surface_that_recedes_by_round_off_is_gone_on_with_as_one_that_stays(speed: float) -> None:
    ends = [worn_evenly(3, 200.0, speed=each).initiations([0.5, 1e3]) for each in (speed, 0.0)]
    for found, expected in zip(*ends, strict=True):
        assert found is not None
        assert expected is not None
        assert found.cycles == pytest.approx(expected.cycles, rel=0.02)


def test_blocks_high_and_low_add_up_by_miner_whatever_their_order_until_wear_takes_one_away() -> None:
    depths = LAMBDA_mm * np.linspace(0.0, 8.0, 33)
    fade = -depths / LAMBDA_mm / np.log(10.0)
    high, low = (Rates(1, np.log10(rate) + fade[None]) for rate in (1e-3, 1e-4))

    def after(first: Rates, second: Rates, speed: float) -> float:
        spans = [Span(0.0, 500.0, (first,)), Span(500.0, 1000.0, (second,))]
        damage = Damage(depths, spans, lambda cycle: np.array([speed * cycle]))
        return float(damage.of_present(damage.at(1000.0)).max())

    assert after(high, low, 0.0) == pytest.approx(0.55)
    assert after(low, high, 0.0) == pytest.approx(0.55)
    # Of what the high block did first, wear takes the most away.
    assert after(high, low, 2e-5) < 0.7 * after(low, high, 2e-5)


DEPTHS_mm = LAMBDA_mm * np.linspace(0.0, 12.0, 97)


@dataclass(frozen=True)
class Asked:
    """A block of a programme: its length, the share of life that a cycle takes at the surface, what it wears."""

    cycles: int
    rate: float
    speed_mm: float = 0.0
    decay_mm: float = LAMBDA_mm

    @property
    def rates(self) -> Rates:
        return Rates(1, np.log10(self.rate) - DEPTHS_mm[None] / self.decay_mm / np.log(10.0))


def cycles_to_cracks_in_blocks(blocks: list[Asked], ran: int, sums: list[float]) -> list[float]:
    """Cycles until sums are reached when a run of so many cycles of a programme goes on with it."""
    schedule: Schedule[Any] = Schedule(
        tuple(CycleBlock(cycles=block.cycles, contact={"friction": 0.1 * k}) for k, block in enumerate(blocks, 1)),
        ran,
        cast("Any", "alone"),
        lambda values: cast("Any", values["contact"]["friction"]),
    )
    course = BlockCourse.of(schedule, ran)
    ends, depths = [0.0], [0.0]
    for one in course.done:
        ends.append(one.end)
        depths.append(depths[-1] + (one.end - one.start) * blocks[one.block].speed_mm)
    damage = Damage(
        DEPTHS_mm,
        [Span(one.start, one.end, (blocks[one.block].rates,)) for one in course.done],
        lambda cycle: np.array([np.interp(cycle, ends, depths)]),
        [
            Ahead(one.end - one.start, blocks[one.block].rates, np.array([blocks[one.block].speed_mm]))
            for one in course.ahead
        ],
    )
    return [np.inf if one is None else one.cycles for one in damage.initiations(sums)]


def miner(blocks: list[Asked], asked: float, most: int) -> float:
    """The first cycle at which the sum of any point that is still there reaches what is asked, cycle by cycle."""
    wears = any(block.speed_mm for block in blocks)
    points = (np.arange(0.0, 6.0, 0.002) if wears else np.zeros(1)) * LAMBDA_mm
    sums, worn, done = np.zeros_like(points), 0.0, 0
    while done < most and worn < points[-1] + 1e-12:
        for block in blocks:
            count = max(1, block.cycles // 40)
            for _ in range(block.cycles // count):
                worn += 0.5 * count * block.speed_mm
                below = points - worn
                taken = count * block.rate * np.exp(-np.maximum(below, 0.0) / block.decay_mm)
                sums += np.where(below >= 0.0, taken, 0.0)
                worn += 0.5 * count * block.speed_mm
                done += count
                if sums[points >= worn].max(initial=0.0) >= asked:
                    return done
    return np.inf


HIGH, LOW = Asked(2000, 4e-6), Asked(1000, 2e-7)
WORN_HIGH, WORN_LOW = Asked(400, 2e-5, 1e-6), Asked(400, 1e-6, 4e-6)


@pytest.mark.parametrize(
    ("blocks", "ran"),
    [
        ([HIGH, LOW], 6000),  # whole turns
        ([HIGH, LOW], 2300),  # ends inside a block of its first turn
        ([LOW, Asked(500, 1e-6), HIGH, Asked(70, 3e-5)], 11000),  # several blocks, ends inside one
        ([Asked(1, 1e-2), Asked(50, 1e-9)], 510),
        ([WORN_HIGH, WORN_LOW], 1600),
        ([WORN_HIGH, Asked(3000, 1e-7, 1e-8), Asked(100, 3e-5, 1e-7)], 5000),
        ([Asked(400, 2e-4, 0.0, 0.5 * LAMBDA_mm), Asked(400, 1e-6, 2e-6)], 500),  # what the first does wears off
    ],
)
def test_blocks_start_again_beyond_the_end_of_a_run(blocks: list[Asked], ran: int) -> None:
    """Miner's repetition of the blocks, cycle by cycle, and a bound beyond the run of a life within it."""
    sums = [0.02, 0.05, 0.15, 0.19, 1.0]
    for asked, found in zip(sums, cycles_to_cracks_in_blocks(blocks, ran, sums), strict=True):
        expected = miner(blocks, asked, 200_000)
        assert found == pytest.approx(expected, rel=0.01) or min(found, expected) > 190_000


def test_blocks_that_a_run_has_not_reached_are_named_and_left_out() -> None:
    study = line_study(programme=[{"cycles": 100}, {"cycles": 50, "contact": {"friction": 0.3}, "name": "dry"}])
    short, whole = BlockCourse.of(study.schedule, 80), BlockCourse.of(study.schedule, 120)
    assert short.not_reached == ("dry",)
    assert [one.end - one.start for one in short.ahead] == [20.0, 80.0]
    assert whole.not_reached == ()
    assert [(one.block, one.end - one.start) for one in whole.ahead] == [(1, 30.0), (0, 100.0), (1, 20.0)]


POINTS: dict[str, Any] = {
    "format": 1, "name": "short of data",
    "conditions": {"normal_load_N": 20.0, "displacement_amplitude_um": 30.0, "frequency_Hz": 1.0, "cycles": 2},
    "contact": {"friction": 0.5},
}  # fmt: skip
ELASTIC = {"youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3}
SHORT = {
    "wires": POINTS | {"kind": "crossed-wires", "wires": ELASTIC | {"diameter_mm": 1.0}},
    "ball": POINTS | {"kind": "ball-on-flat", "bodies": {"ball": ELASTIC | {"diameter_mm": 6.0}, "flat": ELASTIC}},
    "line": {name: table for name, table in TABLES.items() if name not in ("wear", "log")},
}


@pytest.mark.parametrize("contact", SHORT)
@pytest.mark.parametrize("body", ["both", "lower", "upper"])
@pytest.mark.parametrize(
    ("stated", "lacking"),
    [
        ({"criterion": "stress-life", "fatigue_strength_coefficient_MPa": 475.0}, "fatigue_strength_exponent"),
        ({"criterion": "crossland", "fatigue_strength_exponent": B}, "fatigue_strength_coefficient_MPa"),
        (
            {name: own for name, own in OWN.items() if name != "fatigue_ductility_exponent"},
            "fatigue_ductility_exponent",
        ),
        (OWN | {"criterion": "fatemi-socie", "fatemi_socie_factor": 0.6}, "yield_strength_MPa"),
        (OWN | {"criterion": "crossland", "torsion_fatigue_limit_MPa": 300.0}, "fatigue_limit_MPa"),
        (OWN | {"threshold_MPa_sqrt_m": 6.0}, "fatigue_limit_MPa"),
        (OWN | {"averaging": "line"}, "critical_distance_um"),
    ],
)
def test_a_life_that_lacks_data_says_so_before_the_run(
    contact: str, body: str, stated: dict[str, Any], lacking: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("wirewear.simulation.run_study", lambda *_, **__: pytest.fail("it is run first"))
    Path("study.toml").write_text(toml_text(SHORT[contact] | {"life": stated}), encoding="utf-8")
    assert f" needs {lacking}: state" in wirewear("life", "study.toml", "--body", body, code=2).output


@pytest.mark.parametrize("log", [{"contact_states": 0}, {"loop_cycles": [1, 100]}])
def test_a_life_that_lacks_recorded_stresses_of_a_block_says_so_before_the_run(log: dict[str, Any]) -> None:
    blocks = [{"cycles": 100}, {"cycles": 50, "contact": {"friction": 0.3}, "name": "dry"}, {"cycles": 100}]
    study = line_study(programme=blocks, conditions={"cycles": 250}, log={"loop_cycles": [1, 250]} | log, life=OWN)
    with pytest.raises(ResultError, match=r"of (block 1 and )?dry, and there are none"):
        require_life(study, study.body_names, {})
    require_life(line_study(programme=blocks, conditions={"cycles": 250}, log=None), ("pad",), OWN)
