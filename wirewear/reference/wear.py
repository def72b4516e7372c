"""Gross-slip wear in closed form, from geometry and book-keeping alone (N, mm, mJ)."""

import math
from dataclasses import dataclass

from wirewear.reference.hertz import require_positive


@dataclass(frozen=True)
class CrossedWireScar:
    """Round overlap of two equal worn wires; depth and volume are those of both wires together."""

    volume_mm3: float
    depth_mm: float
    radius_mm: float


@dataclass(frozen=True)
class LineScar:
    """Worn segment of a cylinder on a flat, both bodies together."""

    area_mm2: float
    depth_mm: float
    half_width_mm: float


def worn_volume(energy_wear_coefficient_mm3_per_J: float, dissipated_energy_mJ: float) -> float:
    """V = αE in mm³ (Fouvry et al., Wear 255 (2003) 287)."""
    return energy_wear_coefficient_mm3_per_J * 1e-3 * dissipated_energy_mJ


def crossed_wire_scar(volume_mm3: float, wire_radius_mm: float) -> CrossedWireScar:
    """Scar of equal wires of radius R crossed at 90°, when it is much longer than the stroke.

    The wires touch like a sphere of radius R on a flat, so the overlap is a cap: V = πRh², a² = 2Rh. With V ~ N the
    depth grows as N^½. Raises ValueError for an argument that is not positive.
    """
    require_positive(volume_mm3=volume_mm3, wire_radius_mm=wire_radius_mm)
    depth = math.sqrt(volume_mm3 / (math.pi * wire_radius_mm))
    return CrossedWireScar(volume_mm3, depth, (4.0 * wire_radius_mm * volume_mm3 / math.pi) ** 0.25)


def line_contact_scar(area_mm2: float, radius_mm: float) -> LineScar:
    """Scar of a cylinder on a flat: A = 2b³/(3R), h = b²/(2R). With A ~ N the depth grows as N^⅔.

    Raises ValueError for an argument that is not positive.
    """
    require_positive(area_mm2=area_mm2, radius_mm=radius_mm)
    half_width = (1.5 * radius_mm * area_mm2) ** (1.0 / 3.0)
    return LineScar(area_mm2, half_width**2 / (2.0 * radius_mm), half_width)


def worn_pressure(normal_load_N: float, scar: CrossedWireScar) -> float:
    """Uniform pressure P/(πa²) that wear tends to, in MPa."""
    return normal_load_N / (math.pi * scar.radius_mm**2)


def explicit_stability_limit(
    mesh_size_mm: float,
    energy_wear_coefficient_mm3_per_J: float,
    friction: float,
    contact_modulus_MPa: float,
    slip_per_update_mm: float,
    *,
    plane: bool = True,
) -> float:
    """Largest stable cycle jump of an explicit wear update, in cycles.

    A ripple of wave number k changes the pressure by E*k/2 times its height, so one update multiplies it by
    1 − ΔN·αµs·E*k/2, which must stay above −1: ΔN < 4/(αµs·E*k). The shortest ripple of a line of nodes has
    k = π/h_mesh, giving 4h/(παµE*s) (plane=True); the chequered ripple of a square grid √2 times that (plane=False).
    Raises ValueError for an argument that is not positive.
    """
    require_positive(
        mesh_size_mm=mesh_size_mm,
        energy_wear_coefficient_mm3_per_J=energy_wear_coefficient_mm3_per_J,
        friction=friction,
        contact_modulus_MPa=contact_modulus_MPa,
        slip_per_update_mm=slip_per_update_mm,
    )
    depth_per_pressure = energy_wear_coefficient_mm3_per_J * 1e-3 * friction * slip_per_update_mm
    wave_number = math.pi / mesh_size_mm * (1.0 if plane else math.sqrt(2.0))
    return 4.0 / (depth_per_pressure * contact_modulus_MPa * wave_number)
