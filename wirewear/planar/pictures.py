"""Pictures of line contacts: worn profiles, pressure, loops, growth of scars, meshes, holders; stresses inside."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from itertools import cycle as endless
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from geometry import ContactPatch, Elastic, PlanarGeometry, PlanarMesh, QuadMesh, build_planar
from geometry.arrays import IntArray
from solvers.interior import Interior
from solvers.line_surface_stress import LineSurfaceStress
from solvers.strain import IntegrationPoints, integration_points
from wirewear.base.errors import ResultError
from wirewear.base.writing import in_one_step, writing
from wirewear.interior.bodies import Tracked, plane_section, stressed_grid, untracked
from wirewear.interior.pictures import STRESS_COLOURS
from wirewear.interior.state import InnerState
from wirewear.interior.strength import Strength, StrengthAsked, require_room, strength_over
from wirewear.pictures import style
from wirewear.pictures.gallery import loops_by_run
from wirewear.pictures.smooth import chosen_cycles
from wirewear.pictures.style import INK, cycle_name, new_figure, panel_letters, save
from wirewear.pictures.supports import HeldBody, Supports, draw_boundary_conditions
from wirewear.planar.model import plan, require_affordable_meshes
from wirewear.planar.tables import PlanarStudy, planar_study_from_tables
from wirewear.results import BODIES, RunResult, Scar, read_loops

if TYPE_CHECKING:
    import pyvista


def write_planar_meshes(study: PlanarStudy, fidelity: str, folder: Path) -> list[Path]:
    """Mesh both bodies; leave pad.vtu, specimen.vtu and boundary_conditions.png in a folder.
    Raises StudyError if the study cannot be meshed, or asks for more memory than there is; GeometryError if the mesh is
    distorted; ResultError if the files cannot be written.
    """
    meshes = plan(study, fidelity)
    require_affordable_meshes(study.name, meshes)
    bodies = {"pad": build_planar(meshes.pad), "specimen": build_planar(meshes.specimen)}
    with writing(ResultError, f"cannot write meshes to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, body in bodies.items():
            with in_one_step(folder / f"{name}.vtu") as partial:
                body.mesh.write(partial)
    picture = style.save(
        lambda: planar_supports(study, bodies["pad"], bodies["specimen"]), folder / "boundary_conditions.png"
    )
    return [*(folder / f"{name}.vtu" for name in bodies), picture]


def planar_supports(study: PlanarStudy, pad: PlanarMesh, specimen: PlanarMesh) -> Figure:
    """Both bodies with what holds and moves them, per mm of thickness."""
    conditions, holder = study.conditions, study.holder
    tangential, rotational = holder.tangential_stiffness_N_per_mm2, holder.rotational_stiffness_N_per_rad
    supports = Supports(
        load=f"{conditions.normal_load_N_per_mm:g} N/mm",
        stroke=f"±{conditions.displacement_amplitude_um:g} µm",
        tangential="" if tangential == "rigid" else f"{tangential:g} N/mm²",
        rotational="" if rotational == "rigid" else f"{rotational:g} N/rad",
        pivot_height=None if rotational == "rigid" else holder.pivot_height_mm,
    )
    view = ("pad on specimen, plane strain", _held(pad, upper=True), _held(specimen, upper=False))
    return draw_boundary_conditions([view], supports, along_motion=[True])


def _held(body: PlanarMesh, *, upper: bool) -> HeldBody:
    points = body.mesh.points * np.array([1.0, -1.0 if upper else 1.0])
    edges = points[body.mesh.boundary_facets()]
    return HeldBody(edges, points[body.mesh.surfaces["grip"]], body.bedding is not None)


def planar_drawings(results: Sequence[RunResult]) -> dict[str, Callable[[], Figure]]:
    """What can be drawn of these results, by file name: each run by itself, and several side by side."""
    logged = [result for result in results if result.loops]
    found: dict[str, Callable[[], Figure]] = {}
    for result in logged:
        suffix = f"_{result.variant}" if len(results) > 1 else ""
        found |= {
            f"profiles{suffix}": partial(planar_profiles, result),
            f"loops{suffix}": partial(loops_by_run, [replace(result, loops=read_loops(result))], "N/mm"),
        }
    return found | ({"variants": partial(planar_variants, logged)} if len(logged) > 1 else {})


def planar_variants(results: Sequence[RunResult]) -> Figure:
    """Depth of both bodies, pressure at mid-stroke and loop at the last logged cycle, run beside run."""
    figure = style.new_figure(5.2)
    panels = figure.subplots(2, 2)
    for colour, dashes, result in zip(endless(style.VARIANT_COLOURS), endless(style.VARIANT_DASHES), results):
        last = max(loop.cycle for loop in result.loops)
        look = {"color": colour, "linestyle": dashes}
        for axes, body in zip(panels[0], BODIES, strict=True):
            scar = result.scar(last, body)
            axes.plot(scar.axial_um, scar.depth_um[:, 0], **look)
        pad = result.scar(last, "pad")
        panels[1][0].plot(pad.axial_um, pad.pressure_MPa[:, 0], **look)
        loop = next(one for one in read_loops(result) if one.cycle == last)
        x, q = (np.append(v, v[0]) for v in (loop.displacement_um, loop.tangential_force_N))
        panels[1][1].plot(x, q, label=f"{result.variant or result.name}, {style.cycle_name(last)} cycles", **look)
    reach = max(_reach(result) for result in results)
    deepest = max(axes.get_ylim()[1] for axes in panels[0])
    for axes, title in zip(
        panels.ravel(),
        ("worn depth, pad", "worn depth, specimen", "pressure at mid-stroke", "friction loop"),
        strict=True,
    ):
        axes.set_title(title)
    for axes in (*panels[0], panels[1][0]):
        axes.set(xlim=(-reach, reach), xlabel="x (µm)")
    for axes in panels[0]:
        axes.set(ylim=(deepest, 0.0), ylabel="depth (µm)")
    panels[1][0].set_ylim(bottom=0.0)
    panels[1][0].set_ylabel("pressure (MPa)")
    panels[1][1].set(xlabel="displacement (µm)", ylabel="tangential force (N/mm)")
    figure.legend(*panels[1][1].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    style.panel_letters(list(panels.ravel()))
    return figure


def planar_profiles(result: RunResult) -> Figure:
    """Depth of both bodies and pressure at mid-stroke over x, from the first logged cycle to the last."""
    cycles = chosen_cycles([loop.cycle for loop in result.loops])
    figure = style.new_figure(5.2)
    panels = figure.subplots(2, 2)
    reach = _reach(result)
    for axes, body in zip(panels[0], BODIES, strict=True):
        for colour, cycle in zip(style.cycle_colours(len(cycles)), cycles, strict=True):
            scar = result.scar(cycle, body)
            axes.plot(scar.axial_um, -scar.depth_um[:, 0], color=colour, label=style.cycle_name(cycle))
        axes.set(title=f"worn depth, {body}", xlabel="x (µm)", ylabel="depth (µm)")
        axes.yaxis.set_major_formatter(lambda value, _: f"{abs(value):g}")
        axes.set_xlim(-reach, reach)
    lowest = min(axes.get_ylim()[0] for axes in panels[0])
    for axes in panels[0]:
        axes.set_ylim(lowest, -0.05 * lowest)
    for colour, cycle in zip(style.cycle_colours(len(cycles)), cycles, strict=True):
        scar = result.scar(cycle, "pad")
        panels[1][0].plot(scar.axial_um, scar.pressure_MPa[:, 0], color=colour, label=style.cycle_name(cycle))
    panels[1][0].set(title="pressure at mid-stroke", xlabel="x (µm)", ylabel="pressure (MPa)", xlim=(-reach, reach))
    panels[1][0].set_ylim(bottom=0.0)
    _growth(panels[1][1], result)
    handles, labels = panels[1][0].get_legend_handles_labels()
    figure.legend(handles, labels, title="cycles", loc="outside right upper")
    style.panel_letters(list(panels.ravel()))
    return figure


def _growth(axes: Axes, result: RunResult) -> None:
    cycles = result.evolution["cycle"]
    for colour, dashes, body in zip(style.VARIANT_COLOURS, style.VARIANT_DASHES, BODIES, strict=False):
        depth = result.evolution[f"max_depth_{body}_um"]
        worn = depth > 0.0
        if worn.any():
            axes.plot(cycles[worn], depth[worn], color=colour, linestyle=dashes, marker="o", markersize=3, label=body)
    axes.set(title="largest depth", ylabel="depth (µm)")
    style.cycle_axis(axes)
    if axes.lines:
        axes.set_yscale("log")
        axes.legend()
    else:
        axes.text(0.5, 0.5, "nothing is worn", transform=axes.transAxes, ha="center", va="center")


def _reach(result: RunResult) -> float:
    """Half-width of the picture: all that is worn or under pressure, with a margin."""

    def of_one(scar: Scar) -> float:
        shown = (scar.pressure_MPa > 0.0) | (scar.depth_um > 0.01 * max(scar.max_depth_um, 1e-12))
        return float(np.abs(scar.axial_um[shown[:, 0]]).max())

    return 1.15 * max(map(of_one, result.scars))


@dataclass(frozen=True, eq=False)
class PlanarBody:
    """Pad or specimen with its nodes in the worn surface, or where they were when fresh, and its factors."""

    meshed: PlanarMesh
    material: Elastic
    interior: Interior
    points: IntegrationPoints

    @property
    def mesh(self) -> QuadMesh:
        return self.meshed.mesh

    @property
    def patch(self) -> ContactPatch:
        return self.meshed.patch

    @cached_property
    def surface(self) -> LineSurfaceStress:
        return LineSurfaceStress.of(self.meshed, self.material)


def planar_states(
    result: RunResult, body: str, cycle: int, at: Sequence[str | int] | None = None, *, worn: bool = True
) -> tuple[InnerState[PlanarBody], ...]:
    """A body at positions of a recorded cycle, all recorded ones by default.

    worn: the nodes stand in the worn surface; else where they were when fresh.
    Raises ResultError if no contact forces of that body are recorded at that cycle, or there is no such position;
    GeometryError if wear distorts the mesh too much.
    """
    forces = result.forces(cycle, body)
    chosen = list(range(len(forces.phase))) if at is None else [forces.position(one) for one in at]
    depth = b""
    if worn:
        depth = np.maximum(1e-3 * result.scar(forces.cycle, body).depth_um, 0.0).tobytes()
    found = _meshed(_tables(result), result.fidelity, body, depth)
    nodes = found.patch.nodes.ravel()[forces.nodes]
    displacements = found.interior.displacements(nodes, forces.force_N[chosen])
    upper = result.is_upper(body)
    return tuple(InnerState(found, forces, k, moved, upper) for k, moved in zip(chosen, displacements, strict=True))


def run_geometry(result: RunResult, body: str) -> PlanarGeometry:
    """What the mesh of a body was built from in a run."""
    return _geometry(_study(_tables(result)), result.fidelity, body)


@lru_cache(maxsize=2)
def _meshed(tables: str, fidelity: str, body: str, depth: bytes) -> PlanarBody:
    """A body meshed as in the run, worn by a depth (n,) in mm or, of no length, fresh, with its factors."""
    study = _study(tables)
    meshed = build_planar(_geometry(study, fidelity, body))
    if depth:
        meshed = meshed.worn(np.frombuffer(depth))
    material = (study.pad if body == "pad" else study.specimen).elastic
    held: IntArray = meshed.mesh.surface_nodes("grip")
    interior = Interior(meshed.mesh, material, held if meshed.bedding is None else held[:0], meshed.bedding)
    return PlanarBody(meshed, material, interior, integration_points(meshed.mesh))


def _tables(result: RunResult) -> str:
    return json.dumps(result.study, sort_keys=True, default=str)


def _study(tables: str) -> PlanarStudy:
    loaded: dict[str, Any] = json.loads(tables)
    return planar_study_from_tables(loaded, "the result")


def _geometry(study: PlanarStudy, fidelity: str, body: str) -> PlanarGeometry:
    meshes = plan(study, fidelity)
    return meshes.pad if body == "pad" else meshes.specimen


_LEVELS = 11


def state_grid(state: InnerState[PlanarBody]) -> pyvista.UnstructuredGrid:
    """A body's quadrilaterals at y = 0, in µm, with the fields of `interior.grids.stressed_grid`."""
    import pyvista

    return stressed_grid(state, pyvista.CellType.QUAD)


def write_planar_fields(
    result: RunResult,
    folder: Path,
    *,
    cycle: int,
    at: Sequence[str | int] | None,
    worn: bool = True,
    tracked: Tracked = untracked,
) -> list[Path]:
    """Write `<body>_<cycle>_<position>.vtu` and `section_<cycle>_<position>.png` for positions, None for all.

    Where the bodies are apart, nothing is drawn. `tracked` shows how far the positions are.
    Raises ResultError if nothing is recorded there, or the folder cannot be written; GeometryError if wear distorts a
    mesh too much.
    """
    recorded = result.forces(cycle, BODIES[0])
    written = []
    for one in tracked(range(len(recorded.phase)) if at is None else at, "solving and writing"):
        k = recorded.position(one)
        states = {body: planar_states(result, body, cycle, [k], worn=worn)[0] for body in BODIES}
        grids = {body: state_grid(state) for body, state in states.items()}
        with writing(ResultError, f"cannot write fields to {folder}"):
            folder.mkdir(parents=True, exist_ok=True)
            for body, grid in grids.items():
                written.append(folder / f"{body}_{recorded.cycle:07d}_{k:03d}.vtu")
                with in_one_step(written[-1]) as partial:
                    grid.save(partial)
        if any(grid.cell_data["von_mises_MPa"].any() for grid in grids.values()):
            written.append(_drawn(states["pad"], grids, folder / f"section_{recorded.cycle:07d}_{k:03d}.png"))
    return written


def _drawn(pad: InnerState[PlanarBody], grids: Mapping[str, pyvista.UnstructuredGrid], path: Path) -> Path:
    forces = pad.forces
    # The recorded forces reach as far as the contact ever does.
    reach = 1e3 * float(np.abs(pad.body.patch.axial_mm[forces.nodes]).max())
    title = f"cycle {cycle_name(forces.cycle)}, drive {forces.drive_um[pad.position]:.1f} µm"
    return save(lambda: _section(list(grids.values()), 2.5 * reach, title), path)


def _section(grids: Sequence[pyvista.UnstructuredGrid], half_um: float, title: str) -> Figure:
    """Both bodies whole, and near the contact."""
    largest = max(float(grid.cell_data["von_mises_MPa"].max()) for grid in grids)
    levels = np.linspace(0.0, largest, _LEVELS)
    figure = new_figure(3.2)
    panels = figure.subplots(1, 2)
    everything = np.vstack([grid.points for grid in grids])
    whole = 0.52 * float(np.ptp(everything[:, [0, 2]], axis=0).max())
    for axes, half, name in zip(panels, (whole, half_um), ("both bodies", "near the contact"), strict=True):
        for grid in grids:
            cut = plane_section(grid)
            values = np.clip(cut.values, 0.0, 0.9999 * largest)
            axes.tricontourf(cut.places, values, levels=levels, cmap=STRESS_COLOURS)
            axes.tricontour(cut.places, cut.values, levels=levels[1:], colors=INK, linewidths=0.3)
        centre = 0.5 * (everything[:, 2].max() + everything[:, 2].min()) if half == whole else 0.0
        axes.set(
            aspect="equal",
            xlim=(-half, half),
            ylim=(centre - half, centre + half),
            xlabel="x, along the motion [µm]",
            title=name,
        )
        axes.grid(visible=False)
    panels[0].set_ylabel("z [µm]")
    panel_letters(list(panels))
    colours = ScalarMappable(Normalize(0.0, largest), STRESS_COLOURS)
    figure.colorbar(colours, ax=panels, label="von Mises stress [MPa]", pad=0.01)
    figure.suptitle(title, fontsize=9)
    return figure


def planar_strength(result: RunResult, body: str, cycle: int, asked: StrengthAsked) -> Strength:
    """Stresses of the pad or specimen over a recorded cycle, at all its recorded positions, at nodes near the contact.

    Averages are over discs. Raises ResultError when no contact forces of it are recorded or it is smaller than the
    averaging length, GeometryError when wear distorts the mesh too much.
    """
    return strength_over(planar_states(result, body, planar_assessable(result, body, cycle, asked)), asked, state_grid)


def planar_assessable(result: RunResult, body: str, cycle: int, asked: StrengthAsked) -> int:
    """The cycle itself, seen without any computation to allow what is asked of a body.
    Raises ResultError if no contact forces of it are recorded, or it is smaller than the averaging length.
    """
    forces, geometry = result.forces(cycle, body), run_geometry(result, body)
    require_room(body, min(2.0 * geometry.half_width_mm, geometry.height_mm), asked.averaging_length_um)
    return forces.cycle
