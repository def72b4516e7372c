"""What the run of a line contact records, of one millimetre of it: profiles, where they end, how the pad tilts."""

from __future__ import annotations

from typing import Any

import numpy as np

from solvers import ContactProblem, CycleTrace
from wirewear.planar.tables import PlanarStudy
from wirewear.results import PRESSURE_LENGTH, ContactForces, Loop, Scar
from wirewear.simulation.checkpoint import MeshHistory
from wirewear.simulation.contact_forces import forces_on
from wirewear.simulation.measure import worn_bodies
from wirewear.simulation.recorded import Recorded


class PlanarRecord(Recorded):
    """The record of one run at a fidelity; `asked` is what it was asked to do, with its identity."""

    contact_kind, bodies, length_mm = "line-contact", ("specimen", "pad"), 1.0

    def __init__(self, study: PlanarStudy, fidelity: str, asked: dict[str, Any]) -> None:
        """Empty, before the run."""
        super().__init__(study, fidelity, 1e-3 * asked[PRESSURE_LENGTH])
        self.study, self._asked = study, asked

    def further_columns(self, loop: Loop, scars: tuple[Scar, Scar]) -> dict[str, float]:
        """How far the pad tilts, and where scars end."""
        ends = {
            f"{side}_edge_{scar.body}_um": edge
            for scar in scars
            for side, edge in zip(("left", "right"), scar.edges_um(), strict=True)
        }
        return {"largest_tilt_deg": float(np.abs(loop.tilt_deg).max()), **ends}

    def scars(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[Scar, Scar]:
        """Profiles with the pressure at mid-stroke."""
        specimen, pad = (
            Scar(
                cycle=cycle,
                body=name,
                diameter_mm=np.inf,
                axis_angle_deg=0.0,
                axial_um=1e3 * body.node_positions[:, 0],
                transverse_um=np.zeros(1),
                depth_um=1e3 * depth,
                energy_density_mJ_per_mm2=energy,
                pressure_MPa=(force[:, 2] / body.patch.node_areas())[:, None],
                slip_distance_um=1e3 * np.reshape(slid, depth.shape),
                length_mm=self.length_mm,
            )
            for name, (body, depth, energy, force, slid) in zip(self.bodies, worn_bodies(problem, trace), strict=True)
        )
        return specimen, pad

    def forces(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[ContactForces, ...]:
        """On specimen and pad."""
        return forces_on(problem, trace, cycle, self.study.log.contact_states, self.bodies)

    def tables(self) -> dict[str, Any]:
        """The study as it is stated."""
        return self.study.model_dump(mode="json", exclude_none=True)

    def settings(self, _history: MeshHistory) -> dict[str, Any]:
        """What it was asked to do."""
        return self._asked | self.tally.fresh | {"simulated_cycles": self.tally.counters.simulated_cycles}
