"""Worn profiles of a line contact's bodies: depths at places along the scar."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.loop_states import crossings
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.observe.observable import (
    ModelLoops,
    Observable,
    Scale,
    Site,
    Sites,
    Smoothness,
    SolverSize,
    Zone,
)
from wirewear.diagnosis.observe.reading import Reading
from wirewear.records import MeasuredProfile

_KNOWN = constants("observe.profiles")

#: Places to either side of the middle, in half-widths of the scar; width of the bins in which depths are averaged.
PLACES, BIN = _KNOWN.numbers("places"), _KNOWN.number("bin")

#: A profile's middle lies half-way between the places with this share of its depth; its half-width is told at that one.
HALF_DEPTH, EDGE = _KNOWN.each("half_depth", "edge")

#: Degree of the curve about which roughness is told; nothing is known better than this share of the depth.
ROUGH_DEGREE, LEAST_ERROR = _KNOWN.count("rough_degree"), _KNOWN.number("least_error")

#: Solver differences: share of the depth, and by how much places differ, in half-widths; alike over so many of these.
DEPTH_SHARE, ASIDE, REACH = _KNOWN.each("depth_share", "aside", "reach")

#: The flat beside the scar begins so far out; a zero is known no better than this share of the depth.
OUTSIDE, FEWEST_OUTSIDE = _KNOWN.number("outside"), _KNOWN.count("fewest_outside")
UNKNOWN_ZERO = _KNOWN.number("unknown_zero")

#: A difference of free shape may be so large a share of the depth.
FREE_SHARE = _KNOWN.number("free_share")

#: Where the middle of a scar ends, and its flanks.
MIDDLE, FLANK = _KNOWN.each("middle", "flank")

#: The least points of a profile.
FEWEST_POINTS = _KNOWN.count("fewest_points")

BODIES = ("pad", "specimen")


@dataclass(frozen=True, eq=False)
class ReadProfile:
    """A measured profile about its own middle: half-width, depth, roughness, and what its zero may be off by.

    `alike`: correlation of the roughness of neighbours.
    """

    x_um: Array
    depth_um: Array
    half_width_um: float
    deepest_um: float
    rough_um: float
    zero_um: float
    alike: float

    def error_of(self, count: int, known_um: float) -> float:
        """Standard deviation of a mean of so many neighbouring depths, each known no better than stated."""
        own = max(count * (1.0 - self.alike) / (1.0 + self.alike), 1.0)
        return max(self.rough_um, known_um) / float(np.sqrt(own))


def read_profile(profile: MeasuredProfile) -> ReadProfile:
    """A profile moved onto its middle; its zero is the file's, as uncertain as the flat beside the scar is off it."""
    x, depth = profile.x_um, profile.depth_um
    smooth = _smoothed(x, depth)
    deepest = max(float(smooth.max()), 1e-6)
    left, right = crossings(x, smooth, HALF_DEPTH * deepest)
    x = x - 0.5 * (left + right)
    ends = crossings(x, smooth, EDGE * deepest)
    half = max(0.5 * (ends[1] - ends[0]), 1e-6)
    inside = np.abs(x) < half
    rough = depth - smooth
    rough_um = max(float(np.std(rough[inside])) if inside.any() else 0.0, LEAST_ERROR * deepest)
    outside = np.abs(x) > OUTSIDE * half
    off = 0.0
    if np.count_nonzero(outside) >= FEWEST_OUTSIDE:
        off = float(abs(depth[outside].mean()))
        # What is no wear beside the scar may be within it, too.
        rough_um = max(rough_um, float(depth[outside].std()))
        rough = np.where(outside, depth - depth[outside].mean(), rough)
    alike = float(np.corrcoef(rough[:-1], rough[1:])[0, 1]) if np.ptp(rough) > 0.0 else 0.0
    return ReadProfile(x, depth, half, deepest, rough_um, max(off, UNKNOWN_ZERO * deepest), max(alike, 0.0))


class ProfileDepths(Observable):
    """Levels are places in µm from the scar's middle."""

    name = "profile"
    words, unit = "worn depth along the profile", "um"
    zones = (
        Zone("profile_middle", "profile: middle", "in the middle of the scar"),
        Zone("profile_flanks", "profile: flanks", "on the flanks of the scar"),
        Zone("profile_edges", "profile: edges", "at the edges of the scar"),
    )
    simulated = True
    of_scars = True

    def sites(self, reading: Reading) -> list[Site]:
        """Even places across the scars of both bodies."""
        found = []
        for body in BODIES:
            own = [read_profile(one) for one in reading.profiles if one.body == body and _holds_enough(one)]
            if own:
                half = float(np.median([one.half_width_um for one in own]))
                places = sorted({side * half * at for at in PLACES for side in (-1.0, 1.0)})
                found += [Site(reading.last_cycle, level=place, wire=body) for place in places]
        return found

    def measure(self, reading: Reading, repeat: int, sites: Sites) -> tuple[Array, Array]:
        """Means of bins about the places."""
        values, noise = np.full((2, len(sites)), np.nan)
        for profile in reading.profiles:
            if profile.repeat != repeat or not _holds_enough(profile):
                continue
            one = read_profile(profile)
            reach = 0.5 * BIN * one.half_width_um
            for place in np.flatnonzero(sites.wire == profile.body):
                level = float(sites.level[place])
                if not one.x_um[0] <= level <= one.x_um[-1]:
                    continue
                near = np.abs(one.x_um - level) <= reach
                count = int(np.count_nonzero(near))
                values[place] = one.depth_um[near].mean() if count else np.interp(level, one.x_um, one.depth_um)
                noise[place] = one.error_of(count, reading.depth_noise_um)
        return values, noise

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """Those of the course's end."""
        values = np.zeros(len(sites))
        for body, (x, depth) in course.profiles.items():
            own = sites.wire == body
            values[own] = np.interp(sites.level[own], x, depth, left=0.0, right=0.0)
        return values

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """A share of the depth, and walls that stand elsewhere."""
        size = np.zeros(len(sites))
        for body, (x, depth) in loops.course.profiles.items():
            own = sites.wire == body
            if not own.any():
                continue
            slope = np.abs(np.gradient(depth, x))
            half = _half_width(sites.level[own])
            at = sites.level[own]
            walls = ASIDE * half * np.interp(at, x, slope, left=0.0, right=0.0)
            share = DEPTH_SHARE * np.interp(at, x, depth, left=0.0, right=0.0)
            size[own] = np.sqrt(walls**2 + share**2 + (LEAST_ERROR * float(depth.max())) ** 2)
        return SolverSize(size, hooked=False)

    def free_size(self, setup: Setup, predicted: Array) -> Array:  # noqa: ARG002
        """A share of the largest depth."""
        return np.full(predicted.size, FREE_SHARE * max(float(np.abs(predicted).max(initial=0.0)), 1e-6))

    def zone(self, sites: Sites, amplitude_um: float) -> NDArray[np.str_]:  # noqa: ARG002
        """By the place over the scar's half-width."""
        place = np.abs(places_of(sites))
        return np.where(place < MIDDLE, "profile_middle", np.where(place < FLANK, "profile_flanks", "profile_edges"))

    def smoothness(self, sites: Sites, scale: Scale) -> Smoothness:  # noqa: ARG002
        """Smooth along each body's scar."""
        family = np.array([BODIES.index(body) for body in sites.wire], dtype=np.intp)
        return replace(Smoothness.of_whole_loops(len(sites)), along=places_of(sites) / REACH, family=family)

    def common_error(self, reading: Reading, sites: Sites) -> Array:
        """What the zero of the profiles may be off by."""
        off = np.zeros(len(sites))
        for body in BODIES:
            own = [read_profile(one).zero_um for one in reading.profiles if one.body == body and _holds_enough(one)]
            off[sites.wire == body] = float(np.median(own)) if own else 0.0
        return off


def places_of(sites: Sites) -> Array:
    """Places (n,) of profile depths over the half-width of their body's scar."""
    places = np.zeros(len(sites))
    for body in BODIES:
        own = sites.wire == body
        if own.any():
            places[own] = sites.level[own] / _half_width(sites.level[own])
    return places


def _half_width(levels: Array) -> float:
    """That of the scar over which these places are spread."""
    return float(np.abs(levels).max()) / PLACES[-1]


def _holds_enough(profile: MeasuredProfile) -> bool:
    return profile.x_um.size >= FEWEST_POINTS


def _smoothed(x: Array, depth: Array) -> Array:
    """A smooth curve through a profile; few points are taken as they are."""
    count = x.size
    if count <= 3 * ROUGH_DEGREE:
        return depth
    width = max(count // (3 * ROUGH_DEGREE), 1)
    even = np.linspace(x[0], x[-1], count)
    smooth: Array = uniform_filter1d(np.interp(even, x, depth), 2 * width + 1, mode="nearest")
    return np.interp(x, even, smooth)
