"""Fair sizes of gaps: what is left of them beside the best imitation."""

from dataclasses import replace

import pytest

from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.independent import fair_size as fair_size_module
from studies.blind.generators.independent.fair_size import fair_size
from studies.blind.generators.independent.friction import LAWS
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import Nuisances, Scatter
from studies.blind.generators.waveform import Waveform

MODEL = IndependentModel("dahl", points=24, library=("tangential_compliance", "friction_offset"))

NUISANCES = Nuisances(
    repeats=1,
    scatter=Scatter(0.01, 0.005, 0.04, 0.3),
    displacement_noise_um=0.15,
    force_noise_N=0.008,
    correlation=0.0,
    outlier_share=0.0,
    waveform=Waveform(0.0, 0.0),
    amplitude_drift=0.0,
    drive="stroke",
    samples=200,
    has_normal_force=True,
    has_evolution=True,
    has_scars=True,
    loop_cycles=((100, 20_000),),
    evolution_cycles=(100, 20_000),
)


def case(kind: str, *effects: TrueEffect, left_out: tuple[str, ...] = ()) -> Case:
    return Case("a case", kind, "easy", effects, left_out, Nominal(cycles=20_000), NUISANCES, 1)


SPRING = TrueEffect("tangential_compliance", {"stiffness_N_per_mm": 300.0})
SLIPPERY = TrueEffect("friction_offset", {"friction": 0.55})
SATURATED = TrueEffect("saturating_force_cell", {"loss_at_plateau": 0.1})


def test_without_an_effect_there_is_no_gap() -> None:
    assert fair_size(case("none"), MODEL) == 0.0


@pytest.mark.slow
def test_what_a_known_effect_makes_alone_is_imitated_by_it() -> None:
    whole = fair_size(case("single", SPRING), MODEL)
    imitated = fair_size(case("pair", SPRING), MODEL)
    assert imitated < 1e-3
    assert whole > 100.0


@pytest.mark.slow
def test_an_effect_that_may_not_be_named_imitates_nothing() -> None:
    allowed = fair_size(case("left_out", SPRING), MODEL)
    barred = fair_size(case("left_out", SPRING, left_out=("tangential_compliance",)), MODEL)
    assert allowed < 1e-3
    assert barred > 100.0


@pytest.mark.slow
def test_a_pair_is_larger_than_what_one_of_it_leaves_and_smaller_than_both() -> None:
    pair = fair_size(case("pair", SPRING, SLIPPERY), MODEL)
    both = fair_size(case("single", SPRING, SLIPPERY), MODEL)
    assert 1.0 < pair < both


@pytest.mark.slow
def test_a_saturating_force_cell_is_imitated_in_part_by_less_friction() -> None:
    seen = fair_size(case("single", SATURATED), MODEL)
    left = fair_size(case("outside", SATURATED), MODEL)
    assert 1.0 < left < 0.9 * seen


@pytest.mark.slow
def test_what_moves_the_force_as_its_zero_does_is_no_larger_than_a_zero_may_be() -> None:
    """A crosstalk of 0.4 % of the load: less than one force zero of 1 % of 0.7 times the load."""
    crossed = TrueEffect("force_crosstalk", {"coefficient": 0.004})
    assert fair_size(case("single", crossed), MODEL) < 1.5


@pytest.mark.slow
def test_how_friction_is_mobilised_is_no_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stiff spring stands out less where the law of friction is not known: both act just after a reversal."""
    stiff = case("single", TrueEffect("tangential_compliance", {"stiffness_N_per_mm": 3000.0}))
    unsure = fair_size(stiff, MODEL)
    fair_size_module._by_other_laws.cache_clear()
    monkeypatch.setattr(fair_size_module, "LAWS", {MODEL.law: LAWS[MODEL.law]})
    sure = fair_size(stiff, MODEL)
    fair_size_module._by_other_laws.cache_clear()
    assert 1.0 < unsure < 0.8 * sure


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_a_gap_is_smaller_under_more_noise(share: float) -> None:
    noisier = replace(
        NUISANCES,
        displacement_noise_um=share * NUISANCES.displacement_noise_um,
        force_noise_N=share * NUISANCES.force_noise_N,
    )
    own = fair_size(case("single", SPRING), MODEL)
    other = fair_size(replace(case("single", SPRING), nuisances=noisier), MODEL)
    assert (other < own) == (share > 1.0)
