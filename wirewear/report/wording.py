"""What a run came to, in sentences and rows for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from wirewear.page.frame import figure
from wirewear.quantity import counted
from wirewear.report.data import slope_mm3_per_J
from wirewear.report.maps import TRANSITION, energy_ratio
from wirewear.results import RunResult

#: What each quality of a run says, and from where on it should be looked at.
QUALITIES: Mapping[str, tuple[str, float]] = {
    "force_balance": ("forces on the holder that do not balance, relative", 1e-6),
    "penetration": ("penetration of one body into the other, relative to the approach", 1e-4),
    "complementarity": ("pressure where the bodies do not touch, relative", 1e-4),
    "slip_direction_error_rad": ("angle between friction and slip [rad]", 1e-2),
    "elastic_slip": ("slip that a penalty lets through, relative", 1e-2),
    "loop_area_against_friction_work": ("area of a loop against friction work in the contact, relative", 5e-3),
    "volume_against_energy": ("worn volume against the wear law's, relative", 1e-3),
    "energy_against_loops": ("energy that wore against energy of the recorded loops, relative", 2e-2),
    "mirror_error": ("pressures against their mirror image on the way back, relative", 2e-2),
}


@dataclass(frozen=True)
class Health:
    """One closure: what it is, the worst value that each run met (None: not defined), from where on to look at it."""

    meaning: str
    worst: tuple[float | None, ...]
    limit: float

    @property
    def sound(self) -> bool:
        """Whether all values are below the limit."""
        return all(value is None or value <= self.limit for value in self.worst)


class Judged(Protocol):
    """A result that says how well it closes."""

    @property
    def quality(self) -> Mapping[str, float]:
        """The worst residuals met, by name."""


def health(results: Sequence[Judged]) -> list[Health]:
    """The closures of runs, in the order of QUALITIES; others follow by their names, without a limit."""
    known = [name for name in QUALITIES if any(name in result.quality for result in results)]
    others = sorted({name for result in results for name in result.quality if name not in QUALITIES})
    meanings = dict(QUALITIES) | {name: (name.replace("_", " "), float("inf")) for name in others}
    return [
        Health(meanings[name][0], tuple(result.quality.get(name) for result in results), meanings[name][1])
        for name in [*known, *others]
    ]


def sentence(result: RunResult) -> str:
    """What came out, for a reader in a hurry."""
    evolution = result.evolution
    if not evolution["cycle"].size:
        return f"{result.label}: no cycle is measured yet ({result.message})."
    slip, energy = evolution["slip_amplitude_um"], float(evolution["accumulated_energy_J"][-1])
    amplitude = float(evolution["displacement_amplitude_um"][-1])
    worn = float(evolution["worn_volume_moving_mm3"][-1] + evolution["worn_volume_fixed_mm3"][-1])
    depths = {wire: float(evolution[f"max_depth_{wire}_um"][-1]) for wire in ("fixed", "moving")}
    text = (
        f"{result.label}: after {cycles_of(evolution['cycle'][-1])} the wires slip ±{slip[-1]:.3g} µm of the "
        f"±{amplitude:.3g} µm imposed (at first ±{slip[0]:.3g} µm), in {regime(result)}."
    )
    if worn > 0.0:
        text += (
            f" {energy:.3g} J of friction have worn {figure_volume(worn)}: {depths['fixed']:.3g} µm deep in the fixed "
            f"wire, {depths['moving']:.3g} µm in the moving one."
        )
    return text if result.status == "complete" else f"{text} The run is {result.status}: {result.message}."


def cycles_of(number: float) -> str:
    """For example: 1 cycle, 10 000 cycles."""
    return f"{counted(number)} cycle{'' if round(number) == 1 else 's'}"


def regime(result: RunResult) -> str:
    """Gross slip, partial slip, or both over the test, by the energy ratio of the measured loops."""
    evolution = result.evolution
    ratio = energy_ratio(
        evolution["dissipated_energy_mJ"], evolution["displacement_amplitude_um"], evolution["max_tangential_force_N"]
    )
    slides = ratio[np.isfinite(ratio)] > TRANSITION
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
    volumes = {wire: evolution[f"worn_volume_{wire}_mm3"] for wire in ("moving", "fixed")}
    both = volumes["moving"] + volumes["fixed"]
    rows = [("friction energy that wore, in all", f"{energy[-1]:.4g} J")]
    rows += [(f"worn volume of the {wire} wire", figure_volume(float(own[-1]))) for wire, own in volumes.items()]
    rows.append(("worn volume of both wires", figure_volume(float(both[-1]))))
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
