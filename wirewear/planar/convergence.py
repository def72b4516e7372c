"""How far a line contact's results depend on its resolution: the study again with mesh, positions and jumps refined.

What is refined and how figures are extrapolated is that of crossed wires.
"""

from __future__ import annotations

from wirewear.base.errors import StudyError
from wirewear.planar.model import plan
from wirewear.planar.run import run_planar_variants
from wirewear.planar.tables import PlanarStudy
from wirewear.simulation.convergence import (
    BASE,
    JUMPS,
    MESH,
    POSITIONS,
    PRESSURES,
    Figure,
    RefinedSubject,
    Resolution,
    each_refined,
    finer_tolerance,
    last_of,
)

FIGURES = (
    Figure("largest tangential force", "N/mm", last_of("max_tangential_force_N")),
    Figure("energy of the last cycle", "mJ/mm", last_of("dissipated_energy_mJ")),
    Figure("slip amplitude δ0", "µm", last_of("slip_amplitude_um")),
    Figure("depth of the pad", "µm", last_of("max_depth_pad_um")),
    Figure("depth of the specimen", "µm", last_of("max_depth_specimen_um")),
    Figure("worn area of both bodies", "µm²", lambda result: 1e6 * float(result.worn_volume_mm3[-1])),
    Figure("half-width of the contact", "µm", last_of("contact_half_width_um")),
    *PRESSURES,
)


def resolutions_of(study: PlanarStudy) -> tuple[Resolution, ...]:
    """Those that a study has: without wear there are no jumps."""
    return (MESH, POSITIONS, JUMPS) if max(study.energy_coefficients()) > 0.0 else (MESH, POSITIONS)


def refined_study(study: PlanarStudy, fidelity: str) -> PlanarStudy:
    """The study with itself and its refinements as variants.

    Raises:
        StudyError: the study has variants of its own; choose one of them.
    """
    if study.variant_names:
        raise StudyError(f"the study {study.name!r} has variants: choose one of {', '.join(study.variant_names)}.")
    tolerance, mesh = plan(study, fidelity).jump_tolerance, study.mesh

    def finer(resolution: Resolution, factor: float) -> dict[str, float]:
        return {
            MESH: {"mesh_refinement": factor * mesh.mesh_refinement},
            POSITIONS: {"increments_refinement": factor * mesh.increments_refinement},
            JUMPS: {"jump_tolerance": finer_tolerance(tolerance, factor)},
        }[resolution]

    settings: dict[str, dict[str, float]] = {BASE: {}}
    settings |= each_refined(resolutions_of(study), finer)
    refined = {name: study.model_copy(update={"mesh": mesh.model_copy(update=own)}) for name, own in settings.items()}
    return study.with_variants(tuple((name, own.named(name)) for name, own in refined.items()))


LINES = RefinedSubject(FIGURES, resolutions_of, refined_study, run_planar_variants)
