"""Tier T2: records of cases made by the independent model."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from studies.blind.causes import causes_of
from studies.blind.generators import sampling
from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.files import scar_lines_um
from studies.blind.generators.generator import LIBRARY_EFFECTS, MadeRecord, weaker_of
from studies.blind.generators.independent.foundation import Grid
from studies.blind.generators.independent.sensing import Reading, read
from studies.blind.generators.independent.wear_test import POINTS, Snapshot, grid_of, snapshots
from studies.blind.generators.independent.world import World
from studies.blind.generators.independent.worlds import nominal_world, with_drive, with_effects, with_specimens
from studies.blind.generators.nominal import Nominal, drawn_nominals
from studies.blind.generators.nuisances import FORCE_ZERO, SpecimenDraw
from wirewear.base.errors import RunError
from wirewear.records import MeasuredScar

Array = NDArray[np.float64]

#: Steps of the finite differences that turn scatter of specimens into scatter of figures.
STEPS = {"friction": 0.02, "load": 0.02, "wear": 0.1, "angle_deg": 2.0}
COMPARED = (0.001, 0.01, 0.1, 0.3, 1.0)  #: Figures are compared at these parts of the test.
PHASES = 64  #: Phases at which shapes of loops are compared.


@dataclass(frozen=True)
class IndependentModel:
    """Wires on an elastic foundation, with a friction law other than Coulomb's (see `friction.LAWS`).

    `points` is the resolution: points of the grid to each side of the contact.
    """

    law: str = "dahl"
    points: int = POINTS
    tier: str = "T2"
    library: Sequence[str] = LIBRARY_EFFECTS
    outside: Sequence[str] = causes_of("first")

    @property
    def description(self) -> str:
        """What the manifest says of it."""
        drawn = "" if tuple(self.outside) == causes_of("first") else ", causes of no library drawn from another set"
        return f"wires on an elastic foundation, friction law {self.law}{drawn}"

    def nominals(self, number: int, random: np.random.Generator) -> tuple[Nominal, ...]:
        return drawn_nominals(number, random)

    def make(self, case: Case) -> MadeRecord:
        """The record of a case; the same for the same case.
        Raises RunError if the case's world cannot be run: its contact does not slip.
        """
        random = np.random.default_rng(case.seed)
        true = self.true_world(case)
        tests: list[sampling.LoggedTest] = []
        with _slipping(case):
            for repeat in range(1, case.nuisances.repeats + 1):
                world = with_drive(with_specimens(true, case.nuisances.specimen(random)), case.nuisances)
                tests.append(_repeat(world, case, repeat, self.points, random))
        return MadeRecord(sampling.record_of(case, tests), case.nuisances, *self.sized(case))

    def sized(self, case: Case) -> tuple[dict[str, float], float]:
        """What the case's effects change: figures of the readings and scars, each over one test's scatter; and what the
        weaker of two changes, see `weaker_of`. Raises RunError if the contact does not slip.

        The shape of a loop counts as one figure: the root of the mean square over the phases. Figures that the record
        does not hold, of scars or of the normal force, do not count.
        """
        if not case.effects:
            return {}, 0.0
        with _slipping(case):
            return _sized(case, self)

    def true_world(self, case: Case) -> World:
        """The world with a case's effects in it."""
        stated = nominal_world(case.nominal, self.law, held_on_sensor=case.nuisances.drive == "sensor")
        return with_effects(stated, case)


@contextmanager
def _slipping(case: Case) -> Iterator[None]:
    """Raises RunError where the world's contact does not slip."""
    try:
        yield
    except ArithmeticError as error:
        raise RunError(f"{case.name} cannot be made: {error}") from error


def _repeat(world: World, case: Case, repeat: int, points: int, random: np.random.Generator) -> sampling.LoggedTest:
    taken: list[Snapshot] = []

    def readings() -> Iterator[tuple[int, sampling.Channels]]:
        for snapshot in snapshots(world, case.nuisances.all_cycles, points):
            taken[:] = [snapshot]
            yield snapshot.cycle, _in_um(read(world, snapshot.loop, snapshot.cycle))

    loops, evolution = sampling.logged_channels(readings(), case, repeat, random)
    scars = _scars(grid_of(world, points), taken[0], case, repeat, random) if case.nuisances.has_scars else []
    return sampling.LoggedTest(loops, evolution, scars)


def _in_um(reading: Reading) -> sampling.Channels:
    return 1e3 * reading.displacement_mm, reading.tangential_force_N, reading.normal_force_N


def _scars(grid: Grid, last: Snapshot, case: Case, repeat: int, random: np.random.Generator) -> list[MeasuredScar]:
    scars = []
    for wire, depth, x in _depths(grid, last):
        lines = scar_lines_um(case.nominal, wire)
        surface = RegularGridInterpolator((x, grid.y_mm), depth.T, bounds_error=False, fill_value=0.0)
        points = np.stack(np.meshgrid(1e-3 * lines[0], 1e-3 * lines[1], indexing="ij"), axis=-1)
        scars.append(sampling.logged_scar(repeat, wire, lines, 1e3 * surface(points), random))
    return scars


def _depths(grid: Grid, snapshot: Snapshot) -> tuple[tuple[str, Array, Array], ...]:
    return ("moving", snapshot.shapes.moving, grid.moving_x_mm), ("fixed", snapshot.shapes.fixed, grid.x_mm)


def _sized(case: Case, model: IndependentModel) -> tuple[dict[str, float], float]:
    cycles = tuple(sorted({max(round(part * case.nominal.cycles), 1) for part in COMPARED}))
    held = case.nuisances.drive == "sensor"
    expected, sensitivities = expected_figures(case.nominal, model, cycles, held)
    scatter = figure_scatter(expected, sensitivities, case)
    lacks = [] if case.nuisances.has_scars else ["scar"]
    lacks += [] if case.nuisances.has_normal_force else ["normal_force"]
    names = [name for name in expected if not name.startswith(tuple(lacks))]
    ends = np.cumsum([expected[name].size for name in names])

    def over_scatter(effects: Sequence[TrueEffect]) -> Array:
        found = figures_of(model.true_world(replace(case, effects=tuple(effects))), cycles, model.points)
        return np.concatenate([(found[name] - expected[name]) / scatter[name] for name in names])

    def by_figure(changes: Array) -> list[float]:
        return [round(float(np.sqrt(np.mean(part**2))), 3) for part in np.split(changes, ends[:-1])]

    changed = over_scatter(case.effects)
    weaker = weaker_of(case.effects, over_scatter, changed, lambda left: max(by_figure(left)))
    return dict(zip(names, by_figure(changed), strict=True)), weaker


@lru_cache(maxsize=64)
def expected_figures(
    nominal: Nominal, model: IndependentModel, cycles: tuple[int, ...], held_on_sensor: bool
) -> tuple[Mapping[str, Array], Mapping[str, Mapping[str, Array]]]:
    """Figures of the assumed world, and their derivatives by relative friction, load and wear."""
    world = nominal_world(nominal, model.law, held_on_sensor=held_on_sensor)
    figures = figures_of(world, cycles, model.points)
    sensitivities = {}
    for source, step in STEPS.items():
        draw = replace(SpecimenDraw(), **{source: getattr(SpecimenDraw(), source) + step})
        moved = figures_of(with_specimens(world, draw), cycles, model.points)
        sensitivities[source] = {name: (moved[name] - figures[name]) / step for name in figures}
    return figures, sensitivities


def figures_of(world: World, cycles: Sequence[int], points: int) -> dict[str, Array]:
    """Noise-free figures of the readings at some cycles, and of the scars at the end; the loop's shape as an array."""
    figures: dict[str, Array] = {}
    for snapshot in snapshots(world, cycles, points):
        displacement, force, normal = _in_um(read(world, snapshot.loop, snapshot.cycle))
        named: dict[str, float | Array] = {
            **sampling.loop_figures(displacement, force),
            "mean_force_N": 0.5 * float(force.max() + force.min()),
            "normal_force_N": float(normal.mean()),
            "loop_shape_N": force[:: force.size // PHASES],
        }
        figures.update({f"{name} at {snapshot.cycle}": np.atleast_1d(value) for name, value in named.items()})
    grid = grid_of(world, points)
    for wire, depth, x in _depths(grid, snapshot):
        skew = float(x @ depth.T @ grid.y_mm) / float(depth.sum())
        figures[f"scar_depth_um of {wire}"] = np.atleast_1d(1e3 * float(depth.max()))
        figures[f"scar_skew_um2 of {wire}"] = np.atleast_1d(1e6 * skew)
    return figures


def figure_scatter(
    expected: Mapping[str, Array], sensitivities: Mapping[str, Mapping[str, Array]], case: Case
) -> dict[str, Array]:
    """One test's standard deviation of each figure: scatter of specimens and what noise leaves in a figure."""
    nuisances = case.nuisances
    averaged = np.sqrt(nuisances.samples / 8.0)
    floor = {
        "displacement_amplitude_um": nuisances.displacement_noise_um,
        "slip_amplitude_um": nuisances.displacement_noise_um,
        "max_tangential_force_N": nuisances.force_noise_N,
        "mean_force_N": nuisances.force_noise_N * np.hypot(1.0 / averaged, FORCE_ZERO),
        "normal_force_N": nuisances.force_noise_N / averaged,
        "scar_depth_um": sampling.PROFILOMETER_NOISE_um,
    }
    deviations = {}
    for name, values in expected.items():
        quantity = name.split(" ", 1)[0]
        noise = floor.get(quantity, 1e-3 * np.abs(values))
        if quantity == "loop_shape_N":
            noise = np.hypot(
                nuisances.force_noise_N, nuisances.displacement_noise_um * _steepness(values, case.nominal)
            )
        parts = [(sensitivities[source][name] * getattr(nuisances.scatter, source)) ** 2 for source in STEPS]
        deviations[name] = np.sqrt(noise**2 + np.sum(parts, axis=0))
    return deviations


def _steepness(force_N: Array, nominal: Nominal) -> Array:
    """Force that an error of 1 µm in the displacement makes, at even phases of a sine (n,)."""
    phase = 2.0 * np.pi * np.arange(force_N.size) / force_N.size
    displacement = nominal.amplitude_um * np.sin(phase)
    rise = np.roll(force_N, -1) - np.roll(force_N, 1)
    run = np.roll(displacement, -1) - np.roll(displacement, 1)
    return np.abs(rise) / np.maximum(np.abs(run), 0.05 * nominal.amplitude_um)
