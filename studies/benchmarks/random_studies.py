"""Random studies of long wear within stated physical ranges: how many run to their end, and how the others fail.

Usage: random_studies.py [--count 120] [--seed 1] [--processes 1] [--output runs/random_studies]

Every study is drawn from the seed, so that a failing one can be repeated: `--only 17` runs the 17th alone, `--show 17`
prints it. Studies that are done already (their line stands in results.jsonl) are not run again.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import resource
import shutil
import signal
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
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
MODULUS_MPa = (70e3, 210e3)
RIG_N_per_mm = (10.0, 3e4)
RIGID_SHARE = 0.25
CYCLES = 10_000
#: Volume that gross slip would wear over the test, in areas of the fresh contact times its approach; steel wires of
#: 0.45 mm wear some 60 of them.
VOLUME_PER_CONTACT = (1.0, 100.0)
#: The same over the cube of the thinner wire's diameter: scars stay below some 8 % of it.
LARGEST_VOLUME = 0.003
#: Share of the studies that have any effects, and of the effects that one of these has.
WITH_EFFECTS = 0.6
EACH_EFFECT = 0.25


class OutOfTimeError(Exception):
    """A study took more CPU time than it was given."""


class _Draw:
    """A source of random numbers."""

    def __init__(self, seed: int, index: int) -> None:
        self._random = np.random.default_rng([seed, index])

    def uniform(self, low: float, high: float) -> float:
        return float(self._random.uniform(low, high))

    def log_uniform(self, low: float, high: float) -> float:
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def happens(self, share: float) -> bool:
        return bool(self._random.random() < share)


def draw(seed: int, index: int) -> str:
    """The TOML of one random study."""
    random = _Draw(seed, index)
    diameters = [random.log_uniform(*DIAMETER_mm) for _ in range(2)]
    if random.happens(0.5):
        diameters[1] = diameters[0]
    # Very unequal wires are not what a crossed-wire test uses.
    diameters[1] = min(max(diameters[1], diameters[0] / 2.5), diameters[0] * 2.5)
    load, friction = random.log_uniform(*LOAD_N), random.uniform(*FRICTION)
    angle = 90.0 if random.happens(0.4) else random.uniform(*ANGLE_deg)
    motion = 0.0 if random.happens(0.6) else random.uniform(-90.0, 90.0)
    rigid = random.happens(RIGID_SHARE)
    stiffness = random.log_uniform(*RIG_N_per_mm)
    steel = reference.Elastic(MODULUS_MPa[1], 0.3)
    fixed = reference.Elastic(random.uniform(*MODULUS_MPa), 0.3) if random.happens(0.3) else steel
    radii = diameters[0] / 2.0, diameters[1] / 2.0
    hertz = reference.hertz_crossed_cylinders(load, *radii, angle, first=steel, second=fixed)
    # Hertz's contact must be small against the wires for the study to make sense: the load is lowered where it is not.
    room = LARGEST_CONTACT * min(diameters) / hertz.major_semi_axis_mm
    if room < 1.0:
        load *= room**3
        hertz = reference.hertz_crossed_cylinders(load, *radii, angle, first=steel, second=fixed)
    tangential = reference.mindlin_stiffness(
        reference.tangential_contact_modulus(steel, fixed), hertz.contact_radius_mm
    )
    threshold = 1.5 * friction * load / tangential + (0.0 if rigid else friction * load / stiffness)
    longest = max(MOST_STROKE_PER_RADIUS * hertz.contact_radius_mm, 1.2 * threshold)
    amplitude = min(random.log_uniform(STROKE_PER_THRESHOLD * threshold, longest), 0.9 * min(diameters))
    amplitude = max(amplitude, LEAST_AMPLITUDE_mm)
    volume = random.log_uniform(*VOLUME_PER_CONTACT) * math.pi * hertz.contact_radius_mm**2 * hertz.approach_mm
    volume = min(volume, LARGEST_VOLUME * min(diameters) ** 3)
    coefficient = min(volume / (4e-3 * friction * load * amplitude * CYCLES), 9e-3)
    held, quoted = random.happens(0.1), '"rigid"'
    return "\n".join(
        [
            "format = 1",
            f'name = "random study {index} of seed {seed}"',
            'kind = "crossed-wires"',
            "[wires]",
            f"diameter_mm = {diameters[0]!r}",
            f"youngs_modulus_MPa = {steel.youngs_modulus_MPa!r}",
            "poissons_ratio = 0.3",
            f"crossing_angle_deg = {angle!r}",
            "[wires.fixed]",
            f"diameter_mm = {diameters[1]!r}",
            f"youngs_modulus_MPa = {fixed.youngs_modulus_MPa!r}",
            "[conditions]",
            f"normal_load_N = {load!r}",
            f"displacement_amplitude_um = {1e3 * amplitude!r}",
            f"motion_angle_deg = {motion!r}",
            "frequency_Hz = 1.0",
            f"cycles = {CYCLES}",
            *([f"approach_um = {1e3 * hertz.approach_mm * random.uniform(1.0, 3.0)!r}"] if held else []),
            "[contact]",
            f"friction = {friction!r}",
            f'primary_wire = "{"moving" if random.happens(0.3) else "fixed"}"',
            *(
                [f'friction_law = {{name = "shear-limited", shear_strength_MPa = {random.log_uniform(100.0, 1e3)!r}}}']
                if random.happens(0.1)
                else []
            ),
            *_wear(random, coefficient, friction, 4e-3 * friction * load * amplitude * CYCLES),
            "[holder]",
            f"tangential_stiffness_N_per_mm = {quoted if rigid else repr(stiffness)}",
            *_rotation(random),
            *([] if held or random.happens(0.8) else [f"normal_spring_stiffness_N_per_mm = {_spring(random, load)!r}"]),
            "[log]",
            f"loop_cycles = [1, 10, 30, 100, 300, 1000, 3000, {CYCLES}]",
            *_effects(random, held, friction, amplitude, hertz.approach_mm, angle),
        ]
    )


def _wear(random: _Draw, per_J: float, friction: float, energy_J: float) -> list[str]:
    law = f"energy_wear_coefficient_mm3_per_J = {per_J!r}"
    if random.happens(0.3):
        law = f"archard_wear_coefficient_mm3_per_N_m = {min(per_J * friction, 9e-3)!r}"
    lines = ["[wear]", law, f"moving_share = {random.uniform(0.0, 1.0) if random.happens(0.5) else 0.5!r}"]
    if random.happens(0.2):
        by, end = ("cycles", float(CYCLES)) if random.happens(0.5) else ("energy_J", energy_J)
        first, last = random.log_uniform(0.3, 3.0), random.log_uniform(0.3, 3.0)
        lines += [
            f'variation = "{by}"',
            f"variation_points = [[0, {first!r}], [{random.uniform(0.1, 0.9) * end!r}, {last!r}]]",
        ]
    return lines


def _rotation(random: _Draw) -> list[str]:
    if not random.happens(0.15):
        return []
    height = random.log_uniform(1.0, 20.0)
    return [
        f"rotational_stiffness_N_mm_per_rad = {random.log_uniform(100.0, RIG_N_per_mm[1]) * height**2!r}",
        f"pivot_height_mm = {height!r}",
    ]


def _spring(random: _Draw, load: float) -> float:
    """A loading spring that gives way by 0.1 to 3 mm under the load, N/mm."""
    return load / random.log_uniform(0.1, 3.0)


def _effects(
    random: _Draw, held: bool, friction: float, amplitude_mm: float, approach_mm: float, angle: float
) -> list[str]:
    if not random.happens(WITH_EFFECTS):
        return []
    amplitude, approach = 1e3 * amplitude_mm, 1e3 * approach_mm
    ends = random.uniform(0.5, 1.5), random.uniform(0.5, 1.5)
    wears = random.log_uniform(0.3, 3.0), random.log_uniform(0.3, 3.0)
    # The crossing angle as it truly is must stay within its range too.
    turned = random.uniform(-5.0, 5.0 if angle <= 85.0 else 0.0) if angle >= 35.0 else random.uniform(0.0, 5.0)
    every = {
        "free_play": f"gap_um = {random.uniform(0.05, 0.8) * amplitude!r}",
        "roughness_compliance": f"layer_um = {random.log_uniform(0.05, 1.0) * approach!r}\n"
        f"cycles = {random.log_uniform(30.0, 1e5)!r}",
        "third_body": f"retained_fraction = {random.uniform(0.05, 0.7)!r}\n"
        f"modulus_MPa = {random.log_uniform(100.0, 5e4)!r}",
        "misalignment": f"angle_deg = {random.uniform(-3.0, 3.0)!r}",
        "plasticity": f"flattening_um = {random.log_uniform(0.05, 1.0) * approach!r}",
        "crossing_angle_error": f"angle_deg = {turned!r}",
        "friction_evolution": f"initial = {ends[0] * friction!r}\nfinal = {ends[1] * friction!r}\n"
        f"cycles = {random.log_uniform(30.0, CYCLES)!r}",
        "wear_rate_evolution": f"initial_factor = {wears[0]!r}\nfinal_factor = {wears[1]!r}\n"
        f"cycles = {random.log_uniform(30.0, CYCLES)!r}",
        "normal_load_drift": f"fraction_per_100k_cycles = {random.uniform(-0.9, 2.0)!r}",
    }
    needs_load = {"misalignment", "normal_load_drift", "plasticity"}
    chosen = [name for name in every if random.happens(EACH_EFFECT) and not (held and name in needs_load)]
    return [f'[[effects]]\nname = "{name}"\n{every[name]}' for name in chosen]


def run_one(seed: int, index: int, folder: Path, cpu_limit_s: float) -> dict[str, object]:
    """Run one study and say how it ended."""
    begun = time.process_time()
    row: dict[str, object] = {"seed": seed, "index": index}
    home = folder / f"{seed}-{index}"
    shutil.rmtree(home, ignore_errors=True)
    signal.signal(signal.SIGPROF, _stop)
    signal.setitimer(signal.ITIMER_PROF, cpu_limit_s)
    try:
        study = parse_study(draw(seed, index), f"random study {index}")
        (result,) = run_study(study, fidelity="quick", output=home)
        row |= {"ended": "complete", "message": "", **result.quality}
        row["simulated_cycles"] = result.settings["simulated_cycles"]
    except OutOfTimeError:
        row |= {"ended": "out of time", "message": f"stopped after {cpu_limit_s:g} s of CPU time"}
    except WirewearError as error:
        row |= {"ended": "refused", "message": str(error)}
    except Exception as error:  # noqa: BLE001 - any other end is what this script is there to find
        row |= {"ended": type(error).__name__, "message": str(error)}
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    row["cpu_s"] = round(time.process_time() - begun, 1)
    row["peak_MiB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    return row


def _stop(_signal: int, _frame: object) -> None:
    raise OutOfTimeError


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
    parser.add_argument("--only", type=int, nargs="+")
    parser.add_argument("--show", type=int)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--cpu-limit", type=float, default=600.0, help="s of CPU time for one study")
    parser.add_argument("--output", type=Path, default=Path("runs/random_studies"))
    asked = parser.parse_args()
    if asked.show is not None:
        print(draw(asked.seed, asked.show))
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    asked.output.mkdir(parents=True, exist_ok=True)
    table = asked.output / "results.jsonl"
    rows = {int(str(row["index"])): row for row in done_before(table) if row["seed"] == asked.seed}
    wanted = asked.only or [index for index in range(asked.count) if index not in rows]
    with ProcessPoolExecutor(asked.processes, max_tasks_per_child=1) as pool:
        every = [pool.submit(run_one, asked.seed, index, asked.output, asked.cpu_limit) for index in wanted]
        for one in as_completed(every):
            row = one.result()
            with table.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
            print(*(f"{row.get(key, '-')}" for key in _SHOWN), flush=True)
            rows[int(str(row["index"]))] = row
    report(list(rows.values()))


_SHOWN = ("index", "ended", "cpu_s", "simulated_cycles", "mirror_error", "energy_against_loops", "message")


def report(rows: list[dict[str, object]]) -> None:
    """Print how many ended how, and the distributions of what they measured."""
    for ended, count in Counter(str(row["ended"]) for row in rows).most_common():
        print(f"{ended}: {count} of {len(rows)} ({100.0 * count / len(rows):.1f} %)")
    for name in (
        "cpu_s",
        "simulated_cycles",
        "mirror_error",
        "energy_against_loops",
        "loop_area_against_friction_work",
        "peak_MiB",
    ):
        values = np.array([float(str(row[name])) for row in rows if name in row])
        if len(values):
            median, most, all_but_few = np.percentile(values, [50.0, 90.0, 99.0])
            print(
                f"{name}: {len(values)} studies, median {median:.3g}, 90 % below {most:.3g}, "
                f"99 % below {all_but_few:.3g}, largest {values.max():.3g}"
            )


if __name__ == "__main__":
    main()
