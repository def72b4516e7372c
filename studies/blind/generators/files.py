"""Records on disk without a trace: every number of a column has the same width, every file the same time.

Sizes of files then follow from the number of rows alone, which the nuisances decide.
"""

import hashlib
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from studies.blind.errors import BlindError
from studies.blind.generators.cases import Case
from studies.blind.generators.line_nominal import LineNominal
from studies.blind.generators.nominal import Nominal
from wirewear.base.files import toml_text
from wirewear.base.writing import folder_in_one_step, writing
from wirewear.records import AnyRecord, MeasuredProfile, MeasuredScar, RecordTables
from wirewear.records.contact_tables import RECORDS, LineRecordTables
from wirewear.records.tables import PointRecordTables

Array = NDArray[np.float64]

#: Scar maps reach beyond the scar that the statements lead one to expect, in steps of so many points a half-width.
MAP_MARGIN, MAP_POINTS = 1.25, 26

FILE_TIME_s = 946684800  #: Time of every file: 2000-01-01 00:00 UTC.

LOOP_FORMATS = {"time_s": "%09.6f", "displacement_um": "%+09.3f", "tangential_force_N": "%+09.4f"}
NORMAL_FORMAT = {"normal_force_N": "%+09.4f"}
EVOLUTION_FORMATS = {
    "displacement_amplitude_um": "%08.3f",
    "slip_amplitude_um": "%08.3f",
    "max_tangential_force_N": "%08.4f",
    "dissipated_energy_mJ": "%09.5f",
}
SCAR_FORMATS = {"x_um": "%+08.1f", "y_um": "%+08.1f", "depth_um": "%+09.3f"}


def conditions_table(nominal: Nominal | LineNominal) -> dict[str, Any]:
    """Load, stroke and cycles, in the words of records and studies alike."""
    return {
        "normal_load_N": nominal.load_N,
        "displacement_amplitude_um": nominal.amplitude_um,
        "frequency_Hz": nominal.frequency_Hz,
        "cycles": nominal.cycles,
    }


def record_tables(case: Case) -> PointRecordTables:
    """The tables of experiment.toml."""
    nominal, nuisances = case.nominal, case.nuisances
    stated = nominal.stated
    if nominal.stiffness_N_per_mm is not None:
        stated["tangential_stiffness_N_per_mm"] = nominal.stiffness_N_per_mm
    of_wires = nominal.kind == RecordTables.contact_kind
    tables = RECORDS[nominal.kind].model_validate(
        {
            "format": 1,
            "name": case.name,
            **({} if of_wires else {"contact": {"kind": nominal.kind}}),
            **nominal.tables,
            "conditions": {**conditions_table(nominal), "drive": nuisances.drive},
            "stated": stated,
            "noise": nuisances.stated_noise,
            "files": {"loops": "loops.csv"},
        }
    )
    return cast("PointRecordTables", tables)


def line_record_tables(nominal: LineNominal, name: str, noise: Mapping[str, float]) -> LineRecordTables:
    """The tables of a nominal line contact's record with this name and noise."""
    stated: dict[str, Any] = {
        "friction": nominal.friction,
        "pad_energy_wear_coefficient_mm3_per_J": nominal.pad_wear_mm3_per_J,
        "specimen_energy_wear_coefficient_mm3_per_J": nominal.specimen_wear_mm3_per_J,
    }
    if nominal.stiffness_N_per_mm is not None:
        stated["tangential_stiffness_N_per_mm"] = nominal.stiffness_N_per_mm
    return LineRecordTables.model_validate(
        {
            "format": 1,
            "name": name,
            "contact": {"kind": "cylinder-on-flat", "length_mm": nominal.length_mm},
            "pad": {"radius_mm": nominal.radius_mm, **_elastic(nominal.pad_MPa)},
            "specimen": _elastic(nominal.specimen_MPa),
            "conditions": {**conditions_table(nominal), "drive": "stroke"},
            "stated": stated,
            "noise": dict(noise),
            "files": {},
        }
    )


def _elastic(constants: tuple[float, float]) -> dict[str, float]:
    return {"youngs_modulus_MPa": constants[0], "poissons_ratio": constants[1]}


def scar_lines_um(nominal: Nominal, body: str) -> tuple[Array, Array]:
    """Lines of a scar map along and across the motion: of a size that follows from the statements alone."""
    along, across = (1e3 * MAP_MARGIN * reach for reach in nominal.scar_reach_mm)
    step = float(np.ceil(across / MAP_POINTS))
    return _lines(along + (nominal.amplitude_um if body == nominal.bodies[0] else 0.0), step), _lines(across, step)


def _lines(half: float, step: float) -> Array:
    count = int(np.ceil(half / step))
    return step * np.arange(-count, count + 1.0)


def write_traceless(folder: Path, record: AnyRecord) -> str:
    """Write a record in one step and return its SHA-256.
    Raises BlindError if the folder exists or cannot be written.
    """
    with writing(BlindError, f"cannot write {folder}"), folder_in_one_step(folder) as partial:
        names = {"loops": _loops(partial, record)}
        if record.evolution:
            names["evolution"] = _evolution(partial, record)
        worn = record.tables.worn
        for body in record.tables.body_names:
            if own := record.scars_of(body):
                names[f"{worn.name}_{body}"] = _surfaces(partial, f"{worn.name}_{body}.csv", own)
        tables = record.tables.model_copy(update={"files": type(record.tables.files)(**names)})
        text = toml_text(tables.model_dump(mode="json", exclude_none=True, exclude_unset=True))
        (partial / "experiment.toml").write_text(text, encoding="utf-8")
        for path in (*partial.iterdir(), partial):
            os.utime(path, (FILE_TIME_s, FILE_TIME_s))
    return record_hash(folder)


def record_hash(folder: Path) -> str:
    """SHA-256 of a record's files, names and contents. Raises BlindError if the record cannot be read."""
    digest = hashlib.sha256()
    try:
        for path in sorted(folder.iterdir()):
            digest.update(path.name.encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    except OSError as problem:
        raise BlindError(f"the record {folder} cannot be read ({problem.strerror or problem}).") from None
    return digest.hexdigest()


def _loops(folder: Path, record: AnyRecord) -> str:
    has_normal = record.loops[0].normal_force_N is not None
    formats = {**LOOP_FORMATS, **(NORMAL_FORMAT if has_normal else {})}
    blocks = []
    for loop in record.loops:
        count = loop.time_s.size
        leading = (np.full(count, loop.repeat), np.full(count, loop.cycle), np.arange(count))
        channels = [loop.time_s, loop.displacement_um, loop.tangential_force_N]
        blocks.append((*leading, *channels, *([] if loop.normal_force_N is None else [loop.normal_force_N])))
    return _write(folder, "loops.csv", {"repeat": "%d", "cycle": "%d", "sample": "%d", **formats}, blocks)


def _evolution(folder: Path, record: AnyRecord) -> str:
    blocks = [
        (
            np.full(part.columns["cycle"].size, part.repeat),
            *(part.columns[name] for name in ("cycle", *EVOLUTION_FORMATS)),
        )
        for part in record.evolution
    ]
    return _write(folder, "evolution.csv", {"repeat": "%d", "cycle": "%d", **EVOLUTION_FORMATS}, blocks)


def _surfaces(folder: Path, name: str, surfaces: Sequence[MeasuredScar | MeasuredProfile]) -> str:
    formats = {key: form for key, form in SCAR_FORMATS.items() if key in surfaces[0].points}
    blocks = [(np.full(one.points["x_um"].size, one.repeat), *one.points.values()) for one in surfaces]
    return _write(folder, name, {"repeat": "%d", **formats}, blocks)


def _write(
    folder: Path, name: str, formats: dict[str, str], blocks: Iterable[Sequence[Array | NDArray[np.int64]]]
) -> str:
    line = ",".join(formats.values())
    rows = [line % values for block in blocks for values in zip(*(column.tolist() for column in block), strict=True)]
    (folder / name).write_text("\n".join([",".join(formats), *rows]) + "\n", encoding="ascii")
    return name
