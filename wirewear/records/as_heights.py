"""A finished simulation as a logger and a profilometer would have left it: loops, and heights of the worn bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geometry import Flat, Profile
from wirewear.base.errors import RecordError
from wirewear.base.writing import prepared_folder, write_csv, writing
from wirewear.planar.tables import FACE_KEYS, PadFace
from wirewear.records.surfaces import SCAR_STEP_um
from wirewear.records.values import MeasuredLoop
from wirewear.records.writing import frame_of, loops_frame
from wirewear.results import BODIES

if TYPE_CHECKING:
    from wirewear.results import RunResult, Scar

Array = NDArray[np.float64]

#: The map reaches this many times as far as the scar, so that most of it is unworn; of a wire's radius at most a share,
#: beyond which no instrument sees its flanks.
REACH, FLANK = 1.6, 0.9

#: Heights of a body's surface anew for every repeat, as columns x_um, y_um and height_um (or without y_um).
Surface = Callable[[], Mapping[str, Array]]


def write_as_heights(
    folder: Path, loops: Sequence[MeasuredLoop], surfaces: Mapping[str, Surface], repeats: int
) -> list[Path]:
    """Write `loops.csv` and one file of heights for every surface and repeat; their paths.

    Raises:
        RecordError: a file cannot be written.
    """
    frames = {"loops": loops_frame(loops)}
    frames |= {f"{n}_{r}": frame_of(own()) for n, own in surfaces.items() for r in range(1, repeats + 1)}
    prepared_folder(folder)
    with writing(RecordError, f"cannot write to {folder}"):
        return [write_csv(folder / f"{name}.csv", frame) for name, frame in frames.items()]


def scar_surfaces(result: RunResult, noise_um: float, random: np.random.Generator) -> dict[str, Surface]:
    """Both wires of a run at its end, by names of files."""
    last = max((scar.cycle for scar in result.scars), default=0)
    ends = [scar for scar in result.scars if scar.cycle == last]
    return {f"scar_{scar.body}": surface_of_wire(scar, noise_um, random) for scar in ends}


def profile_surfaces(result: RunResult, noise_um: float, random: np.random.Generator) -> dict[str, Surface]:
    """Both bodies of a run at its end across the scar, by names of files."""
    last = max(scar.cycle for scar in result.scars)
    pad = PadFace(**{key: result.study["pad"].get(key) for key in FACE_KEYS}).profile
    found = {}
    for body, face in zip(BODIES, (pad, Flat()), strict=True):
        own = result.scar(last, body)
        found[f"profile_{body}"] = surface_of_profile(own.axial_um, own.depth_um[:, 0], face, noise_um, random)
    return found


def surface_of_wire(scar: Scar, noise_um: float, random: np.random.Generator) -> Surface:
    """A worn wire in its own frame: x along its axis, y across."""
    worn = scar.depth_um > 0.01 * scar.max_depth_um
    axial, transverse = (
        _lines(float(np.abs(line[worn.any(axis=axis)]).max(initial=SCAR_STEP_um)))
        for line, axis in ((scar.axial_um, 1), (scar.transverse_um, 0))
    )
    transverse = transverse[np.abs(transverse) <= FLANK * scar.radius_um]
    a, t = np.meshgrid(axial, transverse, indexing="ij")
    height = (scar.unworn_height_um(a, t) - scar.depth_at(*scar.sliding_coordinates(a, t))).ravel()

    def surface() -> Mapping[str, Array]:
        noise = noise_um * random.standard_normal(height.size)
        return {"x_um": a.ravel(), "y_um": t.ravel(), "height_um": height + noise}

    return surface


def surface_of_profile(
    x_um: Array, depth_um: Array, face: Profile, noise_um: float, random: np.random.Generator
) -> Surface:
    """A worn body of a line contact along the motion, with that unworn face."""
    x = _lines(float(np.abs(x_um[depth_um > 0.01 * depth_um.max()]).max(initial=SCAR_STEP_um)), SCAR_STEP_um / 5.0)
    plane_mm = np.column_stack([1e-3 * x, np.zeros_like(x)])
    height = 1e3 * face.height(plane_mm) - np.interp(x, x_um, depth_um, left=0.0, right=0.0)
    return lambda: {"x_um": x, "height_um": height + noise_um * random.standard_normal(x.size)}


def _lines(half_um: float, step_um: float = SCAR_STEP_um) -> Array:
    """Places as far as a map of a scar that reaches so far to either side."""
    count = int(np.ceil(REACH * half_um / step_um))
    return np.arange(-count, count + 1) * np.float64(step_um)
