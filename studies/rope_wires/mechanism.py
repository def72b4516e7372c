"""Why lives of rope wires fall with load, and fall and rise again with stroke: what stress does, and what removal does.

    python -m studies.rope_wires.mechanism --output DIR

Lives of the driven wire four ways: without wear; with the stresses of the worn states, but nothing removed; with those
of the unworn state under a surface that recedes; and as they are. Leaves mechanism.csv and mechanism.png.
"""

import csv
import tomllib
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from wirewear import lives
from wirewear.base.words import counted
from wirewear.pictures import style
from wirewear.simulation import simulate
from wirewear.stress.damage import Damage, Initiation
from wirewear.test import study_from_tables

STUDY = Path(__file__).with_name("study.toml")
CYCLES = [1, 10, 100, 300, 1000, 3000]  #: Recorded; lives that are longer go on as the last one.
STROKES_um, LOAD_N = (0.2, 0.5, 1.5, 5.0, 15.0, 45.0), 2.0
LOADS_N, STROKE_um = (1.0, 4.0), 1.5
#: Columns of mechanism.csv, and what they are called.
KINDS = {
    "no_wear": "no wear",
    "unworn_stress_removed": "unworn stress, damage removed",
    "worn_stress_nothing_removed": "worn stress, nothing removed",
    "as_it_is": "both (default)",
}
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
    ways = replace(damage, spans=fresh), replace(damage, worn_mm=lambda _: nothing)
    cycles = (unworn.cycles, *map(until_one, ways), whole.cycles)
    return {"stroke_um": stroke_um, "load_N": load_N, **dict(zip(KINDS, cycles, strict=True))}


def until_one(damage: Damage) -> float:
    """Cycles until the sum reaches 1."""
    initiation: Initiation | None = damage.initiations([1.0])[0]
    return np.inf if initiation is None else initiation.cycles


def draw(rows: list[dict[str, float]]) -> Figure:
    """Lives over the stroke, each way, called as in docs/life.md."""
    figure = style.new_figure(3.6)
    axes = figure.subplots()
    strokes = sorted((one for one in rows if one["load_N"] == LOAD_N), key=lambda one: one["stroke_um"])
    for place, ((kind, label), mark) in enumerate(zip(KINDS.items(), "os^D", strict=True)):
        lives_of = [one[kind] for one in strokes]
        look = style.variant_style(place) | ({"color": style.GREY} if kind == "no_wear" else {})
        axes.loglog([one["stroke_um"] for one in strokes], lives_of, marker=mark, label=label, **look)
    axes.set(xlabel="displacement amplitude [µm]", ylabel="cycles until a crack begins")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}" if value < 1e4 else counted(round(value))))
    figure.legend(loc="outside upper center", ncols=2)
    return figure


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
    style.save(partial(draw, rows), output / "mechanism.png")


if __name__ == "__main__":
    main()
