"""Fit of the unworn surface under a map or profile of heights.

Wear only removes material. The unworn surface is therefore one on which part of the map lies within its noise, some of
it at the border, and above which little stands (piled-up material). Surfaces through a few random points are rated by
that, and the best is fitted to all points that are neither worn nor piled up. A form is a deviation of the body's
unworn shape from the stated one; a surface's parameters give its position and then its form (`unworn_bodies`).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt, uniform_filter

from geometry.arrays import Array, BoolArray
from wirewear.loops.robust import biweight, median_deviation
from wirewear.records.spikes import FINEST_um, noise_um
from wirewear.records.surface_search import block_medians, sought
from wirewear.records.unworn_bodies import Surface, jacobian

FAR, FARTHER = 3.0, 4.0  #: Noise of unworn points, and of their means, hardly exceeds so many deviations.


MOST_POINTS = 20_000  #: Points that a surface is fitted to, at most; a map has often millions.

#: What was taken to be unworn is doubtful where less of a map or of its border lies on it, or more stands above it, by
#: more than a share of the scar's depth.
LEAST_ON, LEAST_BORDER, MOST_ABOVE, MOST_AT_BORDER, LITTLE = 0.08, 0.25, 0.15, 0.1, 0.03

#: A volume is known well within this share, by so many deviations.
WELL_KNOWN, CERTAIN = 0.03, 2.0

SETTLED = 5  #: Rounds in which a fit settles on what is not worn.


LEFT = 0.4  #: Of the points that lie within the noise so many are left beside what is close to a scar.

#: Form that instruments leave; a form as large as this share of a scar's depth is not distinguished from it, unless
#: the scar stays beside it and most of the border is bare.
FLATNESS_um, HIDDEN, MOST = 0.05, 0.5, 0.5

#: A form is one that is so many of its deviations, and larger than what is left beside it.
FORM, BESIDE = 6.0, 1.0

#: Bodies are stated within this share of their shape's height range; larger forms are sought by no search.
SURE = 0.05

HELPS = "a map that reaches farther beyond the scar would help, or worn depths (depth_um) in place of heights"


@dataclass(frozen=True, eq=False)
class Unworn:
    """Unworn surface that was found under a map, and how much of the map lies on it.

    parameters: of the surface. share, border: shares of the map and of its border that lie on it. above, border_above:
    shares that stand above it. doubt_um3: standard deviation of the volume below it over the whole map. form_um: height
    range of the form across the map, 0 if there is none. unclear: parameters with a form that may be the scar and is
    not subtracted; else None.
    """

    parameters: Array
    share: float
    border: float
    above: float
    border_above: float
    doubt_um3: float
    form_um: float = 0.0
    unclear: Array | None = None

    @property
    def doubtful(self) -> bool:
        """True if too little of the map lies on the surface, or too much above it, so that it may not be the unworn
        one.
        """
        return self.share < LEAST_ON or self.border < LEAST_BORDER or self._raised

    @property
    def _raised(self) -> bool:
        return self.above > MOST_ABOVE or self.border_above > MOST_AT_BORDER

    def remarks(self, where: str, depth: Array, places: Array, surface: Surface, body: str) -> tuple[str, ...]:
        """Sentences on doubts about the surface found in a file, and on a subtracted form; empty if there are none.

        where: names the file. depth: (n_x, n_y) below the surface at places (2, n_x, n_y), in µm. surface: gives words
        for the form. body: whose worn volume is wanted without its form; "" if the form counts as depth.
        """
        said = []
        if self._raised:
            said.append(
                f"{self.above:.0%} of the map and {self.border_above:.0%} of its border stand above what was taken to "
                f"be unworn, as if that were worn, too; {HELPS}"
            )
        elif self.doubtful:
            said.append(
                f"only {self.share:.0%} of the map and {self.border:.0%} of its border lie on what was taken to be "
                f"unworn; {HELPS}"
            )
        volume = float(np.abs(np.nansum(depth))) * _cell(places)
        if body and self.doubt_um3 * CERTAIN > WELL_KNOWN * volume > 0.0:
            share = CERTAIN * self.doubt_um3 / volume
            shows = f"shows the worn volume within {share:.1%} only" if share < 1.0 else "cannot show the worn volume"
            said.append(f"what is unworn {shows}; {HELPS}")
        if self.form_um and body:
            whose = self.parameters if self.unclear is None else self.unclear
            what = "that is taken off" if self.unclear is None else f"that may be the scar, and is left; {HELPS}"
            said.append(f"{surface.form_text(whose, body)}, {self.form_um:.2g} µm across the map: {what}")
        return tuple(f"{where}: {one}" for one in said)


def _cell(places: Array) -> float:
    """Area of one point in µm² for places (2, n_x, n_y), or its length in µm along a profile."""
    steps = (places[:, 1:2, :1] - places[:, :1, :1], places[:, :1, 1:2] - places[:, :1, :1])
    return float(np.prod([np.linalg.norm(step) for step in steps if step.size]))


def unworn_surface(surface: Surface, places: Array, height: Array, start: Array, *, form: bool = True) -> Unworn:
    """The unworn surface under heights (n_x, n_y) at places (2, n_x, n_y), all in µm; NaN is an unknown height.

    start: position parameters at which the search begins. form: True to allow a form, which is then part of the
    surface; False to count it as depth.
    """
    found, scale = sought(surface, places, height, start)
    found, unworn = _settled(surface, places, height, found, scale)
    form_um, unclear = 0.0, None
    if surface.forms and (seen := _form(surface, places, height, found, unworn)) is not None:
        formed, left = _fitted(surface, places, height, seen, unworn)
        formed, more = _settled(surface, places, height, formed, min(scale, _within(left)))
        form_um = _form_um(surface, places, formed)
        deepest, left_deepest = (
            float(np.nanpercentile(surface.height(own, places.reshape(2, -1)) - height.ravel(), 99.5))
            for own in (found, formed)
        )
        # A form beside which the scar stays is not the scar.
        beside = left_deepest > HIDDEN * deepest and _judged(surface, places, height, formed, more).border > MOST
        clear = form_um < HIDDEN * deepest or beside
        if clear and np.count_nonzero(more) > LEFT * np.count_nonzero(unworn):
            found, unworn = formed, more
        else:
            unclear = formed
    if surface.forms and found.size == surface.placing and _judged(surface, places, height, found, unworn).doubtful:
        formed, more = _settled(surface, places, height, *sought(surface, places, height, _whole(surface, start)))
        of_shape = SURE * float(np.ptp(surface.height(np.zeros(surface.placing), places.reshape(2, -1))))
        if _form_um(surface, places, formed) < of_shape and not _judged(surface, places, height, formed, more).doubtful:
            found, unworn, form_um, unclear = formed, more, _form_um(surface, places, formed), None
    if found.size > surface.placing and not form:
        found, form_um = _fitted(surface, places, height, found[: surface.placing], unworn)[0], 0.0
    return replace(_judged(surface, places, height, found, unworn), form_um=form_um, unclear=unclear)


def _whole(surface: Surface, parameters: Array) -> Array:
    """The parameters, with 0 for all of the form's that are missing."""
    return np.append(parameters, np.zeros(surface.placing + surface.forms - parameters.size))


def _settled(surface: Surface, places: Array, height: Array, found: Array, scale: float) -> tuple[Array, BoolArray]:
    """Parameters fitted to all points that are neither worn nor piled up, and marks of these points (n_x, n_y)."""
    flat, unworn = places.reshape(2, -1), np.zeros(height.shape, dtype=bool)
    rough = max(scale, FAR * noise_um(height))
    for place in range(SETTLED):
        rest = height - surface.height(found, flat).reshape(height.shape)
        # The first surface is only about right.
        unworn = bare(rest, scale, 0.5 ** (place + 1) * rough if place < SETTLED - 1 else 0.0)
        if np.count_nonzero(unworn) <= found.size:
            break
        found, left = _fitted(surface, places, height, found, unworn)
        scale = min(scale, _within(left))
    return found, unworn


def _within(left: Array) -> float:
    """Distance within which points with these residuals (m,) lie on the surface."""
    return 2.0 * FAR * max(median_deviation(left), FINEST_um)


def _form_um(surface: Surface, places: Array, found: Array) -> float:
    """Height range across the map of a surface's form in µm."""
    flat = places.reshape(2, -1)[:, :: max(places[0].size // MOST_POINTS, 1)]
    changed = jacobian(surface, found[: surface.placing], flat, found.size)[1][:, surface.placing :]
    return float(np.ptp(changed @ found[surface.placing :]))


def _fitted(surface: Surface, places: Array, height: Array, found: Array, unworn: BoolArray) -> tuple[Array, Array]:
    """Parameters fitted robustly to the points marked in `unworn`, starting from `found`, and residuals (m,)."""
    chosen = np.flatnonzero(unworn)
    chosen = chosen[:: max(chosen.size // MOST_POINTS, 1)]
    middle, slopes = jacobian(surface, found, places.reshape(2, -1)[:, chosen], found.size)
    rest = height.ravel()[chosen] - middle
    # Shoulders of a scar and of what is piled up lie all to one side: a mean would follow them.
    left = rest - np.median(rest)
    # Times that a fit weighs its points by what they leave.
    for _ in range(4):
        weight = np.sqrt(biweight(left, max(median_deviation(left), FINEST_um)))
        change = np.linalg.lstsq(weight[:, None] * slopes, weight * rest, rcond=None)[0]
        left = rest - slopes @ change
    return np.asarray(found + change), np.asarray(left)


def bare(rest: Array, scale: float, least: float) -> BoolArray:
    """Marks of points (n_x, n_y) that are neither worn nor piled up nor close to such, from heights `rest` in µm above
    the surface.

    scale: distance within which points lie on the surface. least: means of neighbours within it always count as unworn.
    Means are judged, as a scar's edge is shallower than the noise; fewer neighbours are used if too few points remain.
    """
    known = np.isfinite(rest)
    white = noise_um(rest)
    near = known & (np.abs(rest) < FAR * white)
    off = ~near
    for share in (0.02, 0.01, 0.0):
        wide = tuple(2 * round(share * n) + 1 for n in rest.shape)
        mean = uniform_filter(np.where(known, rest, 0.0), wide, mode="reflect")
        held = uniform_filter(known.astype(float), wide, mode="reflect")
        mean = np.where(held > 0.1, mean / np.maximum(held, 0.1), 0.0)
        above = mean[known & (mean > 0.0) & (mean < scale)]
        # Of what lies on it half stands above by noise alone.
        noise = float(np.median(above)) / 0.6745 if above.size else scale
        limit = max(min(FARTHER * max(noise, white / float(np.sqrt(np.prod(wide)))), scale), least)
        off = known & (np.abs(mean) > limit)
        found = known & ~binary_dilation(
            off, np.ones([min(max(n, 3), m) for n, m in zip(wide, rest.shape, strict=True)], dtype=bool)
        )
        if np.count_nonzero(found) > LEFT * np.count_nonzero(near):
            return np.asarray(found)
    return near & ~off


@dataclass(frozen=True, eq=False)
class _Means:
    """Means of unworn points in parts of a map: heights above a surface (m,), and derivatives by its
    parameters (m, k).
    """

    rest: Array
    slopes: Array

    @classmethod
    def of(cls, surface: Surface, places: Array, rest: Array, found: Array, unworn: BoolArray) -> "_Means":
        """Weighted means for a surface that was found, with derivatives for all its parameters."""
        at, means, count, _ = block_medians(places, np.where(unworn, rest, np.nan), parts=24, known=0.05)
        weight = np.sqrt(count / count.max(initial=1))
        slopes = jacobian(surface, found, at, surface.placing + surface.forms)[1]
        return cls(weight * means, weight[:, None] * slopes)

    def fitted(self, size: int) -> tuple[Array, Array, float]:
        """First `size` parameters by least squares, their covariance, and the standard deviation of residuals."""
        slopes = self.slopes[:, :size]
        inverse = np.linalg.pinv(slopes)
        change = inverse @ self.rest
        left = self.rest - slopes @ change
        deviation = float(np.sqrt(left @ left / max(left.size - size, 1)))
        return change, deviation**2 * inverse @ inverse.T, deviation


def _form(surface: Surface, places: Array, height: Array, found: Array, unworn: BoolArray) -> Array | None:
    """Parameters including a form; None if no form is seen."""
    rest = height - surface.height(found, places.reshape(2, -1)).reshape(height.shape)
    means, whole = _Means.of(surface, places, rest, found, unworn), surface.placing + surface.forms
    if means.rest.size < 2 * whole:
        return None
    change, covariance, deviation = means.fitted(whole)
    own = slice(surface.placing, whole)
    certain = change[own] @ np.linalg.pinv(covariance[own, own]) @ change[own] / surface.forms
    of_form = means.slopes @ change - means.slopes[:, : surface.placing] @ means.fitted(surface.placing)[0]
    if certain < FORM**2 or float(np.sqrt(np.mean(of_form**2))) < BESIDE * deviation:
        return None
    return np.asarray(_whole(surface, found) + change)


def _farther(surface: Surface, places: Array, height: Array, found: Array, unworn: BoolArray) -> Array | None:
    """Parameters fitted to the half of the unworn points farthest from all others; None if they are too few.

    Points near a scar may be raised by piled-up material.
    """
    away = distance_transform_edt(unworn | ~np.isfinite(height))
    # Unworn points a parameter that are fitted by their farther half, too.
    if not np.isfinite(away).all() or np.count_nonzero(unworn) < 20 * found.size:
        return None
    return _fitted(surface, places, height, found, unworn & (away >= np.median(away[unworn])))[0]


def _judged(surface: Surface, places: Array, height: Array, found: Array, unworn: BoolArray) -> Unworn:
    flat = places.reshape(2, -1)
    rest = height - surface.height(found, flat).reshape(height.shape)
    _, blocks, _, border = block_medians(places, rest)
    points = rest[unworn]
    limit = FAR * max(median_deviation(points), noise_um(height))
    on = np.abs(blocks) < limit
    means, whole = _Means.of(surface, places, rest, found, unworn), surface.placing + surface.forms
    doubt = np.inf
    if means.rest.size > found.size:
        # A form that is not seen may be as large as instruments leave it, or as one that is not certain.
        size = np.maximum(np.abs(means.fitted(whole)[0]), FLATNESS_um) if means.rest.size > 2 * whole else FLATNESS_um
        flatness = np.where(np.arange(whole) < found.size, 0.0, 1.0 / size**2)
        deviation = max(means.fitted(found.size)[2], 0.1 * FINEST_um)
        covariance = np.linalg.pinv(means.slopes.T @ means.slopes / deviation**2 + np.diag(flatness))
        lever = jacobian(surface, found, flat[:, :: max(height.size // MOST_POINTS, 1)], whole)[1].mean(axis=0)
        # Form that is likely, but not certain enough to be taken off, is in doubt as a whole.
        likely = lever @ covariance @ means.slopes.T @ means.rest / deviation**2
        left_out = float(likely - lever[: found.size] @ means.fitted(found.size)[0])
        doubt = float(np.hypot(np.sqrt(lever @ covariance @ lever), left_out))
        if (farther := _farther(surface, places, height, found, unworn)) is not None:
            doubt = max(doubt, abs(float(lever[: found.size] @ (farther - found))) / CERTAIN)
        doubt *= _cell(places) * height.size
    # What is little beside the scar's depth is a form that is left.
    above = blocks > max(limit, LITTLE * float(-np.percentile(blocks, 1.0)))
    share, at_border, raised, raised_at_border = (float(np.mean(one)) for one in (on, on[border], above, above[border]))
    return Unworn(found, share, at_border, raised, raised_at_border, doubt)
