"""Pairs of runs of tests without a gap: one solver's record against the diagnosis' own nominal run.

Each is linear about the present means; what is learned of many stands in `solver_sizes.py`.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from wirewear import WirewearError, read_record
from wirewear.diagnosis.infer.covariance import OWN, SCATTER, SHARED, components, derivatives
from wirewear.diagnosis.observe.observed_record import read_at_corners
from wirewear.diagnosis.observe.reduction import Layout, Observations, reduce
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.nominal import nominal_run, nominal_study
from wirewear.diagnosis.surrogate.nominal_model import nominal_inputs
from wirewear.diagnosis.surrogate.wear_states import NUMERICAL, WearStates
from wirewear.records import RecordTables

Array = NDArray[np.float64]

MOST_CYCLES = 5  #: Cycles of a pair that are used at most: a covariance of more numbers costs more than it shows.
WITH = {"slip": "energy", "force": "energy"}  #: Components that share a factor with another one.


@dataclass(frozen=True, eq=False)
class Pair:
    """One record against its nominal run, linear about the present means.

    Attributes:
        name, test: of the record, and of the test that it is of.
        solver: what made it, such as T1; records of one solver on one test count as one.
        residual: (n,) measured less computed.
        fixed: (n, n) covariance of what is not learned: noise, and how a loop is read.
        freedoms: (n, k) changes by one present deviation of each freedom.
        parts: (n, n) present covariance of each learned component.
    """

    name: str
    test: str
    solver: str
    residual: Array
    fixed: Array
    freedoms: Array
    parts: Mapping[str, Array]


def pairs_of(folder: Path, *, scattered: bool = False) -> Iterator[Pair]:
    """All pairs that a folder of records makes; `scattered` if their specimens scatter as one expects of a rig."""
    for path in sorted(path.parent for path in folder.glob("*/experiment.toml")):
        try:
            record, _ = read_at_corners(read_record(path))
            study = nominal_study(record)
            states = WearStates.of_run(nominal_run(study))
            setup = nominal_inputs(study, record.tables.conditions.drive)
            observed = reduce(record)
            yield pair_of(path.name, test_of(record.tables), states, setup, observed, scattered=scattered)
        except WirewearError as problem:
            click.echo(f"{path.name}: {problem}")


def solver_of(name: str) -> str:
    """The tier in a record's name; the independent model's where there is none, as in blind batches of it."""
    found = re.search(r"_(T\d)(_|$)", name)
    return found[1] if found else "T2"


def test_of(tables: RecordTables) -> str:
    """What is alike in all records of one test."""
    asked = tables.conditions
    return f"{tables.wires} {asked.normal_load_N} {asked.displacement_amplitude_um} {asked.cycles}"


def pair_of(
    name: str, test: str, states: WearStates, setup: SurrogateInputs, observed: Observations, *, scattered: bool = False
) -> Pair:
    """One pair, of the first repeat, thinned to a few cycles of loops and of the evolution."""
    layout, keep = observed.layout, np.zeros(len(observed.layout), dtype=bool)
    for part in layout:
        known = np.unique(part.sites.cycle)
        kept = known[np.unique(np.linspace(0, known.size - 1, min(known.size, MOST_CYCLES)).round().astype(int))]
        keep[part.rows] = np.isin(part.sites.cycle, kept)
    keep &= np.isfinite(observed.values[0])
    thin: Layout = layout.taken(keep)
    predicted = thin.observed(simulate(states, setup, thin.cycles))
    found = components(states, setup, thin)
    common = observed.common[keep]
    fixed = found.pop(OWN) + np.diag(observed.noise[0, keep] ** 2) + common @ common.T
    for scatter in (SCATTER, SHARED) if scattered else ():
        columns = derivatives(states, setup, thin, scatter)
        fixed = fixed + columns @ columns.T
    parts: dict[str, Array] = {}
    for name_of_own, block in found.items():
        key = WITH.get(name_of_own, name_of_own)
        parts[key] = parts[key] + block if key in parts else block
    freedoms = derivatives(states, setup, thin, NUMERICAL)
    return Pair(name, test, solver_of(name), observed.values[0, keep] - predicted, fixed, freedoms, parts)
