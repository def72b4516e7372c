"""The outcome of a run as sentences and rows of texts."""

from collections.abc import Mapping, Sequence
from typing import SupportsFloat

import numpy as np

from geometry.arrays import Array
from wirewear.base.frame import figure
from wirewear.base.words import counted
from wirewear.base.writing import json_text
from wirewear.comparison.maps import energy_ratio, line_through_origin, slides
from wirewear.results import BORNE, BORNE_IS, ELASTIC_LAYERS, PLAY_TRAVEL, SPRING_TRAVEL, RunResult
from wirewear.results.export import named_for_users
from wirewear.results.health import limit_of
from wirewear.results.scar import figure_volume
from wirewear.results.values import ENDLESS, FLOW, FLOW_CYCLES, RATCHETTING, SKIN


def slope_mm3_per_J(energy_J: Array, volume_mm3: Array) -> float:
    """Slope in mm³/J of the least-squares line through the origin of worn volumes (n,) over energies (n,); NaN if
    nothing was dissipated.
    """
    dissipated = np.max(energy_J, initial=0.0) > np.finfo(np.float64).tiny
    return line_through_origin(energy_J, volume_mm3).slope_mm3_per_J if dissipated else float("nan")


def sentence(result: RunResult) -> str:
    """A few sentences on a run's results: slip and regime, energy, worn volume and depths, or why no cycle is
    measured yet.
    """
    evolution = result.evolution
    if not evolution["cycle"].size:
        return f"{result.label}: no cycle is measured yet ({result.message})."
    slip, energy = evolution["slip_amplitude_um"], float(evolution["accumulated_energy_J"][-1])
    amplitude = float(evolution["displacement_amplitude_um"][-1])
    worn, (driven, other) = float(result.worn_volume_mm3[-1]), result.bodies
    depths = {body: float(evolution[f"max_depth_{body}_um"][-1]) for body in result.bodies}
    text = (
        beyond_strength(result)
        + beyond_fretting(result, amplitude)
        + taken_by_rig(result.label, amplitude, result.settings)
        + (
            f"{result.label}: after {cycles_of(evolution['cycle'][-1])} the surfaces slip ±{length(slip[-1])} of the "
            f"±{length(amplitude)} imposed (at first ±{length(slip[0])}), in {regime(result)}."
        )
    )
    if worn > 0.0:
        where = f" on {said}" if (said := result.extent.said) else ""
        text += (
            f" {energy:.3g} J of friction{where} have worn {figure_volume(worn)}: {depths[other]:.3g} µm deep in the "
            f"{result.called(other)}, {depths[driven]:.3g} µm in the {result.called(driven)}."
        )
    text += flow_sentence(result.settings)
    for body in result.bodies:
        through = [f"at cycle {counted(round(cycle))}" if cycle else "not yet" for cycle in result.worn_through(body)]
        if through:
            text += f" The {result.called(body)}'s layers, from the outermost, are worn through {', '.join(through)}."
        if body in result.settings.get(ELASTIC_LAYERS, {}):
            whole = float(result.layer_faces_um(body)[-1])
            text += (
                f" They are of another material, which changes pressures and contact: at the deepest place "
                f"{max(whole - depths[body], 0.0):.3g} of {whole:.3g} µm are left."
            )
    return text if result.status == "complete" else f"{text} The run is {result.status}: {result.message}."


def beyond_strength(result: RunResult) -> str:
    """Sentence if the pressure exceeds what any body bears; "" if it does not, or the result does not say."""
    ratio = result.quality.get("pressure_against_strength", 0.0)
    if ratio <= limit_of("pressure_against_strength"):
        return ""
    borne, yields = float(result.settings[BORNE]), "indentation_strain" in result.quality
    state = (
        "this lies beyond what plasticity was checked for"
        if yields
        else "such a state is impossible, as the bodies would flow, which is not simulated"
    )
    return (
        f"{result.label}: {state}: the pressure of {1e-3 * ratio * borne:.3g} GPa is more than the {1e-3 * borne:.3g} "
        f"GPa that they bear{' unhardened' * yields} ({result.settings[BORNE_IS]}). "
    )


def beyond_fretting(result: RunResult, amplitude_um: float) -> str:
    """Sentence if the stroke is longer than the thinnest body is thick; "" if it is not."""
    diameters = (one for scar in result.scars for one in (scar.diameter_mm, scar.diameter_along_mm))
    radius_um = 500.0 * min(diameters, default=float("inf"))
    if amplitude_um < radius_um:
        return ""
    return (
        f"{result.label}: this is no fretting: ±{length(amplitude_um)} is more than the radius of a body, "
        f"{length(radius_um)}; displacement_amplitude_um may be in another unit. "
    )


def flow_sentence(settings: Mapping[str, SupportsFloat]) -> str:
    """Sentence on whether metal that flows shakes down; "" of settings without any.

    settings: of a result.
    """
    if FLOW_CYCLES not in settings:
        return ""
    count = cycles_of(float(settings[FLOW_CYCLES]))
    flow, left = (f"{100.0 * float(settings[name]):.2g} %" for name in (FLOW, RATCHETTING))
    if float(settings[ENDLESS]):
        return f" Unworn, the metal flows without end under the sliding contact, after {count}."
    if not float(settings[FLOW_CYCLES]):
        return " The metal is pressed; flow by sliding is not followed, since the contact sticks or slides far."
    if not float(settings[FLOW]):
        skin = ", but for its skin" if float(settings.get(SKIN, 0.0)) else ""
        return f" Unworn, the metal shakes down within {count}{skin}."
    known = "its skin shears more, and strains beneath it are known to 0.3 %"
    return f" Unworn, the metal flows by a strain of {flow} a cycle after {count} and ratchets by {left}; {known}."


def taken_by_rig(label: str, amplitude_um: float, settings: Mapping[str, SupportsFloat]) -> str:
    """Sentence if rig and play take up the whole stroke before friction is overcome; "" if they do not. label: names
    the run. settings: of the result; those of older versions lack the values, which then count as 0.
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
    """Length in µm as text with three digits, in mm from there on where it needs more."""
    return f"{round(value_um, 6):.3g} µm" if abs(value_um) < 999.5 else f"{1e-3 * value_um:.3g} mm"


def cycles_of(number: float) -> str:
    """Number of cycles as text, such as "1 cycle" or "10 000 cycles"."""
    return f"{counted(number)} cycle{'' if round(number) == 1 else 's'}"


def regime(result: RunResult) -> str:
    """Gross slip, partial slip or mixed regime of a run's cycles in words, or that the contact opens; for criteria see
    `slides`.
    """
    if any(float(loop.normal_force_N.min()) <= 0.0 for loop in result.loops):
        return "a contact that opens within its cycles"
    evolution = result.evolution
    amplitude = evolution["displacement_amplitude_um"]
    energy, force = evolution["dissipated_energy_mJ"], evolution["max_tangential_force_N"]
    whole = slides(energy, amplitude, evolution["slip_amplitude_um"], force)
    whole = whole[np.isfinite(energy_ratio(energy, amplitude, force))]
    if not whole.size or whole.all():
        return "gross slip throughout" if whole.size else "no loop that encloses energy"
    return "both partial and gross slip (a mixed regime)" if whole.any() else "partial slip throughout"


def balance(result: RunResult) -> list[tuple[str, str]]:
    """Rows (name, value) of a run's friction energy, worn volumes, and measured and stated wear coefficient, as
    texts.
    """
    evolution, study = result.evolution, result.study
    energy = evolution["accumulated_energy_J"]
    volumes, both = {body: evolution[f"worn_volume_{body}_mm3"] for body in result.bodies}, result.worn_volume_mm3
    rows = [("friction energy that wore, in all", f"{energy[-1]:.4g} J")]
    rows += [
        (f"worn volume of the {result.called(body)}", figure_volume(float(own[-1]))) for body, own in volumes.items()
    ]
    rows.append(("worn volume of both bodies", figure_volume(float(both[-1]))))
    rows.append(
        ("volume per energy, from the line through all points", f"{figure(slope_mm3_per_J(energy, both))} mm³/J")
    )
    stated = (study.get("wear") or {}).get("energy_wear_coefficient_mm3_per_J")
    if stated is not None:
        rows.append(("wear coefficient that the study states", f"{figure(stated)} mm³/J"))
    return rows


def settings_rows(values: Mapping[str, object], place: str = "") -> list[tuple[str, str]]:
    """Rows (dotted name, value) of nested settings as texts, numbers with six digits; place: name of the table around
    them.
    """
    rows: list[tuple[str, str]] = []
    for key, value in values.items():
        name = f"{place}.{key}" if place else str(key)
        if isinstance(value, Mapping):
            rows += settings_rows(value, name)
        else:
            rows.append((name, f"{value:.6g}" if isinstance(value, float) else str(value)))
    return rows


def runs_json(results: Sequence[RunResult]) -> str:
    """JSON list with an object for each run: names, the sentence that sums it up, the last row of the evolution, and
    quality measures with their limits.
    """
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
        "flow": {
            name: float(result.settings[name])
            for name in (FLOW_CYCLES, FLOW, RATCHETTING, SKIN, ENDLESS)
            if name in result.settings
        },
        "quality": {
            name: {"worst": worst, "limit": limit_of(name), "sound": worst <= limit_of(name)}
            for name, worst in result.quality.items()
        },
    }
