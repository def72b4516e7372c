"""The page of the runs of a study side by side, in one file, and what a run came to in sentences and rows."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.frame import figure
from wirewear.base.quantity import counted
from wirewear.base.writing import json_text, write_text, writing
from wirewear.loops.opening import ENERGY_TRANSITION, SYSTEM_FREE_TRANSITION
from wirewear.results import PLAY_TRAVEL, SPRING_TRAVEL, RunResult
from wirewear.results.flat import named_for_users
from wirewear.results.quality import health, limit_of
from wirewear.results.scar import called
from wirewear.views.run_data import page_data, slope_mm3_per_J
from wirewear.views.run_maps import TRANSITION, energy_ratio


def sentence(result: RunResult) -> str:
    """What came out, for a reader in a hurry."""
    evolution = result.evolution
    if not evolution["cycle"].size:
        return f"{result.label}: no cycle is measured yet ({result.message})."
    slip, energy = evolution["slip_amplitude_um"], float(evolution["accumulated_energy_J"][-1])
    amplitude = float(evolution["displacement_amplitude_um"][-1])
    worn, (driven, other) = float(result.worn_volume_mm3[-1]), result.bodies
    depths = {body: float(evolution[f"max_depth_{body}_um"][-1]) for body in result.bodies}
    text = taken_by_rig(result.label, amplitude, result.settings) + (
        f"{result.label}: after {cycles_of(evolution['cycle'][-1])} the surfaces slip ±{length(slip[-1])} of the "
        f"±{length(amplitude)} imposed (at first ±{length(slip[0])}), in {regime(result)}."
    )
    if worn > 0.0:
        where = f" on {result.length_mm:g} mm of the contact" if result.length_mm else ""
        text += (
            f" {energy:.3g} J of friction{where} have worn {figure_volume(worn)}: {depths[other]:.3g} µm deep in the "
            f"{called(other)}, {depths[driven]:.3g} µm in the {called(driven)}."
        )
    return text if result.status == "complete" else f"{text} The run is {result.status}: {result.message}."


def taken_by_rig(label: str, amplitude_um: float, settings: Mapping[str, Any]) -> str:
    """A sentence where rig and play give way by the whole stroke before friction is overcome; else nothing.

    settings: of a result; those of earlier versions do not say.
    """
    springs, play = (float(settings.get(name, 0.0)) for name in (SPRING_TRAVEL, PLAY_TRAVEL))
    if springs + play < amplitude_um:
        return ""
    parts = [f"µP/K = {length(springs)}"] if springs > 0.0 else []
    parts += [f"half the free play = {length(play)}"] if play > 0.0 else []
    what = "the rig" if not play else "the free play" if not springs else "the rig with its free play"
    return (
        f"{label}: {what} takes the whole stroke, so the contact sticks at least in its middle: "
        f"{' and '.join(parts)} to either side {'are' if len(parts) > 1 else 'is'} no less than "
        f"δa = {length(amplitude_um)}. "
    )


def length(value_um: float) -> str:
    """A length in µm to three digits; what is below a picometre is none."""
    return f"{round(value_um, 6):.3g} µm"


def cycles_of(number: float) -> str:
    """For example: 1 cycle, 10 000 cycles."""
    return f"{counted(number)} cycle{'' if round(number) == 1 else 's'}"


def regime(result: RunResult) -> str:
    """Gross slip, partial slip, or both over the test, by the measured loops: their energy ratio, or their width where
    the slopes of worn scars carry more force than friction does.
    """
    evolution = result.evolution
    amplitude = evolution["displacement_amplitude_um"]
    ratio = energy_ratio(evolution["dissipated_energy_mJ"], amplitude, evolution["max_tangential_force_N"])
    wide = evolution["slip_amplitude_um"] / amplitude > ENERGY_TRANSITION / SYSTEM_FREE_TRANSITION
    slides = ((ratio > ENERGY_TRANSITION) | wide)[np.isfinite(ratio)]
    if not slides.size or slides.all():
        return "gross slip throughout" if slides.size else "no loop that encloses energy"
    return "both partial and gross slip (a mixed regime)" if slides.any() else "partial slip throughout"


def figure_volume(volume_mm3: float) -> str:
    """A worn volume in the unit in which it is a number to remember."""
    return f"{1e9 * volume_mm3:.3g} µm³" if volume_mm3 < 1e-6 else f"{1e3 * volume_mm3:.3g}·10⁻³ mm³"


def balance(result: RunResult) -> list[tuple[str, str]]:
    """Energies and volumes of a run and what they should be, as rows."""
    evolution, study = result.evolution, result.study
    energy = evolution["accumulated_energy_J"]
    volumes, both = {body: evolution[f"worn_volume_{body}_mm3"] for body in result.bodies}, result.worn_volume_mm3
    rows = [("friction energy that wore, in all", f"{energy[-1]:.4g} J")]
    rows += [(f"worn volume of the {called(body)}", figure_volume(float(own[-1]))) for body, own in volumes.items()]
    rows.append(("worn volume of both bodies", figure_volume(float(both[-1]))))
    rows.append(
        ("volume per energy, from the line through all points", f"{figure(slope_mm3_per_J(energy, both))} mm³/J")
    )
    stated = (study.get("wear") or {}).get("energy_wear_coefficient_mm3_per_J")
    if stated is not None:
        rows.append(("wear coefficient that the study states", f"{figure(stated)} mm³/J"))
    return rows


def settings_rows(values: Mapping[str, Any], place: str = "") -> list[tuple[str, str]]:
    """Nested settings as rows of dotted names; numbers to six digits, lists as long as they are."""
    rows: list[tuple[str, str]] = []
    for key, value in values.items():
        name = f"{place}.{key}" if place else str(key)
        if isinstance(value, Mapping):
            rows += settings_rows(value, name)
        else:
            rows.append((name, f"{value:.6g}" if isinstance(value, float) else str(value)))
    return rows


PAGE_NAME = "report.html"
HERE = Path(__file__).parent

_SCRIPTS = ("fretting_log", "slider", "run")


def runs_json(results: Sequence[RunResult]) -> str:
    """A list with an object for each run: its sentence, its last row of the evolution, its qualities and limits."""
    return json_text([_run(result) for result in results])


def _run(result: RunResult) -> dict[str, object]:
    columns = named_for_users(result, result.evolution)
    last = {name: float(column[-1]) for name, column in columns.items() if len(column)}
    return {
        "name": result.name,
        "variant": result.variant,
        "fidelity": result.fidelity,
        "status": result.status,
        "sentence": sentence(result),
        "last": last,
        "quality": {
            name: {"worst": worst, "limit": limit_of(name), "sound": worst <= limit_of(name)}
            for name, worst in result.quality.items()
        },
    }


def run_page(results: Sequence[RunResult]) -> str:
    """The page of runs, all of one study. Raises ResultError if none has measured a cycle yet."""
    shown = [result for result in results if len(result.evolution["cycle"])]
    if not shown:
        raise ResultError("nothing is measured yet, so there is nothing to report")
    data = page_data(shown)
    scripts = (frame.HERE / "charts.js", frame.HERE / "surface.js", *(HERE / f"{one}.js" for one in _SCRIPTS))
    return frame.rendered(
        HERE / "run.html",
        {
            "name": shown[0].name,
            "fidelity": shown[0].fidelity,
            "results": shown,
            "maps": bool(data["runs"][0]["conditions"]),
            "sentences": [sentence(result) for result in results],
            "complete": all(result.status == "complete" for result in results),
            "balance": [balance(result) for result in shown],
            "transition": TRANSITION,
            "health": health(shown),
            "study": [settings_rows(result.study) for result in shown],
            "settings": [settings_rows(result.settings) for result in shown],
            "data": frame.embedded(data),
            "script": frame.script(*scripts),
        },
    )


def write_page(results: Sequence[RunResult], folder: Path) -> Path:
    """Write the page of runs, all of one study, as report.html into a folder and return its path.
    Raises ResultError if no run has measured a cycle yet, or the page cannot be written.
    """
    text = run_page(results)
    with writing(ResultError, f"cannot write the page to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return write_text(folder / PAGE_NAME, text)
