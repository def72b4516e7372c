"""Runs that no memory holds, or that would never end, refused before anything is meshed."""

from __future__ import annotations

from collections.abc import Callable

from geometry import GeometryError
from wirewear.base.budget import free_memory, size_text
from wirewear.base.errors import StudyError
from wirewear.base.quantity import counted
from wirewear.simulation.discretisation import Discretisation, discretise
from wirewear.simulation.patches import unknowns
from wirewear.simulation.plan import RunPlan
from wirewear.study import Study

#: Cycle jumps that a run may take: at some tenths of a second each, days.
MOST_JUMPS = 1_000_000

#: That gmsh takes for every node of a patch, with all that lies beneath it; measured.
BYTES_PER_NODE = 230e3

_COARSER = 1.1


def needed_memory(plan: RunPlan) -> float:
    """Bytes that a run takes at least."""
    sizes = [(unknowns(stage.moving), unknowns(stage.fixed)) for stage in plan.meshes.stages]
    # Of every logged cycle: four fields on both patches.
    logged = len(plan.logged_cycles) * max(8.0 * 4 * sum(pair) / 3.0 for pair in sizes)
    return max(_of_pair(*pair) for pair in sizes) + logged


def require_affordable(plan: RunPlan) -> None:
    """See that a run can come to its end on this machine.

    Raises:
        StudyError: it takes more memory than there is, or more cycle jumps than can be waited for; with what would fit.
    """
    _require_an_end(plan.study)
    needed, free = needed_memory(plan), free_memory()
    if needed > free:
        most = max(max(unknowns(stage.moving), unknowns(stage.fixed)) for stage in plan.meshes.stages)
        raise _too_much(plan.study, plan.fidelity, most, needed, free, lambda: _what_fits(plan, free))


def require_affordable_wires(study: Study, fidelity: str, meshes: Discretisation) -> None:
    """See that the compliances of two wires can be held.

    Raises:
        StudyError: they take more memory than there is; with what would fit.
    """
    sizes = (unknowns(meshes.moving), unknowns(meshes.fixed))
    needed, free = _of_pair(*sizes), free_memory()
    if needed > free:
        asked_um = 1e3 * meshes.fixed.transverse.fine_mm
        raise _too_much(
            study, fidelity, max(sizes), needed, free, lambda: _size_that_fits(study, fidelity, asked_um, free)
        )


def _too_much(
    study: Study, fidelity: str, most: int, needed: float, free: float, remedy: Callable[[], str]
) -> StudyError:
    return StudyError(
        f"the study {study.name!r} at {fidelity} fidelity asks for {counted(most // 3)} nodes in a contact and "
        f"{size_text(needed)} of memory, of which {size_text(free)} are free: {remedy()}, or allow more by "
        "--most-memory."
    )


def affordable_jobs(plans: list[RunPlan], jobs: int) -> int:
    """How many of the runs may be made side by side, at most `jobs`."""
    largest = max((needed_memory(plan) for plan in plans), default=1.0)
    return max(1, min(jobs, int(min(free_memory() / largest, 1e6))))


def _of_pair(moving: int, fixed: int) -> float:
    """Bytes for wires of so many unknowns: their compliances by quarters and room to make one, or a mesh being made."""
    largest = max(moving, fixed)
    compliances = 8.0 / 4.0 * (moving**2 + fixed**2 + largest**2)
    return max(compliances, BYTES_PER_NODE * largest / 3.0)


def _require_an_end(study: Study) -> None:
    jump = study.wear.explicit_jump_cycles if study.wear else None
    cycles = study.conditions.cycles
    if jump is not None and cycles / jump > MOST_JUMPS:
        raise StudyError(
            f"explicit_jump_cycles = {jump:g} in [wear] asks for {counted(cycles / jump)} cycle jumps, which take "
            f'months: give at least {cycles / MOST_JUMPS:.2g}, or update = "implicit", whose jumps grow with the '
            "cycles."
        )


def _what_fits(plan: RunPlan, free: float) -> str:
    """What would take no more than that."""
    if len(plan.logged_cycles) > 100:
        return "log fewer cycles, or mesh coarser"
    return _size_that_fits(plan.study, plan.fidelity, 1e3 * plan.discretisation.fixed.transverse.fine_mm, free)


def _size_that_fits(study: Study, fidelity: str, asked_um: float, free: float) -> str:
    try:
        element_um = _fitting(lambda size: _memory_of(study, fidelity, size), asked_um, free)
    except (GeometryError, StudyError):  # larger elements do not make a mesh
        return "this needs a machine with more memory"
    return f"give contact_mesh_um = {element_um:.2g} or more in [fidelity.{fidelity}]"


def _memory_of(study: Study, fidelity: str, element_um: float) -> float:
    sizes = discretise(study.changed({"fidelity": {fidelity: {"contact_mesh_um": element_um}}}), fidelity)
    return _of_pair(unknowns(sizes.moving), unknowns(sizes.fixed))


def _fitting(memory_of: Callable[[float], float], element_um: float, free: float) -> float:
    """The smallest of growing elements whose meshes take no more than that."""
    while memory_of(element_um) > free:
        element_um *= _COARSER
    return element_um
