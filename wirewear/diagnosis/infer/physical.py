"""The gap in physical units: slip amplitude, dissipated energy and force, before and after adding the effects."""

from collections.abc import Mapping

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.model.forward import LoopCourse, simulate
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.evolution import half_width, loop_area
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.profiles import ProfileDepths
from wirewear.diagnosis.observe.reduction import Observations


def physical_gap(
    states: WearStates, observed: Observations, before: Setup, after: Setup, cycles: tuple[int, ...]
) -> Mapping[str, tuple[float, float]]:
    """Mean distances of measured and computed loops over the held-out cycles, (before, after).

    Where no loop was held out, a scar alone, they are those of all loops; a distance that no loop shows is left out.
    """
    profiles = _profiles(states, observed, before, after)
    if not observed.loops:
        return profiles
    logged = {loop.cycle for loop in observed.loops}
    used = sorted(logged.intersection(cycles) or logged)
    at = np.array(used, dtype=float)
    courses = [simulate(states, setup, at) for setup in (before, after)]
    slip, energy, force = (
        np.array(rows).T for rows in zip(*(_figures(c, observed, used) for c in courses), strict=True)
    )
    found = {"slip_amplitude_um": slip, "dissipated_energy_percent": energy, "tangential_force_rms_N": force}
    known = {name: values[np.isfinite(values).all(axis=1)] for name, values in found.items()}
    return {name: (float(v[:, 0].mean()), float(v[:, 1].mean())) for name, v in known.items() if v.size} | profiles


def _profiles(
    states: WearStates, observed: Observations, before: Setup, after: Setup
) -> dict[str, tuple[float, float]]:
    """Root mean square of measured less computed depths along profiles; nothing where there are none."""
    layout = observed.layout
    keep = layout.of_kind(ProfileDepths)
    if not keep.any():
        return {}
    part = layout.taken(keep)
    mean = np.nanmean(observed.values[:, keep], axis=0)
    rest = [mean - part.observed(simulate(states, setup, part.cycles)) for setup in (before, after)]
    first, second = (float(np.sqrt(np.nanmean(one**2))) for one in rest)
    return {"profile_depth_um": (first, second)}


def _figures(course: LoopCourse, observed: Observations, cycles: list[int]) -> tuple[Array, Array, Array]:
    """Distances at each cycle: half width [µm], area [%], force at equal displacement on the plateaus [N]."""
    widths = half_width(course.displacement_um, course.tangential_force_N)
    areas = loop_area(course.displacement_um, course.tangential_force_N)
    slip, energy, force = [], [], []
    keep = observed.layout.of_kind(PlateauForce) & np.isin(observed.layout.cycle, cycles)
    plateaus = observed.layout.taken(keep)
    left = np.nanmean(observed.values[:, keep], axis=0) - plateaus.observed(course)
    for row, cycle in enumerate(cycles):
        here = [loop for loop in observed.loops if loop.cycle == cycle]
        slip.append(abs(float(np.mean([loop.half_width_um for loop in here])) - float(widths[row])))
        measured = float(np.mean([loop.energy_mJ for loop in here]))
        energy.append(100.0 * abs(float(areas[row]) / measured - 1.0))
        rest = left[plateaus.cycle == cycle]
        force.append(float(np.sqrt(np.mean(rest**2))) if rest.size else np.nan)
    return np.array(slip), np.array(energy), np.array(force)
