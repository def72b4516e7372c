"""Two bodies that wear as one slides over the other: gaps on a grid, sweeps of a stroke, and what they remove.

The near body is curved along the motion (the fixed wire, the pad), the far one straight (the moving wire, the flat). A
jump of many cycles is one sweep with the wear of all of them, implicit at each position: what is worn away there adds
to the local compliance, so that no jump is unstable. Energy wear after Fouvry et al., Wear 255 (2003) 287. mm, N, MPa.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from wirewear.base.errors import RunError

Array = NDArray[np.float64]

#: Positions of a stroke at which a loop's forces are computed, closer to its ends, and fewest and most of a sweep.
POSITIONS, SWEPT = 13, (7, 15)
GOLDEN = 0.6180339887  #: Uneven part of successive sweeps' positions: the golden ratio's.
#: Shares of the load for which a stick zone's approach is computed.
SHARES = np.array([0.02, 0.1, 0.25, 0.45, 0.7, 1.0])


class Elastic(Protocol):
    """Elastic bodies under a normal load."""

    def press(self, gap_mm: Array, load_N: float, local: Array | float) -> tuple[Array, float]:
        """Pressures (n_x, n_y) [MPa] and approach [mm]; `local` is a further compliance in place [mm/MPa]."""
        ...


@dataclass(frozen=True)
class Layer:
    """What lies between the bodies: debris fills a share of what is worn; the rest gives way by itself [mm/MPa]."""

    filled: float = 0.0
    bed_modulus_MPa: float = np.inf
    rough_mm: float = 0.0


#: Pressure at which asperities close by ln 2 of their height, and how much more easily layers shear than they close.
ASPERITY_MPa, ROUGH_SHEAR, BED_SHEAR = 100.0, 1.21, 0.286


@dataclass(frozen=True, eq=False)
class Touch:
    """The contact along a stroke: slopes' forces and approaches (n,) at places [mm], and means of it."""

    place_mm: Array
    slope_N: Array
    approach_mm: float
    area_mm2: float
    shear_mm_per_N: float


class Pair:
    """Both bodies' shapes and worn depths; `sign` is +1 where the far body is the driven one, else −1."""

    def __init__(self, shape_mm: Array, steps_mm: tuple[float, float], reach_mm: float, sign: int, bodies: Elastic):
        """Nothing is worn yet."""
        self.shape, (self.dx, self.dy), self.sign, self.bodies = shape_mm, steps_mm, sign, bodies
        self.reach = int(np.ceil(reach_mm / self.dx)) + 2
        self.near = np.zeros_like(shape_mm)
        self.far = np.zeros((shape_mm.shape[0] + 2 * self.reach, shape_mm.shape[1]))
        self.sweeps = 0
        self.half_length_mm = self.approach_mm = 0.0
        self.area_mm2 = 4.0 * self.cell_mm2

    @property
    def cell_mm2(self) -> float:
        return self.dx * self.dy

    def flatten(self, approach_mm: float, half_slip_mm: float) -> None:
        """Press both bodies into one another before any wear, half of the overlap each, all along the stroke."""
        self.near += 0.5 * np.maximum(approach_mm - self.shape, 0.0)
        for place in np.linspace(-half_slip_mm, half_slip_mm, 41):
            here = self._rows(place)[0]
            overlap = 0.5 * np.maximum(approach_mm - self.shape, 0.0)
            self.far[here] = np.maximum(self.far[here], overlap)

    def touch(self, load_N: float, half_slip_mm: float, layer: Layer) -> Touch:
        """The contact at places of a stroke as it is worn now."""
        places = half_slip_mm * np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, POSITIONS))
        slopes, approaches, areas, sheared = [], [], [], []
        rise = np.gradient(self.far, self.dx, axis=0)
        for place in places:
            pressure, self.approach_mm = self.bodies.press(*self._problem(place, load_N, layer))
            here = self._moved(rise, place) * (1.0 - layer.filled)
            slopes.append(self.sign * float((pressure * here).sum()) * self.cell_mm2)
            self._measure(pressure > 1e-3 * pressure.max())
            approaches.append(self.approach_mm)
            areas.append(self.area_mm2)
            sheared.append(float((self._shear(place, pressure, layer) * pressure).sum()) * self.cell_mm2 / load_N)
        area = float(np.mean(areas))
        return Touch(places, np.array(slopes), float(np.mean(approaches)), area, float(np.mean(sheared)) / area)

    def sweep(self, load_N: float, half_slip_mm: float, depth_per_MPa: float, share: float, layer: Layer) -> None:
        """Wear along one stroke: `depth_per_MPa` is that of both bodies under a pressure that stays, `share` the far's.

        It is spread over the places of the sweep.
        """
        fewest, most = SWEPT
        wanted = 2.0 * half_slip_mm / max(0.7 * self.half_length_mm, self.dx)
        count = int(np.clip(np.ceil(wanted), fewest, most))
        self.sweeps += 1
        offset = (GOLDEN * self.sweeps) % 1.0
        places = half_slip_mm * (2.0 * (np.arange(count) + offset) / count - 1.0)
        for place in places if self.sweeps % 2 else places[::-1]:
            gap, load, local = self._problem(place, load_N, layer)
            worn = depth_per_MPa / count * self.spread()
            pressure, self.approach_mm = self.bodies.press(gap, load, local + (1.0 - layer.filled) * worn)
            self._measure(pressure > 0.0)
            self._wear(worn * pressure, *self._rows(place), share)
        # Bodies that are alike about their middle stay so, in whichever order the places came.
        for field in self._fields:
            field[:] = 0.5 * (field + field[::-1, ::-1])

    def spread(self) -> Array | float:
        """How wear by a pressure is spread in place; evenly unless a simulator says otherwise."""
        return 1.0

    def under(self, way_mm: Array, friction: float, load_N: Array) -> Array:  # noqa: ARG002
        """Friction over its limit of the moment along a stroke, under loads (n,) that vary; few pairs know it."""
        raise RunError("this simulator follows no load that varies in the cycle.")

    @property
    def scars_mm(self) -> tuple[Array, Array]:
        """Worn depths of the near and of the far body, over their own lines."""
        return self.near, self.far

    @property
    def _fields(self) -> tuple[Array, ...]:
        return self.near, self.far

    def _wear(self, depth: Array, rows: slice, weight: float, share: float) -> None:
        """Nothing is worn yet."""
        self.near += (1.0 - share) * depth
        self.far[rows] += (1.0 - weight) * share * depth
        self.far[rows.start + 1 : rows.stop + 1] += weight * share * depth

    def _measure(self, touching: NDArray[np.bool_]) -> None:
        self.half_length_mm = 0.5 * self.dx * float(touching.any(axis=1).sum())
        self.area_mm2 = max(self._area(touching), self.cell_mm2)

    def _area(self, touching: NDArray[np.bool_]) -> float:
        return self.cell_mm2 * float(touching.sum())

    def _problem(self, place: float, load_N: float, layer: Layer) -> tuple[Array, float, Array]:
        """Gap, load and compliance in place."""
        worn = self.near + self._moved(self.far, place)
        bed = layer.filled * worn / layer.bed_modulus_MPa
        local = (bed + layer.rough_mm / (ASPERITY_MPa + load_N / self.area_mm2)) * self.spread()
        return self.shape + (1.0 - layer.filled) * worn, load_N, local

    def _shear(self, place: float, pressure: Array, layer: Layer) -> Array:
        """Shear compliance of the layers in place [mm/MPa]."""
        bed = layer.filled * (self.near + self._moved(self.far, place)) / (BED_SHEAR * layer.bed_modulus_MPa)
        return np.asarray(bed + ROUGH_SHEAR * layer.rough_mm / (ASPERITY_MPa + pressure * self.spread()))

    def _rows(self, place: float) -> tuple[slice, float]:
        """Rows of the far body that face the near one, and the weight of those one further on."""
        at = self.reach - self.sign * place / self.dx
        first = int(np.floor(at))
        return slice(first, first + self.shape.shape[0]), at - first

    def _moved(self, field: Array, place: float) -> Array:
        rows, weight = self._rows(place)
        return np.asarray((1.0 - weight) * field[rows] + weight * field[rows.start + 1 : rows.stop + 1])


class StickingPair(Pair):
    """Bodies in partial slip by superposition of normal solutions: a stick zone gives way as a smaller load's contact.

    Cattaneo (1938), Mindlin (1949); contacts of any shape: Jäger, Arch. Appl. Mech. 65 (1995) 478, and Ciavarella, Int.
    J. Solids Struct. 35 (1998) 2349. `sheared` are the bodies as tractions move them, `easier` times as far.
    """

    sheared: Elastic
    easier = 1.0
    shares = SHARES
    curve = (np.array([0.0, 1.0]), np.array([0.0, 1.0]))

    def settle(self, load_N: float, layer: Layer) -> None:
        """Trace the displacement over the friction's coefficient, and the share of the limit, up to full slip."""
        gap, _, local = self._problem(0.0, load_N, layer)
        approaches = [self.sheared.press(gap, share * load_N, local)[1] for share in self.shares[::-1]]
        given = self.easier * (approaches[0] - np.r_[approaches, gap.min()])
        self.curve = given, 1.0 - np.r_[self.shares[::-1], 0.0]

    def lag_mm(self, friction: float, load_N: float) -> float:  # noqa: ARG002 - settled at this load
        """Displacement at which everything slips."""
        return float(friction * self.curve[0][-1])

    def stroke(self, way_mm: Array, half_mm: float, friction: float, load_N: float) -> Array:  # noqa: ARG002
        """Friction over its limit along a stroke that begins at a reversal (Masing's rule)."""
        given, share = friction * self.curve[0], self.curve[1]
        return np.asarray(2.0 * np.interp(0.5 * way_mm, given, share) - np.interp(half_mm, given, share))
