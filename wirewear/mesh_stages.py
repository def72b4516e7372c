"""Meshes that follow a growing scar: fine for the fresh contact, coarser and wider as the scar grows."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, log

from geometry import WireGeometry
from wirewear.contact_extents import Ellipse, fresh_ellipse
from wirewear.discretisation import LEVELS, Sizes, fresh_contact, predicted_scar, wire_geometries
from wirewear.study import Study

#: Growth of the scar's half-width that one mesh is to serve.
_GROWTH_PER_STAGE = 1.8


@dataclass(frozen=True)
class MeshStage:
    """Meshes of both wires while the scar's largest half-width grows from one to the other, mm."""

    from_half_width_mm: float
    to_half_width_mm: float
    moving: WireGeometry
    fixed: WireGeometry


def mesh_stages(study: Study, fidelity: str) -> tuple[MeshStage, ...]:
    """Meshes from the fresh contact to the predicted scar, one stage without wear; equal growth in every stage.

    Raises:
        StudyError: a patch would not fit on its wire.
    """
    fresh, scar = fresh_ellipse(fresh_contact(study)), predicted_scar(study)
    if scar is None or scar.major_mm <= fresh.major_mm:
        return (stage_mesh(study, fidelity, fresh.major_mm, fresh.major_mm),)
    growth = scar.major_mm / fresh.major_mm
    count = max(1, ceil(log(growth) / log(_GROWTH_PER_STAGE)))
    widths = [fresh.major_mm * growth ** (k / count) for k in range(count + 1)]
    return tuple(stage_mesh(study, fidelity, low, high) for low, high in pairwise(widths))


def stage_mesh(study: Study, fidelity: str, now_mm: float, then_mm: float) -> MeshStage:
    """Meshes for a scar whose largest half-width is `now_mm` and is to grow to `then_mm`.

    A scar no larger than the fresh contact is meshed for the fresh contact. Fine elements are those of the fresh
    contact or, where larger, `now_mm` over the level's number per scar; the others the grown scar over that number.
    The patch holds the grown scar with the same margin as in a run on one mesh.

    Raises:
        StudyError: a patch would not fit on its wire.
    """
    level = LEVELS[fidelity]
    fresh, final = fresh_ellipse(fresh_contact(study)), predicted_scar(study)
    shape = fresh if final is None else final

    def outline(half_width_mm: float) -> Ellipse:
        return shape.enlarged(half_width_mm / shape.major_mm)

    worn = max(now_mm, then_mm) > fresh.major_mm * (1.0 + 1e-9)
    later = outline(then_mm) if worn else None
    # Elements for a scar of half-width w are w / per_scar; those for a contact are its radius over per_contact_radius.
    equivalent = now_mm * level.per_contact_radius / level.per_scar
    contact = fresh if equivalent <= fresh.major_mm else outline(equivalent)
    moving, fixed = wire_geometries(study, Sizes(contact, later), level)
    return MeshStage(now_mm, then_mm, moving, fixed)
