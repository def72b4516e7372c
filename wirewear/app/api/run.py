"""Results of runs that can draw themselves and convert their data to other formats, and lives of their bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from wirewear.base.errors import ResultError
from wirewear.base.frame import notebook_table
from wirewear.base.units import unit_of, words_of
from wirewear.base.words import counted
from wirewear.results import RunResult, write_result
from wirewear.results import read_result as read_plain
from wirewear.results import read_results as read_all_plain
from wirewear.results.export import labelled, surface_mesh, tables_of, write_netcdf
from wirewear.results.scar import called

if TYPE_CHECKING:
    from collections.abc import Callable

    import polars as pl
    import pyvista
    import xarray
    from matplotlib.figure import Figure

    from wirewear.stress.life import BodyLife


@dataclass(frozen=True, eq=False, repr=False)
class Run(RunResult):
    """Result of one run with methods to draw, convert and save it."""

    @classmethod
    def of(cls, result: RunResult) -> Run:
        """A `Run` with the same fields as a result that has no methods to draw or save it."""
        return cls(**{field.name: getattr(result, field.name) for field in fields(RunResult) if field.init})

    def plot(self, what: str = "overview", *, beside: Sequence[RunResult] = ()) -> Figure:
        """Figure named "overview", or like one of the pictures of `wirewear show`; beside: runs that are drawn with
        this one. Raises ResultError if there is no such picture, or the run has recorded nothing that it shows.
        """
        from wirewear.kinds import contacts_of
        from wirewear.pictures.style import styled

        results = distinguished([self, *beside])
        contacts = contacts_of(self)
        known = dict(contacts.drawings(results))
        known["overview"] = contacts.overview(results)
        if what not in known:
            raise ResultError(f"there is no picture {what!r} of this run: choose one of {', '.join(known)}.")
        with styled():
            return known[what]()

    def to_xarray(self) -> xarray.DataTree:
        """Evolution, loops and scars as labelled arrays, each with its unit in `attrs["units"]`.

        Raises ResultError if xarray is not installed.
        """
        return labelled(self)

    def to_polars(self, table: str = "evolution") -> pl.DataFrame:
        """The table "evolution", "loops" or "scars" as a data frame. Raises ResultError if there is no such table."""
        tables = tables_of(self)
        if table not in tables:
            raise ResultError(f"there is no table {table!r}: choose one of {', '.join(tables)}.")
        return tables[table](self)

    def surface(self, wire: str | None = None, cycle: float | None = None) -> pyvista.StructuredGrid:
        """Worn surface of a body as a mesh in µm, with depth, pressure, slip and energy at its points.

        wire: name of the body; None for the held one. cycle: None for the last one with scars. Raises ResultError if no
        scar is recorded near that cycle, there is no such body, or it is a line contact.
        """
        self.with_maps()
        body = wire or self.bodies[1]
        return surface_mesh(self.scar(self._last_scar() if cycle is None else cycle, body), upper=self.is_upper(body))

    def body(
        self, wire: str | None = None, cycle: float | None = None, at: str | int = "mid-forward", *, worn: bool = True
    ) -> pyvista.UnstructuredGrid:
        """Hexahedral mesh of a body in µm, with displacements and stresses at one position of a cycle.

        wire: name of the body; None for the held one. cycle: None for the last one with scars. at: "mid-forward",
        "end-forward", "after-end-forward", "mid-back", "end-back", "after-end-back", or the number of a recorded
        position. worn: True if the mesh follows the worn surface.
        Raises ResultError if no contact forces are recorded near that cycle, there is no such body or position, or it
        is a line contact; GeometryError if wear distorts the mesh too much.
        """
        from wirewear.stress import body_grid, body_states

        self.with_maps()
        cycle = self._last_scar() if cycle is None else cycle
        return body_grid(body_states(self, wire or self.bodies[1], cycle, [at], worn=worn)[0])

    def save(self, path: str | Path) -> Path:
        """Write the result as HDF5, for `read_result`, or as netCDF if the name ends in .nc; return the path.

        Raises ResultError if it cannot be written.
        """
        path = Path(path)
        if path.suffix == ".nc":
            return write_netcdf(self, path)
        write_result(path, self)
        return path

    def __repr__(self) -> str:
        evolution = self.evolution
        if not evolution["cycle"].size:
            return f"<Run {self.label!r}, {self.fidelity}, {self.status}: no cycle yet>"
        return (
            f"<Run {self.label!r}, {self.fidelity}, {self.status}: {counted(evolution['cycle'][-1])} cycles, "
            f"{len(self.loops)} loops, slip {evolution['slip_amplitude_um'][-1]:.1f} µm, "
            f"{evolution[f'max_depth_{self.bodies[1]}_um'][-1]:.2f} µm deep>"
        )

    def _repr_html_(self) -> str:
        from wirewear.pictures.style import styled

        evolution = self.evolution
        if not evolution["cycle"].size:
            return notebook_table(repr(self).strip("<>"), {"message": self.message})
        rows = {
            "cycles": f"{counted(evolution['cycle'][-1])}, {evolution['cycle'].size} measured",
            "slip amplitude, first → last": _course(self, "slip_amplitude_um", "µm"),
            "energy per cycle, first → last": _course(self, "dissipated_energy_mJ", "mJ"),
            "friction energy in all": f"{evolution['accumulated_energy_J'][-1]:.4g} J",
            f"deepest wear, {' and '.join(map(called, self.bodies))}": " and ".join(
                f"{evolution[f'max_depth_{body}_um'][-1]:.4g}" for body in self.bodies
            )
            + " µm",
        }
        picture = BytesIO()
        with styled():
            self.plot().savefig(picture, format="png", dpi=110)
        note = f"{self.status}: {self.message}" if self.message else self.status
        return notebook_table(f"{self.label}, {self.fidelity} fidelity", rows, note=note, pictures=[picture.getvalue()])

    def _last_scar(self) -> float:
        return max(self.scar_cycles(), default=1)


def distinguished(results: Sequence[RunResult]) -> list[RunResult]:
    """Copies of the results with distinct labels; equal ones are extended by keys in which the studies differ, or by a
    number.
    """
    labels = [result.label for result in results]
    if len(set(labels)) == len(labels):
        return list(results)
    stated = [_stated(result.study) | {"fidelity": result.fidelity} for result in results]
    # Of values that differ between runs, two stand in the label of each.
    differing = [key for key in stated[0] if len({one.get(key) for one in stated}) > 1][:2]
    own: list[RunResult] = []
    for result, values in zip(results, stated, strict=True):
        known = [f"{words_of(key)} {values.get(key, '–')} {unit_of(key)}".removesuffix(" 1") for key in differing]
        label = ", ".join([result.label, *known])
        again = sum(one.label.partition(" (")[0] == label for one in own)
        own.append(replace(result))
        object.__setattr__(own[-1], "label", f"{label} ({again + 1})" if again else label)
    return own


def _stated(table: Mapping[str, object]) -> dict[str, str]:
    """Values of a study by key, without the table [log]."""
    found: dict[str, str] = {}
    for key, value in table.items():
        if key != "log":
            found |= _stated(value) if isinstance(value, Mapping) else {key: str(value)}
    return found


def read_result(path: str | Path) -> Run:
    """The run stored in a file, or in the folder of one run.

    Raises ResultError if there is none, it is damaged, or the folder holds several.
    """
    return Run.of(one_run(Path(path)))


def one_run(path: Path) -> RunResult:
    """Result of the only run in a file or folder. Raises ResultError if there is none, or several, or it cannot be
    read.
    """
    if not path.is_dir():
        return read_plain(path)
    runs = read_all_plain(path)
    if len(runs) > 1:
        raise ResultError(
            f"{path} holds several runs ({', '.join(run.variant for run in runs)}): name one's folder, or read all "
            "with read_results."
        )
    return runs[0]


def read_results(path: str | Path) -> tuple[Run, ...]:
    """All runs at `path`, sorted by variant: a result file, a run's folder, or a folder of variants' folders. Raises
    ResultError if nothing is found there, or a file found cannot be read.
    """
    return tuple(Run.of(result) for result in read_all_plain(Path(path)))


def _course(run: RunResult, column: str, unit: str) -> str:
    values = run.evolution[column]
    return f"{values[0]:.4g} → {values[-1]:.4g} {unit}"


def lives(
    result: RunResult,
    bodies: Sequence[str] = (),
    *,
    values: Mapping[str, object] | None = None,
    wear_states: int | None = None,
    tell: Callable[[str, int], None] = lambda _body, _cycle: None,
) -> tuple[BodyLife, ...]:
    """Fatigue lives of the bodies of a run, both by default, by [life] of its study.

    bodies: their names, or "lower" and "upper". values: replace keys of [life]. wear_states: most wear states used in
    each block of cycles. tell: called with each body and cycle before it is computed.
    Raises StudyError if a value is not allowed, or data are lacking; ResultError if the run has recorded no contact
    forces; GeometryError if wear distorts a mesh too much.
    """
    from wirewear.kinds import contacts_of
    from wirewear.results.scar import body_named
    from wirewear.stress.averaging import averaging_radius_mm
    from wirewear.stress.life import WEAR_STATES, life_of, recorded_cycles
    from wirewear.stress.strength import StrengthAsked, assessable
    from wirewear.test import study_from_tables
    from wirewear.test.any_study import life_data

    inside = contacts_of(result).inside
    study = study_from_tables(result.study, result.label)
    named = [body_named(body, result.label, result.bodies) for body in bodies or result.bodies]
    found = []
    for body, table in life_data(study, named, values or {}).items():
        length_um = 2e3 * averaging_radius_mm(table, plane=False)
        first = min(recorded_cycles(result, body), default=1)
        assessable(result, body, first, StrengthAsked(averaging_length_um=length_um), inside)
        states_at, watch = partial(inside.states, result, body), partial(tell, body)
        most = wear_states or WEAR_STATES
        found.append(life_of(result, body, table, states_at, study.schedule, wear_states=most, watch=watch))
    return tuple(found)
