"""What stands on the page of a line contact's run; everything is per mm of thickness."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from wirewear.pictures.colours import VARIANT_COLOURS
from wirewear.pictures.smooth import smooth_curve
from wirewear.planar.results import BODIES, PlanarResult, is_planar_result, read_planar_result
from wirewear.results import RESULT_FILE_NAME
from wirewear.views import run_wording as wording
from wirewear.views.run_data import DASHES, LOOP_POINTS, numbers, pressure_courses
from wirewear.views.run_shared import measured, page_of

PROFILE_COLUMNS = ("x_um", "depth_um", "pressure_MPa", "slip_amplitude_um")

#: Panels over the cycles: the name of each in the page, and its title.
PANELS = (
    ("amplitudes", "Displacement and slip amplitude"),
    ("energy", "Energy per cycle"),
    ("force", "Largest tangential force"),
    ("worn", "Deepest wear"),
    ("peak", "Largest pressure"),
    ("volume", "Worn area against friction energy"),
)


def line_contacts_at(path: Path) -> tuple[PlanarResult, ...]:
    """The runs of line contacts in a file, in a run's folder or in those of its variants; none where others are.

    Raises:
        ResultError: a file of such a run is damaged.
    """
    files = [path / RESULT_FILE_NAME, *sorted(path.glob(f"*/{RESULT_FILE_NAME}"))] if path.is_dir() else [path]
    return tuple(read_planar_result(file) for file in files if is_planar_result(file))


def line_page(results: Sequence[PlanarResult]) -> str:
    """The page of runs, all of one study.

    Raises:
        ResultError: none has measured a cycle yet.
    """
    shown = measured(results)
    data = {"runs": [_run(result, index) for index, result in enumerate(shown)]}
    special = {"labels": [_label(result) for result in shown], "panels": PANELS}
    return page_of("line", results, [sentence(result) for result in shown], data, special)


def sentence(result: PlanarResult) -> str:
    """What came out, for a reader in a hurry."""
    evolution = result.evolution
    slip, amplitude = evolution["slip_amplitude_um"], float(evolution["displacement_amplitude_um"][-1])
    text = wording.taken_by_rig(_label(result), amplitude, result.settings) + (
        f"{_label(result)}: after {wording.cycles_of(evolution['cycle'][-1])} the surfaces slip "
        f"±{wording.length(slip[-1])} of the ±{wording.length(amplitude)} imposed (at first "
        f"±{wording.length(slip[0])})."
    )
    depths = {body: float(evolution[f"{body}_max_depth_um"][-1]) for body in BODIES}
    if max(depths.values()) > 0.0:
        energy = float(evolution["accumulated_energy_J_per_mm"][-1])
        text += (
            f" {energy:.3g} J/mm of friction have worn the specimen {depths['specimen']:.3g} µm deep, the pad "
            f"{depths['pad']:.3g} µm."
        )
    return text if result.status == "complete" else f"{text} The run is {result.status}: {result.message}."


def _label(result: PlanarResult) -> str:
    return result.variant or result.name


def _run(result: PlanarResult, index: int) -> dict[str, Any]:
    loops = sorted(result.loops, key=lambda loop: loop.cycle)
    curves = [smooth_curve(loop.displacement_um, loop.tangential_force_N_per_mm, LOOP_POINTS) for loop in loops]
    return {
        "label": _label(result),
        "color": VARIANT_COLOURS[index % len(VARIANT_COLOURS)],
        "dash": DASHES[index % len(DASHES)],
        "evolution": {name: numbers(column) for name, column in result.evolution.items()},
        "pressures": pressure_courses(result.evolution, result.settings),
        "loops": [
            {"cycle": loop.cycle, "x": numbers(x), "q": numbers(q)} for loop, (x, q) in zip(loops, curves, strict=True)
        ],
        "profiles": [
            {"cycle": cycle} | {body: _profile(result, cycle, body) for body in BODIES}
            for cycle in sorted({profile.cycle for profile in result.profiles})
        ],
    }


def _profile(result: PlanarResult, cycle: int, body: str) -> dict[str, list[float | None]]:
    profile = result.profile(cycle, body)
    return {name: numbers(getattr(profile, name)) for name in PROFILE_COLUMNS}
