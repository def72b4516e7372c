"""How far a line contact's figures lie from those without effects, over one test's scatter."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from studies.blind.generators.cases import Case
from studies.blind.generators.lines.readings import profile_at, read_test
from studies.blind.generators.nuisances import SpecimenDraw
from studies.blind.generators.sampling import Channels, loop_figures
from wirewear.effects import Effect
from wirewear.results import BODIES, RunResult

PROFILE_NOISE_um = 0.03  #: Noise of a profile's points.
COMPARED = (0.02, 0.2, 1.0)  #: Shares of the test at which gaps are sized.


def differences(nominal: RunResult, true: RunResult, changes: Sequence[Effect[Any]], case: Case) -> dict[str, float]:
    """What the case's effects change of figures, over one test's scatter: noise of the figure and that of specimens."""
    if not case.effects:
        return {}
    cycles = sorted({max(round(share * case.nominal.cycles), 1) for share in COMPARED})
    nothing = replace(case, effects=())
    same = SpecimenDraw()
    pairs = zip(
        read_test(nominal, (), nothing, same, cycles), read_test(true, changes, case, same, cycles), strict=True
    )
    rows = [(_figures(before), _figures(after)) for (_, before), (_, after) in pairs]
    found = {
        name: float(np.sqrt(np.mean([((a[name] - b[name]) / _scatter(case, b)[name]) ** 2 for b, a in rows])))
        for name in rows[0][0]
        if name != "normal_force_N" or case.nuisances.has_normal_force
    }
    if case.nuisances.has_scars:
        found |= _profile_differences(nominal, true, case)
    return {name: round(value, 3) for name, value in found.items()}


def _figures(channels: Channels) -> dict[str, float]:
    x, q, p = channels
    figures = dict(loop_figures(x, q))
    top, low = int(np.argmax(x)), int(np.argmin(x))
    # Travel from a reversal to half of the force, on either branch.
    half = 0.25 * float(np.ptp(q))
    falls, rises = np.roll(q, -top), np.roll(q, -low)
    down = int(np.argmax(falls < falls.max() - half))
    up = int(np.argmax(rises > rises.min() + half))
    figures["stick_um"] = 0.5 * (float(x[top] - x[(top + down) % x.size]) + float(x[(low + up) % x.size] - x[low]))
    figures["mean_force_N"] = float(q.mean())
    figures["normal_force_N"] = float(p.mean())
    return figures


def _scatter(case: Case, before: Mapping[str, float]) -> dict[str, float]:
    own, nominal, samples = case.nuisances, case.nominal, np.sqrt(case.nuisances.samples / 8.0)
    force = own.force_noise_N / samples
    place = own.displacement_noise_um / np.sqrt(4.0)
    friction, plateau = float(np.hypot(own.scatter.friction, own.scatter.load)), nominal.friction * nominal.load_N
    return {
        "displacement_amplitude_um": max(place, 1e-3 * nominal.amplitude_um),
        "slip_amplitude_um": float(np.hypot(place, 0.003 * nominal.amplitude_um)),
        "max_tangential_force_N": float(np.hypot(force, friction * plateau)),
        "dissipated_energy_mJ": float(np.hypot(0.003, friction)) * before["dissipated_energy_mJ"],
        "stick_um": float(np.hypot(place, 0.05 * before["stick_um"])),
        "mean_force_N": float(np.hypot(0.2 * own.force_noise_N, 0.002 * plateau)),
        "normal_force_N": float(np.hypot(force, own.scatter.load * nominal.load_N)),
    }


def _profile_differences(nominal: RunResult, true: RunResult, case: Case) -> dict[str, float]:
    scatter = case.nuisances.scatter
    spread = float(np.sqrt(scatter.wear**2 + scatter.friction**2 + scatter.load**2))
    found = {}
    for body in BODIES:
        x, before = profile_at(nominal, body, float(case.nominal.cycles))
        after = np.interp(x, *profile_at(true, body, float(case.nominal.cycles)), left=0.0, right=0.0)
        size = np.hypot(spread * float(before.max()), PROFILE_NOISE_um)
        inside = before > 0.05 * before.max()
        found[f"scar_{body}"] = float(np.sqrt(np.mean(((after - before)[inside] / size) ** 2)))
    return found
