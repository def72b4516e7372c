"""CalculiX running in its folder: what each of its increments took, by the moments at which it reported them."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from .calculix_results import read_completed
from .measured_process import ProcessCost, Usage, run_measured

JOB = "wires"  #: CalculiX's name of the job: the deck is wires.inp.


@dataclass(frozen=True)
class Completed:
    """A finished increment: total time in the deck's steps; wall and CPU seconds of the run until then."""

    time: float
    wall_s: float
    cpu_s: float


@dataclass(frozen=True)
class CalculixRun:
    """The run as a whole and its increments in order."""

    cost: ProcessCost
    completed: tuple[Completed, ...]


@dataclass(frozen=True)
class SlidingCost:
    """Sliding increments that were finished, and seconds for each of them: CPU and wall."""

    increments: int
    cpu_s: float
    wall_s: float


class Completions:
    """Watches CalculiX's .sta file, to which it adds a line whenever an increment has converged."""

    def __init__(self, sta: Path, announce: Callable[[Completed], None]) -> None:
        """Nothing is completed yet; announce is called with every increment."""
        self._sta = sta
        self._announce = announce
        self._size = 0
        self._completed: list[Completed] = []

    @property
    def completed(self) -> tuple[Completed, ...]:
        return tuple(self._completed)

    def __call__(self, used: Usage) -> None:
        """Put what has been used until now to every increment that is new."""
        size = self._sta.stat().st_size if self._sta.exists() else 0
        if size == self._size:
            return
        self._size = size
        times = read_completed(self._sta.read_text(encoding="ascii", errors="replace"))
        for time in times[len(self._completed) :]:
            self._completed.append(Completed(time, used.wall_s, used.cpu_s))
            self._announce(self._completed[-1])


def run_calculix(
    program: str, folder: Path, most_s: float, announce: Callable[[Completed], None] = lambda _: None
) -> CalculixRun:
    """Run the deck in a folder on one thread, for at most so many wall seconds. Results of a run before are removed.

    announce: called with every increment when it is finished.
    """
    for suffix in ("sta", "dat", "frd", "cvg"):
        (folder / f"{JOB}.{suffix}").unlink(missing_ok=True)
    completions = Completions(folder / f"{JOB}.sta", announce)
    cost = run_measured(
        [program, "-i", JOB],
        folder,
        folder / "calculix.log",
        # What it wrote of finished increments would else be lost in a buffer when it is stopped.
        environment={"GFORTRAN_UNBUFFERED_ALL": "1"},
        most_s=most_s,
        watch=completions,
    )
    completions(Usage(cost.wall_s, cost.cpu_s, cost.peak_memory_MB))
    return CalculixRun(cost, completions.completed)


def sliding_cost(completed: tuple[Completed, ...], pressed: float, moments: tuple[float, ...]) -> SlidingCost | None:
    """Cost of the increments between the end of the normal load and the last of `moments` that was reached.

    pressed, moments: total times. What came before, increments cut into several included, and what was still going on
    at the end do not count. None when none was finished.
    """
    at = {moment: one for moment in (pressed, *moments) for one in completed if abs(one.time - moment) < 1e-3}
    reached = [moment for moment in moments if moment in at]
    if pressed not in at or not reached:
        return None
    first, last, count = at[pressed], at[reached[-1]], len(reached)
    return SlidingCost(count, (last.cpu_s - first.cpu_s) / count, (last.wall_s - first.wall_s) / count)
