"""What an engine of tasks costs and bears: throughput, overhead, a worker killed half-way.

    python -m studies.benchmarks.engines FOLDER [--runs 100]

A coarse study of the steel wires is swept over rig and friction by processes of this machine, and by a local Dask
cluster of two workers of which one is killed when half of the runs are done. Both tables must be the same files.
"""

import hashlib
import operator
import os
import signal
import time
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import click
from distributed import LocalCluster

from wirewear.base.cluster import engine_of
from wirewear.base.engine import Engine, LocalProcesses, results_of
from wirewear.base.writing import prepared_folder
from wirewear.faces.study_script import StudyScript
from wirewear.sweeps import load_sweep, run_sweep
from wirewear.sweeps.page import write_table
from wirewear.sweeps.running import Forecast
from wirewear.sweeps.sweep import SweepRow

STUDY = """format = 1
name = "coarse steel wires"
kind = "crossed-wires"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 20.0
frequency_Hz = 3.0
cycles = 100
[contact]
friction = 0.62
[wear]
energy_wear_coefficient_mm3_per_J = 3.0e-5
[holder]
tangential_stiffness_N_per_mm = 175.0
[fidelity.quick]
contact_mesh_um = 9.0
outer_mesh_um = 18.0
[log]
loop_cycles = [1, 100]
"""

SWEEP = """format = 1
name = "engines"
study = "study.toml"
design = "latin-hypercube"
samples = {runs}
[[vary]]
key = "holder.tangential_stiffness_N_per_mm"
low = 100.0
high = 5000.0
scale = "logarithmic"
[[vary]]
key = "contact.friction"
low = 0.3
high = 0.8
"""

#: Tasks that do nothing, to see what handing one over takes.
EMPTY = 400


@dataclass
class Killer:
    """Watches a sweep, and kills a worker when half of its runs are done."""

    workers: tuple[int, ...] = ()
    killed: list[int] = field(default_factory=list)
    seen: list[int] = field(default_factory=list)

    def note(self, sentence: str) -> None:
        """Print it."""
        click.echo(sentence)

    def foreseen(self, forecast: Forecast) -> None:
        """Print it."""
        click.echo(forecast.sentence)

    def done(self, row: SweepRow, rows: int, of: int) -> None:
        """Count it, and kill when it is time."""
        self.seen.append(row.number)
        if self.workers and not self.killed and rows >= of // 2:
            os.kill(self.workers[0], signal.SIGKILL)
            self.killed.append(self.workers[0])


def swept(path: Path, output: Path, engine: Engine, watcher: Killer) -> tuple[dict[str, str], float, float]:
    """Hashes of the tables' files, wall time and CPU time of the runs."""
    begun = time.monotonic()
    sweep = load_sweep(path)
    result = run_sweep(sweep, output, engine, watcher)
    wall = time.monotonic() - begun
    hashes = {p.name: hashlib.sha256(p.read_bytes()).hexdigest()[:16] for p in write_table(output, sweep, result.rows)}
    return hashes, wall, sum(row.cpu_s for row in result.rows.values())


def overhead_s(engine: Engine) -> float:
    """Time to hand over a task that does nothing, beyond what starting the engine takes."""
    begun = time.monotonic()
    results_of(engine, [partial(operator.index, 1)] * 2)
    started = time.monotonic()
    results_of(engine, [partial(operator.index, 1)] * EMPTY)
    return ((time.monotonic() - started) - (started - begun)) / EMPTY


@click.command(cls=StudyScript, help=__doc__)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--runs", type=click.IntRange(4), default=100, show_default=True)
@click.option("--few", type=click.IntRange(4), default=20, show_default=True, help="Runs that tell the throughput.")
def main(folder: Path, runs: int, few: int) -> None:
    """Measure and print."""
    prepared_folder(folder)
    (folder / "study.toml").write_text(STUDY)
    whole, short = folder / "whole.toml", folder / "short.toml"
    whole.write_text(SWEEP.format(runs=runs))
    short.write_text(SWEEP.format(runs=few))
    alone = swept(short, folder / "one", LocalProcesses(1), Killer())
    both = swept(short, folder / "two", LocalProcesses(2), Killer())
    click.echo(
        f"{few} runs: 1 process {alone[1]:.1f} s, 2 processes {both[1]:.1f} s, {alone[1] / both[1]:.2f} times as fast"
    )
    hashes, wall, cpu = swept(whole, folder / "processes", LocalProcesses(2), Killer())
    click.echo(f"{runs} runs by processes: {wall:.1f} s, {cpu:.1f} s of CPU time")
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster:
        killer = Killer(tuple(worker.process.pid for worker in cluster.workers.values()))
        far, wall, cpu = swept(whole, folder / "cluster", engine_of(scheduler=cluster.scheduler_address), killer)
        click.echo(f"{runs} runs by a cluster: {wall:.1f} s, {cpu:.1f} s of CPU time; killed {len(killer.killed)}")
        click.echo(f"numbers handed over: {len(killer.seen)}, different ones: {len(set(killer.seen))}")
        click.echo(
            f"overhead of a task: cluster {1e3 * overhead_s(engine_of(scheduler=cluster.scheduler_address)):.1f} ms"
        )
    click.echo(
        f"overhead of a task: processes {1e3 * overhead_s(LocalProcesses(2)):.1f} ms, of a run {cpu / runs:.2f} s"
    )
    click.echo(f"tables are the same files: {hashes == far}")
    if hashes != far or len(set(killer.seen)) != len(killer.seen):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
