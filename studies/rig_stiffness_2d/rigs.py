"""Each rig of the two studies: its loop and its contact at the end of the stroke, and what rotation changes of them.

Everything is per mm of thickness. A rig is a variant of cylinder.toml or flat.toml: `translating_1` holds the pad by a
spring along the motion (scenario 1), `rotating_1` by one against rotation about a pivot (scenario 2).
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wirewear import ResultError, RunError
from wirewear.loops import analyse_loop
from wirewear.results import RunResult
from wirewear.simulation import run_study, simulate
from wirewear.test import LineStudy, study_from_tables
from wirewear.test.study import read_study

Array = NDArray[np.float64]

CONTACTS = ("cylinder", "flat")
#: Element size under the contact in µm and increments a cycle.
LEVELS = {"quick": (20.0, 32), "standard": (5.0, 64), "fine": (2.5, 96)}

#: Relative difference of K_t,m that still counts as equal, and how many springs are tried for it.
EQUAL, _MOST_TRIALS = 2e-3, 8

_SLIDES = 0.999  #: Share of friction times load from which on nothing sticks.


@dataclass(frozen=True, eq=False)
class Rig:
    """The closed loop of a case in a scenario, and its contact at the largest displacement.

    stiffness: of the spring, N/mm² (scenario 1) or N/rad (2).  Loop, arrays (m,): displacement_um,
    tangential_force_N_per_mm.  Contact, arrays (n,) over x_um in the pad's frame: pressure and shear on the pad, and
    the slip amplitude, a quarter of the path that a point of the pad slides under pressure in a cycle.
    """

    contact: str
    case: int
    scenario: int
    stiffness: float
    regime: str
    measured_stiffness_N_per_mm2: float
    largest_tilt_deg: float
    dissipated_energy_mJ_per_mm: float
    displacement_um: Array
    tangential_force_N_per_mm: Array
    x_um: Array
    pressure_MPa: Array
    shear_MPa: Array
    slip_amplitude_um: Array

    @property
    def pressure_centre_um(self) -> float:
        """Where the resultant of the pressure acts on the pad."""
        return float(np.trapezoid(self.pressure_MPa * self.x_um, self.x_um) / self.load_N_per_mm * 1e-3)

    @property
    def load_N_per_mm(self) -> float:
        """Resultant of the pressure."""
        return float(np.trapezoid(self.pressure_MPa, 1e-3 * self.x_um))

    @property
    def pressed_width_um(self) -> float:
        """Width under pressure."""
        return float(np.gradient(self.x_um)[self.pressure_MPa > 0.0].sum())


@dataclass(frozen=True)
class Change:
    """Scenario 2 against scenario 1 of a case.

    stiffness_ratio: of K_t,m.  loop: largest difference of the forces at equal displacement over the largest force.
    Of the pressure at the largest displacement: pressure_centre_um, how far its centre moves on the pad;
    pressure_reshaped, the share of the load that presses elsewhere relative to that centre, ∫|p2 - p1| dx / (2 P);
    peak_pressure_ratio, width_ratio, of the peak and of the width under pressure.
    """

    contact: str
    case: int
    stiffness_ratio: float
    loop: float
    pressure_centre_um: float
    pressure_reshaped: float
    peak_pressure_ratio: float
    width_ratio: float

    @classmethod
    def between(cls, one: Rig, two: Rig) -> "Change":
        """What rotation instead of translation changes; both rigs on the same mesh and steps."""
        force = two.tangential_force_N_per_mm - one.tangential_force_N_per_mm
        shift = two.pressure_centre_um - one.pressure_centre_um
        aligned = np.interp(one.x_um + shift, two.x_um, two.pressure_MPa)
        apart = np.trapezoid(np.abs(aligned - one.pressure_MPa), 1e-3 * one.x_um)
        return cls(
            contact=one.contact,
            case=one.case,
            stiffness_ratio=two.measured_stiffness_N_per_mm2 / one.measured_stiffness_N_per_mm2,
            loop=float(np.abs(force).max() / np.abs(one.tangential_force_N_per_mm).max()),
            pressure_centre_um=shift,
            pressure_reshaped=float(0.5 * apart / one.load_N_per_mm),
            peak_pressure_ratio=float(two.pressure_MPa.max() / one.pressure_MPa.max()),
            width_ratio=two.pressed_width_um / one.pressed_width_um,
        )


def shipped(contact: str, fidelity: str = "standard") -> LineStudy:
    """The study of a contact at a resolution."""
    file = Path(__file__).parent / f"{contact}.toml"
    size_um, increments = LEVELS[fidelity]
    study: LineStudy = study_from_tables(read_study(file), file.name)
    return study.with_values({"mesh.contact_mesh_um": size_um, "mesh.increments_per_cycle": increments})


def simulated(fidelity: str, folder: Path, jobs: int = 1) -> list[tuple[Rig, Rig]]:
    """Both scenarios of all cases, translating and rotating; what a folder holds of them is read.
    Raises StudyError, RunError, SolverError or ResultError as any run of a line contact does.
    """
    pairs = []
    for contact in CONTACTS:
        study = shipped(contact, fidelity)
        results = run_study(study, fidelity=fidelity, output=folder / contact, resume=True, jobs=jobs)
        rigs = [rig_of(result, contact) for result in results]
        pairs += list(zip(rigs[0::2], rigs[1::2], strict=True))
    return pairs


def rig_of(result: RunResult, contact: str) -> Rig:
    """What the run of a variant came to.
    Raises ResultError if nothing lies on the micro-slip branches of its loop, or it kept no contact forces.
    """
    holder: dict[str, Any] = result.study["holder"]
    spring = {"translating": "tangential_stiffness_N_per_mm", "rotating": "rotational_stiffness_N_mm_per_rad"}
    kind, case = result.variant.split("_")
    loop, pad = result.loops[-1], result.scar(result.loops[-1].cycle, "pad")
    load = result.study["conditions"]["normal_load_N"]
    figures = analyse_loop(loop.displacement_um, loop.tangential_force_N, load)
    if figures.measured_stiffness_N_per_um is None:
        raise ResultError(f"{result.label}: no increment lies on the micro-slip branches, so K_t,m cannot be measured.")
    forces = result.forces(loop.cycle, "pad")
    end = int(forces.drive_um.argmax())
    traction = np.zeros((len(pad.axial_um), 3))
    traction[forces.nodes] = forces.force_N[end]
    traction /= 1e-3 * np.gradient(pad.axial_um)[:, None]
    largest = float(np.abs(loop.tangential_force_N).max())
    return Rig(
        contact=contact,
        case=int(case),
        scenario=1 if kind == "translating" else 2,
        stiffness=float(holder[spring[kind]]),
        regime="gross slip" if largest > _SLIDES * result.study["contact"]["friction"] * load else "partial slip",
        measured_stiffness_N_per_mm2=1e3 * figures.measured_stiffness_N_per_um.value,
        largest_tilt_deg=float(np.abs(loop.tilt_deg).max()),
        dissipated_energy_mJ_per_mm=float(result.evolution["dissipated_energy_mJ"][-1]),
        displacement_um=loop.displacement_um,
        tangential_force_N_per_mm=loop.tangential_force_N,
        x_um=pad.axial_um,
        pressure_MPa=np.maximum(-traction[:, 2], 0.0),
        shear_MPa=traction[:, 0],
        slip_amplitude_um=0.25 * pad.slip_distance_um[:, 0],
    )


def equally_stiff(one: Rig, study: LineStudy, fidelity: str) -> Rig:
    """A rotating rig with the K_t,m of a translating one, by the secant rule on both compliances.

    study: of a rotating variant.  In series 1/K_t,m = 1/K_c + H²/(K_θ + K_r): in the springs' compliances it is nearly
    a straight line.
    Raises RunError if no spring was found.
    """
    pivot, wanted = study.holder.pivot_height_mm or 0.0, one.measured_stiffness_N_per_mm2
    least = 1.01 * study.conditions.normal_load_N * pivot
    stiffness = max(one.stiffness * pivot**2, least)
    tried: list[tuple[float, float]] = []
    for _ in range(_MOST_TRIALS):
        trial = study.changed({"holder": {"rotational_stiffness_N_mm_per_rad": stiffness}})
        result = simulate(replace(trial, variant_name=f"rotating_{one.case}"), fidelity=fidelity)
        two = rig_of(result, one.contact)
        found = two.measured_stiffness_N_per_mm2
        if abs(found / wanted - 1.0) <= EQUAL:
            return two
        tried.append((1.0 / stiffness, 1.0 / found))
        if len(tried) == 1:
            # A spring alone: the contact's own compliance is left as it is.
            change = (1.0 / wanted - 1.0 / found) / pivot**2
        else:
            (x0, y0), (x1, y1) = tried[-2:]
            change = (1.0 / wanted - y1) * (x1 - x0) / (y1 - y0) if y1 != y0 else 0.0
        stiffness = 1.0 / min(max(1.0 / stiffness + change, 1e-3 / stiffness), 1.0 / least)
    raise RunError(
        f"no rotational stiffness was found with which K_t,m is {wanted:.4g} N/mm² in {_MOST_TRIALS} trials; the last, "
        f"{stiffness:.3g} N/rad, gave {found:.4g} N/mm²"
    )
