"""Gap-free pairs of runs: nominal tests drawn by a Latin hypercube, each as other solvers see it.

    python -m studies.diagnosis.gap_free FOLDER --tests 24 [--seed N] [--reference T1] [--reference T2:dahl]

A reference is a forward model of the blind check: T1 (finer mesh, other increments and contact formulation) or T2 with
one of its friction laws. It makes a record of one specimen, without scatter and nearly without noise, of every test.
The other half of a pair, the nominal run, is the diagnosis' own. An interrupted run goes on with the same command.
"""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from math import exp, log
from pathlib import Path

import click
import numpy as np
from scipy.stats import qmc

from wirewear import WirewearError, write_record
from wirewear.blind.cases import Case
from wirewear.blind.nominal import MOST_LOST, WIDEST_SCAR, MATERIALS_MPa, Nominal
from wirewear.blind.nuisances import Nuisances, Scatter
from wirewear.blind.tiers import generator_of
from wirewear.blind.waveform import Waveform
from wirewear.engine import engine_of

#: Ranges that tests are drawn from, those of blind batches.
DIAMETERS_mm = (0.3, 0.8)
LOADS_N, AMPLITUDES_um, FRICTIONS = (1.0, 4.0), (30.0, 80.0), (0.45, 0.8)
WEAR_mm3_per_J, STIFFNESSES_N_per_mm, SPRINGS_N_per_mm = (8e-6, 5e-5), (80.0, 600.0), (0.5, 5.0)
CYCLES = (20_000, 50_000, 100_000, 200_000)

#: Share of the holders that are believed rigid.
RIGID = 0.3

#: What a record of a pair holds in noise, as shares of the amplitude and of the friction force.
NOISE = 5e-4

REFERENCES = ("T1", "T2:dahl", "T2:iwan", "T2:weakening")


def drawn_tests(number: int, seed: int) -> tuple[Nominal, ...]:
    """So many tests of a Latin hypercube; those whose rig takes too much of the stroke are left out of a larger one."""
    count = number
    while True:
        points = qmc.LatinHypercube(9, rng=np.random.default_rng(seed)).random(count)
        tests = [test for test in map(_test, points.tolist()) if _is_sound(test)]
        if len(tests) >= number:
            return tuple(tests[:number])
        count += max(number // 2, 1)


def _test(at: list[float]) -> Nominal:
    def between(ends: tuple[float, float], share: float) -> float:
        return exp(log(ends[0]) + share * log(ends[1] / ends[0]))

    modulus, ratio = MATERIALS_MPa[int(at[1] * len(MATERIALS_MPa))]
    stiffness = None if at[7] < RIGID else round(between(STIFFNESSES_N_per_mm, (at[7] - RIGID) / (1.0 - RIGID)))
    return Nominal(
        diameter_mm=round(between(DIAMETERS_mm, at[0]), 2),
        youngs_modulus_MPa=modulus,
        poissons_ratio=ratio,
        load_N=round(between(LOADS_N, at[2]), 1),
        amplitude_um=round(between(AMPLITUDES_um, at[3])),
        frequency_Hz=3.0,
        cycles=CYCLES[int(at[4] * len(CYCLES))],
        friction=round(between(FRICTIONS, at[5]), 2),
        wear_mm3_per_J=float(f"{between(WEAR_mm3_per_J, at[6]):.1e}"),
        stiffness_N_per_mm=stiffness,
        spring_N_per_mm=round(between(SPRINGS_N_per_mm, at[8]), 1),
    )


def _is_sound(test: Nominal) -> bool:
    stiffness = test.stiffness_N_per_mm
    lost_um = 0.0 if stiffness is None else 1e3 * test.friction * test.load_N / stiffness
    return lost_um < MOST_LOST * test.amplitude_um and test.expected_scar_mm < WIDEST_SCAR * test.diameter_mm / 2


def case_of(test: Nominal, name: str) -> Case:
    """A case without effect, scatter or drift, and with as little noise as readers of loops need."""
    cycles = tuple(cycle for cycle in (100, 300, 1000, 3000, 10_000, 30_000, 60_000, 100_000) if cycle < test.cycles)
    nuisances = Nuisances(
        repeats=1,
        scatter=Scatter(0.0, 0.0, 0.0, 0.0),
        displacement_noise_um=NOISE * test.amplitude_um,
        force_noise_N=NOISE * test.friction * test.load_N,
        correlation=0.0,
        outlier_share=0.0,
        waveform=Waveform(0.0, 0.0),
        amplitude_drift=0.0,
        drive="stroke",
        samples=400,
        has_normal_force=True,
        has_evolution=True,
        has_scars=True,
        loop_cycles=((*cycles, test.cycles),),
        evolution_cycles=tuple(np.unique(np.round(np.geomspace(10, test.cycles, 40)).astype(int)).tolist()),
    )
    return Case(name, "none", None, (), (), test, nuisances, seed=1)


def made(folder: Path, test: Nominal, name: str, reference: str) -> str:
    """Write the record of a test by a reference, unless it is there; what to print of it."""
    if (folder / name / "experiment.toml").exists():
        return ""
    tier, _, law = reference.partition(":")
    try:
        record = generator_of(tier, law=law or None).make(case_of(test, name)).record
    except WirewearError as problem:
        return f"{name}: {problem} ({asdict(test)})"
    write_record(folder / name, record)
    return name


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--tests", type=click.IntRange(1), default=24, show_default=True)
@click.option("--seed", type=click.IntRange(0), default=14, show_default=True)
@click.option("--reference", "references", type=click.Choice(REFERENCES), multiple=True, help="[default: all]")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Records side by side.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask cluster whose workers see FOLDER, instead of --jobs.")
def main(folder: Path, tests: int, seed: int, references: tuple[str, ...], jobs: int, scheduler: str | None) -> None:
    """Make a record of every test and reference in FOLDER, as TEST_REFERENCE."""
    tasks = [
        partial(made, folder.resolve(), test, f"test_{place:02d}_{reference.replace(':', '_')}", reference)
        for place, test in enumerate(drawn_tests(tests, seed), start=1)
        for reference in references or REFERENCES
    ]
    for one in engine_of(jobs, scheduler).done(tasks):
        if told := one.value():
            click.echo(told)


if __name__ == "__main__":
    main()
