"""Sensitivity indices: the share of a figure's variance that each varied key causes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wirewear.sweeps.sweep import Design, SweepRow
from wirewear.sweeps.tables import LATIN_HYPERCUBE, SOBOL

FEWEST_RUNS = {LATIN_HYPERCUBE: 40, SOBOL: 8}  #: Fewer complete runs (of Sobol's design: blocks) show nothing.
CONSTANT = 1e-9  #: Figures that vary by less than this share of their mean are constant.


@dataclass(frozen=True)
class Index:
    """Share (0 to 1) of a figure's variance that a key causes: alone (`first`), and with all interactions (`total`,
    None but for Sobol).

    Errors are half-widths of 95 % intervals by bootstrap.
    """

    figure: str
    key: str
    first: float
    first_error: float
    total: float | None = None
    total_error: float | None = None


def indices(design: Design, rows: Mapping[int, SweepRow], figure: str, seed: int = 1) -> list[Index]:
    """Sensitivity indices of all keys for one figure; empty for a grid, a constant figure, or too few complete runs
    (FEWEST_RUNS).

    rows: by the number of the run, from 1. seed: of the bootstrap. Sobol's indices by Saltelli's and Jansen's
    estimators (Saltelli et al., Comput. Phys. Commun. 181 (2010) 259); for a Latin hypercube first-order indices by
    RBD-FAST (Plischke, Reliab. Eng. Syst. Saf. 95 (2010) 354).
    """
    if design.kind not in FEWEST_RUNS:
        return []
    of_runs = [rows[number].figures if number in rows else None for number in range(1, len(design.points) + 1)]
    numbers = [None if one is None else one.get(figure) for one in of_runs]
    values = np.array([np.nan if number is None else number for number in numbers], dtype=float)
    shares = design.shares
    if design.kind == SOBOL:
        block = len(design.factors) + 2
        whole = np.isfinite(values.reshape(-1, block)).all(axis=1)
        count, keep = int(whole.sum()), np.repeat(whole, block)
    else:
        keep = np.isfinite(values)
        count = int(keep.sum())
    values, shares = values[keep], shares[keep]
    if count < FEWEST_RUNS[design.kind] or np.ptp(values) <= CONSTANT * abs(float(np.mean(values))):
        return []
    if design.kind == SOBOL:
        from SALib.analyze import sobol

        found = sobol.analyze(design.problem, values, calc_second_order=False, seed=seed)
    else:
        from SALib.analyze import rbd_fast

        found = rbd_fast.analyze(design.problem, shares, values, seed=seed)
    columns = (np.asarray(found[name]).tolist() for name in ("S1", "S1_conf", "ST", "ST_conf") if name in found)
    return [Index(figure, key, *numbers) for key, *numbers in zip(design.keys, *columns, strict=True)]
