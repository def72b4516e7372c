"""Pairs of runs: nominal tests drawn by a Latin hypercube, each as other solvers see it, without a gap or with one.

    python -m studies.diagnosis.gap_free FOLDER --tests 24 [--seed N] [--reference T1] [--reference T2:dahl]
    python -m studies.diagnosis.gap_free FOLDER --tests 24 --effects [--only wear_rate_offset] [--reference T1]
    python -m studies.diagnosis.gap_free FOLDER --tests 10 --rigs 10 [--reference T2:iwan]

A reference is a forward model of the blind check: T0 (the nominal run's mesh and increments), T1 (finer mesh, other
increments and contact formulation) or T2 with one of its friction laws. It makes a record of one specimen, without
scatter and nearly without noise, of every test.
The other half of a pair, the nominal run, is the diagnosis' own. With `--effects` every effect of the library is put
into one test after the other, easy and hard, and truth.json beside the record says how large. With `--rigs` so many
records of every test have the specimens, noise and channels of a blind batch. An interrupted run goes on with the same
command.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from math import exp, log
from pathlib import Path

import click
import numpy as np
from scipy.stats import qmc

from studies.blind import LIBRARY_EFFECTS
from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.nominal import MOST_LOST, WIDEST_SCAR, MATERIALS_MPa, Nominal
from studies.blind.generators.nuisances import Nuisances, Scatter, drawn_nuisances
from studies.blind.generators.sizes import drawn_parameters
from studies.blind.generators.tiers import generator_of
from studies.blind.generators.waveform import Waveform
from studies.study_script import StudyScript
from wirewear import WirewearError, write_record
from wirewear.base.engine import engine_of
from wirewear.base.writing import prepared_folder, write_text
from wirewear.records import AnyRecord, ExperimentRecord

#: Ranges that tests are drawn from, those of blind batches.
DIAMETERS_mm = (0.3, 0.8)
LOADS_N, AMPLITUDES_um, FRICTIONS = (1.0, 4.0), (30.0, 80.0), (0.45, 0.8)
WEAR_mm3_per_J, STIFFNESSES_N_per_mm, SPRINGS_N_per_mm = (8e-6, 5e-5), (80.0, 600.0), (0.5, 5.0)
CYCLES = (20_000, 50_000, 100_000, 200_000)

RIGID = 0.3  #: Share of the holders that are assumed rigid.
NOISE = 5e-4  #: What a record of a pair holds in noise, as shares of the amplitude and of the friction force.
TRUTH = "truth.json"  #: File beside a record that holds the effect in it.

REFERENCES = ("T0", "T1", "T2:dahl", "T2:iwan", "T2:weakening")


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


def case_of(test: Nominal, name: str, effects: tuple[TrueEffect, ...] = ()) -> Case:
    """A case without scatter or drift, and with as little noise as readers of loops need."""
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
    return Case(name, "single" if effects else "none", None, effects, (), test, nuisances, seed=1)


def of_a_rig(test: Nominal, name: str, seed: tuple[int, ...]) -> Case:
    """A gap-free case as a blind batch would draw it."""
    random = np.random.default_rng(seed)
    return Case(name, "none", None, (), (), test, drawn_nuisances(test, random), seed=int(random.integers(2**63)))


def with_effects(tests: tuple[Nominal, ...], names: tuple[str, ...], seed: int) -> Iterator[tuple[int, TrueEffect]]:
    """Every effect easy and hard, each in the next test, by the test's place."""
    random = np.random.default_rng(seed)
    for turn, (name, ease) in enumerate((name, ease) for name in names for ease in ("easy", "hard")):
        place = turn % len(tests)
        yield place, TrueEffect(name, drawn_parameters(name, ease, tests[place], random))


def wires_of(record: AnyRecord) -> ExperimentRecord:
    """What references of wires make: records of wires. Raises TypeError if it is a line contact's."""
    if not isinstance(record, ExperimentRecord):
        raise TypeError("references of wires make records of wires")
    return record


def made(folder: Path, case: Case, reference: str) -> str:
    """Write the record of a case by a reference, unless it is there; what to print of it."""
    if (folder / case.name / "experiment.toml").exists():
        return ""
    tier, _, law = reference.partition(":")
    try:
        record = generator_of(tier, law=law or None).make(case).record
    except WirewearError as problem:
        return f"{case.name}: {problem} ({asdict(case.nominal)})"
    write_record(folder / case.name, wires_of(record))
    write_text(folder / case.name / TRUTH, json.dumps([asdict(effect) for effect in case.effects]) + "\n")
    return case.name


def planned(
    tests: tuple[Nominal, ...], reference: str, seed: int, effects: tuple[str, ...], rigs: int
) -> Iterator[Case]:
    """The cases of one reference: every effect, or so many rigs of every test, or every test alone."""
    where = reference.replace(":", "_")
    names = [f"test_{place:02d}_{where}" for place in range(1, len(tests) + 1)]
    if effects:
        for turn, (place, effect) in enumerate(with_effects(tests, effects, seed)):
            size = ("easy", "hard")[turn % 2]
            yield case_of(tests[place], f"{names[place]}_{effect.effect}_{size}", (effect,))
    elif rigs:
        for place, test in enumerate(tests):
            for rig in range(rigs):
                yield of_a_rig(test, f"{names[place]}_rig_{rig + 1:02d}", (seed, place, rig))
    else:
        yield from (case_of(test, name) for test, name in zip(tests, names, strict=True))


@click.command(cls=StudyScript)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--tests", type=click.IntRange(1), default=24, show_default=True)
@click.option("--first", type=click.IntRange(1), help="Only so many of the tests.  [default: all]")
@click.option("--seed", type=click.IntRange(0), default=14, show_default=True)
@click.option("--reference", "references", type=click.Choice(REFERENCES), multiple=True, help="[default: all]")
@click.option("--effects", "has_effects", is_flag=True, help="Every effect of the library in turn, not gap-free.")
@click.option("--only", type=click.Choice(LIBRARY_EFFECTS), multiple=True, help="Of --effects.  [default: all]")
@click.option("--rigs", type=click.IntRange(0), default=0, help="Records of every test as rigs give them.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Records side by side.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask cluster whose workers see FOLDER, instead of --jobs.")
def main(
    folder: Path,
    tests: int,
    first: int | None,
    seed: int,
    references: tuple[str, ...],
    has_effects: bool,
    only: tuple[str, ...],
    rigs: int,
    jobs: int,
    scheduler: str | None,
) -> None:
    """Make a record of every test and reference in FOLDER, as TEST_REFERENCE, with _EFFECT_SIZE or _rig_NUMBER."""
    prepared_folder(folder)
    drawn = drawn_tests(tests, seed)[:first]
    effects = (only or LIBRARY_EFFECTS) if has_effects else ()
    tasks = [
        partial(made, folder.resolve(), case, reference)
        for reference in references or REFERENCES
        for case in planned(drawn, reference, seed, effects, rigs)
    ]
    for one in engine_of(jobs, scheduler).done(tasks):
        if row := one.value():
            click.echo(row)


if __name__ == "__main__":
    main()
