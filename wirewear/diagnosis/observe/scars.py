"""Observables of worn surfaces: volume, depth, length, width and skew of scars, and depths along line contacts'
profiles.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.observe import observable
from wirewear.diagnosis.observe.measured_loops import LEAST_NOISE
from wirewear.diagnosis.observe.observed_record import Reading
from wirewear.diagnosis.surrogate.forward import PredictedLoops
from wirewear.diagnosis.surrogate.loop_states import skew_and_noise
from wirewear.records import MeasuredProfile, MeasuredScar
from wirewear.records.spikes import noise_um
from wirewear.results.scar import SCAR_FIGURES, crossings

_KNOWN = constants("observe.scars")

#: A map knows depths within this; figures of a scar that is hardly deeper mean little.
DEPTH_ERROR_um = _KNOWN.number("depth_error")

#: Error of a profilometer's figures, zeros and depths, relative; that of a skew in units of the depth's relative error.
FIGURE_ERROR = _KNOWN.number("figure_error")
SHALLOW_SKEW = _KNOWN.number("shallow_skew")

#: The least points of a map.
FEWEST_POINTS = _KNOWN.count("fewest_points")

_PROFILES = constants("observe.scars.profiles")

#: Places to either side of the middle, in half-widths of the scar; width of the bins in which depths are averaged.
PLACES, BIN = _PROFILES.numbers("places"), _PROFILES.number("bin")

#: A profile's middle lies half-way between the places with this share of its depth; its half-width is read at that one.
HALF_DEPTH, EDGE = _PROFILES.each("half_depth", "edge")

#: Degree of the curve about which roughness is measured.
ROUGH_DEGREE = _PROFILES.count("rough_degree")

#: Solver differences: by how much places differ, in half-widths.
ASIDE = _PROFILES.number("aside")

#: The flat beside the scar begins so far out.
OUTSIDE, FEWEST_OUTSIDE = _PROFILES.number("outside"), _PROFILES.count("fewest_outside")

#: A scar is so many times as deep as neighbouring depths differ by noise.
STANDS_OUT = _PROFILES.number("stands_out")

#: Where the middle of a scar ends, and its flanks.
MIDDLE, FLANK = _PROFILES.each("middle", "flank")

#: The least points of a profile.
FEWEST_POINTS_OF_A_PROFILE = _PROFILES.count("fewest_points")
BODIES = ("pad", "specimen")


class _OfScars(observable.Observable):
    """Observable with numbers for each body, after the last cycle."""

    of_scars = True

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:  # noqa: ARG002
        return observable.SolverSize(np.zeros(len(sites)), hooked=False)

    def smoothness(self, sites: observable.Sites, scale: observable.Scale) -> observable.Smoothness:  # noqa: ARG002
        return replace(observable.Smoothness.of_whole_loops(len(sites)), family=np.arange(len(sites)))


class ScarFigures(_OfScars):
    """Logarithms of the `SCAR_FIGURES` of scars: volume in µm³, depth, length and width in µm."""

    name = "scar"
    words, unit = "scar", "relative"
    zones = (observable.Zone("scar", "scars"),)

    def sites(self, reading: Reading) -> list[observable.Site]:
        return [replace(site, figure=figure) for site in _of_bodies(reading) for figure in SCAR_FIGURES]

    def measure(self, reading: Reading, repeat: int, sites: observable.Sites) -> tuple[Array, Array]:
        """Logarithms (n,) of the scars' figures in one repeat, and their standard deviations (n,); NaN without a
        map.
        """
        values, noise = np.full((2, len(sites)), np.nan)
        for scar in maps_of(reading, repeat):
            figures = scar.figures
            for place, site in enumerate(sites):
                # That nothing is worn says that nothing is deeper than the error of a depth.
                least = DEPTH_ERROR_um if site.figure == "depth" else 0.0
                figure = max(figures[site.figure], least)
                if site.body == scar.body and figure > 0.0:
                    values[place] = np.log(figure)
                    noise[place] = np.hypot(FIGURE_ERROR, _shallow(figures, least))
        return values, noise

    def common_error(self, reading: Reading, sites: observable.Sites) -> Array:
        """Error (n,) that all repeats share: for a shallow scar the bias of its log depth, 3 noise deviations over the
        depth; else 0.
        """
        off = np.zeros(len(sites))
        for scar in reading.scars:
            raised = 3.0 * noise_um(scar.depth_um) / max(scar.figures["depth"], DEPTH_ERROR_um)
            if raised > 1.0 / STANDS_OUT:
                off[(sites.body == scar.body) & (sites.figure == "depth")] = raised
        return off

    def predict(self, predicted: PredictedLoops, sites: observable.Sites) -> Array:
        figure = np.array([SCAR_FIGURES.index(name) for name in sites.figure], dtype=int)
        least = np.where(figure == SCAR_FIGURES.index("depth"), DEPTH_ERROR_um, 1e-6)
        return np.asarray(np.log(np.maximum(predicted.scars[sites.level.astype(int), figure], least)))


class ScarSkew(_OfScars):
    """Skew of a scar in rad, from which the crossing angle can be inferred."""

    name = "skew"
    words, unit = "skew of the scar", "rad"
    zones = (observable.Zone("skew", "skew of the scars"),)

    def sites(self, reading: Reading) -> list[observable.Site]:
        return _of_bodies(reading)

    def measure(self, reading: Reading, repeat: int, sites: observable.Sites) -> tuple[Array, Array]:
        values, noise = np.full((2, len(sites)), np.nan)
        for scar in maps_of(reading, repeat):
            own = sites.body == scar.body
            values[own], by_noise = skew_and_noise(scar.x_um, scar.y_um, scar.worn_um, noise_um(scar.depth_um))
            noise[own] = np.hypot(_shallow(scar.figures) * SHALLOW_SKEW, by_noise)
        return values, noise

    def predict(self, predicted: PredictedLoops, sites: observable.Sites) -> Array:
        return np.asarray(predicted.skew[sites.level.astype(int)])


def _of_bodies(reading: Reading) -> list[observable.Site]:
    """One site for each body that has maps; its level is the body's index."""
    worn = {scar.body for scar in reading.scars}
    names = enumerate(reading.body_names)
    return [observable.Site(reading.last_cycle, level=float(place), body=body) for place, body in names if body in worn]


def maps_of(reading: Reading, repeat: int) -> list[MeasuredScar]:
    """Maps of one repeat that have at least `FEWEST_POINTS` points."""
    return [scar for scar in reading.scars if scar.repeat == repeat and scar.depth_um.size >= FEWEST_POINTS]


def _shallow(figures: Mapping[str, float], least_um: float = 0.0) -> float:
    """Relative error of a scar's depth, which is taken to be at least `least_um`."""
    return DEPTH_ERROR_um / max(figures["depth"], least_um, 1e-9)


@dataclass(frozen=True, eq=False)
class ReadProfile:
    """Measured profile (n,) centred on its scar, with half-width, roughness and uncertainty of its zero
    in µm.

    alike: correlation of the roughness of neighbouring depths.
    """

    x_um: Array
    depth_um: Array
    half_width_um: float
    rough_um: float
    zero_um: float
    alike: float

    def error_of(self, count: int, known_um: float) -> float:
        """Standard deviation in µm of a mean of `count` neighbouring depths; known_um: the stated error of one depth, 0
        if unknown.
        """
        own = max(count * (1.0 - self.alike) / (1.0 + self.alike), 1.0)
        return max(self.rough_um, known_um) / float(np.sqrt(own))


def read_profile(profile: MeasuredProfile) -> ReadProfile:
    """Prepare a profile: centred on its scar; as uncertain in its zero as the flat beside the scar lies off 0."""
    x, depth = profile.x_um, profile.depth_um
    smooth = _smoothed(x, depth)
    deepest = max(float(smooth.max()), 1e-6)
    left, right = crossings(x, smooth, HALF_DEPTH * deepest)
    x = x - 0.5 * (left + right)
    ends = crossings(x, smooth, EDGE * deepest)
    half = max(0.5 * (ends[1] - ends[0]), 1e-6)
    inside = np.abs(x) < half
    rough = depth - smooth
    rough_um = max(float(np.std(rough[inside])) if inside.any() else 0.0, LEAST_NOISE * deepest)
    # What does not stand out of the differences of neighbours is no scar, whatever a curve through few points shows.
    between = noise_um(depth[:, None])
    if deepest < STANDS_OUT * between:
        rough_um = max(rough_um, between)
    outside = np.abs(x) > OUTSIDE * half
    off = 0.0
    if np.count_nonzero(outside) >= FEWEST_OUTSIDE:
        off = float(abs(depth[outside].mean()))
        # What is no wear beside the scar may be within it, too.
        rough_um = max(rough_um, float(depth[outside].std()))
        rough = np.where(outside, depth - depth[outside].mean(), rough)
    alike = float(np.corrcoef(rough[:-1], rough[1:])[0, 1]) if np.ptp(rough) > 0.0 else 0.0
    return ReadProfile(x, depth, half, rough_um, max(off, FIGURE_ERROR * deepest), max(alike, 0.0))


class ProfileDepths(observable.Observable):
    """Worn depths in µm along a profile. Levels are distances in µm from the scar's middle."""

    name = "profile"
    words, unit = "worn depth along the profile", "um"
    zones = (
        observable.Zone("profile_middle", "profile: middle", "in the middle of the scar"),
        observable.Zone("profile_flanks", "profile: flanks", "on the flanks of the scar"),
        observable.Zone("profile_edges", "profile: edges", "at the edges of the scar"),
    )
    simulated = True
    of_scars = True

    def sites(self, reading: Reading) -> list[observable.Site]:
        found = []
        for body in BODIES:
            own = [read_profile(one) for one in reading.profiles if one.body == body and _holds_enough(one)]
            if own:
                half = float(np.median([one.half_width_um for one in own]))
                places = sorted({side * half * at for at in PLACES for side in (-1.0, 1.0)})
                found += [observable.Site(reading.last_cycle, level=place, body=body) for place in places]
        return found

    def measure(self, reading: Reading, repeat: int, sites: observable.Sites) -> tuple[Array, Array]:
        """Mean depth (n,) in µm of a profile in a bin about each site, and its standard deviation (n,); NaN beyond the
        profile.
        """
        values, noise = np.full((2, len(sites)), np.nan)
        for profile in reading.profiles:
            if profile.repeat != repeat or not _holds_enough(profile):
                continue
            one = read_profile(profile)
            reach = 0.5 * BIN * one.half_width_um
            for place in np.flatnonzero(sites.body == profile.body):
                level = float(sites.level[place])
                if not one.x_um[0] <= level <= one.x_um[-1]:
                    continue
                near = np.abs(one.x_um - level) <= reach
                count = int(np.count_nonzero(near))
                values[place] = one.depth_um[near].mean() if count else np.interp(level, one.x_um, one.depth_um)
                noise[place] = one.error_of(count, reading.depth_noise_um)
        return values, noise

    def predict(self, predicted: PredictedLoops, sites: observable.Sites) -> Array:
        values = np.zeros(len(sites))
        for body, (x, depth) in predicted.profiles.items():
            own = sites.body == body
            values[own] = np.interp(sites.level[own], x, depth, left=0.0, right=0.0)
        return values

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:
        """Solver differences in µm: a share of the depth, and walls displaced by the share `ASIDE` of the
        half-width.
        """
        size = np.zeros(len(sites))
        for body, (x, depth) in loops.predicted.profiles.items():
            own = sites.body == body
            if not own.any():
                continue
            slope = np.abs(np.gradient(depth, x))
            half = _half_width(sites.level[own])
            at = sites.level[own]
            walls = ASIDE * half * np.interp(at, x, slope, left=0.0, right=0.0)
            share = FIGURE_ERROR * np.interp(at, x, depth, left=0.0, right=0.0)
            size[own] = np.sqrt(walls**2 + share**2 + (LEAST_NOISE * float(depth.max())) ** 2)
        return observable.SolverSize(size, hooked=False)

    def zone(self, sites: observable.Sites, amplitude_um: float) -> NDArray[np.str_]:  # noqa: ARG002
        place = np.abs(places_of(sites))
        return np.where(place < MIDDLE, "profile_middle", np.where(place < FLANK, "profile_flanks", "profile_edges"))

    def smoothness(self, sites: observable.Sites, scale: observable.Scale) -> observable.Smoothness:  # noqa: ARG002
        family = np.array([BODIES.index(body) for body in sites.body], dtype=np.intp)
        along = places_of(sites) / observable.REACH
        return replace(observable.Smoothness.of_whole_loops(len(sites)), along=along, family=family)

    def common_error(self, reading: Reading, sites: observable.Sites) -> Array:
        """Standard deviation (n,) in µm of the profiles' zero, the median of a body's profiles; 0 for a body without
        any.
        """
        off = np.zeros(len(sites))
        for body in BODIES:
            own = [read_profile(one).zero_um for one in reading.profiles if one.body == body and _holds_enough(one)]
            off[sites.body == body] = float(np.median(own)) if own else 0.0
        return off


def places_of(sites: observable.Sites) -> Array:
    """Places (n,) of sites across the scar, over the half-width of their body's scar."""
    places = np.zeros(len(sites))
    for body in BODIES:
        own = sites.body == body
        if own.any():
            places[own] = sites.level[own] / _half_width(sites.level[own])
    return places


def _half_width(levels: Array) -> float:
    """Half-width in µm of the scar over which these levels are spread."""
    return float(np.abs(levels).max()) / PLACES[-1]


def _holds_enough(profile: MeasuredProfile) -> bool:
    return profile.x_um.size >= FEWEST_POINTS_OF_A_PROFILE


def _smoothed(x: Array, depth: Array) -> Array:
    """Smooth curve (n,) through a profile; the depths themselves if there are few points."""
    count = x.size
    if count <= 3 * ROUGH_DEGREE:
        return depth
    width = max(count // (3 * ROUGH_DEGREE), 1)
    even = np.linspace(x[0], x[-1], count)
    smooth: Array = uniform_filter1d(np.interp(even, x, depth), 2 * width + 1, mode="nearest")
    return np.interp(x, even, smooth)
