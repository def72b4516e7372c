"""Random studies within stated physical ranges: how many run to their end, and how the others fail.

Usage: random_studies.py [--count 120] [--seed 1] [--output runs/random_studies]

Every study is drawn from the seed, so that a failing one can be repeated: `--only 17` runs the 17th alone. Studies that
are done already (their line stands in results.jsonl) are not run again.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from wirewear import WirewearError, parse_study, reference, run_study

#: Ranges the studies are drawn from; lengths and stiffnesses on a logarithmic scale.
DIAMETER_mm = (0.2, 2.0)
LOAD_N = (0.5, 20.0)
FRICTION = (0.05, 1.2)
STROKE_PER_THRESHOLD = 0.3
MOST_STROKE_PER_RADIUS = 10.0
#: Major semi-axis of the fresh contact over the thinner wire's diameter.
LARGEST_CONTACT = 0.15
LEAST_AMPLITUDE_mm = 1e-4
ANGLE_deg = (30.0, 90.0)
RIG_N_per_mm = (10.0, 3e4)
RIGID_SHARE = 0.25
CYCLES = 300


def draw(seed: int, index: int) -> str:
    """The TOML of one random study."""
    random = np.random.default_rng([seed, index])

    def log_uniform(low: float, high: float) -> float:
        return float(np.exp(random.uniform(math.log(low), math.log(high))))

    diameters = [log_uniform(*DIAMETER_mm) for _ in range(2)]
    if random.random() < 0.5:
        diameters[1] = diameters[0]
    # Very unequal wires are not what a crossed-wire test uses.
    diameters[1] = min(max(diameters[1], diameters[0] / 2.5), diameters[0] * 2.5)
    load, friction = log_uniform(*LOAD_N), float(random.uniform(*FRICTION))
    angle = float(random.uniform(*ANGLE_deg))
    rigid = random.random() < RIGID_SHARE
    stiffness = log_uniform(*RIG_N_per_mm)
    steel = reference.Elastic(210000.0, 0.3)
    hertz = reference.hertz_crossed_cylinders(
        load, diameters[0] / 2.0, diameters[1] / 2.0, angle, first=steel, second=steel
    )
    # Hertz's contact must be small against the wires for the study to make sense: the load is lowered where it is not.
    room = LARGEST_CONTACT * min(diameters) / hertz.major_semi_axis_mm
    if room < 1.0:
        load *= room**3
        hertz = reference.hertz_crossed_cylinders(
            load, diameters[0] / 2.0, diameters[1] / 2.0, angle, first=steel, second=steel
        )
    tangential = reference.mindlin_stiffness(
        reference.tangential_contact_modulus(steel, steel), hertz.contact_radius_mm
    )
    threshold = 1.5 * friction * load / tangential + (0.0 if rigid else friction * load / stiffness)
    longest = max(MOST_STROKE_PER_RADIUS * hertz.contact_radius_mm, 1.2 * threshold)
    amplitude = min(log_uniform(STROKE_PER_THRESHOLD * threshold, longest), 0.9 * min(diameters))
    amplitude = max(amplitude, LEAST_AMPLITUDE_mm)
    # Wear that would deepen the fresh contact by about its own approach over the test.
    energy_J = 4e-3 * friction * load * amplitude * CYCLES
    volume = math.pi * hertz.contact_radius_mm**2 * hertz.approach_mm
    coefficient = min(volume / energy_J, 9e-3)
    return f"""
format = 1
name = "random study {index} of seed {seed}"
kind = "crossed-wires"
[wires]
diameter_mm = {diameters[0]!r}
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
crossing_angle_deg = {angle!r}
[wires.fixed]
diameter_mm = {diameters[1]!r}
[conditions]
normal_load_N = {load!r}
displacement_amplitude_um = {1e3 * amplitude!r}
frequency_Hz = 1.0
cycles = {CYCLES}
[contact]
friction = {friction!r}
[wear]
energy_wear_coefficient_mm3_per_J = {coefficient!r}
[holder]
tangential_stiffness_N_per_mm = {'"rigid"' if rigid else repr(stiffness)}
[log]
loop_cycles = [1, {CYCLES}]
"""


def run_one(seed: int, index: int, folder: Path) -> dict[str, object]:
    """Run one study and say how it ended."""
    started = time.perf_counter()
    row: dict[str, object] = {"seed": seed, "index": index}
    try:
        study = parse_study(draw(seed, index), f"random study {index}")
        (result,) = run_study(study, fidelity="quick", output=folder / f"{seed}-{index}")
        row |= {"ended": "complete", "message": "", "quality": dict(result.quality)}
        row["mean_iterations"] = result.settings["mean_iterations_per_increment"]
    except WirewearError as error:
        row |= {"ended": "refused", "message": str(error)}
    except Exception as error:  # noqa: BLE001 - any other end is what this script is there to find
        row |= {"ended": type(error).__name__, "message": str(error)}
    row["seconds"] = round(time.perf_counter() - started, 1)
    return row


def done_before(path: Path) -> Iterator[dict[str, object]]:
    """Rows of an earlier, interrupted run."""
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            yield json.loads(line)


def main() -> None:
    """Run them all and print how they ended."""
    parser = argparse.ArgumentParser(description="random studies within stated physical ranges")
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    parser.add_argument("--output", type=Path, default=Path("runs/random_studies"))
    asked = parser.parse_args()
    asked.output.mkdir(parents=True, exist_ok=True)
    table = asked.output / "results.jsonl"
    known = {(row["seed"], row["index"]): row for row in done_before(table)}
    rows = []
    for index in [asked.only] if asked.only is not None else range(asked.count):
        row = known.get((asked.seed, index)) if asked.only is None else None
        if row is None:
            row = run_one(asked.seed, index, asked.output)
            with table.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
        print(index, row["ended"], row["seconds"], "s", row.get("mean_iterations", ""), row["message"], flush=True)
        rows.append(row)
    complete = sum(row["ended"] == "complete" for row in rows)
    print(f"{complete} of {len(rows)} ran to their end ({100.0 * complete / len(rows):.1f} %)")


if __name__ == "__main__":
    main()
