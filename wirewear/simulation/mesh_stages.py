"""Meshes that follow a growing scar: fine for the fresh contact, coarser and wider as the scar grows."""

from dataclasses import dataclass
from itertools import pairwise
from math import ceil, log

from geometry import BodyGeometry
from wirewear.base.errors import StudyError
from wirewear.simulation.discretisation import Discretisation
from wirewear.simulation.patches import ElementSizes, affordable_meshes
from wirewear.study import Study

#: Growth of the scar's half-width that one mesh is to serve.
_GROWTH_PER_STAGE = 1.8
_MOST_SPARE = 3
_LEAST_GROWTH = 1.1


@dataclass(frozen=True)
class MeshStage:
    """Meshes of both bodies while the scar's largest half-width grows from one to the other, mm."""

    from_half_width_mm: float
    to_half_width_mm: float
    moving: BodyGeometry
    fixed: BodyGeometry


def mesh_stages(study: Study, fidelity: str, plan: Discretisation) -> tuple[MeshStage, ...]:
    """Meshes from the fresh contact to the predicted scar, of equal growth in every stage.

    One stage, on the plan's meshes, where nothing wears, where the scar stays as small as one stage serves, or where
    the study gives sizes of its own or asks not to follow the scar.

    Raises:
        StudyError: a patch would not fit on its body.
    """
    fresh, scar = plan.expected.fresh, plan.expected.scar
    growth = 1.0 if scar is None else scar.major_mm / fresh.major_mm
    if growth <= _GROWTH_PER_STAGE or not _follows(study, fidelity):
        return (MeshStage(fresh.major_mm, growth * fresh.major_mm, plan.moving, plan.fixed),)
    count = ceil(log(growth) / log(_GROWTH_PER_STAGE))
    widths = [fresh.major_mm * growth ** (k / count) for k in range(count + 1)]
    return tuple(_stage(study, plan, low, high, fresh=k == 0) for k, (low, high) in enumerate(pairwise(widths)))


def spare_stages(study: Study, fidelity: str, plan: Discretisation, last: MeshStage) -> tuple[MeshStage, ...]:
    """Meshes for contacts that leave the last planned ones, as over soft layers or at shifting loads, in case they do.

    As many as fit on the bodies; none where the study gives sizes of its own or asks not to follow the scar.
    """
    stages: list[MeshStage] = []
    width, growth = last.to_half_width_mm, _GROWTH_PER_STAGE
    while _follows(study, fidelity) and len(stages) < _MOST_SPARE and growth > _LEAST_GROWTH:
        try:
            stages.append(_stage(study, plan, width, growth * width, fresh=False))
            width *= growth
        except StudyError:
            growth = growth**0.5
    return tuple(stages)


def _follows(study: Study, fidelity: str) -> bool:
    chosen = study.fidelity(fidelity)
    given = (study.mesh.scar_half_width_um, chosen.contact_mesh_um, chosen.outer_mesh_um)
    return study.mesh.follow_scar and all(size is None for size in given)


def _stage(study: Study, plan: Discretisation, now_mm: float, then_mm: float, *, fresh: bool) -> MeshStage:
    """Meshes for a scar whose largest half-width is `now_mm` and is to grow to `then_mm`.

    The patch holds the grown scar with the same margin as in a run on one mesh. The first stage resolves the fresh
    contact where it goes, the others the grown scar up to its edges.
    """
    contact = plan.expected.fresh
    shape = plan.expected.scar or contact
    sizes = ElementSizes(contact, shape.enlarged(then_mm / shape.major_mm), fresh=fresh)
    moving, fixed, _ = affordable_meshes(study, sizes, plan.level)
    return MeshStage(now_mm, then_mm, moving, fixed)
