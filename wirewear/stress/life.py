"""How many cycles a body of a run lasts until a crack begins in it, where, and on which plane.

A wear state is a recorded cycle with the worn surface of that time. Columns are lines into the body's depth, at the
crossings of lines (a,) along and (t,) across its axis, in the body's own axes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geometry.arrays import Array, IntArray
from geometry.patch import linear_weights
from solvers.elasticity.linear_elasticity import interpolation
from wirewear.base.errors import ResultError, renamed
from wirewear.results import RunResult
from wirewear.results.scar import called
from wirewear.stress.averaging import averaging, averaging_radius_mm, kernel_of, widened
from wirewear.stress.criteria import LifeCriterion, criterion_of
from wirewear.stress.damage import FLOOR, Ahead, Damage, Initiation, Rates, Span
from wirewear.stress.state import InnerState, one_thread
from wirewear.stress.strength import material_points, stresses_of
from wirewear.test.any_study import AnyStudy, life_data
from wirewear.test.life import LifeTable
from wirewear.test.programme import BlockCourse, Schedule

#: The states of a body over a recorded cycle.
StatesAt = Callable[[int], Sequence[InnerState[Any]]]

_DEPTHS, _GROWTH = 11, 1.35  #: Depths below the surface at which damage is found, and growth of their spacing.
_FINER = 4  #: Depths from which averages are taken, for each at which damage is found.
_BESIDE = 4.0  #: Elements beside whatever touches that are looked at.
WEAR_STATES = 6  #: Wear states of a life at most, if not asked for more.


@dataclass(frozen=True, eq=False)
class LifeState:
    """Damage that one cycle does to a body in the wear state of `cycle`, in columns at the crossings of lines axial_mm
    (a,) and transverse_mm (t,), at d depths below the worn surface. share (a, t, d): decimal logarithms of the share of
    life it takes. normal (a, t, d, 3): of the critical planes. worn_mm (a, t): depth worn off.
    """

    cycle: int
    axial_mm: Array
    transverse_mm: Array
    share: Array
    normal: Array
    worn_mm: Array

    def onto(self, axial_mm: Array, transverse_mm: Array) -> tuple[Array, Array]:
        """(logarithms (c, d), worn depths (c,) in mm), interpolated to the c columns at the crossings of other lines;
        beyond its own lines as at their edge.
        """
        a, t = linear_weights(self.axial_mm, axial_mm), linear_weights(self.transverse_mm, transverse_mm)
        share, worn = (np.einsum("ai,tj,ij...->at...", a, t, own) for own in (self.share, self.worn_mm))
        return share.reshape(-1, share.shape[2]), worn.ravel()


def wear_state(
    states: Sequence[InnerState[Any]], criterion: LifeCriterion, table: LifeTable, depths_mm: Array, worn_mm: Array
) -> LifeState:
    """The damage per cycle of a body from its states over one recorded cycle; the nodes of its mesh stand in the worn
    surface. depths_mm (d,): depths below the worn surface at which damage is found. worn_mm (n_a, n_t): depth worn off
    at the nodes of the patch.
    """
    first = states[0]
    patch, mesh = first.body.patch, first.body.mesh
    plane = first.body.plane
    loaded = first.places_mm[first.loaded_nodes]
    reach = averaging_radius_mm(table, plane=plane)
    margin = reach + _BESIDE * patch.smallest_element
    rows, columns = (
        np.flatnonzero((lines >= loaded[:, k].min() - margin) & (lines <= loaded[:, k].max() + margin))
        for k, lines in enumerate((patch.axial_mm, patch.transverse_mm))
    )
    axial, transverse = patch.axial_mm[rows], patch.transverse_mm[columns]
    # Averages reach beside the patch, and stresses bend more over a spacing of depths than lives may.
    fine = np.interp(np.arange(_FINER * (_DEPTHS - 1) + 1) / _FINER, np.arange(_DEPTHS), depths_mm)
    ends = mesh.points.min(axis=0), mesh.points.max(axis=0)
    wide = [widened(lines, reach, *(end[k] for end in ends)) for k, lines in enumerate((axial, transverse))]
    grid = np.stack(np.meshgrid(*wide, indexing="ij"), axis=-1).reshape(-1, 2)
    below = patch.height(grid)[:, None] - fine
    places = np.concatenate([np.broadcast_to(grid[:, None], (*below.shape, 2)), below[..., None]], axis=2).reshape(
        -1, 3
    )
    taken = interpolation(mesh, places[:, [0, 2]] if plane else places)
    nodes = np.unique(taken.indices)
    kernel = kernel_of(table, plane=plane)
    mean = averaging((axial, transverse, depths_mm), (*wide, fine), kernel) @ taken[:, nodes]
    history = np.array([mean @ one for one in stresses_of(states, nodes)])
    damage = criterion.damage(history)
    shape = (len(axial), len(transverse), len(depths_mm))
    share, normal = damage.share.reshape(shape), damage.normal.reshape(*shape, 3)
    if not reach and not kernel(0.0)[0].any():
        share[..., 0], normal[..., 0, :] = _at_surface(states, criterion, patch.nodes[np.ix_(rows, columns)])
    return LifeState(
        first.forces.cycle,
        axial,
        transverse,
        np.log10(share, out=np.full(shape, FLOOR), where=share > 10.0**FLOOR),
        normal,
        worn_mm[np.ix_(rows, columns)],
    )


def _at_surface(states: Sequence[InnerState[Any]], criterion: LifeCriterion, nodes: IntArray) -> tuple[Array, Array]:
    """Share (a, t) of life per cycle and normals (a, t, 3) at nodes (a, t) of the patch, of stresses that are not
    averaged: each of the worst of the points nearest to it, where the contact ends among them.
    """
    points = material_points(states, nodes.ravel())
    damage = criterion.damage(points.history)
    order = np.argsort(damage.share, kind="stable")
    worst = np.empty(int(nodes.max()) + 1, dtype=np.int64)
    worst[points.node[order]] = order
    chosen = worst[nodes]
    return damage.share[chosen], damage.normal[chosen]


@dataclass(frozen=True, eq=False)
class BodyLife:
    """Life of a body until a crack begins in it. initiation: the crack; low, high: ends of the 95 % interval by the
    scatter of the data; each None if none begins. plane: True for a line contact.

    table: what was asked, with all data. states: wear states, in order; damage: its sums in columns on the lines of the
    last of them. course: the cycles of the run, and what would follow. to_world (3, 3): from the body's axes to the
    test's.
    """

    body: str
    table: LifeTable
    states: tuple[LifeState, ...]
    damage: Damage
    initiation: Initiation | None
    low: Initiation | None
    high: Initiation | None
    course: BlockCourse
    to_world: Array
    plane: bool

    @property
    def begun(self) -> Initiation | None:
        """Former name of `initiation`, None if no crack begins; warns with DeprecationWarning."""
        renamed("BodyLife.begun", "BodyLife.initiation")
        return self.initiation

    @property
    def called(self) -> str:
        return called(self.body)

    @property
    def averaged(self) -> bool:
        """True if stresses are averaged over a length; otherwise lives do not converge with the mesh."""
        return averaging_radius_mm(self.table, plane=self.plane) > 0.0

    @cached_property
    def columns_mm(self) -> Array:
        """Places (c, 2) of the columns along and across the body's axis, from its point of first contact."""
        last = self.states[-1]
        return np.stack(np.meshgrid(last.axial_mm, last.transverse_mm, indexing="ij"), axis=-1).reshape(-1, 2)

    @property
    def place_um(self) -> tuple[float, float]:
        """(x, y) in µm where the crack begins, in the test's axes from the body's point of first contact. Raises
        ResultError if none begins.
        """
        column = self.columns_mm[self._crack.column]
        x, y, _ = 1e3 * self.to_world @ np.append(column, 0.0)
        return float(x), float(y)

    @property
    def depth_um(self) -> float:
        """Depth in µm of the crack's place below the surface worn by then. Raises ResultError if none begins."""
        worn = float(self.damage.worn_mm(min(self._crack.cycles, self.damage.end))[self._crack.column])
        return 1e3 * max(float(self.damage.levels_mm[self._crack.level]) - worn, 0.0)

    @property
    def worn_um(self) -> float:
        """Depth in µm worn off above the crack's place until it begins. Raises ResultError if none begins."""
        return 1e3 * float(self.damage.worn_mm(min(self._crack.cycles, self.damage.end))[self._crack.column])

    @property
    def normal(self) -> Array:
        """Unit normal (3,), x component ≥ 0, of the plane on which the crack begins, in the test's axes; zero if the
        criterion has no planes. Raises ResultError if none begins.
        """
        crack, k = self._crack, int(np.abs(self.damage.depths_mm - 1e-3 * self.depth_um).argmin())
        cycle = min((one.cycle for one in self.states), key=lambda own: abs(np.log(own / max(crack.cycles, 1.0))))
        if crack.beyond:
            shares = [one.cycles * 10.0 ** one.rates.share[crack.column, k] for one in self.damage.ahead]
            cycle = self.damage.ahead[int(np.argmax(shares))].rates.cycle
        near = next(one for one in self.states if one.cycle == cycle)
        x, y = self.columns_mm[crack.column]
        i, j = (int(np.abs(lines - at).argmin()) for lines, at in ((near.axial_mm, x), (near.transverse_mm, y)))
        normal = self.to_world @ near.normal[i, j, k]
        return np.asarray(-normal if normal[0] < 0.0 else normal)

    @property
    def plane_angle_deg(self) -> float | None:
        """Angle, 0 to 90, between the crack's plane and the plane of contact; None if the criterion has no planes.
        Raises ResultError if no crack begins.
        """
        size = float(np.linalg.norm(self.normal))
        return float(np.degrees(np.arccos(np.clip(abs(self.normal[2]) / size, 0.0, 1.0)))) if size else None

    @property
    def _crack(self) -> Initiation:
        if self.initiation is None:
            raise ResultError(f"no crack begins in the {self.called}")
        return self.initiation

    @property
    def cycles(self) -> float:
        """Cycles until a crack begins; infinite where none does."""
        return np.inf if self.initiation is None else self.initiation.cycles

    @property
    def interval(self) -> tuple[float, float]:
        """(least, largest) number of cycles between which 95 % of lives lie, by the scatter of the data alone; infinite
        where no crack begins.
        """
        low, high = (np.inf if one is None else one.cycles for one in (self.low, self.high))
        return low, high

    @cached_property
    def growth(self) -> tuple[Array, Array]:
        """(cycles (n,), largest damage sum (n,) at points not yet worn off), after each step of the sum."""
        steps = [(now.cycle, float(self.damage.of_present(now).max())) for now in self.damage.course()]
        return np.array([cycle for cycle, _ in steps]), np.array([largest for _, largest in steps])


@one_thread()
def life_of(
    result: RunResult,
    body: str,
    table: LifeTable,
    states_at: StatesAt,
    schedule: Schedule[Any],
    *,
    wear_states: int = WEAR_STATES,
    watch: Callable[[int], None] = lambda _: None,
) -> BodyLife:
    """The life of a body from as many recorded cycles of its run as it needs.

    table: what is asked, with all data. states_at: gives the body's states over a recorded cycle. schedule: blocks of
    the test. wear_states: recorded cycles taken of each block, at most. watch: called with every cycle that is looked
    at. Raises ResultError if the run has recorded no contact forces of the body in one of its blocks; StudyError if
    data are lacking; GeometryError if wear distorts a mesh too much.
    """
    recorded = recorded_cycles(result, body)
    course = require_recorded(schedule, recorded, result.label)
    known: dict[int, LifeState] = {}
    depths, criterion, first = np.zeros(0), None, None
    # Of 95 % of a normal distribution.
    thresholds = 10.0 ** (1.96 * table.scatter * np.array([0.0, -1.0, 1.0]))
    left = _chosen(recorded, course, wear_states)
    found: BodyLife | None = None

    def until_ended() -> Iterator[int]:
        """Cycles in turn, until all lives have ended."""
        while left and (found is None or found.high is None or found.high.cycles >= left[0]):
            yield left.pop(0)

    def upcoming() -> Iterator[int]:
        """Cycles in turn until all lives have ended, with the recorded ones on either side of the life."""
        yield from until_ended()
        if found is not None and found.initiation is not None and not found.initiation.beyond:
            place = int(np.searchsorted(recorded, found.cycles))
            yield from [cycle for cycle in recorded[max(place - 1, 0) : place + 1] if cycle not in known]
        yield from until_ended()

    for cycle in upcoming():
        watch(cycle)
        states = states_at(cycle)
        if criterion is None or first is None:
            first, criterion = states[0], criterion_of(table, states[0].body.material)
            step = 0.5 * first.body.patch.smallest_element
            depths = step * (_GROWTH ** np.arange(_DEPTHS) - 1.0) / (_GROWTH - 1.0)
        # The depth (n_a, n_t) worn off a body by a recorded cycle on its patch, in its own axes, in mm.
        order = slice(None, None, -1 if result.is_upper(body) else 1)
        known[cycle] = wear_state(
            states, criterion, table, depths, np.maximum(1e-3 * result.scar(cycle, body).depth_um[:, order], 0.0)
        )
        if not all(course.among(known, one.block) for one in course.done if one.start < max(known)):
            continue
        ordered = tuple(known[one] for one in sorted(known))
        damage = _damage(result, body, ordered, depths, course, last=max(known) == recorded[-1])
        initiation, low, high = damage.initiations(thresholds.tolist())
        plane = first.body.plane
        found = BodyLife(body, table, ordered, damage, initiation, low, high, course, first.to_world, plane)
    if found is None:
        raise ResultError(f"{result.label}: no cycle of the {called(body)} is looked at")
    return found


def recorded_cycles(result: RunResult, body: str) -> list[int]:
    """Cycles at which a run has recorded contact forces on a body, increasing; empty if there are none."""
    return sorted({one.cycle for one in result.contact_forces if one.body == body})


def require_life(study: AnyStudy, bodies: Sequence[str], values: Mapping[str, object]) -> None:
    """Raise StudyError or ResultError if the run of a study would lack what the lives of `bodies` need.
    values: keys of [life] that are given in place of the study's.
    """
    life_data(study, bodies, values)
    cycles = (*study.log.loop_cycles, study.conditions.cycles) if study.log.contact_states else ()
    require_recorded(study.schedule, cycles, f"the study {study.name!r}")


def require_recorded(schedule: Schedule[Any], cycles: Sequence[int], where: str) -> BlockCourse:
    """The stages of a test that has recorded contact forces at `cycles`. Raises ResultError, which begins with `where`,
    if a block of it has none.
    """
    course = BlockCourse.of(schedule, max(cycles, default=schedule.cycles))
    silent = [
        course.names[block]
        for block in dict.fromkeys(one.block for one in course.done)
        if not course.among(cycles, block)
    ]
    if silent:
        of_blocks = f" of {' and '.join(silent)}" if schedule.blocks else ""
        raise ResultError(
            f"{where}: a life needs the contact forces of a recorded cycle{of_blocks}, and there are none: state "
            "loop_cycles and contact_states in [log], and run it again."
        )
    return course


def _chosen(recorded: Sequence[int], course: BlockCourse, count: int) -> list[int]:
    """At most `count` recorded cycles of each block: the first, the last, and others evenly by logarithms."""
    chosen: set[int] = set()
    for block in {one.block for one in course.done}:
        own = course.among(recorded, block)
        wanted = np.geomspace(own[-1], own[0], count) if len(own) > count else own
        chosen |= {own[int(np.abs(np.log(np.array(own) / at)).argmin())] for at in wanted}
    return sorted(chosen)


def _damage(
    result: RunResult, body: str, states: Sequence[LifeState], depths: Array, course: BlockCourse, *, last: bool
) -> Damage:
    """Damage in columns on the lines of the last state, up to its cycle, or to the end of the run and beyond."""
    lines = states[-1].axial_mm, states[-1].transverse_mm
    on = [one.onto(*lines) for one in states]
    rates = {one.cycle: Rates(one.cycle, share) for one, (share, _) in zip(states, on, strict=True)}
    # Of a block's later turns only the last may be recorded: the nearest turn stands for the others.
    of_block = {one.block: [rates[c] for c in course.among(rates, one.block)] for one in course.done}
    end = course.end if last else float(states[-1].cycle)
    spans = []
    for stage in course.done:
        if stage.start >= end:
            break
        inside = [one for one in of_block[stage.block] if one.cycle in stage]
        nearest = min(of_block[stage.block], key=lambda one: abs(one.cycle - stage.end))
        spans.append(Span(stage.start, min(stage.end, end), tuple(inside or [nearest])))
    cycles = np.array([0.0, *(one.cycle for one in states)])
    worn = np.array([np.zeros(len(on[0][1])), *(depth for _, depth in on)])
    evolution, deepest = result.evolution["cycle"], result.evolution[f"max_depth_{body}_um"]

    def worn_mm(cycle: float) -> Array:
        """Worn depths at a cycle: between two states they grow as the scar's largest depth does."""
        later = int(np.clip(np.searchsorted(cycles, cycle), 1, len(cycles) - 1))
        before, after = cycles[later - 1], cycles[later]
        low, here, high = np.interp([before, min(cycle, after), after], [0.0, *evolution], [0.0, *deepest])
        part = (here - low) / (high - low) if high > low else (min(cycle, after) - before) / (after - before)
        return np.asarray(worn[later - 1] + part * (worn[later] - worn[later - 1]))

    def speed_mm(block: int) -> Array:
        """Worn depths per cycle of a block: their mean over the last tenth of its latest turn, or over all of that if
        it is shorter.
        """
        stage = course.latest(block)
        first, final = max(stage.start, 0.9 * stage.end), min(stage.end, end)
        return (worn_mm(final) - worn_mm(first)) / (final - first)

    # Up to a state before the last one, what follows is not asked.
    following = course.ahead if last else ()
    ahead = [Ahead(one.end - one.start, of_block[one.block][-1], speed_mm(one.block)) for one in following]
    return Damage(depths, spans, worn_mm, ahead)
