"""Page and table of a running test, and its lines for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import isfinite, nan
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from geometry.arrays import Array
from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.words import counted
from wirewear.base.writing import write_csv, write_text, writing
from wirewear.comparison.running_test import FollowedLoop
from wirewear.diagnosis.watch import Look
from wirewear.pictures.panels import draw_loop, name_axes
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, cycle_axis, new_figure, panel_letters, svg
from wirewear.records import AnyRecord

HERE = Path(__file__).parent
PAGE, TABLE = "follow.html", "follow.csv"


@dataclass(frozen=True, eq=False)
class RunningTest:
    """A test so far. energies_J: (n,) of each of its n loops. wear_mm3_per_J: expected worn volume of both bodies per
    friction energy, None before it is known. looks: diagnoses of the record so far, the first one first.
    """

    record: AnyRecord
    loops: Sequence[FollowedLoop]
    energies_J: Array
    wear_mm3_per_J: float | None
    looks: tuple[Look, ...] = ()
    alarm_rate: float = field(kw_only=True)

    def looked(self, look: Look, wear_mm3_per_J: float | None) -> RunningTest:
        """A copy with one more look, and the wear coefficient that is known by then."""
        return replace(self, looks=(*self.looks, look), wear_mm3_per_J=wear_mm3_per_J)

    @property
    def worn_mm3(self) -> Array:
        """Expected worn volume (n,) of both bodies by the energy so far; NaN where unknown."""
        return self.energies_J * (nan if self.wear_mm3_per_J is None else self.wear_mm3_per_J)

    @property
    def warnings(self) -> tuple[Look, ...]:
        """The looks that alarm and name other causes than the alarm before."""
        found: list[Look] = []
        for look in self.looks:
            if look.alarms and (not found or (found[-1].causes, found[-1].verdict) != (look.causes, look.verdict)):
                found.append(look)
        return tuple(found)

    @property
    def warning(self) -> str | None:
        """The warning of the last look; None if that gives none."""
        warnings = self.warnings
        return self.warned(warnings[-1]) if warnings and warnings[-1] is self.looks[-1] else None

    def warned(self, look: Look) -> str:
        """A warning as text: cycle, time of the test, clock, and the answer."""
        at = hours(look.cycle / self.record.tables.conditions.frequency_Hz)
        # Beyond this odds say no more.
        odds = frame.figure(float(np.exp(min(look.log_odds, 100.0))), 1)
        return (
            f"WARNING at cycle {counted(look.cycle)}, {at} of the test, {look.clock}: {look.sentence} "
            f"(odds for a gap {odds} to 1)"
        )

    def line(self, place: int) -> str:
        """The line printed for the loop with this index: cycle, time, regime, friction, energies, wear so far."""
        loop = self.loops[place]
        begin = f"cycle {counted(loop.cycle):>9}  {hours(loop.time_s)}"
        if loop.refused:
            return f"{begin}  not analysed: {loop.refused}"
        of_friction = f"µ {loop.friction:.3f}" if isfinite(loop.friction) else f"Q*/P {loop.force_ratio:.3f}"
        worn = self.worn_mm3[place]
        wear = f"  worn {frame.figure(worn)} mm³ by {frame.figure(self.wear_mm3_per_J)} mm³/J" if isfinite(worn) else ""
        return (
            f"{begin}  {loop.regime:<12}  {of_friction}  E_d {frame.figure(loop.dissipated_energy_mJ)} mJ  "
            f"ΣE_d {frame.figure(self.energies_J[place])} J{wear}"
        )

    @property
    def alarms_per_hour(self) -> float:
        """False alarms per hour of test, at most."""
        conditions = self.record.tables.conditions
        duration_h: float = conditions.cycles / conditions.frequency_Hz / 3600.0
        return self.alarm_rate / duration_h

    def rows(self) -> list[dict[str, object]]:
        """Rows of the table: figures of each loop, and what is dissipated and worn by then."""
        return [
            {key: value for key, value in vars(loop).items() if key != "refused"}
            | {"energy_J": float(energy), "worn_by_energy_mm3": float(worn), "refused": loop.refused}
            for loop, energy, worn in zip(self.loops, self.energies_J, self.worn_mm3, strict=True)
        ]


def hours(time_s: float) -> str:
    """A duration as hours, minutes and seconds, as in 12:03:59."""
    whole = round(time_s)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"


def write_follow(course: RunningTest, folder: Path, *, ended: bool) -> list[Path]:
    """Write follow.html and follow.csv into a folder and return their paths. Raises ResultError if a file cannot be
    written.
    """
    last, warnings = course.loops[-1], course.warnings
    first = course.record.tables.conditions
    page = frame.rendered(
        HERE / "follow.html",
        {
            "course": course,
            "ended": ended,
            "last": last,
            "cycles": first.cycles,
            "share": min(last.cycle / first.cycles, 1.0),
            "hours": hours,
            "warned": [course.warned(look) for look in warnings],
            "shown": [*enumerate(course.loops)][-12:],
            "picture": frame.inline_svg(svg(lambda: _figure(course)), "course"),
            "refresh_s": 10,  # a browser then reads the page again
            "table": TABLE,
        },
    )
    with writing(ResultError, f"cannot write the page to {folder}"):
        return [write_text(folder / PAGE, page), write_csv(folder / TABLE, course.rows())]


def _figure(course: RunningTest) -> Figure:
    """The last loop; friction, friction energy and worn volume over the cycles; the evidence for a gap at each look."""
    figure = new_figure(5.6)
    loop, friction, energy, odds = panels = [*figure.subplots(2, 2).flat]
    measured = course.record.loops[-1].complete
    draw_loop(loop, measured.displacement_um, measured.tangential_force_N, color=INK, linewidth=1.0)
    name_axes(loop)
    loop.set_title(f"loop of cycle {counted(measured.cycle)}", loc="left")
    cycles = np.array([max(one.cycle, 1) for one in course.loops], dtype=float)
    for axes, values, label in (
        (friction, [one.friction for one in course.loops], "coefficient of friction"),
        (energy, course.energies_J, "friction energy [J]"),
    ):
        axes.plot(cycles, values, "o-", color=VARIANT_COLOURS[0], markersize=3, linewidth=1.0)
        axes.set_ylabel(label)
        cycle_axis(axes)
    if course.wear_mm3_per_J:
        per = 1e3 * course.wear_mm3_per_J
        other = energy.secondary_yaxis("right", functions=(lambda e: per * e, lambda v: v / per))
        other.set_ylabel("worn by energy [10⁻³ mm³]")
    friction.set_ylim(0.0, 1.15 * max([0.1, *(one.friction for one in course.loops if isfinite(one.friction))]))
    friction.set_title("friction", loc="left")
    energy.set_title("energy and wear so far", loc="left")
    at = [look.cycle for look in course.looks]
    odds.plot(at, [max(look.log_odds, 0.0) / np.log(10.0) for look in course.looks], "o-", color=VARIANT_COLOURS[1],
              markersize=3, linewidth=1.0, label="log₁₀ odds for a gap")  # fmt: skip
    odds.plot(at, [look.threshold / np.log(10.0) for look in course.looks], "--", color=GREY, label="an alarm needs")
    odds.set_title("evidence for a gap", loc="left")
    if at:
        cycle_axis(odds)
        odds.legend(loc="best")
    panel_letters(panels)
    return figure
