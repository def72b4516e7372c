"""Maps of both bodies' scars: their figures (volume, depth, length, width), and their skew."""

from dataclasses import replace

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.loop_states import SCAR_FIGURES, scar_figures, scar_skew
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
from wirewear.records import MeasuredScar

_KNOWN = constants("observe.scars")

#: A map knows depths within this; figures of a scar that is hardly deeper mean little.
DEPTH_ERROR_um = _KNOWN.number("depth_error")

#: Error of a profilometer's figures, relative; of a skew in rad, and what a shallow scar adds to it in units of its
#: relative error of depth.
FIGURE_ERROR = _KNOWN.number("figure_error")
SKEW_ERROR, SHALLOW_SKEW = _KNOWN.each("skew_error", "shallow_skew")

#: The least points of a map.
FEWEST_POINTS = _KNOWN.count("fewest_points")

#: A difference of free shape may be so large in the logarithm of figures, in skews.
FREE_FIGURE, FREE_SKEW = _KNOWN.each("free_figure", "free_skew")


class _OfScars(Observable):
    """One number a body, after the last cycle."""

    of_scars = True

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:  # noqa: ARG002
        """Whatever the hooks."""
        return SolverSize(np.zeros(len(sites)), hooked=False)

    def smoothness(self, sites: Sites, scale: Scale) -> Smoothness:  # noqa: ARG002
        """No number has anything in common with another."""
        return replace(Smoothness.of_whole_loops(len(sites)), family=np.arange(len(sites)))


class ScarFigures(_OfScars):
    """Their logarithms."""

    name = "scar"
    words, unit = "scar", "relative"
    free_share = FREE_FIGURE
    zones = (Zone("scar", "scars"),)

    def sites(self, reading: Reading) -> list[Site]:
        """All figures of the bodies that have maps."""
        return [replace(site, figure=figure) for site in _of_bodies(reading) for figure in SCAR_FIGURES]

    def measure(self, reading: Reading, repeat: int, sites: Sites) -> tuple[Array, Array]:
        """From the map above the unworn ground."""
        values, noise = np.full((2, len(sites)), np.nan)
        for scar in maps_of(reading, repeat):
            figures = _figures(scar, above_ground(scar))
            for place, site in enumerate(sites):
                # That nothing is worn says that nothing is deeper than the error of a depth.
                least = DEPTH_ERROR_um if site.figure == "depth" else 0.0
                figure = max(figures[site.figure], least)
                if site.wire == scar.body and figure > 0.0:
                    values[place] = np.log(figure)
                    noise[place] = np.hypot(FIGURE_ERROR, _shallow(figures, least))
        return values, noise

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """Those of the course's end."""
        figure = np.array([SCAR_FIGURES.index(name) for name in sites.figure], dtype=int)
        least = np.where(figure == SCAR_FIGURES.index("depth"), DEPTH_ERROR_um, 1e-6)
        return np.asarray(np.log(np.maximum(course.scars[sites.level.astype(int), figure], least)))


class ScarSkew(_OfScars):
    """Shear of a swept scar, from which the crossing angle follows."""

    name = "skew"
    words, unit = "skew of the scar", "rad"
    free_share = FREE_SKEW
    zones = (Zone("skew", "skew of the scars"),)

    def sites(self, reading: Reading) -> list[Site]:
        """One a body that has maps."""
        return _of_bodies(reading)

    def measure(self, reading: Reading, repeat: int, sites: Sites) -> tuple[Array, Array]:
        """From the map above the unworn ground."""
        values, noise = np.full((2, len(sites)), np.nan)
        for scar in maps_of(reading, repeat):
            depth = above_ground(scar)
            values[sites.wire == scar.body] = scar_skew(scar.x_um, scar.y_um, depth)
            noise[sites.wire == scar.body] = np.hypot(SKEW_ERROR, _shallow(_figures(scar, depth)) * SHALLOW_SKEW)
        return values, noise

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """Those of the course's end."""
        return np.asarray(course.skew[sites.level.astype(int)])


def _of_bodies(reading: Reading) -> list[Site]:
    """One for each body that has maps; the level is its place among both."""
    worn = {scar.body for scar in reading.scars}
    names = enumerate(reading.body_names)
    return [Site(reading.last_cycle, level=float(place), wire=body) for place, body in names if body in worn]


def maps_of(reading: Reading, repeat: int) -> list[MeasuredScar]:
    """Maps of one repeat that have enough points."""
    return [scar for scar in reading.scars if scar.repeat == repeat and scar.depth_um.size >= FEWEST_POINTS]


def above_ground(scar: MeasuredScar) -> Array:
    """Depths (n_x, n_y) less the reading where nothing is worn: what others evaluate is often clipped or off zero."""
    ground = float(np.median(scar.rim_um)) if scar.rim_um.size else 0.0
    return np.nan_to_num(scar.depth_um - ground)


def _figures(scar: MeasuredScar, depth_um: Array) -> dict[str, float]:
    return dict(zip(SCAR_FIGURES, scar_figures(scar.x_um, scar.y_um, depth_um), strict=True))


def _shallow(figures: dict[str, float], least_um: float = 0.0) -> float:
    """Relative error of a scar's depth, taken to be at least so large."""
    return DEPTH_ERROR_um / max(figures["depth"], least_um, 1e-9)
