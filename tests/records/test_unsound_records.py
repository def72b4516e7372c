"""What `check` knows, `diagnose`, `compare` and `export` know: nothing is concluded from what cannot be, or it is said.

On version 8318817 each of these records was "no gap" without a word.
"""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from tests.diagnosis.diagnosis_cases import diagnosed
from tests.exam.independent_records import independent_record
from tests.synthetic_results import result
from wirewear import RecordError, RunResult, check_record, load_study, read_record
from wirewear.comparison.comparison import compare
from wirewear.diagnosis import diagnose
from wirewear.records import ExperimentRecord, MeasuredLoop
from wirewear.records.checking import problems_of

STEEL_WIRES = Path(__file__).parents[2] / "studies" / "steel_wires"
EXAMPLE = STEEL_WIRES / "example_records" / "no_gap"
STUDY = load_study(STEEL_WIRES / "study.toml")
Change = Callable[[ExperimentRecord], ExperimentRecord]


@pytest.fixture(scope="module")
def sound() -> ExperimentRecord:
    return read_record(EXAMPLE)


def depths(changed: Callable[[Array], Array]) -> Change:
    return lambda record: replace(
        record, scars=tuple(replace(scar, depth_um=changed(scar.depth_um)) for scar in record.scars)
    )


def loops(**factors: float) -> Change:
    def changed(record: ExperimentRecord) -> ExperimentRecord:
        return replace(
            record,
            loops=tuple(
                replace(loop, **{name: factor * getattr(loop, name) for name, factor in factors.items()})
                for loop in record.loops
            ),
        )

    return changed


def run() -> RunResult:
    """Figures made up for the steel wires' test."""
    return replace(result(), study=STUDY.variant("compliant").resolved())


REFUSED = [
    pytest.param(depths(lambda d: d + 1e4), "more than the smallest diameter of 450 µm", id="too deep"),
    pytest.param(depths(lambda d: d - 1e4), "their sign seems wrong", id="all negative"),
    pytest.param(loops(tangential_force_N=-1.0), "as if its sign were wrong, in 12 of 12 loops", id="turned force"),
    pytest.param(loops(tangential_force_N=1e200), "which no dry friction gives", id="squares beyond any number"),
]


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize(("change", "words"), REFUSED)
def test_a_record_that_cannot_be_is_refused_with_a_cause(sound: ExperimentRecord, change: Change, words: str) -> None:
    assert json.loads(json.dumps(check_record(change(sound)).to_json()))["remarks"]
    for conclude in (problems_of, diagnose, lambda record: compare(run(), record)):
        with pytest.raises(
            RecordError, match=r"nothing can be concluded from the record 'no_gap \(simulated\)': "
        ) as refused:
            conclude(change(sound))
        assert words in str(refused.value)
        assert str(refused.value).count(". ") == 0


def rolled(samples: int) -> Change:
    return lambda record: replace(
        record,
        loops=tuple(
            replace(loop, tangential_force_N=np.roll(loop.tangential_force_N, samples)) for loop in record.loops
        ),
    )


def drifting(record: ExperimentRecord) -> ExperimentRecord:
    """By 5 % of the stroke within each cycle."""
    rate = 0.1 * record.tables.conditions.displacement_amplitude_um * record.tables.conditions.frequency_Hz
    moved = (replace(loop, displacement_um=loop.displacement_um + rate * loop.time_s) for loop in record.loops)
    return replace(record, loops=tuple(moved))


def viscous(record: ExperimentRecord) -> ExperimentRecord:
    random = np.random.default_rng(4)

    def changed(loop: MeasuredLoop) -> MeasuredLoop:
        phase = 2.0 * np.pi * record.tables.conditions.frequency_Hz * loop.time_s
        x, q = 60.0 * np.sin(phase), 1.2 * np.cos(phase)
        return loop.read_as(replace(loop.signals(), displacement_um=x + random.normal(0.0, 0.1, x.size),
                                    tangential_force_N=q + random.normal(0.0, 0.005, q.size)))  # fmt: skip

    return replace(record, loops=tuple(changed(loop) for loop in record.loops))


NAMED = [
    pytest.param(rolled(3), r"In 12 of 12 analysed loops the force comes 3\.\d samples late", id="late force"),
    pytest.param(rolled(-3), "In 12 of 12 analysed loops the force begins to fall .* before", id="late displacement"),
    pytest.param(drifting, r"In 12 of 12 .* the displacement .* (4\.\d|5\.\d)% of its stroke", id="drift"),
    pytest.param(viscous, "In 12 of 12 analysed loops the loop is an ellipse without a plateau", id="viscous"),
]


@pytest.mark.parametrize(("change", "words"), NAMED)
def test_check_names_what_the_channels_of_its_loops_do(sound: ExperimentRecord, change: Change, words: str) -> None:
    texts = [remark.text for remark in check_record(change(sound)).remarks]
    assert any(re.search(words, text) for text in texts), texts
    assert not any(text.startswith("In ") for text in (remark.text for remark in check_record(sound).remarks))


@pytest.mark.slow
def test_a_record_in_which_nothing_is_worn_where_wear_is_expected_is_a_gap() -> None:
    """On version 8318817 depths of zero were left out, and this was "no gap"."""
    unworn = depths(lambda d: 0.0 * d)(independent_record(scars=True))
    assert diagnosed(unworn).diagnosis.verdict != "no_gap"


def _driven(samples: int, dense_at_turns: bool, noise_um: float) -> list[MeasuredLoop]:
    """Loops of a sine of 60 µm read at even times, or at times that stand close where it turns."""
    random, loops = np.random.default_rng(3), []
    for cycle in (1, 10, 100, 1000, 10_000):
        phase = np.arange(samples) / samples
        if dense_at_turns:
            # As a simulation's increments: few over the stroke, many of unlike sizes behind the turns.
            behind = 0.25 + 0.1 * np.linspace(0.0, 1.0, samples // 2 - 10) ** 2
            half = np.concatenate([np.linspace(-0.15, 0.25, 10, endpoint=False), behind]) + 0.15
            phase = np.concatenate([half, half + 0.5])
        x = 60.0 * np.sin(2.0 * np.pi * phase)
        q = 1.24 * np.tanh(20.0 * np.cos(2.0 * np.pi * phase))
        x, q = (v + s * random.standard_normal(samples) for v, s in ((x, noise_um), (q, noise_um / 20.0)))
        loops.append(MeasuredLoop(1, cycle, phase / 3.0, x, q, None))
    return loops


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("stated", [0.0, 0.15])
@pytest.mark.parametrize(("samples", "dense_at_turns"), [(92, True), (128, False), (256, False)])
def test_noise_that_is_as_stated_draws_no_remark(
    sound: ExperimentRecord, samples: int, dense_at_turns: bool, stated: float
) -> None:
    noise = sound.tables.noise.model_copy(update={"displacement_um": stated, "tangential_force_N": stated / 20.0})
    tables = sound.tables.model_copy(update={"noise": noise})
    record = replace(sound, tables=tables, loops=tuple(_driven(samples, dense_at_turns, stated)))
    assert [remark.text for remark in check_record(record).remarks if remark.topic == "noise"] == []
    louder = replace(record, loops=tuple(_driven(samples, dense_at_turns, 3.0 * stated + 0.3)))
    texts = [remark.text for remark in check_record(louder).remarks if remark.topic == "noise"]
    assert len(texts) == 2
    assert all("but stated as" in text for text in texts)


def stepped(step_N: float) -> Change:
    def changed(record: ExperimentRecord) -> ExperimentRecord:
        read = [
            replace(loop, tangential_force_N=step_N * np.round(loop.tangential_force_N / step_N))
            for loop in record.loops
        ]
        return replace(record, loops=tuple(read))

    return changed


@pytest.mark.seconds
def test_a_force_of_coarse_steps_is_noted_with_its_step(sound: ExperimentRecord) -> None:
    (text,) = (one.text for one in check_record(stepped(0.1)(sound)).remarks if one.topic == "resolution")
    assert text.startswith("The tangential force is read in steps of 0.1 N, ")
    assert f"{len(sound.loops)} of {len(sound.loops)} loops" in text
