"""Compile the solver's inner loops once, by a coarse run that needs them, so that no later run has to wait for it.

Usage: python tools/compile_ahead.py
"""

import sys
from pathlib import Path

from wirewear import load
from wirewear.simulation import simulate

STUDY = Path(__file__).parents[1] / "studies" / "steel_wires" / "study.toml"

#: What makes that study coarse and short.
COARSE = {
    "conditions.displacement_amplitude_um": 20.0,
    "conditions.cycles": 100,
    "log.loop_cycles": [1, 100],
    "fidelity.quick.contact_mesh_um": 12.0,
    "fidelity.quick.outer_mesh_um": 18.0,
    "fidelity.quick.increments_per_wear_cycle": 16,
}


def main() -> int:
    """Run the study and keep nothing of it but the machine code."""
    simulate(load(STUDY).variant("compliant").with_values(COARSE), fidelity="quick")
    return 0


if __name__ == "__main__":
    sys.exit(main())
