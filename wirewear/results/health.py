"""Qualities of a run: residuals and closures, their limits, and what helps where one is beyond its limit.

A closure is the difference of two values that should agree, such as a loop's area and the friction work. The names of
QUALITIES are those of `RunResult.quality`.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

ENERGIES_AGREE = 5e-3  #: Friction energies that differ by more than this share are not taken to agree.

#: Meaning and limit of each quality of a run.
QUALITIES: Mapping[str, tuple[str, float]] = {
    "force_balance": ("forces on the holder that do not balance, relative", 1e-6),
    "penetration": ("penetration of one body into the other, relative to the approach", 1e-4),
    "complementarity": ("pressure where the bodies do not touch, relative", 1e-4),
    "slip_direction_error_rad": ("angle between friction and slip [rad]", 1e-2),
    "elastic_slip": ("slip that a penalty lets through, relative", 1e-2),
    "loop_area_against_friction_work": ("area of a loop against friction work in the contact, relative", 2e-3),
    "volume_against_energy": ("worn volume against the wear law's, relative", 1e-3),
    "first_cycle_against_loop": ("energy that wore in the first cycle against its loop's, relative", ENERGIES_AGREE),
    "energy_against_loops": ("energy that wore against energy of the recorded loops, relative", ENERGIES_AGREE),
    "slip_against_loops": ("slip in the contact against the loop's width, over the contact's displacement", 2e-2),
    "depth_between_nodes": ("error of either body's largest depth by its elements, relative, estimated", 3e-2),
    "slip_between_nodes": ("error of loops' energies by the number of nodes that slip, relative, estimated", 5e-2),
    "law_between_nodes": ("error of laws other than Coulomb's by the fresh contact's elements, estimated", 2e-2),
    "pressure_against_strength": (
        "largest pressure against what the softer body bears, of which more is impossible",
        1.0,
    ),
    "indentation_strain": ("strain of the print, 0.2 a/R, beyond which plasticity of small strains ends", 0.1),
    "flow_energy": ("work on metal that flows, less friction, against what is plastic or stored, relative", 5e-3),
    "mirror_error": ("pressures against their mirror image on the way back, relative", 2e-2),
}

#: Qualities of the test itself, which do not depend on the mesh.
OF_THE_TEST = frozenset({"pressure_against_strength", "indentation_strain"})

#: Ends of sentences on how to reduce other qualities that are beyond their limits.
_OF_THE_PROGRAM = "is an error of the program: please report it with the study"
_REMEDIES: Mapping[str, str] = {
    "first_cycle_against_loop": "falls with more increments_per_wear_cycle and increments_per_cycle in [fidelity], "
    "mostly where little of the contact slips; no jump is yet part of it",
    "energy_against_loops": "falls with a smaller jump_tolerance in [fidelity] or with more loop_cycles in [log], not "
    "with the mesh",
    "slip_against_loops": _OF_THE_PROGRAM,
    "volume_against_energy": _OF_THE_PROGRAM,
    "flow_energy": _OF_THE_PROGRAM,
}


def remedies(beyond: Collection[str]) -> list[str]:
    """Sentences on how to reduce qualities beyond their limits, by name; none for those of the test itself."""
    # What the first cycle lacks, all cycles lack.
    beyond = set(beyond) - ({"energy_against_loops"} if "first_cycle_against_loop" in beyond else set())
    others = sorted(beyond - OF_THE_TEST - set(_REMEDIES))
    mesh = (
        [f"{_spoken(others)} mostly fall{'s' * (len(others) == 1)} with a finer --fidelity or [mesh]."]
        if others
        else []
    )
    return [*(f"{_spoken([name])} {_REMEDIES[name]}." for name in sorted(beyond & set(_REMEDIES))), *mesh]


def _spoken(names: Sequence[str]) -> str:
    return ", ".join(name.replace("_", " ") for name in names).capitalize()


@dataclass(frozen=True)
class Health:
    """One quality: its meaning, its worst value in each run (None if not defined), and the limit to it."""

    meaning: str
    worst: tuple[float | None, ...]
    limit: float

    @property
    def sound(self) -> bool:
        """True if no worst value exceeds the limit."""
        return all(value is None or value <= self.limit for value in self.worst)


class Judged(Protocol):
    """Anything with measures of its numerical quality, such as a result."""

    @property
    def quality(self) -> Mapping[str, float]:
        """The worst value of each quality, by its name in QUALITIES."""


def health(results: Sequence[Judged]) -> list[Health]:
    """The qualities of runs, in the order of QUALITIES; then others by name, whose limit is infinite."""
    known = [name for name in QUALITIES if any(name in result.quality for result in results)]
    others = sorted({name for result in results for name in result.quality if name not in QUALITIES})
    meanings = {name: meaning for name, (meaning, _) in QUALITIES.items()}
    return [
        Health(
            meanings.get(name, name.replace("_", " ")),
            tuple(result.quality.get(name) for result in results),
            limit_of(name),
        )
        for name in [*known, *others]
    ]


def limit_of(name: str) -> float:
    """The limit of a quality by its name; infinite if it has none."""
    return QUALITIES[name][1] if name in QUALITIES else float("inf")


def flagged(name: str, value: float) -> str:
    """`value` of the quality `name` as text, with its limit if it exceeds that."""
    limit = limit_of(name)
    return f"{value:.1e}, more than {limit:.1e}" if value > limit else f"{value:.1e}"
