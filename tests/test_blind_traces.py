"""A blind record's files tell nothing of its effect: not by size, name, time, width or rounding."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from studies.blind import make_batch
from studies.blind.generators.cases import Case, TrueEffect, planned_cases
from studies.blind.generators.files import record_hash, write_traceless
from studies.blind.generators.generator import Generator
from studies.blind.generators.independent.fair_size import fair_size
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import Nuisances, Scatter
from studies.blind.generators.waveform import Waveform
from tests.blind_batches import PlainModel, truth_in

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

SPRING = TrueEffect("tangential_compliance", {"stiffness_N_per_mm": 300.0})
SLIPPERY = TrueEffect("friction_offset", {"friction": 0.55})


LAST_DIGITS = slice(9, None, 7)

#: By chance a batch lies above this once in some thousands (Student's distribution, 19 degrees of freedom).
CHANCE = 4.0


def case(kind: str, *effects: TrueEffect, left_out: tuple[str, ...] = ()) -> Case:
    return Case("a case", kind, "easy", effects, left_out, Nominal(cycles=20_000), NUISANCES, 1)


@pytest.mark.slow
def test_what_a_known_effect_makes_alone_is_imitated_by_it() -> None:
    whole = fair_size(case("single", SPRING), MODEL)
    imitated = fair_size(case("pair", SPRING), MODEL)
    assert imitated < 1e-3
    assert whole > 100.0


@pytest.mark.slow
def test_a_pair_is_larger_than_what_one_of_it_leaves_and_smaller_than_both() -> None:
    pair = fair_size(case("pair", SPRING, SLIPPERY), MODEL)
    both = fair_size(case("single", SPRING, SLIPPERY), MODEL)
    assert 1.0 < pair < both


@pytest.mark.first_case
@pytest.mark.seconds
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


@pytest.fixture(scope="module")
def large_batch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Enough records for a forest to learn from."""
    folder = tmp_path_factory.mktemp("blind") / "large"
    make_batch(folder, cases=150, seed=5, generator=PlainModel())
    return folder


def metadata(folder: Path) -> list[float]:
    """All that can be seen of a record without looking at what was measured."""
    features: list[float] = [len(folder.name), int(folder.name.split("_")[1]), folder.stat().st_mtime]
    for name in ("experiment.toml", "loops.csv", "evolution.csv", "scar_moving.csv", "scar_fixed.csv"):
        path = folder / name
        if not path.exists():
            features += [0.0] * 7
            continue
        lines = path.read_text(encoding="utf-8").splitlines()
        fields = [field for line in lines[1:200] for field in line.split(",")]
        decimals = [len(field.partition(".")[2]) for field in fields]
        last_digits = [int(field[-1]) for field in fields if field[-1:].isdigit()]
        size, times = path.stat().st_size, path.stat().st_mtime
        features += [size, size / len(lines), times, len(lines), float(np.mean(decimals)), max(map(len, lines))]
        features.append(float(np.mean(np.array(last_digits) % 5 == 0)))
    return features


@pytest.mark.parametrize(
    "model",
    [PlainModel(), pytest.param(IndependentModel(points=6), marks=pytest.mark.slow)],
    ids=["plain", "independent"],
)
def test_files_have_the_same_sizes_names_times_and_widths_with_a_strong_effect_as_without_one(
    model: Generator, tmp_path: Path
) -> None:
    case = planned_cases(4, 1, model.library, model.outside)[0]
    strong = (TrueEffect("friction_offset", {"friction": 1.5 * case.nominal.friction}),)
    for name, effects in (("without", ()), ("with", strong)):
        write_traceless(tmp_path / name / case.name, model.make(replace(case, effects=effects)).record)
    without, with_effect = (np.array(metadata(tmp_path / name / case.name)) for name in ("without", "with"))
    assert record_hash(tmp_path / "without" / case.name) != record_hash(tmp_path / "with" / case.name)
    without[LAST_DIGITS] = with_effect[LAST_DIGITS] = 0.0
    assert without.tolist() == with_effect.tolist()


def deviations_from_chance(seen: "np.ndarray[Any, Any]", label: "np.ndarray[Any, Any]") -> float:
    """How far a random forest's area under the ROC lies above that for shuffled labels, over their scatter."""
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.metrics import roc_auc_score

    random = np.random.default_rng(0)
    areas = []
    for labels in (label, *(random.permutation(label) for _ in range(20))):
        forest = RandomForestClassifier(60, random_state=0, min_samples_leaf=3, oob_score=True).fit(seen, labels)
        areas.append(roc_auc_score(labels, forest.oob_decision_function_[:, 1]))
    return float((areas[0] - np.mean(areas[1:])) / np.std(areas[1:], ddof=1))


@pytest.mark.slow
def test_a_random_forest_learns_nothing_from_sizes_names_times_and_rounding(large_batch: Path) -> None:
    truths = truth_in(large_batch)["truths"]
    seen = np.array([metadata(large_batch / truth["case"]) for truth in truths])
    labels = {
        "whether there is an effect": np.array([bool(truth["effects"]) for truth in truths]),
        "whether it is easy": np.array([truth["ease"] == "easy" for truth in truths]),
        "whether it is in the sensors": np.array(
            [any("displacement" in e["effect"] or "force" in e["effect"] for e in t["effects"]) for t in truths]
        ),
    }
    for what, label in labels.items():
        assert deviations_from_chance(seen, label) < CHANCE, what


@pytest.mark.slow
def test_the_same_forest_sees_a_trace_where_there_is_one(large_batch: Path) -> None:
    truths = truth_in(large_batch)["truths"]
    label = np.array([bool(truth["effects"]) for truth in truths])
    seen = np.array([metadata(large_batch / truth["case"]) for truth in truths])
    # As if one number in fifty of the loops had one digit more in records with an effect.
    decimals = 3 + 7 + 4
    seen[:, decimals] += 0.02 * label
    assert deviations_from_chance(seen, label) > CHANCE
