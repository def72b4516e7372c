"""Time and memory of checking a large record: 3 repeats of 2 000 loops with 512 samples each.

Usage: bench_record_check.py [--loops 2000] [--samples 512]

The record is written to a temporary folder and checked in a process of its own, whose CPU and wall time and largest
memory are printed beside the time to read the same file with numpy.loadtxt on a hundredth of its lines, scaled up.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import click
import numpy as np

from wirewear.faces.study_script import StudyScript

TABLES = """format = 1
name = "large"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 60.0
frequency_Hz = 3.0
cycles = 100000
[files]
loops = "loops.csv"
"""


def write(folder: Path, loops: int, samples: int) -> None:
    """A record of 3 repeats with noise."""
    random = np.random.default_rng(1)
    phase = 2.0 * np.pi * np.arange(samples) / samples
    x = 60.0 * np.sin(phase)
    q = 1.24 * np.clip(np.sin(phase + 0.5 * np.pi) * 8.0, -1.0, 1.0)
    with (folder / "loops.csv").open("w", encoding="utf-8") as file:
        file.write("repeat,cycle,sample,time_s,displacement_um,tangential_force_N,normal_force_N\n")
        for repeat in (1, 2, 3):
            for cycle in range(1, loops + 1):
                table = np.column_stack(
                    [
                        np.full(samples, repeat),
                        np.full(samples, cycle),
                        np.arange(samples),
                        phase / (6.0 * np.pi),
                        x + 0.15 * random.standard_normal(samples),
                        q + 0.008 * random.standard_normal(samples),
                        2.0 + 0.01 * random.standard_normal(samples),
                    ]
                )
                np.savetxt(file, table, fmt=["%d", "%d", "%d", "%.6f", "%.3f", "%.5f", "%.4f"], delimiter=",")
    (folder / "experiment.toml").write_text(TABLES, encoding="utf-8")


def baseline_s(path: Path, share: int = 100) -> float:
    """CPU time of numpy.loadtxt, from every 1/share of the lines."""
    with path.open(encoding="utf-8") as file:
        rows = sum(1 for _ in file) - 1
    started = time.process_time()
    np.loadtxt(path, delimiter=",", skiprows=1, max_rows=rows // share)
    return share * (time.process_time() - started)


@click.command(cls=StudyScript)
@click.option("--loops", type=click.IntRange(1), default=2000, show_default=True, help="Of each repeat.")
@click.option("--samples", type=click.IntRange(8), default=512, show_default=True, help="Of each loop.")
def main(loops: int, samples: int) -> None:
    """Write a large record, check it, and print the time and the memory that this takes."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write(folder, loops, samples)
        size = (folder / "loops.csv").stat().st_size
        started = time.perf_counter()
        command = [sys.executable, "-c", "from wirewear.faces import main; main()", "check", str(folder)]
        subprocess.run(command, check=False, stdout=subprocess.DEVNULL)
        wall = time.perf_counter() - started
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu, memory = used.ru_utime + used.ru_stime, used.ru_maxrss / 2**20
        plain = baseline_s(folder / "loops.csv")
    click.echo(f"3 × {loops} loops of {samples} samples, {size / 1e6:.0f} MB")
    click.echo(f"wirewear check: {wall:.1f} s ({cpu:.1f} s of CPU), {memory:.2f} GiB")
    click.echo(f"numpy.loadtxt of the same file: {plain:.1f} s of CPU; ratio {cpu / plain:.2f}")


if __name__ == "__main__":
    main()
