"""The picture of docs/partial_slip.md, and errors of loops' energies in partial slip at each level.

Usage: python -m studies.benchmarks.partial_slip [--level quick] [--kind ball] [--runs fine] [--output DIR]

A ball of 12.7 mm on a flat, wires of 0.45 mm at 90° and of 1 mm at 30° and a barrel are pressed on the meshes of their
runs and loaded until they all but slide. Loops of every amplitude are the first loading twice as large (Masing), so in
each of their four quarters friction works as much; they are compared with Mindlin and Deresiewicz at the same force.
The second row of each has the core's radius less a(1 − Q/µP)^⅓ in elements, and the error of the stiffness K, without
what the bodies' bulk gives way, in percent; a contact takes up to 15 GiB at fine. --runs adds whole runs at half of the
sliding force, on a rigid rig and on one as stiff as the contact. --lines adds whole runs of a cylinder of 25 mm on a
flat, under a bulk stress in phase with the force, against Nowell and Hills (the stick zone by moments of µp − q), and
--worn volumes of a ball and of a line contact that have worn out under held forces.
"""

from dataclasses import dataclass
from math import acosh, pi
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.patches import Circle
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import brentq

from studies.study_script import StudyScript
from wirewear import reference
from wirewear.pictures import style
from wirewear.simulation import simulate
from wirewear.simulation.workbench import (
    ContactProblem,
    ContactState,
    advance,
    contact_problem,
    discretise,
    press,
    unloaded_state,
)
from wirewear.test import Study, study_from_tables
from wirewear.test.fidelity import FIDELITIES
from wirewear.test.gaps import hertz_of
from wirewear.verification.partial_slip_run import held_force_shape, held_force_study

SHARES = (0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 0.85, 0.95)
LINE = 150.0, 0.6, 25.0  #: Load in N/mm, friction and radius in mm of a line contact.
BULK = ((0.3, 60.0), (0.3, 120.0), (0.6, 60.0), (0.6, 200.0), (0.9, 60.0))  #: Its shares of µP, and stresses in MPa.
DRAWN = 0.5  #: Share of µP at which the annulus is drawn.
_STEEL: dict[str, Any] = {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3}
KINDS: dict[str, tuple[float, float, dict[str, Any]]] = {
    "ball": (
        40.0,
        0.6,
        {
            "kind": "point-contact",
            "bodies": {"lower": {"shape": "flat", **_STEEL}, "upper": {"shape": "ball", "diameter_mm": 12.7, **_STEEL}},
        },
    ),
    **{
        f"wires at {angle:g}°": (
            load,
            friction,
            {"kind": "crossed-wires", "wires": {"diameter_mm": diameter, "crossing_angle_deg": angle, **_STEEL}},
        )
        for diameter, angle, load, friction in ((0.45, 90.0, 2.0, 0.62), (1.0, 30.0, 10.0, 0.5))
    },
    "barrel 6:1": (
        30.0,
        0.6,
        {
            "kind": "point-contact",
            "bodies": {
                "lower": {"shape": "flat", **_STEEL},
                "upper": {"shape": "barrel", "diameter_mm": 10.0, "diameter_along_mm": 60.0, **_STEEL},
            },
        },
    ),
}


@dataclass(frozen=True)
class Loading:
    """A first loading: force in N and friction's work so far in mJ at its steps, and the states there.

    stiffness_error: relative error of K.
    """

    problem: ContactProblem
    exact: reference.PartialSlipPoint
    force: NDArray[np.float64]
    work: NDArray[np.float64]
    states: tuple[ContactState, ...]
    stiffness_error: float

    @property
    def shares(self) -> NDArray[np.float64]:
        """Amplitude of the tangential force over µP."""
        return self.force / self.exact.limit_N

    def energy_errors(self) -> NDArray[np.float64]:
        """Relative errors of the energies of loops up to each step's force."""
        exact = np.array([reference.energy_per_cycle(self.exact, force) for force in self.force[1:]])
        return np.array(4.0 * self.work[1:] / exact - 1.0)

    def core_errors(self) -> NDArray[np.float64]:
        """Mean radius of the nodes that stick less the closed form's, at each step, over the side of an element there:
        of those that gave way last.
        """
        sizes, start, found = self.problem.primary.node_areas, self.states[0], []
        before, edge = start.traction[:, 2] > 0.0, float(np.sqrt(sizes.min()))
        for state, share in zip(self.states[1:], self.shares[1:], strict=True):
            sticks = (state.traction[:, 2] > 0.0) & (state.primary_slid == start.primary_slid)
            edge = float(np.sqrt(sizes[before & ~sticks].mean())) if (before & ~sticks).any() else edge
            core = self.exact.contact_radius_mm * max(1.0 - float(share), 0.0) ** (1.0 / 3.0)
            found.append((float(np.sqrt(sizes[sticks].sum() / np.pi)) - core) / edge)
            before = sticks
        return np.array(found)


def study_of(kind: str, held_N: float, rig: dict[str, Any] | None = None) -> Study:
    """One cycle of a contact under a held force, on a rigid rig or one with the keys `rig`."""
    load, friction, bodies = KINDS[kind]
    conditions = {"normal_load_N": load, "displacement_amplitude_um": 30.0, "frequency_Hz": 1.0, "cycles": 1}
    tables = {
        "format": 1,
        "name": kind,
        **bodies,
        "contact": {"friction": friction},
        "conditions": conditions | {"held_tangential_force_N": held_N},
        "log": {"loop_cycles": [1]},
        **({"holder": rig} if rig else {}),
    }
    study: Study = study_from_tables(tables, kind)
    return study


def exact_of(kind: str) -> reference.PartialSlipPoint:
    """The closed form of a contact, which moves along x."""
    load, friction, _ = KINDS[kind]
    lower, upper = study_of(kind, 0.5 * friction * load).bodies
    hertz = hertz_of(load, lower, upper)
    stiffness = reference.elliptic_stiffness(hertz, lower.material, hertz.major_angle_rad)
    return reference.PartialSlipPoint(load, friction, hertz.contact_radius_mm, stiffness)


def run_error(kind: str, level: str, rig_over_contact: float) -> float:
    """Relative error of a run's energy under half of the sliding force; the rig's stiffness is so many times the
    contact's, infinite for a rigid one.
    """
    exact = exact_of(kind)
    rig = {"tangential_stiffness_N_per_mm": rig_over_contact * exact.stiffness_N_per_mm}
    study = study_of(kind, DRAWN * exact.limit_N, rig if np.isfinite(rig_over_contact) else None)
    first = simulate(study, fidelity=level).evolution
    force = float(first["max_tangential_force_N"][0])
    return float(first["dissipated_energy_mJ"][0]) / reference.energy_per_cycle(exact, force) - 1.0


def loaded(kind: str, level: str) -> Loading:
    """The first loading of a contact on the meshes of a level, until it all but slides."""
    load, friction, _ = KINDS[kind]
    study = study_of(kind, 0.5 * friction * load)
    problem = contact_problem(study, discretise(study, level), lambda _stage: None)
    exact = exact_of(kind)
    pressed, _ = press(problem, unloaded_state(problem))
    tiny = advance(problem, pressed, 1e-6 * exact.limit_N / exact.stiffness_N_per_mm, 0.0)[0]
    whole, bulk = tiny.drive / _force(tiny), _bulk(problem, kind)
    forces = exact.limit_N * np.array([0.0, *SHARES])
    displacement = reference.loading_displacement(exact, forces)
    displacement += (whole - 1.0 / exact.stiffness_N_per_mm) * forces
    states, work = [pressed], [0.0]
    for place in displacement[1:]:
        state, reports = advance(problem, states[-1], float(place), 0.0)
        states.append(state)
        work.append(work[-1] + sum(report.friction_work for report in reports))
    reached = np.array([_force(state) for state in states])
    stiffness_error = 1.0 / (whole - bulk) / exact.stiffness_N_per_mm - 1.0
    return Loading(problem, exact, reached, np.array(work), tuple(states), stiffness_error)


def _bulk(problem: ContactProblem, kind: str) -> float:
    """Compliance in mm/N along the motion of both bodies beyond that of half-spaces: what a force at one node moves
    those at the rim by, less Cerruti's displacement.
    """
    hertz = hertz_of(KINDS[kind][0], *study_of(kind, 1.0).bodies)
    nu, modulus, found = _STEEL["poissons_ratio"], _STEEL["youngs_modulus_MPa"], 0.0
    c, s = np.cos(hertz.major_angle_rad), np.sin(hertz.major_angle_rad)
    for body in (problem.primary, problem.secondary):
        x, y = body.node_positions.T
        r, middle = np.hypot(x, y), int(np.argmin(x**2 + y**2))
        reach = np.hypot((c * x + s * y) / hertz.major_semi_axis_mm, (c * y - s * x) / hertz.minor_semi_axis_mm)
        rim = (reach > 0.9) & (reach < 1.2)
        moved = body.folded.between(np.flatnonzero(rim), np.array([middle]))[::3, 0]
        shape = (1.0 + nu) * (1.0 - nu + nu * (x[rim] / r[rim]) ** 2)
        found += float((moved - shape / (np.pi * modulus * r[rim])).mean())
    return found


def _force(state: ContactState) -> float:
    return abs(float(state.primary_force[:, 0].sum()))


def line_run(level: str, share: float, bulk_MPa: float = 0.0, cycles: int = 1) -> Any:
    """A run of the line contact `LINE` under this share of its sliding force; it wears if there are several cycles."""
    load, friction, radius = LINE
    tables = {
        "format": 1,
        "name": "line",
        "kind": "cylinder-on-flat",
        "pad": {"radius_mm": radius, **_STEEL},
        "specimen": {**_STEEL, **({"bulk": {"axial_stress_amplitude_MPa": bulk_MPa}} if bulk_MPa else {})},
        "conditions": {
            "normal_load_N_per_mm": load,
            "displacement_amplitude_um": 30.0,
            "held_tangential_force_N_per_mm": share * friction * load,
            "cycles": cycles,
        },
        "contact": {"friction": friction},
        "log": {"loop_cycles": sorted({1, cycles})},
        **({"wear": {"pad_energy_mm3_per_J": 1e-3, "specimen_energy_mm3_per_J": 1e-3}} if cycles > 1 else {}),
    }
    return simulate(study_from_tables(tables, "line"), fidelity=level)


def _hertz_line() -> tuple[reference.LineContact, float]:
    load, _, radius = LINE
    steel = reference.Elastic(*_STEEL.values())
    modulus = reference.contact_modulus(steel, steel)
    return reference.hertz_line(load, radius, modulus), modulus


def line_row(level: str, share: float, bulk_MPa: float) -> str:
    """Errors in percent of a loop's energy and of the stick zone's size and shift."""
    run, (hertz, modulus), friction = line_run(level, share, bulk_MPa), _hertz_line(), LINE[1]
    forces = run.computed.forces(1, "specimen")
    x = 1e-3 * run.scar(1, "specimen").axial_um[forces.nodes]
    sheared = forces.force_N[..., 0]
    at_end = int(np.argmax(np.abs(sheared.sum(axis=1))))
    pressed, force = np.abs(forces.force_N[at_end, :, 2]), abs(float(sheared[at_end].sum()))
    unused = friction * pressed - np.abs(sheared[at_end].sum()) / sheared[at_end].sum() * sheared[at_end]
    middle = float(unused @ x / unused.sum())
    half = 2.0 * float(unused @ (x - middle) ** 2 / unused.sum()) ** 0.5
    shift = abs(middle - float(pressed @ x / pressed.sum()))
    limit = friction * hertz.normal_load_N_per_mm
    exact = reference.line_energy_per_cycle(hertz, friction, modulus, force, bulk_MPa)
    found = {
        "energy": float(run.loops[0].friction_work_mJ[-1]) / exact,
        "size": half / (hertz.half_width_mm * reference.line_stick_ratio(force, limit)),
        "shift": shift / reference.line_stick_shift(hertz, friction, bulk_MPa),
    }
    cells = " | ".join(f"{name} {100.0 * (value - 1.0):+.1f}" for name, value in found.items())
    return f"| line, {level}, {share:g}, {bulk_MPa:g} MPa | {cells} |".replace("-", "−")


def worn_row(level: str, share: float) -> str:
    """Errors in percent of volumes worn at the end: of a ball, and of a line contact, whose core leaves a punch's share
    of the load, Q/µ.
    """
    (hertz, modulus), (load, _, radius) = _hertz_line(), LINE
    core, punch = hertz.half_width_mm * (1.0 - share) ** 0.5, 2.0 * share * load / (pi * modulus)

    def depth(x: float) -> float:
        angle = acosh(x / core)
        return float(punch * angle - (x * (x**2 - core**2) ** 0.5 - core**2 * angle) / (2.0 * radius))

    area = 2.0 * quad(depth, core, brentq(depth, 1.001 * core, 20.0 * core))[0]
    ball = simulate(held_force_study(share), fidelity=level).worn_volume_mm3[-1] / held_force_shape(share)[1]
    line = line_run(level, share, cycles=20_000).worn_volume_mm3[-1] / area
    cells = f"ball {100.0 * (ball - 1.0):+.1f} | line {100.0 * (line - 1.0):+.1f}"
    return f"| worn, {level}, {share:g} | {cells} |".replace("-", "−")


def rows(loadings: dict[tuple[str, str], Loading]) -> list[str]:
    """Lines of the table in the docs: errors at the steps nearest to the shares of µP, in percent; and of the core."""
    lines = []
    for (kind, level), one in loadings.items():
        steps = [int(np.argmin(np.abs(one.shares[1:] - q))) for q in SHARES]
        for name, errors in ((level, 100.0 * one.energy_errors()), (f"{level}, core", one.core_errors())):
            lines.append(f"| {kind}, {name} | {' | '.join(f'{errors[step]:+.1f}' for step in steps)} |")
        lines[-1] += f" K {100.0 * one.stiffness_error:+.1f} %"
    return [line.replace("-", "−") for line in lines]


def picture(loadings: dict[tuple[str, str], Loading]) -> Any:
    """What sticks and what slips of the first contact's nodes, and errors of all over the force."""
    figure = style.new_figure(3.2)
    above, errors = figure.subplots(1, 2)
    (_, level), first = next(iter(loadings.items()))
    step = int(np.argmin(np.abs(first.shares - DRAWN)))
    state, start, radius = first.states[step], first.states[0], 1e3 * first.exact.contact_radius_mm
    touches = state.traction[:, 2] > 0.0
    sticks = touches & (state.primary_slid == start.primary_slid)
    x, y = 1e3 * first.problem.primary.node_positions.T
    for which, name, colour in ((sticks, "sticks", style.INK), (touches & ~sticks, "slips", style.VARIANT_COLOURS[1])):
        above.plot(x[which], y[which], linestyle="", marker="o", markersize=2.0, color=colour, label=name)
    inner = radius * (1.0 - float(first.shares[step])) ** (1.0 / 3.0)
    for size in (radius, inner):
        above.add_patch(Circle((0.0, 0.0), size, fill=False, color="grey", linewidth=0.8))
    above.set(title=f"Q/µP = {DRAWN:g}, {level}", xlabel="along the motion [µm]", ylabel="across [µm]", aspect="equal")
    above.set_ylim(-1.25 * radius, 1.5 * radius)
    above.legend(loc="upper center", ncols=2)
    for index, ((kind, at), one) in enumerate(loadings.items()):
        look = {"marker": "osd^"[index % 4], "markersize": 2.5, "linewidth": 0.8}
        wide = one.shares[1:] > 0.9 * SHARES[0]
        errors.plot(
            one.shares[1:][wide],
            100.0 * one.energy_errors()[wide],
            color=style.VARIANT_COLOURS[index],
            label=f"{kind}, {at}",
            **look,
        )
    errors.axhline(0.0, color=style.INK, linewidth=0.8)
    errors.set(title="energy of a loop", xlabel="Q/µP", ylabel="error [%]")
    errors.legend()
    style.panel_letters([above, errors])
    return figure


@click.command(cls=StudyScript)
@click.option("--level", "levels", multiple=True, type=click.Choice(FIDELITIES), default=FIDELITIES[:2])
@click.option("--kind", "kinds", multiple=True, type=click.Choice(tuple(KINDS)), default=tuple(KINDS))
@click.option("--runs", type=click.Choice(FIDELITIES), help="Level of whole runs.")
@click.option("--lines", type=click.Choice(FIDELITIES), help="Level of line contacts' runs.")
@click.option("--worn", type=click.Choice(FIDELITIES), help="Level of runs that wear out.")
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/partial_slip"), show_default=True)
def main(
    levels: tuple[str, ...], kinds: tuple[str, ...], runs: str | None, lines: str | None, worn: str | None, output: Path
) -> None:
    """Load the contacts at each level, draw partial_slip.png and print the rows."""
    output.mkdir(parents=True, exist_ok=True)
    loadings = {(kind, level): loaded(kind, level) for kind in kinds for level in levels}
    drawn = {named: one for named, one in loadings.items() if named[0] in kinds[:2]}
    click.echo(style.save(lambda: picture(drawn), output / "partial_slip.png"))
    click.echo("\n".join(rows(loadings)))
    if lines is not None:
        click.echo("\n".join(line_row(lines, *one) for one in BULK))
    if worn is not None:
        click.echo("\n".join(worn_row(worn, share) for share in (0.15, 0.3, 0.6, 0.9)))
    if runs is None:
        return
    for rig in (np.inf, 1.0):
        errors = " | ".join(f"{100.0 * run_error(kind, runs, rig):+.2f}" for kind in kinds)
        click.echo(f"| rig {rig:g} times as stiff, {runs} | {errors} |".replace("-", "−"))


if __name__ == "__main__":
    raise SystemExit(main())
