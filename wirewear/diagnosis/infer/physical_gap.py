"""How far loops and profiles of a record lie from computed ones, in physical units, before and after an explanation."""

from collections.abc import Mapping

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.observe.along_branches import PlateauForce
from wirewear.diagnosis.observe.channels import half_width, loop_area
from wirewear.diagnosis.observe.reduction import Observations
from wirewear.diagnosis.observe.scars import ProfileDepths
from wirewear.diagnosis.surrogate.forward import PredictedLoops, simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.wear_states import WearStates


def physical_gap(
    states: WearStates, observed: Observations, before: SurrogateInputs, after: SurrogateInputs, cycles: tuple[int, ...]
) -> Mapping[str, tuple[float, float]]:
    """Mean distances of measured and computed loops over the given cycles, before and after adding effects, by a name
    with its unit such as "slip_amplitude_um". before, after: setups. If no loop is of these cycles, all loops count; a
    distance that no loop shows is left out.
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
    states: WearStates, observed: Observations, before: SurrogateInputs, after: SurrogateInputs
) -> dict[str, tuple[float, float]]:
    """Root mean square of measured less computed depths along profiles; nothing where there are none."""
    layout = observed.layout
    keep = layout.of_kind(ProfileDepths)
    if not keep.any():
        return {}
    part = layout.taken(keep)
    mean = np.nanmean(observed.values[:, keep], axis=0)
    rest = mean - part.computed(states, before, after)
    first, second = (float(np.sqrt(np.nanmean(one**2))) for one in rest)
    return {"profile_depth_um": (first, second)}


def _figures(course: PredictedLoops, observed: Observations, cycles: list[int]) -> tuple[Array, Array, Array]:
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
