"""Registration of measured scars: the shift and rotation by which they fit the simulated scars best."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import least_squares

from geometry.arrays import Array
from wirewear.base.errors import ResultError
from wirewear.records import AnyRecord, MeasuredProfile, MeasuredScar
from wirewear.results import RunResult, Scar
from wirewear.results.scar import called

#: Rotations from which the search starts: a scar is much the same after half a turn.
STARTS_deg = np.arange(-75.0, 91.0, 15.0)

#: Change of depth within the scar (root mean square, as a share of the deepest point) that interpolation alone may make
#: when a scar is turned by `TURN_deg`; a scar ends where it is less deep than the share `EDGE` of the deepest point.
ROUND, TURN_deg, EDGE = 0.005, 10.0, 0.02


@dataclass(frozen=True)
class Registration:
    """Position of the measured scar in the frame of the simulated one, each number with its standard deviation.

    A point (x, y) of the simulated frame is found in the measured map by turning it by `rotation_deg` about the origin
    and then shifting it by (shift_x_um, shift_y_um). rotation_held: True for a scar too round to show a rotation, and
    for profiles; the rotation is then 0.
    """

    shift_x_um: float
    shift_y_um: float
    rotation_deg: float
    shift_x_deviation_um: float
    shift_y_deviation_um: float
    rotation_deviation_deg: float
    rotation_held: bool

    def measured_point(self, x_um: Array, y_um: Array) -> tuple[Array, Array]:
        """Coordinates x and y (...) in µm in the measured map of points (...) given in the simulated frame."""
        cosine, sine = np.cos(np.radians(self.rotation_deg)), np.sin(np.radians(self.rotation_deg))
        return x_um * cosine - y_um * sine + self.shift_x_um, x_um * sine + y_um * cosine + self.shift_y_um

    def simulated_point(self, x_um: Array, y_um: Array) -> tuple[Array, Array]:
        """Coordinates x and y (...) in µm in the simulated frame of points (...) given in the measured map."""
        cosine, sine = np.cos(np.radians(self.rotation_deg)), np.sin(np.radians(self.rotation_deg))
        x, y = x_um - self.shift_x_um, y_um - self.shift_y_um
        return x * cosine + y * sine, y * cosine - x * sine


def register(measured: MeasuredScar | MeasuredProfile, simulated: Scar) -> Registration:
    """Least-squares registration of a measured map of depths, or a profile along x only, to the simulated scar.

    The search starts from the maps as they are, from coinciding centroids and from several rotations; the best result
    is taken. Missing depths do not count.
    """
    lines_x, lines_y, field = measured.field
    x, y = (grid.ravel() for grid in np.meshgrid(lines_x, lines_y, indexing="ij"))
    depth = field.ravel()
    known = np.isfinite(depth)
    x, y, depth = x[known], y[known], depth[known]
    start = _centroid(x, y, depth) - _centroid(x, y, simulated.depth_at(x, y))
    held = _fit(simulated, (x, y, depth), start, 2 if lines_y.size > 1 else 1)
    if lines_y.size == 1 or _is_round(simulated, x, y):
        return held
    turned = _fit(simulated, (x, y, depth), start, 3)
    # The deviation of a rotation from which on a scar is too round to have one.
    return held if turned.rotation_deviation_deg > 4.0 else turned


def onto_simulated(
    measured: MeasuredScar | MeasuredProfile, registration: Registration, x_um: Array, y_um: Array
) -> Array:
    """Measured depths (n_x, n_y) in µm at grid lines x (n_x,) and y (n_y,) of the simulated frame; NaN outside the
    map.
    """
    lines_x, lines_y, field = measured.field
    at = registration.measured_point(*np.meshgrid(x_um, y_um, indexing="ij"))
    if lines_y.size == 1:
        return np.interp(at[0], lines_x, field[:, 0], left=np.nan, right=np.nan)
    depth: Array = RegularGridInterpolator((lines_x, lines_y), field, bounds_error=False, fill_value=np.nan)(at)
    return depth


def _is_round(simulated: Scar, x: Array, y: Array) -> bool:
    """True if a turn by TURN_deg hardly changes the simulated depth (rms below ROUND of the deepest point)."""
    cosine, sine = np.cos(np.radians(TURN_deg)), np.sin(np.radians(TURN_deg))
    depth = simulated.depth_at(x, y)
    change = (simulated.depth_at(x * cosine + y * sine, y * cosine - x * sine) - depth)[depth > EDGE * depth.max()]
    return not change.size or bool(np.sqrt(np.mean(change**2)) < ROUND * max(simulated.max_depth_um, 1e-12))


def _centroid(x: Array, y: Array, depth: Array) -> Array:
    # Squared depth lets the scar outweigh the noise of the unworn surface around it.
    weight = np.maximum(depth, 0.0) ** 2
    total = float(weight.sum())
    return np.array([weight @ x, weight @ y]) / total if total > 0.0 else np.zeros(2)


def _fit(simulated: Scar, points: tuple[Array, Array, Array], start: Array, freedoms: int) -> Registration:
    """Best fit with `freedoms` free parameters: shift along x, then along y, then the rotation."""
    x, y, depth = points
    deepest = max(float(np.max(np.abs(depth))), 1e-12)
    scale = np.array([10.0, 10.0, 0.1])[:freedoms]

    def all_three(scaled: Array) -> Array:
        return np.append(scale * scaled, np.zeros(3 - freedoms))

    def residuals(scaled: Array) -> Array:
        shift_x, shift_y, angle = all_three(scaled)
        cosine, sine = np.cos(angle), np.sin(angle)
        from_x, from_y = x - shift_x, y - shift_y
        expected = simulated.depth_at(from_x * cosine + from_y * sine, from_y * cosine - from_x * sine)
        return (expected - depth) / deepest

    starts = [np.zeros(freedoms), np.append(start, 0.0)[:freedoms] / scale]
    if freedoms == 3:
        turns = [np.append(start, np.radians(angle)) / scale for angle in STARTS_deg]
        starts.append(min(turns, key=lambda one: float(np.sum(residuals(one) ** 2))))
    fits = [least_squares(residuals, one, diff_step=1e-3) for one in starts]
    best = min(fits, key=lambda fit: float(fit.cost))
    variance = 2.0 * best.cost / max(x.size - freedoms, 1)
    covariance = variance * np.linalg.pinv(best.jac.T @ best.jac)
    values, deviations = all_three(best.x), all_three(np.sqrt(np.diag(covariance)))
    return Registration(
        shift_x_um=float(values[0]),
        shift_y_um=float(values[1]),
        rotation_deg=float(np.degrees(values[2])),
        shift_x_deviation_um=float(deviations[0]),
        shift_y_deviation_um=float(deviations[1]),
        rotation_deviation_deg=float(np.degrees(deviations[2])),
        rotation_held=freedoms < 3,
    )


@dataclass(frozen=True, eq=False)
class ScarPair:
    """Simulated and measured scar of one body at the end of the test, in the simulated frame, over x_um (n_x,) and y_um
    (n_y,); a line contact has one line y.

    repeats, registrations: of each measured scar. simulated: (n_x, n_y) depths in µm. measured: (repeats, n_x, n_y)
    depths in µm, NaN outside a map. *_volumes_mm3: of each measured map, and of the simulated scar at that map's
    points. spans_um: by name of a length, simulated and measured values in µm, each (repeats,).
    """

    wire: str
    simulated_cycle: int
    repeats: tuple[int, ...]
    registrations: tuple[Registration, ...]
    x_um: Array
    y_um: Array
    simulated: Array
    measured: Array
    simulated_volumes_mm3: tuple[float, ...]
    measured_volumes_mm3: tuple[float, ...]
    spans_um: dict[str, tuple[Array, Array]]

    @property
    def name(self) -> str:
        return called(self.wire)

    @property
    def is_map(self) -> bool:
        return self.y_um.size > 1

    @property
    def mean(self) -> Array:
        """Mean measured depth of the repeats in µm (n_x, n_y); NaN where no repeat has a point."""
        with warnings.catch_warnings():
            # Points that no map covers are meant to stay NaN.
            warnings.simplefilter("ignore", RuntimeWarning)
            mean: Array = np.nanmean(self.measured, axis=0)
        return mean

    def section_along(self, depth: Array) -> Array:
        """Depths (n_x,) of a map (n_x, n_y) on the grid line nearest to y = 0."""
        section: Array = depth[:, int(np.argmin(np.abs(self.y_um)))]
        return section

    def section_across(self, depth: Array) -> Array:
        """Depths (n_y,) of a map (n_x, n_y) on the grid line nearest to x = 0."""
        section: Array = depth[int(np.argmin(np.abs(self.x_um)))]
        return section


def scar_pairs(result: RunResult, record: AnyRecord) -> tuple[tuple[ScarPair, ...], tuple[str, ...]]:
    """Pairs of the simulated and the measured scars of each body that has both at the end, and sentences on what was
    left out.
    """
    pairs, notes = [], []
    length_mm, worn = record.tables.length_mm, record.tables.worn.name
    for body in record.tables.body_names:
        measured = [scar for scar in record.scars_of(body) if np.isfinite(scar.depth_um).any()]
        if not measured:
            notes.append(f"the record has no {worn} of the {called(body)}")
            continue
        try:
            simulated = result.scar(record.tables.conditions.cycles, body)
        except ResultError:
            notes.append(f"the result has no {worn} of the {called(body)} at the end of the test")
            continue
        registrations = [register(scar, simulated) for scar in measured]
        # The map with most points sets the grid; what other maps lack there is missing.
        x, y, _ = max(measured, key=lambda scar: int(scar.depth_um.size)).field
        maps = [onto_simulated(scar, own, x, y) for scar, own in zip(measured, registrations, strict=True)]
        # A map that misses a part misses it of both.
        seen = [_seen_by(scar, own, simulated) for scar, own in zip(measured, registrations, strict=True)]
        pairs.append(
            ScarPair(
                wire=body,
                simulated_cycle=simulated.cycle,
                repeats=tuple(scar.repeat for scar in measured),
                registrations=tuple(registrations),
                x_um=x,
                y_um=y,
                simulated=simulated.sampled(x, y),
                measured=np.stack(maps),
                simulated_volumes_mm3=tuple(one.volume_of(length_mm) for one in seen),
                measured_volumes_mm3=tuple(one.volume_of(length_mm) for one in measured),
                spans_um={name: (_spans(seen, name), _spans(measured, name)) for name in measured[0].spans_um},
            )
        )
    return tuple(pairs), tuple(notes)


def _spans(surfaces: Sequence[MeasuredScar | MeasuredProfile], name: str) -> Array:
    return np.array([one.spans_um[name] for one in surfaces])


def _seen_by(
    measured: MeasuredScar | MeasuredProfile, registration: Registration, simulated: Scar
) -> MeasuredScar | MeasuredProfile:
    """Simulated scar sampled at the points of a measured map."""
    x, y, _ = measured.field
    at = registration.simulated_point(*np.meshgrid(x, y, indexing="ij"))
    return measured.of_field(simulated.depth_at(*at))
