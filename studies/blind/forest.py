"""A baseline that knows no mechanics: a random forest on features of records, trained on a batch that is spent.

    python -m studies.blind.forest TRAINING_RECORDS RECORDS DIAGNOSES

Train on development batches only. Answers go to DIAGNOSES/baselines/random_forest, where scoring finds them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np
from numpy.typing import ArrayLike, NDArray

from studies.blind import Truth, default_key_path, verified
from studies.blind.errors import BlindError
from studies.blind.generators.cases import exact_class
from wirewear import ExperimentRecord, read_record
from wirewear.base.reading import read_json
from wirewear.faces.study_script import StudyScript, understanding

from .answering import DIAGNOSIS, write_json

if TYPE_CHECKING:
    from sklearn.ensemble import RandomForestClassifier

Array = NDArray[np.float64]

#: Stands for what a record does not have; far from every feature.
MISSING = -100.0
PHASES, LOAD_PHASES, TREES = 32, 8, 200


def features(record: ExperimentRecord) -> Array:
    """Loops of the first, the middle and the last logged cycle, loads and scars, each over what is stated (n,)."""
    conditions, stated = record.tables.conditions, record.tables.stated
    plateau = float(stated.friction or 1.0) * conditions.normal_load_N
    cycles = sorted({loop.cycle for loop in record.loops})
    stiffness = stated.tangential_stiffness_N_per_mm
    lost = plateau / stiffness if isinstance(stiffness, float | int) else 0.0
    parts: list[ArrayLike] = [[lost, float(conditions.drive == "sensor")]]
    for cycle in (cycles[0], cycles[len(cycles) // 2], cycles[-1]):
        loops = [loop for loop in record.loops if loop.cycle == cycle]
        parts.append([np.ptp(loop.displacement_um) / conditions.displacement_amplitude_um for loop in loops[:1]])
        parts.append(_mean_over_phases([loop.tangential_force_N / plateau for loop in loops], PHASES))
        loads = [loop.normal_force_N / conditions.normal_load_N for loop in loops if loop.normal_force_N is not None]
        parts.append(_mean_over_phases(loads, LOAD_PHASES))
    energy_J = 4e-6 * plateau * conditions.displacement_amplitude_um * conditions.cycles
    expected = 0.5 * float(stated.energy_wear_coefficient_mm3_per_J or 1.0) * energy_J
    for wire in ("moving", "fixed"):
        scars = record.scars_of(wire)
        moments = [_moments(scar.x_um, scar.y_um, np.nan_to_num(scar.depth_um)) for scar in scars]
        volume = [scar.volume_mm3 / expected for scar in scars]
        parts.append([float(np.mean(volume)), *np.mean(moments, axis=0)] if scars else [MISSING] * 4)
    return np.concatenate([np.asarray(part, dtype=float) for part in parts])


def _mean_over_phases(channels: Sequence[Array], phases: int) -> Array:
    if not channels:
        return np.full(phases, MISSING)
    at = np.arange(phases) / phases
    return np.asarray(np.mean([np.interp(at, np.arange(c.size) / c.size, c, period=1.0) for c in channels], axis=0))


def _moments(x_um: Array, y_um: Array, depth_um: Array) -> list[float]:
    """Largest depth, and skew and roundness of a scar."""
    weight = np.maximum(depth_um, 0.0)
    total = max(float(weight.sum()), 1e-9)
    x2, y2 = float(x_um**2 @ weight.sum(axis=1)) / total, float(y_um**2 @ weight.sum(axis=0)) / total
    return [float(depth_um.max()), float(x_um @ weight @ y_um) / total / np.sqrt(x2 * y2), x2 / y2]


def label(truth: Truth) -> str:
    """What the forest is to say; of a pair, the first effect; an effect that was left out is still there to be seen."""
    name = "outside_library" if truth.kind == "outside" else (truth.effects or ("none",))[0]
    return min(exact_class(name))


def trained(records: Path, truths: Sequence[Truth]) -> RandomForestClassifier:
    """A forest that has seen every record of a batch."""
    from sklearn.ensemble import RandomForestClassifier

    seen = np.array([features(read_record(records / truth.case)) for truth in truths])
    return RandomForestClassifier(TREES, random_state=0, min_samples_leaf=2).fit(seen, [label(t) for t in truths])


def said(forest: RandomForestClassifier, record: ExperimentRecord, left_out: Sequence[str]) -> dict[str, Any]:
    """The forest's answer as a diagnosis; effects that are left out count as outside the library."""
    mass: dict[str, float] = {}
    for name, probability in zip(forest.classes_, forest.predict_proba(features(record)[None])[0], strict=True):
        own = "outside_library" if name in left_out else str(name)
        mass[own] = mass.get(own, 0.0) + float(probability)
    first = max(mass, key=lambda name: mass[name])
    verdict = {"none": "no_gap", "outside_library": "unexplained"}.get(first, "explained")
    causes = [{"effect": name, "probability": mass[name]} for name in sorted(mass, key=lambda name: -mass[name])]
    return {"format": 1, "verdict": verdict, "causes": causes}


@click.command(cls=StudyScript)
@click.argument("training", type=click.Path(path_type=Path))
@click.argument("records", type=click.Path(path_type=Path))
@click.argument("diagnoses", type=click.Path(path_type=Path))
def main(training: Path, records: Path, diagnoses: Path) -> None:
    """Train on the batch TRAINING, whose key lies beside it, and answer every record of RECORDS."""
    batch = verified(training, default_key_path(training))
    manifest, truths = batch.manifest, batch.truths
    path = records / "manifest.json"
    listed = read_json(path, BlindError, "manifest")
    with understanding(path, "manifest of a blind batch"):
        left_out = {name: tuple(case["left_out"]) for name, case in listed["cases"].items()}
    forest = trained(training, truths)
    for name, own in left_out.items():
        answer = said(forest, read_record(records / name), own)
        write_json(diagnoses / "baselines" / "random_forest" / name / DIAGNOSIS, answer)
    click.echo(f"trained on {len(truths)} records of {manifest['model']}; {len(left_out)} answered")


if __name__ == "__main__":
    main()
