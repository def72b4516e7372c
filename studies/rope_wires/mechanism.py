"""Why lives of rope wires fall with load, and fall and rise again with stroke: what stress does, and what removal does.

    python studies/rope_wires/mechanism.py --output DIR

Lives of the driven wire four ways: without wear; with the stresses of the worn states, but nothing removed; with those
of the unworn state under a surface that recedes; and as they are. Leaves mechanism.csv and mechanism.png.
"""

import csv
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import matplotlib.pyplot as plt
import numpy as np

from wirewear import lives
from wirewear.interior.damage import Begun, Damage
from wirewear.simulation import simulate
from wirewear.study import study_from_tables

STUDY = Path(__file__).with_name("study.toml")
CYCLES = [1, 10, 100, 300, 1000, 3000]  #: Recorded; lives that are longer go on as the last one.
STROKES_um, LOAD_N = (0.2, 0.5, 1.5, 5.0, 15.0, 45.0), 2.0
LOADS_N, STROKE_um = (1.0, 4.0), 1.5
KINDS = ("no_wear", "worn_stress_nothing_removed", "unworn_stress_removed", "as_it_is")
BODY = "moving"


def row(stroke_um: float, load_N: float) -> dict[str, float]:
    """Cycles to initiation of one stroke and load, each way; endless where no crack begins."""
    tables: dict[str, Any] = tomllib.loads(STUDY.read_text(encoding="utf-8"))
    tables["conditions"] |= {"displacement_amplitude_um": stroke_um, "normal_load_N": load_N, "cycles": CYCLES[-1]}
    tables["log"]["loop_cycles"] = CYCLES
    whole = lives(simulate(study_from_tables(tables, STUDY.name), fidelity="quick"), [BODY])[0]
    del tables["wear"]
    tables["conditions"]["cycles"], tables["log"]["loop_cycles"] = 1, [1]
    unworn = lives(simulate(study_from_tables(tables, STUDY.name), fidelity="quick"), [BODY])[0]
    damage, nothing = whole.damage, np.zeros(len(whole.columns_mm))
    fresh = [replace(span, rates=damage.spans[0].rates[:1]) for span in damage.spans]
    ways = replace(damage, worn_mm=lambda _: nothing), replace(damage, spans=fresh)
    cycles = (unworn.cycles, *map(until_one, ways), whole.cycles)
    return {"stroke_um": stroke_um, "load_N": load_N, **dict(zip(KINDS, cycles, strict=True))}


def until_one(damage: Damage) -> float:
    """Cycles until the sum reaches 1."""
    begun: Begun | None = damage.begun([1.0])[0]
    return np.inf if begun is None else begun.cycles


def draw(rows: list[dict[str, float]], path: Path) -> None:
    """Lives over the stroke, each way."""
    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    strokes = sorted((one for one in rows if one["load_N"] == LOAD_N), key=lambda one: one["stroke_um"])
    for kind, style in zip(KINDS, ("C7o:", "C0s--", "C1^--", "C3o-"), strict=True):
        label = kind.replace("_", " ").replace("stress ", "stress, ")
        axes.loglog([one["stroke_um"] for one in strokes], [one[kind] for one in strokes], style, label=label)
    axes.set(xlabel="displacement amplitude [µm]", ylabel="cycles to initiation")
    axes.grid(visible=True, which="major", alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=150)


@click.command()
@click.option("--output", type=click.Path(path_type=Path, file_okay=False), required=True)
def main(output: Path) -> None:
    """Run all cases, a quarter of an hour of one core."""
    rows = [row(stroke, LOAD_N) for stroke in STROKES_um] + [row(STROKE_um, load) for load in LOADS_N]
    output.mkdir(parents=True, exist_ok=True)
    with (output / "mechanism.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)
    draw(rows, output / "mechanism.png")


if __name__ == "__main__":
    main()
