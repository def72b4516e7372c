"""Random studies of long wear within stated physical ranges: how many run to their end, and how the others fail.

Usage: random_studies.py [--count 120] [--seed 1] [--shapes] [--processes 1 | --scheduler ADDRESS]
[--output runs/random_studies]. With --shapes bodies of any shapes touch at a point, without it they are wires.

Every study is drawn from the seed, so that a failing one can be repeated: `--only 17` runs the 17th alone, `--show 17`
prints it. Studies that are done already (their line stands in results.jsonl) are not run again.
"""

import json
import os
import resource
import shutil
import signal
import time
from collections import Counter
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from threading import current_thread, main_thread

import click
import numpy as np

from studies.study_script import StudyScript, understanding
from wirewear import WirewearError, parse_study, run_study
from wirewear.base.engine import LocalProcesses, engine_of
from wirewear.base.writing import prepared_folder

from .random_draws import draw, draw_shapes

_SHOWN = ("index", "ended", "cpu_s", "simulated_cycles", "mirror_error", "energy_against_loops", "message")


class OutOfTimeError(Exception):
    """A study took more CPU time than it was given."""


def run_one(drawn: str, seed: int, index: int, folder: Path, cpu_limit_s: float) -> dict[str, object]:
    """Run one study and say how it ended."""
    started = time.process_time()
    row: dict[str, object] = {"seed": seed, "index": index}
    home = folder / f"{seed}-{index}"
    shutil.rmtree(home, ignore_errors=True)
    # A cluster's worker does tasks in a thread, which gets no signals: its studies take the time that they take.
    limited = current_thread() is main_thread()
    if limited:
        signal.signal(signal.SIGPROF, _stop)
        signal.setitimer(signal.ITIMER_PROF, cpu_limit_s)
    try:
        study = parse_study(drawn, f"random study {index}")
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
        if limited:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
    row["cpu_s"] = round(time.process_time() - started, 1)
    row["peak_MiB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    return row


def _stop(_signal: int, _frame: object) -> None:
    raise OutOfTimeError


def done_before(path: Path) -> Iterator[dict[str, object]]:
    """Rows of an earlier, interrupted run; ResultError where the file holds something else."""
    if path.exists():
        with understanding(path, "table of random studies"):
            for line in path.read_text(encoding="utf-8").splitlines():
                row = json.loads(line)
                yield row | {"index": int(row["index"]), "seed": int(row["seed"])}


@click.command(cls=StudyScript)
@click.option("--count", type=click.IntRange(1), default=120, show_default=True)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True)
@click.option("--only", type=click.IntRange(0), multiple=True, help="A study by its number; may be repeated.")
@click.option("--show", type=click.IntRange(0), help="Print the study of this number and run nothing.")
@click.option("--shapes", is_flag=True, help="Bodies of any shapes in place of wires.")
@click.option("--processes", type=click.IntRange(1), default=1, show_default=True)
@click.option("--scheduler", help="Dask cluster whose workers see the output, instead of --processes.")
@click.option(
    "--cpu-limit", type=click.FloatRange(0.0, min_open=True), default=600.0, show_default=True, help="s for one study."
)
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/random_studies"), show_default=True)
def main(
    count: int,
    seed: int,
    only: tuple[int, ...],
    show: int | None,
    shapes: bool,
    processes: int,
    scheduler: str | None,
    cpu_limit: float,
    output: Path,
) -> None:
    """Run random studies within stated physical ranges, and print how they ended."""
    study_of = draw_shapes if shapes else draw
    if show is not None:
        click.echo(study_of(seed, show))
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    table = prepared_folder(output) / "results.jsonl"
    rows = {int(str(row["index"])): row for row in done_before(table) if row["seed"] == seed}
    wanted = only or [index for index in range(count) if index not in rows]
    # A process for each study shows what that one takes of memory.
    engine = engine_of(scheduler=scheduler) if scheduler else LocalProcesses(processes, 1)
    folder = output.resolve()
    for one in engine.done(
        [partial(run_one, study_of(seed, index), seed, index, folder, cpu_limit) for index in wanted]
    ):
        row = one.value()
        with table.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
        print(*(f"{row.get(key, '-')}" for key in _SHOWN), flush=True)
        rows[int(str(row["index"]))] = row
    report(list(rows.values()))


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
