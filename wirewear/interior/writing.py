"""Fields of a cycle as files: one VTU a body and position, a PVD that lists them, and pictures."""

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

from wirewear.base.errors import ResultError
from wirewear.base.writing import in_one_step, write_bytes, writing
from wirewear.interior.bodies import BodyState, Tracked, body_grid, body_states, integration_point_cloud, untracked
from wirewear.pictures.style import save
from wirewear.results import RunResult


def write_fields(
    result: RunResult,
    folder: Path,
    *,
    cycle: float,
    at: Sequence[str | int] | None = ("mid-forward",),
    wires: Sequence[str] = (),
    worn: bool = True,
    integration_points: bool = False,
    pictures: bool = True,
    animation: bool = False,
    tracked: Tracked = untracked,
) -> list[Path]:
    """Write `<body>_<cycle>_<position>.vtu`, `cycle_<cycle>.pvd` over them, and pictures of each position; returns all.

    Where the bodies are apart, nothing is drawn.

    at: names or numbers of positions, None for all that are recorded.  integration_points: also as clouds of points,
    `<body>_<cycle>_<position>_points.vtp`.  animation: a GIF over the positions.  tracked: shows how far bodies,
    files and pictures are.  The time of the PVD file is the share of the cycle passed.
    Raises ResultError if nothing is recorded there, or the folder cannot be written; GeometryError if wear distorts a
    mesh too much.
    """
    from wirewear.interior.pictures import animate_cycle

    by_wire = [body_states(result, wire, cycle, at, worn=worn) for wire in tracked(wires or result.bodies, "solving")]
    moments = list(zip(*by_wire, strict=True))
    logged = moments[0][0].forces.cycle
    written = []
    with writing(ResultError, f"cannot write fields to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for states in tracked(moments, "writing"):
            for state in states:
                written.append(_write_state(folder, state))
                if integration_points:
                    written.append(_write_points(folder, state))
        written.append(_write_series(folder / f"cycle_{logged:07d}.pvd", moments))
    touching = [states for states in moments if any(state.applied.any() for state in states)]
    if pictures:
        for states in tracked(touching, "drawing"):
            written.extend(_draw(folder, states))
    if animation and touching:
        written.append(animate_cycle(touching, folder / f"cycle_{logged:07d}.gif", tracked))
    return written


def _name(state: BodyState) -> str:
    return f"{state.forces.body}_{state.forces.cycle:07d}_{state.position:03d}"


def _draw(folder: Path, states: Sequence[BodyState]) -> list[Path]:
    from wirewear.interior.pictures import draw_cut, draw_section, draw_tractions

    place = f"{states[0].forces.cycle:07d}_{states[0].position:03d}"
    return [
        save(lambda: draw_section(states), folder / f"section_{place}.png"),
        save(lambda: draw_cut(states), folder / f"cut_{place}.png"),
        save(lambda: draw_tractions(states), folder / f"tractions_{place}.png"),
    ]


def _write_state(folder: Path, state: BodyState) -> Path:
    path = folder / f"{_name(state)}.vtu"
    with in_one_step(path) as partial:
        body_grid(state).save(partial)
    return path


def _write_points(folder: Path, state: BodyState) -> Path:
    path = folder / f"{_name(state)}_points.vtp"
    with in_one_step(path) as partial:
        integration_point_cloud(state).save(partial)
    return path


def _write_series(path: Path, moments: Sequence[Sequence[BodyState]]) -> Path:
    root = ET.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ET.SubElement(root, "Collection")
    for states in moments:
        for part, state in enumerate(states):
            time = f"{state.forces.phase[state.position]:.9g}"
            ET.SubElement(collection, "DataSet", timestep=time, group="", part=str(part), file=f"{_name(state)}.vtu")
    ET.indent(root)
    return write_bytes(path, ET.tostring(root, xml_declaration=True, encoding="utf-8"))
