"""What stands on the page of a line contact's run; everything is per mm of thickness."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from wirewear.pictures.colours import VARIANT_COLOURS
from wirewear.pictures.smooth import smooth_curve
from wirewear.results import BODIES, RunResult
from wirewear.results.flat import named_for_users
from wirewear.views import run_wording as wording
from wirewear.views.run_data import DASHES, LOOP_POINTS, numbers, pressure_courses
from wirewear.views.run_shared import measured, page_of

#: Panels over the cycles: the name of each in the page, and its title.
PANELS = (
    ("amplitudes", "Displacement and slip amplitude"),
    ("energy", "Energy per cycle"),
    ("force", "Largest tangential force"),
    ("worn", "Deepest wear"),
    ("peak", "Largest pressure"),
    ("volume", "Worn area against friction energy"),
)


def line_page(results: Sequence[RunResult]) -> str:
    """The page of runs, all of one study.

    Raises:
        ResultError: none has measured a cycle yet.
    """
    shown = measured(results)
    data = {"runs": [_run(result, index) for index, result in enumerate(shown)]}
    special = {"labels": [result.label for result in shown], "panels": PANELS}
    return page_of("line", results, [sentence(result) for result in shown], data, special)


def sentence(result: RunResult) -> str:
    """What came out, for a reader in a hurry."""
    evolution = result.evolution
    slip, amplitude = evolution["slip_amplitude_um"], float(evolution["displacement_amplitude_um"][-1])
    text = wording.taken_by_rig(result.label, amplitude, result.settings) + (
        f"{result.label}: after {wording.cycles_of(evolution['cycle'][-1])} the surfaces slip "
        f"±{wording.length(slip[-1])} of the ±{wording.length(amplitude)} imposed (at first "
        f"±{wording.length(slip[0])})."
    )
    depths = {body: float(evolution[f"max_depth_{body}_um"][-1]) for body in BODIES}
    if max(depths.values()) > 0.0:
        energy = float(evolution["accumulated_energy_J"][-1])
        text += (
            f" {energy:.3g} J/mm of friction have worn the specimen {depths['specimen']:.3g} µm deep, the pad "
            f"{depths['pad']:.3g} µm."
        )
    return text if result.status == "complete" else f"{text} The run is {result.status}: {result.message}."


def _run(result: RunResult, index: int) -> dict[str, Any]:
    loops = sorted(result.loops, key=lambda loop: loop.cycle)
    curves = [smooth_curve(loop.displacement_um, loop.tangential_force_N, LOOP_POINTS) for loop in loops]
    return {
        "label": result.label,
        "color": VARIANT_COLOURS[index % len(VARIANT_COLOURS)],
        "dash": DASHES[index % len(DASHES)],
        "evolution": {name: numbers(column) for name, column in named_for_users(result, result.evolution).items()},
        "pressures": pressure_courses(result.evolution, result.settings),
        "loops": [
            {"cycle": loop.cycle, "x": numbers(x), "q": numbers(q)} for loop, (x, q) in zip(loops, curves, strict=True)
        ],
        "profiles": [
            {"cycle": cycle} | {body: _profile(result, cycle, body) for body in BODIES}
            for cycle in result.scar_cycles()
        ],
    }


def _profile(result: RunResult, cycle: int, body: str) -> dict[str, list[float | None]]:
    scar = result.scar(cycle, body)
    columns = {
        "x_um": scar.axial_um,
        "depth_um": scar.depth_um,
        "pressure_MPa": scar.pressure_MPa,
        "slip_amplitude_um": 0.25 * scar.slip_distance_um,
    }
    return {name: numbers(column.ravel()) for name, column in columns.items()}
