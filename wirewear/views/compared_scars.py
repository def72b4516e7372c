"""Simulated and measured scars on one grid, after registration."""

import warnings
from dataclasses import dataclass

import numpy as np

from wirewear.base.errors import ResultError
from wirewear.records.values import WIRES, Array, ExperimentRecord, MeasuredScar
from wirewear.results import RunResult, Scar
from wirewear.results.scar import worn_volume_mm3
from wirewear.views.registration import Registration, onto_simulated, register


@dataclass(frozen=True, eq=False)
class ScarPair:
    """One wire's scar at the test's end: depths [µm] over `x_um` (n_x,) and `y_um` (n_y,) in the simulated frame.

    `simulated` has shape (n_x, n_y), `measured` (repeats, n_x, n_y), NaN where a map has no points. Worn volumes are
    those of each measured map, and of the simulated scar at that map's points.
    """

    wire: str
    simulated_cycle: int
    repeats: tuple[int, ...]
    registrations: tuple[Registration, ...]
    x_um: Array
    y_um: Array
    simulated: Array
    measured: Array
    simulated_volumes_mm3: tuple[float, ...]
    measured_volumes_mm3: tuple[float, ...]

    @property
    def mean(self) -> Array:
        """Mean of the repeats, (n_x, n_y); NaN where none has a point."""
        with warnings.catch_warnings():
            # Points that no map covers are meant to stay NaN.
            warnings.simplefilter("ignore", RuntimeWarning)
            mean: Array = np.nanmean(self.measured, axis=0)
        return mean

    def section_along(self, depth: Array) -> Array:
        """Depth (n_x,) on the grid line nearest to y = 0."""
        section: Array = depth[:, int(np.argmin(np.abs(self.y_um)))]
        return section

    def section_across(self, depth: Array) -> Array:
        """Depth (n_y,) on the grid line nearest to x = 0."""
        section: Array = depth[int(np.argmin(np.abs(self.x_um)))]
        return section


def scar_pairs(result: RunResult, record: ExperimentRecord) -> tuple[tuple[ScarPair, ...], tuple[str, ...]]:
    """Pairs of the wires of which both have a scar at the end, and sentences about what was left out."""
    pairs, notes = [], []
    for wire in WIRES:
        measured = [scar for scar in record.scars_of(wire) if np.isfinite(scar.depth_um).any()]
        if not measured:
            notes.append(f"the record has no scar of the {wire} wire")
            continue
        try:
            simulated = result.scar(record.tables.conditions.cycles, wire)
        except ResultError:
            notes.append(f"the result has no scar of the {wire} wire at the end of the test")
            continue
        registrations = tuple(register(scar, simulated) for scar in measured)
        # The map with most points sets the grid; what other maps lack there is missing.
        widest = max(measured, key=lambda scar: scar.depth_um.size)
        x, y = widest.x_um, widest.y_um
        maps = [onto_simulated(scar, own, x, y) for scar, own in zip(measured, registrations, strict=True)]
        pairs.append(
            ScarPair(
                wire=wire,
                simulated_cycle=simulated.cycle,
                repeats=tuple(scar.repeat for scar in measured),
                registrations=registrations,
                x_um=x,
                y_um=y,
                simulated=simulated.sampled(x, y),
                measured=np.stack(maps),
                simulated_volumes_mm3=tuple(
                    _seen_by(scar, own, simulated) for scar, own in zip(measured, registrations, strict=True)
                ),
                measured_volumes_mm3=tuple(scar.volume_mm3 for scar in measured),
            )
        )
    return tuple(pairs), tuple(notes)


def _seen_by(measured: MeasuredScar, registration: Registration, simulated: Scar) -> float:
    """Volume [mm³] of the simulated scar at a measured map's points: a map that misses a part misses it of both."""
    at = registration.simulated_point(*np.meshgrid(measured.x_um, measured.y_um, indexing="ij"))
    depth = np.where(np.isfinite(measured.depth_um), simulated.depth_at(*at), 0.0)
    return worn_volume_mm3(measured.x_um, measured.y_um, depth)
