"""Compile the solver's inner loops once, by a coarse run that needs them, so that no later run has to wait for it.

Usage: python tools/compile_ahead.py
"""

from __future__ import annotations

import sys

from wirewear import parse_study
from wirewear.simulation import simulate

STUDY = """
format = 1
name = "coarse wires"
kind = "crossed-wires"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 20.0
frequency_Hz = 3.0
cycles = 100
[contact]
friction = 0.62
[wear]
energy_wear_coefficient_mm3_per_J = 3.0e-5
[holder]
tangential_stiffness_N_per_mm = 167.0
[fidelity.quick]
contact_mesh_um = 12.0
outer_mesh_um = 18.0
increments_per_wear_cycle = 16
"""


def main() -> int:
    """Run the study and keep nothing of it but the machine code."""
    simulate(parse_study(STUDY, "the coarse study"), fidelity="quick")
    return 0


if __name__ == "__main__":
    sys.exit(main())
