"""Made-up results for tests of files, pictures and tables: Coulomb loops behind a spring, and bowls for scars.

They look like a run and follow known formulas; they say nothing about wires.
"""

import gzip
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.results import Evolution, Loop, RunResult, Scar
from wirewear.results.scar import FIELD_COLUMNS

FRICTION, LOAD_N, AMPLITUDE_um = 0.62, 2.0, 60.0
MILESTONES = (1, 100, 1000, 10_000, 100_000)


def loop(cycle: int, stiffness_N_per_mm: float, hook: float = 0.0, samples: int = 200) -> Loop:
    """Coulomb friction behind a spring; the plateau rises by the fraction `hook` towards the stroke ends."""
    phase = 2.0 * np.pi * np.arange(3 * samples) / samples
    drive = AMPLITUDE_um * np.sin(phase)
    stiffness_N_per_um = 1e-3 * stiffness_N_per_mm
    forces, slips, works = [], [], []
    slip = work = 0.0
    for displacement in drive:
        trial = stiffness_N_per_um * (displacement - slip)
        direction = math.copysign(1.0, trial)
        limit = FRICTION * LOAD_N * (1.0 + direction * hook * (displacement / AMPLITUDE_um) ** 3)
        force = math.copysign(min(abs(trial), limit), trial)
        moved = displacement - force / stiffness_N_per_um
        work += 1e-3 * force * (moved - slip)
        slip = moved
        forces.append(force)
        slips.append(slip)
        works.append(work)
    last = slice(2 * samples, 3 * samples)
    return Loop(
        cycle=cycle, time_s=np.arange(samples) / samples / 3.0, displacement_um=drive[last],
        relative_displacement_um=np.array(slips)[last], tangential_force_N=np.array(forces)[last],
        normal_force_N=np.full(samples, LOAD_N), friction_work_mJ=np.array(works)[last] - works[2 * samples - 1],
    )  # fmt: skip


def bowl(
    wire: str,
    depth_um: float,
    half_length_um: float,
    half_width_um: float,
    *,
    axis_angle_deg: float | None = None,
    cycle: int = 100_000,
    lines: Sequence[int] = (61, 41),
) -> Scar:
    """A paraboloid: depth·(1 − (axial/half_length)² − (transverse/half_width)²), never below zero."""
    axial = graded(1.5 * half_length_um, lines[0])
    transverse = graded(1.5 * half_width_um, lines[1])
    inside = 1.0 - (axial[:, None] / half_length_um) ** 2 - (transverse[None, :] / half_width_um) ** 2
    depth = depth_um * np.maximum(inside, 0.0)
    return Scar(
        cycle=cycle, body=wire, diameter_mm=0.45,
        axis_angle_deg={"moving": 0.0, "fixed": 90.0}[wire] if axis_angle_deg is None else axis_angle_deg,
        axial_um=axial, transverse_um=transverse, depth_um=depth, energy_density_mJ_per_mm2=1e3 * depth,
        pressure_MPa=np.where(depth > 0.0, 100.0, 0.0), slip_distance_um=np.where(depth > 0.0, 200.0, 0.0),
    )  # fmt: skip


def profile(body: str, x_um: Array, depth_um: Array, cycle: int = 1, **fields: Any) -> Scar:
    """A line contact's profile, of one millimetre of it; fields (n,) that are not given are its depth."""
    columns = {name: fields.get(name, depth_um)[:, None] for name in FIELD_COLUMNS[1:]}
    return Scar(cycle, body, np.inf, 0.0, x_um, np.zeros(1), depth_um[:, None], **columns, length_mm=1.0)


def graded(half_length_um: float, lines: int) -> Array:
    """Grid lines from −half_length to half_length, finer in the middle."""
    s = np.linspace(-1.0, 1.0, lines)
    return half_length_um * (0.6 * s + 0.4 * s**3)


def result(
    variant: str = "",
    stiffness_N_per_mm: float = 2000.0,
    milestones: Sequence[int] = MILESTONES,
    samples: int = 200,
    status: str = "complete",
) -> RunResult:
    """A whole run whose scars deepen as N^½ and whose loops grow hooks."""
    lost_um = 1e3 * FRICTION * LOAD_N / stiffness_N_per_mm
    last = milestones[-1]
    cycles = np.unique(np.round(np.geomspace(1, last, 40)))
    growth = np.sqrt(cycles / 100_000)
    hooks = 0.4 * growth
    slip = AMPLITUDE_um - lost_um * (1.0 + hooks)
    energy_mJ = 4e-3 * FRICTION * LOAD_N * slip
    half_length, half_width = 40.0 + 80.0 * growth, 15.0 + 60.0 * growth
    scars = []
    for cycle in milestones:
        g = math.sqrt(cycle / 100_000)
        scars.append(bowl("moving", 12.0 * g, AMPLITUDE_um + 80.0 * g, 15.0 + 80.0 * g, cycle=cycle))
        scars.append(bowl("fixed", 20.0 * g, 15.0 + 75.0 * g, 15.0 + 80.0 * g, cycle=cycle))
    return RunResult(
        name="made-up wires",
        variant=variant,
        fidelity="quick",
        status=status,
        message="all cycles simulated",
        study={"name": "made-up wires", "conditions": {"normal_load_N": LOAD_N, "cycles": last}},
        loops=tuple(loop(c, stiffness_N_per_mm, 0.4 * math.sqrt(c / 100_000), samples) for c in milestones),
        evolution=Evolution(
            {
                "cycle": cycles,
                "displacement_amplitude_um": np.full_like(cycles, AMPLITUDE_um),
                "slip_amplitude_um": slip,
                "max_tangential_force_N": FRICTION * LOAD_N * (1.0 + hooks),
                "dissipated_energy_mJ": energy_mJ,
                "normal_force_N": np.full_like(cycles, LOAD_N),
                "accumulated_energy_J": 1e-3 * energy_mJ * cycles,
                "worn_volume_moving_mm3": 1.5e-5 * 1e-3 * energy_mJ * cycles,
                "worn_volume_fixed_mm3": 1.5e-5 * 1e-3 * energy_mJ * cycles,
                "max_depth_moving_um": 12.0 * growth,
                "max_depth_fixed_um": 20.0 * growth,
                "contact_half_width_um": half_width + 0.0 * half_length,
                "max_pressure_MPa": 4650.0 * (1.0 - 0.9 * growth),
                "mid_stroke_pressure_MPa": 4600.0 * (1.0 - 0.95 * growth),
                "mirror_error": 1e-3 * growth,
                "max_mean_pressure_MPa": 3000.0 * (1.0 - 0.9 * growth),
                "mid_stroke_mean_pressure_MPa": 2900.0 * (1.0 - 0.95 * growth),
                "jump_cycles": np.diff(cycles, append=last),
            }
        ),
        scars=tuple(scars),
        settings={"contact_mesh_um": 8.0, "pressure_length_um": 28.6, "degrees_of_freedom": 60_000},
        quality={"force_balance_relative": 1e-9, "penetration_um": 2e-5, "slip_direction_error_deg": 0.01},
        versions={"wirewear": "0"},
        timings_s={"condensation": 20.0, "total": 50.0},
    )


def earlier_line_result() -> bytes:
    """The result of a line contact in the format of its own that earlier versions wrote."""
    return gzip.decompress((Path(__file__).parent / "data" / "line_result_format_2.h5.gz").read_bytes())
