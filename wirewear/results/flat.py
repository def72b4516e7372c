"""Results as flat tables, one row a sample, for spreadsheets and data frames: CSV and Parquet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wirewear.base.errors import ResultError
from wirewear.base.writing import in_one_step, write_csv, writing
from wirewear.results.checks import FloatArray
from wirewear.results.per_mm import per_mm
from wirewear.results.scar import FIELD_COLUMNS, WIRES
from wirewear.results.values import LOOP_COLUMNS, RunResult

if TYPE_CHECKING:
    import polars as pl


def evolution_table(result: RunResult) -> pl.DataFrame:
    """One row for each measured cycle."""
    import polars as pl

    return pl.DataFrame({name: np.array(column) for name, column in named_for_users(result, result.evolution).items()})


def loops_table(result: RunResult) -> pl.DataFrame:
    """One row for each sample of each recorded loop, with its cycle."""
    import polars as pl

    cycles = [np.full(loop.time_s.size, loop.cycle) for loop in result.loops]
    columns = {name: _joined([getattr(loop, name) for loop in result.loops]) for name in LOOP_COLUMNS}
    return pl.DataFrame({"cycle": _joined(cycles, np.int64)} | dict(named_for_users(result, columns)))


def scars_table(result: RunResult) -> pl.DataFrame:
    """One row for each point of each recorded scar; x lies along the motion, both from the first contact."""
    import polars as pl

    places = [scar.sliding_coordinates(scar.axial_um[:, None], scar.transverse_um[None, :]) for scar in result.scars]
    bodies = [np.full(scar.depth_um.size, scar.body) for scar in result.scars]
    columns = {
        "cycle": _joined([np.full(scar.depth_um.size, scar.cycle) for scar in result.scars], np.int64),
        "wire" if result.bodies == WIRES else "body": np.concatenate(bodies) if bodies else np.empty(0, dtype=str),
        "x_um": _joined([np.broadcast_to(x, s.depth_um.shape) for s, (x, _) in zip(result.scars, places, strict=True)]),
        "y_um": _joined([np.broadcast_to(y, s.depth_um.shape) for s, (_, y) in zip(result.scars, places, strict=True)]),
    }
    return pl.DataFrame(columns | {name: _joined([getattr(s, name) for s in result.scars]) for name in FIELD_COLUMNS})


def profiles_table(result: RunResult) -> pl.DataFrame:
    """One row for each point of each recorded profile of a line contact."""
    import polars as pl

    renamed = scars_table(result).rename({"slip_distance_um": "slip_amplitude_um"})
    return renamed.drop("y_um").with_columns(pl.col("slip_amplitude_um") / 4.0)


def named_for_users(result: RunResult, columns: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
    """Columns as tables and reports name them: those of a line contact per mm of its length."""
    return per_mm(columns, result.length_mm) if result.length_mm else columns


def tables_of(result: RunResult) -> dict[str, Callable[[RunResult], pl.DataFrame]]:
    """The tables of a result by their file's name."""
    worn: dict[str, Callable[[RunResult], pl.DataFrame]]
    worn = {"profiles": profiles_table} if result.length_mm else {"scars": scars_table}
    return {"evolution": evolution_table, "loops": loops_table, **worn}


def write_flat_tables(result: RunResult, folder: Path, ending: str) -> list[Path]:
    """Write the tables of a result as "csv" or "parquet"; return their paths.

    Raises:
        ResultError: the folder cannot be written.
    """
    with writing(ResultError, f"cannot write tables to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [_written(folder / f"{name}.{ending}", table(result)) for name, table in tables_of(result).items()]


def _written(path: Path, table: pl.DataFrame) -> Path:
    if path.suffix == ".csv":
        return write_csv(path, table)
    with in_one_step(path) as partial:
        table.write_parquet(partial)
    return path


def _joined(arrays: list[np.ndarray], dtype: type = np.float64) -> np.ndarray:
    return np.concatenate([array.ravel() for array in arrays]) if arrays else np.empty(0, dtype=dtype)
