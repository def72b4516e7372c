"""Measured profiles across the scar of a line contact at the end of a test."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.records.spikes import BORDER, as_measured, border_text, noise_um, spikes_text, without_spikes
from wirewear.results.scar import Scar
from wirewear.test.lengths import extent_of

EDGE = 0.01  #: Depth, relative to the deepest point, that bounds the scar.

#: Noise (three deviations) is small below this share of the depth; a profile keeps so many means beside one another.
CLEAR, FEWEST_ACROSS = 0.1, 8


@dataclass(frozen=True, eq=False)
class MeasuredProfile:
    """Worn depths (n,) in µm of one repeat's body along the sliding direction at the end; negative where piled up.

    height_um, face_um: (n,) measured heights and fitted unworn face; None if depths were measured. spikes_um: (n,)
    measured depths of outlying points, NaN elsewhere; None if there are none. levelling_notes: sentences on the fit.
    """

    repeat: int
    body: str
    x_um: Array
    depth_um: Array
    height_um: Array | None = None
    face_um: Array | None = None
    spikes_um: Array | None = None
    levelling_notes: tuple[str, ...] = ()

    @classmethod
    def from_points(cls, repeat: int, body: str, x_um: Array, depth_um: Array) -> "MeasuredProfile":
        """Profile of points (n,) in their order, outlying ones replaced. Raises RecordError if there are fewer than
        three.
        """
        if x_um.size < 3:
            raise RecordError(f"the profile of repeat {repeat} has fewer than three points.")
        depth, spikes = without_spikes(depth_um[:, None])
        left_out = np.where(spikes[:, 0], depth_um, np.nan) if spikes.any() else None
        return cls(repeat, body, x_um, depth[:, 0], spikes_um=left_out)

    @classmethod
    def of_run(cls, scar: Scar, repeat: int, noise_um: float, random: np.random.Generator) -> "MeasuredProfile":
        """Profile of a simulated scar with the noise of a stylus, `noise_um` as standard deviation."""
        rough = noise_um * random.standard_normal(scar.axial_um.size)
        return cls(repeat, scar.body, scar.axial_um, scar.depth_um[:, 0] + rough)

    @property
    def field(self) -> tuple[Array, Array, Array]:
        """The profile as a map: x (n,), the single line y = 0 (1,), and depths (n, 1), in µm."""
        return self.x_um, np.zeros(1), self.depth_um[:, None]

    def of_field(self, depth_um: Array) -> "MeasuredProfile":
        """Copy of the profile with other depths (n, 1), without heights, face and spikes."""
        return MeasuredProfile(self.repeat, self.body, self.x_um, depth_um[:, 0])

    @property
    def spans_um(self) -> dict[str, float]:
        return {"depth": float(self.smooth_um.max()), "width": self.width_um}

    @property
    def points(self) -> dict[str, Array]:
        return {"x_um": self.x_um, "depth_um": as_measured(self.depth_um, self.spikes_um)}

    @property
    def spikes_note(self) -> str:
        """Sentence on the number of outlying points; "" if there are none."""
        return spikes_text(self.spikes_um, self.depth_um, f"the {self.body}'s profile of repeat {self.repeat}")

    @property
    def border_note(self) -> str:
        """Sentence if much of the worn area lies at the profile's ends, as if it ended within the scar; else ""."""
        (left, right), x = self.edges_um, self.x_um
        width = BORDER * float(np.ptp(x))
        places, depth = self._worn
        ends = (places < x[0] + width) | (places > x[-1] - width)
        area = self.area_um2 if left < right else 0.0
        share = float(np.trapezoid(np.where(ends, depth, 0.0), places)) / area if area > 0.0 else 0.0
        return border_text(share, f"the {self.body}'s profile of repeat {self.repeat}")

    def bridged(self) -> "tuple[MeasuredProfile, str]":
        """The profile itself and "", as a profile has no gaps."""
        return self, ""

    @property
    def sizes(self) -> str:
        return f"{self.smooth_um.max():.3g} µm deep, {self.width_um:.4g} µm wide, {self.area_um2:.4g} µm²"

    @property
    def edges_um(self) -> tuple[float, float]:
        """Positions in µm on either side of all that is worn half as deep as the deepest point, where the smoothed
        depth falls to 1 % of its largest, or the profile's ends. A contact that sticks in its middle wears on both
        sides of it.
        """
        deep = np.flatnonzero(self.smooth_um >= 0.5 * self.smooth_um.max())
        out = np.flatnonzero(self.smooth_um <= self._level_um)
        left, right = out[out < deep[0]], out[out > deep[-1]]
        return (
            self._crossing(int(left[-1]), int(left[-1]) + 1) if len(left) else float(self.x_um[0]),
            self._crossing(int(right[0]), int(right[0]) - 1) if len(right) else float(self.x_um[-1]),
        )

    @cached_property
    def smooth_um(self) -> Array:
        """Depths (n,) in µm, averaged over neighbours until noise is small beside the depth; unchanged for deep
        scars.
        """
        depth = self.depth_um
        noise, deep, smooth = noise_um(depth[:, None]), float(depth.max()), depth
        for _ in range(2):
            count = min(int((3.0 * noise / (CLEAR * deep)) ** 2), depth.size // FEWEST_ACROSS) if deep > 0.0 else 0
            if count < 2:
                return smooth
            padded = np.pad(depth, (count // 2, (count - 1) // 2), mode="reflect")
            smooth = np.convolve(padded, np.full(count, 1.0 / count), mode="valid")
            deep = float(smooth.max())
        return smooth

    def volume_of(self, length_mm: float | None) -> float:
        """Worn volume in mm³ of a contact of this length, or per mm of length if it is None."""
        return 1e-6 * self.area_um2 / extent_of(length_mm).share

    @property
    def width_um(self) -> float:
        left, right = self.edges_um
        return right - left

    @property
    def area_um2(self) -> float:
        """Worn cross-section between the scar's edges in µm²."""
        x, depth = self._worn
        return float(np.trapezoid(depth, x))

    @property
    def _level_um(self) -> float:
        return EDGE * float(self.smooth_um.max())

    @property
    def _worn(self) -> tuple[Array, Array]:
        """Positions and depths from edge to edge."""
        left, right = self.edges_um
        inside = (self.x_um > left) & (self.x_um < right)
        ends = np.interp((left, right), self.x_um, self.depth_um)
        return np.r_[left, self.x_um[inside], right], np.r_[ends[0], self.depth_um[inside], ends[1]]

    def _crossing(self, out: int, worn: int) -> float:
        """Position between two neighbouring points, by index, at which the depth passes the edges' level."""
        rise = float(self.smooth_um[worn] - self.smooth_um[out])
        share = (self._level_um - float(self.smooth_um[out])) / rise if rise > 0.0 else 0.0
        return float(self.x_um[out] + share * (self.x_um[worn] - self.x_um[out]))
