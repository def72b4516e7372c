"""Fretting tests, from experiment records and simulation results, as the points that maps show."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.base.files import TABLE_FILE_NAME
from wirewear.base.recognising import Held, require_no_other
from wirewear.comparison.maps import (
    FreshContact,
    RegressionLine,
    fresh_contact,
    line_through_origin,
    line_with_threshold,
)
from wirewear.diagnosis.fit.fit import tables_of_record
from wirewear.diagnosis.fit.stiffness import rig_compliance
from wirewear.loops import LoopError, LoopFigures
from wirewear.loops.figures import RegimeOfTest, regime_of
from wirewear.records import AnyRecord, read_record
from wirewear.records.common_tables import Source
from wirewear.records.evolution_checks import accumulated_energy_J
from wirewear.records.exporting import true_loop
from wirewear.records.values import MeasuredLoop
from wirewear.results import RunResult, read_loops, read_results
from wirewear.test.lengths import WHOLE, Extent

REGIMES: tuple[RegimeOfTest, ...] = ("partial slip", "mixed", "gross slip")


@dataclass(frozen=True)
class SlidingMap:
    """Sliding criteria of one cycle, means over the repeats: energy_ratio A = E_d/(4 δa Q*), system_free_ratio B =
    E_d/(4 δ0 Q*).
    """

    cycle: int
    energy_ratio: float
    system_free_ratio: float


@dataclass(frozen=True)
class WornTest:
    """Friction energy of one test on fresh specimens in J, and the volume worn off both bodies in mm³."""

    energy_J: float
    volume_mm3: float


@dataclass(frozen=True, eq=False)
class MappedTest:
    """One test with one or several repeats, as a point of maps."""

    name: str  #: Title of the test.
    source: Source | Literal["record"]  #: Origin of the data; "record" if a record does not state it.
    path: str  #: Path that it was read from.
    normal_load_N: float  #: Mean of the loops' median load, or the asked load.
    displacement_amplitude_um: float  #: δa, mean of all loops.
    worn: tuple[WornTest, ...]  #: Energy and volume of each repeat that states both.
    slip_amplitude_um: tuple[float, float] = (float("nan"), float("nan"))  #: δ0 at the first and at the last cycle.
    regime: RegimeOfTest = "partial slip"  #: "mixed" if only some loops slide as a whole.
    sliding: tuple[SlidingMap, ...] = ()  #: Criteria of sliding by cycle.
    cracks: str | None = None  #: "found" or "none", where the test's owner looked for them.
    contact: FreshContact | None = None  #: The fresh contact behind its rig; None where too little is known of it.
    friction: float = float("nan")  #: Coefficient by geometry, mean of all loops; NaN where none slides.
    extent: Extent = WHOLE  #: Extent of the contact; load, energies and volumes are per mm of a line contact.

    @property
    def repeats(self) -> int:
        return len(self.worn)

    @property
    def energy_J(self) -> float:
        """Mean friction energy of a repeat in J; NaN if unknown."""
        return float(np.mean([one.energy_J for one in self.worn])) if self.worn else float("nan")

    @property
    def volume_mm3(self) -> float:
        """Mean worn volume of a repeat in mm³; NaN if unknown."""
        return float(np.mean([one.volume_mm3 for one in self.worn])) if self.worn else float("nan")


def lines_of(tests: Iterable[MappedTest]) -> tuple[RegressionLine | None, RegressionLine | None]:
    """Two regression lines of worn volume over friction energy of all repeats: through the origin, and with a
    threshold. Both are None if no repeat states both. The second is also None if there are fewer than three repeats, or
    if their energies differ by less than a factor of 1.5.
    """
    worn = [one for test in tests for one in test.worn if one.energy_J > 0.0]
    if not worn:
        return None, None
    energy, volume = (np.array([getattr(one, name) for one in worn]) for name in ("energy_J", "volume_mm3"))
    # Energies of tests must differ by this factor for a threshold to exceed their scatter.
    spread = energy.size >= 3 and float(energy.max() / energy.min()) > 1.5
    return line_through_origin(energy, volume), line_with_threshold(energy, volume) if spread else None


Read = tuple[MappedTest, list[tuple[int, LoopFigures]]]


def _figures(loops: Sequence[MeasuredLoop], load_N: float) -> list[tuple[int, LoopFigures]]:
    found = []
    for loop in loops:
        with suppress(LoopError):
            found.append((loop.cycle, loop.figures(load_N)))
    return found


def fretting_tests(path: Path) -> list[MappedTest]:
    """The test of a record, or the tests of a result, one for each variant; line contacts for one millimetre of their
    length. path: folder of a record, or file or folder of results. Raises RecordError if the record cannot be read, or
    none of its loops can be analysed; ResultError if the result cannot be read.
    """
    if path.name != TABLE_FILE_NAME and not (path / TABLE_FILE_NAME).is_file():
        require_no_other(path, RecordError, Held.RECORD, Held.RUN)
        return [_of_result(result, path) for result in read_results(path)]
    return [fretting_test(read_record(path), path)]


def fretting_test(record: AnyRecord, path: Path) -> MappedTest:
    """The test of a record, which was read from a path; see `fretting_tests`. Raises RecordError if none of its loops
    can be analysed.
    """
    asked, extent = record.tables.conditions, record.tables.extent
    loops = _figures(record.loops, asked.normal_load_N)
    loads = [float(np.nanmedian(one.normal_force_N)) for one in record.loops if one.normal_force_N is not None]
    load = float(np.mean(loads)) if loads else asked.normal_load_N
    contact = None
    with suppress(RecordError):
        contact = fresh_contact(tables_of_record(record))
    test = MappedTest(
        name=record.name,
        source=record.tables.metadata.source or "record",
        path=str(path),
        normal_load_N=load * extent.share,
        displacement_amplitude_um=asked.displacement_amplitude_um,
        worn=worn_in(record),
        cracks=record.tables.metadata.cracks,
        contact=None if contact is None else _behind_measured_rig(contact, record, loops),
        extent=extent,
    )
    return completed(test, loops)


def _of_result(result: RunResult, path: Path) -> MappedTest:
    result = result.computed
    evolution = result.evolution
    worn: tuple[WornTest, ...] = ()
    if evolution["cycle"].size and (volume := float(result.worn_volume_mm3[-1])) > 0.0:
        worn = (WornTest(float(evolution["accumulated_energy_J"][-1]), volume),)
    conditions = result.study.get("conditions", {})
    load = float(conditions.get("normal_load_N", np.nan))
    return completed(
        MappedTest(
            name=result.label,
            source="simulated",
            path=str(path),
            normal_load_N=load,
            displacement_amplitude_um=float(conditions.get("displacement_amplitude_um", np.nan)),
            worn=worn,
            contact=fresh_contact(result.study),
            extent=result.extent,
        ),
        _figures([true_loop(loop) for loop in read_loops(result)], load),
    )


def completed(test: MappedTest, loops: Sequence[tuple[int, LoopFigures]]) -> MappedTest:
    """Copy of the test with the figures of its loops; loops: pairs of cycle and figures. Raises RecordError if there
    are none.
    """
    if not loops:
        raise RecordError(f"none of the loops of {test.path} can be analysed.")
    cycles = sorted({cycle for cycle, _ in loops})
    by_cycle = {cycle: [figures for at, figures in loops if at == cycle] for cycle in cycles}
    first, last = (_mean([one.slip_amplitude_um.value for one in by_cycle[cycles[end]]]) for end in (0, -1))
    measured = [one.friction_geometry_independent for _, one in loops]
    return replace(
        test,
        displacement_amplitude_um=_mean([one.displacement_amplitude_um.value for _, one in loops]),
        slip_amplitude_um=(first, last),
        regime=regime_of(one for _, one in loops),
        sliding=tuple(_sliding(cycle, own) for cycle, own in by_cycle.items()),
        friction=_mean([one.value for one in measured if one is not None]),
    )


def _sliding(cycle: int, loops: Sequence[LoopFigures]) -> SlidingMap:
    ratios = ([getattr(one, name) for one in loops] for name in ("energy_ratio", "system_free_ratio"))
    return SlidingMap(cycle, *(_mean([one.value for one in own if one is not None]) for own in ratios))


def worn_in(record: AnyRecord) -> tuple[WornTest, ...]:
    """Friction energy and worn volume of each repeat that shows both bodies' scars and an energy; per mm of a line
    contact's length.
    """
    volumes, per = [*record.worn_volumes_mm3.values()], record.tables.extent.share
    return tuple(
        WornTest(per * energy, per * sum(body[repeat] for body in volumes))
        for repeat in (sorted(set.intersection(*map(set, volumes))) if volumes else ())
        if (energy := accumulated_energy_J(record, repeat)) is not None
    )


def _behind_measured_rig(
    contact: FreshContact, record: AnyRecord, loops: Sequence[tuple[int, LoopFigures]]
) -> FreshContact:
    """Contact with the rig compliance that the first loops show, 1/K_rig = 1/K_t,m − 1/K_c; unchanged if they show
    none.
    """
    known = [(cycle, one.measured_stiffness_N_per_um) for cycle, one in loops]
    stiffness = [(cycle, one.value) for cycle, one in known if one is not None]
    own = record.tables.contact_stiffness_N_per_um
    if not stiffness or own is None:
        return contact
    first = min(cycle for cycle, _ in stiffness)
    mean = _mean([value for cycle, value in stiffness if cycle == first])
    return replace(contact, rig_um_per_N=rig_compliance(mean, own))


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if values else float("nan")
