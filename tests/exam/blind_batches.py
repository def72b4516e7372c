"""A forward model that takes no time, what a batch of it holds; truths of the blind check, and answers to them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from studies.blind.generators.cases import Case, planned_cases
from studies.blind.generators.files import record_hash, record_tables, scar_lines_um
from studies.blind.generators.generator import LIBRARY_EFFECTS, MadeRecord
from studies.blind.generators.nominal import Nominal, drawn_nominals
from studies.blind.generators.sampling import logged_loop, loop_figures
from studies.blind.scoring.answers import Answer, NamedCause
from studies.blind.scoring.figures import batch_figures
from studies.blind.scoring.judging import Truth
from studies.blind.scoring.score import judge_all
from studies.blind.sealing import opened, read_key_file
from wirewear.records import ExperimentRecord, MeasuredEvolution, MeasuredScar


@dataclass(frozen=True)
class PlainModel:
    """Parallelograms whose height, and bowls whose depth, depend strongly on the effect."""

    tier: str = "T2"
    description: str = "parallelograms"
    library: Sequence[str] = LIBRARY_EFFECTS
    outside: Sequence[str] = ("clamp_slip", "bent_guide")

    def nominals(self, number: int, random: np.random.Generator) -> tuple[Nominal, ...]:
        return drawn_nominals(number, random)

    def make(self, case: Case) -> MadeRecord:
        random = np.random.default_rng(case.seed)
        nuisances, nominal = case.nuisances, case.nominal
        factor = 1.0 + sum(0.03 * (1 + sorted((*self.library, *self.outside)).index(e.effect)) for e in case.effects)
        loops, evolution, scars = [], [], []
        for repeat in range(1, nuisances.repeats + 1):
            for cycle in nuisances.loop_cycles[repeat - 1]:
                phase = 2.0 * np.pi * np.arange(256) / 256
                force = np.clip(6.0 * np.cos(phase), -1.0, 1.0) * factor * nominal.friction * nominal.load_N
                channels = nominal.amplitude_um * np.sin(phase), force, np.full(256, nominal.load_N)
                loops.append(logged_loop(repeat, cycle, nominal.frequency_Hz, channels, nuisances, random))
            if nuisances.has_evolution:
                last = loop_figures(loops[-1].displacement_um, loops[-1].tangential_force_N)
                cycles = np.array(nuisances.evolution_cycles, dtype=float)
                columns = {"cycle": cycles, **{name: np.full(cycles.size, value) for name, value in last.items()}}
                evolution.append(MeasuredEvolution(repeat, columns))
            if nuisances.has_scars:
                for wire in ("moving", "fixed"):
                    x, y = scar_lines_um(nominal, wire)
                    bowl = np.maximum(9.0 * factor - np.add.outer((x / 25.0) ** 2, (y / 25.0) ** 2), 0.0)
                    bowl = bowl + 0.05 * random.standard_normal(bowl.shape)
                    scars.append(MeasuredScar(repeat, wire, x, y, bowl))
        record = ExperimentRecord(record_tables(case), tuple(loops), tuple(evolution), tuple(scars))
        return MadeRecord(record, nuisances, {"height": 10.0 * (factor - 1.0)})


def truth_in(folder: Path) -> dict[str, Any]:
    """What the key of a batch says."""
    key = read_key_file(folder.with_name(f"{folder.name}.key"))
    truth: dict[str, Any] = opened((folder / "key.json.enc").read_bytes(), key, "the key")
    return truth


def contents(folder: Path) -> dict[str, str]:
    """The hash of each record."""
    return {path.name: record_hash(path) for path in sorted(folder.iterdir()) if path.is_dir()}


def truths_of(number: int, seed: int = 1) -> tuple[Truth, ...]:
    """Truths of a plan, the gap's size following the ease."""
    random = np.random.default_rng(seed)
    return tuple(
        Truth(
            case=case.name,
            kind=case.kind,
            ease=case.ease,
            effects=tuple(effect.effect for effect in case.effects),
            parameters={effect.effect: effect.parameters for effect in case.effects},
            gap_in_scatter=0.0 if case.ease is None else float(random.uniform(*((1, 6), (6, 40))[case.ease == "easy"])),
        )
        for case in planned_cases(number, seed, LIBRARY_EFFECTS, PlainModel().outside)
    )


def a_truth(kind: str, effect: str | None = None) -> Truth:
    return Truth("case_001", kind, None if effect is None else "easy", (effect,) if effect else (), {}, 9.0)


def answer(
    verdict: str,
    causes: Mapping[str, float] | None = None,
    *,
    joint: bool = False,
    equivalent: Sequence[frozenset[str]] = (),
    intervals: Mapping[str, Mapping[str, tuple[float, float]]] | None = None,
    shrink: float | None = None,
    predicted: float | None = None,
) -> Answer:
    named = tuple(
        NamedCause(effect, probability, (intervals or {}).get(effect, {}), joint)
        for effect, probability in (causes or {}).items()
    )
    return Answer(verdict, named, tuple(equivalent), frozenset(), shrink, predicted, None)


def perfect(truth: Truth) -> Answer:
    if truth.kind == "none":
        return answer("no_gap", {"none": 1.0})
    if truth.is_open:
        return answer("unexplained", {"outside_library": 1.0})
    if truth.kind == "left_out":
        return answer("explained", dict.fromkeys(truth.hypotheses, 1.0))
    intervals = {e: {n: (v - 1.0, v + 1.0) for n, v in truth.parameters[e].items()} for e in truth.effects}
    causes = dict.fromkeys(truth.effects, 1.0)
    joint = truth.kind == "pair"
    return answer("explained", causes, joint=joint, intervals=intervals, shrink=0.95, predicted=0.97)


def figures(truths: Sequence[Truth], answers: Mapping[str, Answer | None]) -> dict[str, Any]:
    return batch_figures(judge_all(truths, answers), {})
