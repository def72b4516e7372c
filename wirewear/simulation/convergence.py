"""Convergence of a study's results: the study run again with finer mesh, positions and cycle jumps.

Each of these resolutions is refined by two factors while the others stay. Every figure, a number at the end of the run,
is extrapolated to its limit, the value at zero spacing, by each resolution; changes and errors of all resolutions add
up.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, isnan, nan
from pathlib import Path
from typing import Any

from rich import box
from rich.markup import escape
from rich.table import Table
from scipy.optimize import brentq

from wirewear.base.engine import Engine
from wirewear.base.errors import ResultError
from wirewear.base.writing import write_csv, writing
from wirewear.results import RunResult
from wirewear.results.scar import called
from wirewear.simulation.discretisation import discretise
from wirewear.simulation.line_model import line_plan
from wirewear.simulation.runs import ObserverOf, run_study
from wirewear.test import AnyStudy, LineStudy, Study
from wirewear.test.any_study import Of, alone

# Orders outside these are accidental. Nothing in the solver is of a higher order than the second.
_LEAST_ORDER, _LARGEST_ORDER = 0.5, 2.0
_ROUND_OFF = 1e-9  # Changes below this share of the value are round-off.

BASE = "base"

CSV_FILE_NAME = "convergence.csv"


@dataclass(frozen=True)
class Limit:
    """A value extrapolated to zero spacing from three values at falling spacings. error: the extrapolated part or,
    without a trend, the range of the values. order: of convergence, None without a trend.
    """

    value: float
    error: float
    order: float | None


def richardson(spacings: Sequence[float], values: Sequence[float]) -> Limit:
    """Richardson's extrapolation of values at three falling spacings, with errors as a power (0.5 to 2) of the spacing.
    Where values show no trend: the finest value, with their range as error. NaN if a value is NaN. Raises ValueError if
    there are not three of each, or the spacings do not fall.
    """
    if len(spacings) != 3 or len(values) != 3 or not spacings[0] > spacings[1] > spacings[2] > 0.0:
        raise ValueError("an extrapolation needs three falling spacings and their values")
    coarse, middle, fine = values
    if any(isnan(value) for value in values):
        return Limit(nan, nan, None)
    first, second = middle - coarse, fine - middle
    if max(abs(first), abs(second)) <= _ROUND_OFF * abs(fine):
        return Limit(fine, 0.0, None)
    if first * second <= 0.0:
        return Limit(fine, max(values) - min(values), None)
    order = _order(spacings, first / second)
    beyond = second / ((spacings[1] / spacings[2]) ** order - 1.0)
    return Limit(fine + beyond, abs(beyond), order)


def _order(spacings: Sequence[float], ratio: float) -> float:
    """The order of convergence for which successive changes have this ratio, between _LEAST_ORDER and
    _LARGEST_ORDER.
    """
    coarse, middle, fine = spacings

    def excess(order: float) -> float:
        return float((coarse**order - middle**order) / (middle**order - fine**order)) - ratio

    if excess(_LEAST_ORDER) >= 0.0:
        return _LEAST_ORDER
    if excess(_LARGEST_ORDER) <= 0.0:
        return _LARGEST_ORDER
    return float(brentq(excess, _LEAST_ORDER, _LARGEST_ORDER))


@dataclass(frozen=True)
class Resolution:
    """A resolution that is refined, such as the mesh. factors: by which its spacing is divided in both runs."""

    name: str
    factors: tuple[float, float]

    @property
    def runs(self) -> tuple[str, str]:
        """Names of the two refined runs, such as "mesh-1.4" and "mesh-2"."""
        first, second = (f"{self.name}-{factor:g}" for factor in self.factors)
        return first, second


MESH = Resolution("mesh", (1.4, 2.0))
POSITIONS = Resolution("positions", (1.5, 2.0))
JUMPS = Resolution("jumps", (1.4, 2.0))


def finer_tolerance(tolerance: float, factor: float) -> float:
    """The jump tolerance for jumps shorter by `factor`: tolerance / factor², as errors go with the square of a jump."""
    return tolerance / factor**2


@dataclass(frozen=True)
class Figure:
    """A number at the end of a run that is compared between resolutions. of: takes it from a result, in `unit`."""

    name: str
    unit: str
    of: Callable[[RunResult], float]


def last_of(column: str, factor: float = 1.0) -> Callable[[RunResult], float]:
    """A function that gives the last value in a column of a result's evolution times `factor`."""
    return lambda result: factor * float(result.evolution[column][-1])


#: Pressures of any contact; means are over a length that no refinement changes.
PRESSURES = (
    Figure("largest mean pressure", "MPa", last_of("max_mean_pressure_MPa")),
    Figure("mean pressure at mid-stroke", "MPa", last_of("mid_stroke_mean_pressure_MPa")),
    Figure("largest pressure at a node", "MPa", last_of("max_pressure_MPa")),
    Figure("pressure at a node at mid-stroke", "MPa", last_of("mid_stroke_pressure_MPa")),
)


def depth_of(body: int) -> Callable[[RunResult], float]:
    """A function that gives the largest depth in µm, at the end, of a result's driven body (0) or held body (1)."""
    return lambda result: float(result.evolution[f"max_depth_{result.bodies[body]}_um"][-1])


def figures_of(bodies: tuple[str, ...]) -> tuple[Figure, ...]:
    """The figures that are compared for a contact at a point between bodies with these names (driven, held)."""
    depths = (Figure(f"depth of the {called(name)}", "µm", depth_of(k)) for k, name in enumerate(bodies))
    return (*FORCES, *depths, VOLUME, *PRESSURES)


FORCES = (
    Figure("largest tangential force", "N", last_of("max_tangential_force_N")),
    Figure("energy of the last cycle", "µJ", last_of("dissipated_energy_mJ", 1e3)),
    Figure("slip amplitude δ0", "µm", last_of("slip_amplitude_um")),
)
VOLUME = Figure("worn volume", "10⁻³ mm³", lambda result: 1e3 * float(result.worn_volume_mm3[-1]))


@dataclass(frozen=True)
class Converged:
    """A figure at the end of the run: its value as the study asks for it, its values in refined runs by their names,
    and its limits by the names of the resolutions.
    """

    figure: Figure
    value: float
    refined: Mapping[str, float]
    limits: Mapping[str, Limit]

    @property
    def limit(self) -> float:
        """The figure's limit by all resolutions: its value plus the change to the limit by each."""
        return self.value + sum(limit.value - self.value for limit in self.limits.values())

    @property
    def error(self) -> float:
        """Error of `limit`, in the figure's unit: the sum of the errors of all resolutions."""
        return sum(limit.error for limit in self.limits.values())


Changes = dict[str, Any]  #: Tables of a study, nested as in its file.


@dataclass(frozen=True)
class RefinedSubject:
    """How convergence is studied for contacts at a point (POINTS) or line contacts (LINES). figures: those compared,
    from the bodies' names. finer: from a study and a fidelity, functions that give the changed keys for a refinement by
    a factor, by resolution.
    """

    figures: Callable[[tuple[str, ...]], Sequence[Figure]]
    finer: Callable[[Any, str], Mapping[Resolution, Callable[[float], Changes]]]

    def refined(self, study: Of, fidelity: str) -> Of:
        """A study whose variants are the given one, named BASE, and its refinements, named as `Resolution.runs`.
        fidelity: level that is refined. Raises StudyError if the given study has variants of its own.
        """
        settings: dict[str, Changes] = {BASE: {}} | {
            run: changes(factor)
            for resolution, changes in self.finer(alone(study), fidelity).items()
            for run, factor in zip(resolution.runs, resolution.factors, strict=True)
        }
        variants = tuple((name, study.changed(changes).tables) for name, changes in settings.items())
        return replace(study, variants=variants, variant_name="")


def finer_point(study: Study, fidelity: str) -> Mapping[Resolution, Callable[[float], Changes]]:
    """For each resolution of a contact at a point: a function that gives the changed keys, nested, for a refinement by
    a factor. The mesh always; with wear also the positions of a cycle and, unless the study states the size of jumps,
    their tolerance.
    """
    sizes, chosen = discretise(study, fidelity), study.fidelity(fidelity)

    def of(own: Changes) -> Changes:
        return {"fidelity": {fidelity: own}}

    finer: dict[Resolution, Callable[[float], Changes]] = {
        MESH: lambda factor: of({"mesh_refinement": factor * chosen.mesh_refinement})
    }
    if study.wear is not None:
        increments = sizes.increments_per_wear_cycle
        finer[POSITIONS] = lambda factor: of({"increments_per_wear_cycle": 4 * ceil(factor * increments / 4)})
        if study.wear.explicit_jump_cycles is None:
            finer[JUMPS] = lambda factor: of({"jump_tolerance": finer_tolerance(sizes.jump_tolerance, factor)})
    return finer


def finer_line(study: LineStudy, fidelity: str) -> Mapping[Resolution, Callable[[float], Changes]]:
    """For each resolution of a line contact: a function that gives the changed keys, nested, for a refinement by a
    factor. Mesh and increments always; with wear also the jumps' tolerance.
    """
    tolerance, mesh = line_plan(study, fidelity).jump_tolerance, study.mesh
    finer: dict[Resolution, Callable[[float], Changes]] = {
        MESH: lambda factor: {"mesh": {"mesh_refinement": factor * mesh.mesh_refinement}},
        POSITIONS: lambda factor: {"mesh": {"increments_refinement": factor * mesh.increments_refinement}},
    }
    if max(study.energy_coefficients()) > 0.0:
        finer[JUMPS] = lambda factor: {"mesh": {"jump_tolerance": finer_tolerance(tolerance, factor)}}
    return finer


POINTS = RefinedSubject(figures_of, finer_point)
LINES = RefinedSubject(
    lambda _: (
        Figure("largest tangential force", "N/mm", last_of("max_tangential_force_N")),
        Figure("energy of the last cycle", "mJ/mm", last_of("dissipated_energy_mJ")),
        Figure("slip amplitude δ0", "µm", last_of("slip_amplitude_um")),
        Figure("depth of the pad", "µm", last_of("max_depth_pad_um")),
        Figure("depth of the specimen", "µm", last_of("max_depth_specimen_um")),
        Figure("worn area of both bodies", "µm²", lambda result: 1e6 * float(result.worn_volume_mm3[-1])),
        Figure("half-width of the contact", "µm", last_of("contact_half_width_um")),
        *PRESSURES,
    ),
    finer_line,
)


def converge(
    study: AnyStudy,
    subject: RefinedSubject,
    *,
    fidelity: str,
    output: Path,
    observer_of: ObserverOf | None = None,
    jobs: int = 1,
    engine: Engine | None = None,
) -> list[Converged]:
    """Run the study and its refinements, each in a folder of `output`, and extrapolate each figure; complete runs there
    are read. subject: POINTS or LINES. The other arguments are as in `run_study`. Raises StudyError if the study has
    variants of its own, and what `run_study` raises.
    """
    results = run_study(
        subject.refined(study, fidelity),
        fidelity=fidelity,
        output=output,
        resume=True,
        observer_of=observer_of,
        jobs=jobs,
        engine=engine,
    )
    return _extrapolated(
        subject.figures(study.body_names),
        tuple(subject.finer(study, fidelity)),
        {result.variant: result for result in results},
    )


def _extrapolated(
    figures: Sequence[Figure], resolutions: Sequence[Resolution], results: Mapping[str, Any]
) -> list[Converged]:
    """Every figure of the base run, with its values in the refined runs and its limits."""
    rows = []
    for figure in figures:
        values = {name: figure.of(result) for name, result in results.items()}
        base = values.pop(BASE)
        limits = {
            resolution.name: richardson(
                [1.0, *(1.0 / factor for factor in resolution.factors)],
                [base, *(values[run] for run in resolution.runs)],
            )
            for resolution in resolutions
        }
        rows.append(Converged(figure, base, values, limits))
    return rows


def convergence_table(rows: Sequence[Converged]) -> Table:
    """A table for rich to print: each figure (at least one), its changes by every refinement, and its limit."""
    shown = Table(box=box.SIMPLE, pad_edge=False, title="The last cycle's figures and where they tend to")
    shown.add_column("figure")
    shown.add_column("value", justify="right", no_wrap=True)
    for run in rows[0].refined:
        name, factor = run.rsplit("-", 1)
        shown.add_column(f"{name}\n× {factor}", justify="right", no_wrap=True)
    for heading in ("limit", "error of\nlimit", "value off\nlimit by"):
        shown.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        changes = (_percent(value - row.value, row.value) for value in row.refined.values())
        shown.add_row(
            escape(f"{row.figure.name} [{row.figure.unit}]"),
            f"{row.value:.5g}",
            *changes,
            f"{row.limit:.5g}",
            _percent(row.error, row.limit, sign=""),
            _percent(row.value - row.limit, row.limit),
        )
    return shown


def _percent(part: float, whole: float, sign: str = "+") -> str:
    return f"{100.0 * part / whole:{sign}.2f} %" if whole else "–"


def write_convergence(folder: Path, rows: Sequence[Converged]) -> Path:
    """Write convergence.csv to `folder`: values in all runs, limit, error and order by each resolution, and the limit
    by all; return its path. Raises ResultError if it cannot be written.
    """
    path = folder / CSV_FILE_NAME
    with writing(ResultError, f"cannot write {path}"):
        return write_csv(path, [_cells(row) for row in rows])


def _cells(row: Converged) -> dict[str, Any]:
    limits: dict[str, float | None] = {}
    for name, limit in row.limits.items():
        limits |= {f"limit_{name}": limit.value, f"error_{name}": limit.error, f"order_{name}": limit.order}
    first = {"figure": row.figure.name, "unit": row.figure.unit, "base": row.value}
    return {**first, **row.refined, **limits, "limit": row.limit, "error": row.error}
