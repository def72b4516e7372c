"""Two bodies of metal that flows, pressed together and slid to and fro on each other.

Each is a half-space beneath its round surface, with its z axis out of it; x is the motion and y across for both. All of
the contact slides: friction is in proportion to pressure, up to the yield stress in shear of the softer metal.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import sqrt

import numpy as np

from geometry.arrays import Array
from solvers.errors import NotConvergedError
from solvers.stress.plastic_zone import PRESSING_TOLERANCE, Flowed, PlasticZone, loaded_together
from solvers.stress.pressing import Indenter

_TWICE = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
_TOLERANCE = 1e-2  #: Of plastic strain over a step of sliding, in the place of a pressing's.
_FINER = 5e-3  #: Of the contact's accuracy, over the tolerance of plastic strain.


@dataclass(frozen=True)
class FlowOfCycle:
    """The largest plastic strain that a cycle goes through at any point of both bodies beneath their skin, and of it
    what is left; skin: the largest in it.

    The skin is the outermost layer: friction as strong as the metal shears it by the more the thinner it is.
    """

    through: float
    left: float
    skin: float


@dataclass(frozen=True)
class EnergyBook:
    """Work of load and drive on fresh bodies so far, and what became of it, mJ."""

    work: float = 0.0
    friction: float = 0.0  #: Friction times slip, of which displacements of the surfaces are part.
    plastic: float = 0.0
    stored: float = 0.0  #: Elastic, by tractions and by the stresses that plastic strain leaves.

    @property
    def missing(self) -> float:
        """What the book lacks over all that is plastic or stored; friction, mostly much more, would hide it."""
        kept = self.plastic + self.stored
        return abs(self.work - self.friction - kept) / kept if kept else 0.0


@dataclass(frozen=True)
class Rubbed:
    """The upper and the lower body pressed, and unloaded after cycles of sliding, with the plastic work done by then.

    endless: whether the metal flowed without end in the next cycle. book: of all before they are unloaded.
    """

    pressed: tuple[Flowed, ...]
    unloaded: tuple[Flowed, ...]
    cycles: tuple[FlowOfCycle, ...]
    work_mJ: float
    pressed_mJ: float
    endless: bool
    book: EnergyBook


@dataclass(frozen=True, eq=False)
class _Touching:
    """Both bodies at the end of a step: the lower one's place in cells, gap (n_x, n_y) of the unworn surfaces there,
    their approach, their states, and how far friction shears either surface along x, (n_x, n_y).
    """

    place: int
    gap_mm: Array
    approach_mm: float
    states: tuple[Flowed, ...]
    sheared_mm: Sequence[Array]

    def opened(self, place: int, gap_mm: Array) -> Array:
        """The gap with the lower body and its print at a place; gap_mm: of unworn surfaces there."""
        return np.asarray(gap_mm - shifted(self.states[1].residual_mm[..., 2], place))


@dataclass
class Rubbing:
    """The upper and the lower body while they are pressed and slid; pairs are in this order.

    zones: metal that may yield, on equal grids. curvatures_per_mm: (2, 2) matrices of the unworn surfaces' curvatures.
    modulus_MPa: contact modulus E* of the pair. friction: coefficient. states: plastic strain, stress and tractions of
    each zone so far. book: energies so far.
    """

    zones: tuple[PlasticZone, PlasticZone]
    curvatures_per_mm: tuple[Array, Array]
    modulus_MPa: float
    friction: float
    states: tuple[Flowed, ...] = field(init=False)
    book: EnergyBook = field(init=False, default=EnergyBook())
    _touching: _Touching = field(init=False)
    _pressure: Array = field(init=False)
    #: Of the last step: gap, place, direction and the plastic strain of both bodies in it.
    _last: tuple[Array, int, float, list[Array]] = field(init=False)
    #: By place and direction: how often it was reached, and the plastic strain of both bodies in the last such step.
    _reached: dict[tuple[int, float], tuple[int, list[Array]]] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self.states = tuple(zone.fresh for zone in self.zones)
        self._pressure = np.ones(self.zones[0].space.shape)
        self._last = (self._pressure, 0, 0.0, [])
        still = np.zeros_like(self._pressure)
        self._touching = _Touching(0, self._gap(0), 0.0, self.states, (still, still))

    def rubbed(self, loads_N: Array, stroke: int, step: int, most: int) -> Rubbed:
        """Press under rising loads (k,), slide by up to `most` cycles of ± `stroke` cells, unload.

        Steps are of `step` cells, in cycles after the first, which change little, of twice as many. Cycles end when the
        metal beneath its skin flows no more, or alike in each. Raises NotConvergedError if pressing has no end.
        """
        for load in loads_N.tolist():
            self._step(load, 0, 0.0)
        pressed, first, load = self.states, self.book.plastic, float(loads_N[-1])
        cycles, endless = list[FlowOfCycle](), False
        out = [min(place, stroke) for place in range(step, stroke + step, step)]
        try:
            for place in out if most else ():
                self._step(load, place, 1.0)
            while len(cycles) < most and not self._repeats(cycles):
                before, half = self.states, out if not cycles else [*out[1:-1:2], stroke]
                back = [*(stroke - place for place in half), *(-place for place in half)]
                for place in back:
                    self._step(load, place, -1.0)
                for place in back:
                    self._step(load, -place, 1.0)
                cycles.append(self._flow_since(before))
        except NotConvergedError:
            endless = True
        nothing = np.zeros((*self._pressure.shape, 3))
        unloaded = loaded_together(self.zones, lambda _: (nothing, nothing), self.states, _TOLERANCE)
        return Rubbed(pressed, unloaded, tuple(cycles), self.book.plastic, first, endless, self.book)

    def _step(self, load_N: float, place: int, direction: float) -> None:
        """Move the lower body to `place` cells along x under a load; direction: of its motion."""
        zones, cell = self.zones, float(np.prod(self.zones[0].space.step_mm))
        gap, approach = self._gap(place), 0.0
        # Where they touch first nothing is left between them.
        indenter = Indenter(gap - gap.min(), zones[0].space.step_mm, self.modulus_MPa)
        borne = min(zone.metal.yield_stress_MPa for zone in zones) / sqrt(3.0)
        before, tolerance = self.states, _TOLERANCE if direction else PRESSING_TOLERANCE

        def tractions(left: Sequence[Array]) -> tuple[Array, Array]:
            nonlocal approach
            opened = -left[0][..., 2] - shifted(left[1][..., 2], place)
            self._pressure, approach = indenter.carried(load_N, opened, self._pressure, _FINER * tolerance)
            push = np.zeros((*self._pressure.shape, 3))
            push[..., 0] = direction * np.minimum(self.friction * self._pressure, borne)
            push[..., 2] = -self._pressure
            return push, shifted(push * np.array([-1.0, 1.0, 1.0]), -place)

        times, steps = self._reached.get((place, direction), (0, []))
        # Fresh metal yields more than it ever does again: only cycles after the first resemble each other.
        if times <= 1:
            steps = self._followed(indenter.gap_mm, place, direction)
        guess = [old.flow.strain + own for old, own in zip(before, steps, strict=True)] if steps else None
        self.states = loaded_together(zones, tractions, before, tolerance, guess)
        grown = [new.flow.strain - old.flow.strain for old, new in zip(before, self.states, strict=True)]
        self._reached[place, direction] = times + 1, grown
        self._last = (indenter.gap_mm, place, direction, grown)
        unstrained, along = np.zeros((1, 1, 3), dtype=complex), np.array([1.0, 0.0, 0.0])
        sheared = [
            zone.space.displacements(unstrained, state.traction_MPa * along)[..., 0]
            for zone, state in zip(zones, self.states, strict=True)
        ]
        # But for what the mean traction does to a half-space without end.
        sheared = [own - own.mean() for own in sheared]
        self._write(_Touching(place, gap, approach + float(gap.min()), self.states, sheared), indenter, cell, grown)

    def _write(self, new: _Touching, indenter: Indenter, cell_mm2: float, grown: Sequence[Array]) -> None:
        """Add a step to the book. grown: (k, 6) plastic strain of each body in it."""
        old, self._touching = self._touching, new
        ends, book = (old, new), self.book
        pressures = [-end.states[0].traction_MPa[..., 2] for end in ends]
        pushed = [float(end.states[0].traction_MPa[..., 0].sum()) for end in ends]
        away = (new.place - old.place) * indenter.step_mm[0]
        # Pressures of either end are drawn over the surfaces of the other.
        drawn = sum(
            float((pressure * (end.opened(new.place, new.gap_mm) - end.opened(old.place, old.gap_mm))).sum())
            for pressure, end in zip(pressures, ends[::-1], strict=True)
        )
        lowered = sum(float(pressure.sum()) for pressure in pressures) * (new.approach_mm - old.approach_mm)
        dragged, sheared, plastic = sum(pushed) * away, 0.0, 0.0
        stored = float((pressures[1] * indenter.displacement(pressures[1])).sum())
        for k, zone in enumerate(self.zones):
            before, after = old.states[k], new.states[k]
            moved = [end.sheared_mm[k] + end.states[k].residual_mm[..., 0] for end in ends]
            along = before.traction_MPa[..., 0] + after.traction_MPa[..., 0]
            sheared += float((along * (moved[1] - moved[0])).sum())
            volumes = np.repeat(zone.space.layers_mm, new.gap_mm.size)
            # The mean stress of a step does what its tractions and what is stored leave.
            stress = (before.stress + after.stress).reshape(-1, 6)
            plastic += float((stress * grown[k]) @ _TWICE @ volumes)
            stored += float((after.traction_MPa[..., 0] * new.sheared_mm[k]).sum())
            stored += float((after.traction_MPa * after.residual_mm).sum())
            stored -= float((after.stress.reshape(-1, 6) * after.flow.strain) @ _TWICE @ volumes)
        half = 0.5 * cell_mm2
        self.book = EnergyBook(
            book.work + half * (lowered - drawn + dragged),
            book.friction + half * (dragged - sheared),
            book.plastic + half * plastic,
            half * stored,
        )

    def _followed(self, gap_mm: Array, place: int, direction: float) -> list[Array]:
        """What plastic strains (k, 6) of the last step become if they go with the contact; none if it turned."""
        gap, at, way, grown = self._last
        if not direction or way != direction:
            return []
        moved = int(gap_mm.min(axis=1).argmin()) - int(gap.min(axis=1).argmin())
        return [
            shifted(own.reshape(-1, *gap_mm.shape, 6).swapaxes(0, 1), cells).swapaxes(0, 1).reshape(-1, 6)
            for own, cells in zip(grown, (moved, moved - (place - at)), strict=True)
        ]

    def _gap(self, place: int) -> Array:
        """Gap (n_x, n_y) in mm with the lower body at `place` cells, on the upper one's grid."""
        space = self.zones[0].space
        at = np.stack(np.meshgrid(*space.axes_mm(), indexing="ij"), axis=-1)
        away = at - np.array([place * space.step_mm[0], 0.0])
        upper, lower = self.curvatures_per_mm
        gap = 0.5 * (np.einsum("xyi,ij,xyj->xy", at, upper, at) + np.einsum("xyi,ij,xyj->xy", away, lower, away))
        return np.asarray(gap)

    def _flow_since(self, before: Sequence[Flowed]) -> FlowOfCycle:
        through, left, outermost, skin = 0.0, 0.0, 0.0, self._pressure.size
        for zone, old, new in zip(self.zones, before, self.states, strict=True):
            own = new.flow.accumulated - old.flow.accumulated
            # Plastic strain of a cycle, over the elastic one at yield, below which metal has shaken down.
            own[own * 2.0 * zone.space.material.shear_modulus_MPa <= 0.02 * zone.metal.yield_stress_MPa] = 0.0
            outermost = max(outermost, float(own[:skin].max()))
            if own[skin:].any():
                change = (new.flow.strain - old.flow.strain)[skin:] ** 2 @ _TWICE
                through, left = max(through, float(own[skin:].max())), max(left, sqrt(float(change.max()) / 1.5))
        return FlowOfCycle(through, left, outermost)

    @staticmethod
    def _repeats(cycles: Sequence[FlowOfCycle]) -> bool:
        """True if the last cycle did not flow beneath the skin, or as much as the one before."""
        if not cycles or cycles[-1].through == 0.0:
            return bool(cycles)
        if len(cycles) < 2:
            return False
        before, last = cycles[-2:]
        # Change of a cycle's strains from those of the cycle before, over its own, below which cycles repeat.
        return max(abs(last.through - before.through), abs(last.left - before.left)) < 0.05 * last.through


def shifted(field: Array, cells: int) -> Array:
    """A field (n_x, ...) moved by `cells` along its first axis, zero where it came from."""
    moved = np.zeros_like(field)
    if cells >= 0:
        moved[cells:] = field[: len(field) - cells]
    else:
        moved[:cells] = field[-cells:]
    return moved
