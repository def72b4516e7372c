"""The test that the benchmarks share: the article's steel wires pressed by 2 N and moved by ±20 µm, without wear."""

from wirewear import Study, parse_study
from wirewear.simulation.workbench import Discretisation, discretise

#: Displacements in µm after each of the ten increments: out to +20, back to -20.
DRIVES_um = (5.0, 10.0, 15.0, 20.0, 13.3333333333, 6.6666666667, 0.0, -6.6666666667, -13.3333333333, -20.0)
#: Increments of the two steps that this takes.
OUT, BACK = 4, 6
AMPLITUDE_um = 20.0


def study(
    contact_mesh_um: float,
    rig: str = "167.0",
    *,
    normal_load_N: float = 2.0,
    amplitude_um: float = AMPLITUDE_um,
    wear_mm3_per_J: float = 0.0,
    cycles: int = 1,
    wires: str = "",
) -> Study:
    """Two steel wires of 0.45 mm at right angles, friction 0.62; rig: stiffness in N/mm, or rigid; wires: keys.

    The whole patch, which holds the scar that the cycles leave, has elements of the given size.
    """
    stiffness = '"rigid"' if rig == "rigid" else rig
    return parse_study(
        f"""
format = 1
name = "crossed steel wires"
kind = "crossed-wires"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
{wires}
[conditions]
normal_load_N = {normal_load_N}
displacement_amplitude_um = {amplitude_um}
frequency_Hz = 3.0
cycles = {cycles}
[contact]
friction = 0.62
[wear]
energy_wear_coefficient_mm3_per_J = {wear_mm3_per_J}
[holder]
tangential_stiffness_N_per_mm = {stiffness}
[fidelity.standard]
contact_mesh_um = {contact_mesh_um}
outer_mesh_um = {contact_mesh_um}
""",
        "the benchmark",
    )


def discretised(of: Study) -> Discretisation:
    """Meshes and increments of a study at standard fidelity."""
    return discretise(of, "standard")
