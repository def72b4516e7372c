"""Observers of a run: the interface by which a run reports its progress, and the progress bar."""

from dataclasses import dataclass
from types import TracebackType

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn

from solvers import ContactState
from wirewear.base.words import counted
from wirewear.results import RunResult


@dataclass(frozen=True)
class Moment:
    """Progress of a run: cycles done and in all, friction energy, largest worn depth of either body, seconds elapsed.
    fraction: share (0 to 1) of the run that is done, by the logarithm of the cycles.
    """

    cycle: float
    cycles: int
    energy_J: float
    max_depth_um: float
    fraction: float
    elapsed_s: float


def moment_of(state: ContactState, done: float, end: float, elapsed_s: float) -> Moment:
    """The progress of a run of `end` cycles after `done` cycles and `elapsed_s` seconds."""
    deepest = max(float(state.wear.primary_depth.max()), float(state.wear.secondary_depth.max()))
    # Jumps grow with the cycles done, so the logarithm of the cycles is what passes evenly.
    fraction = float(np.log(max(done, 1.0)) / np.log(max(end, 1.0 + 1e-9)))
    return Moment(done, int(end), 1e-3 * state.wear.energy_mJ, 1e3 * deepest, min(fraction, 1.0), elapsed_s)


class Observer:
    """Called by a run to report its progress; must not change anything. This one does nothing."""

    def stage(self, text: str) -> None:
        """Called when a part of the preparation begins, which `text` names."""

    def moved(self, moment: Moment) -> None:
        """Called after every increment."""

    def logged(self, result: RunResult) -> None:
        """Called when a loop has been measured and everything so far is on disk."""

    def note(self, sentence: str) -> None:
        """Called with a sentence that the user of the run should read."""


class ProgressBar(Observer):
    """A bar on the terminal with cycles, energy, depth and time left, open while its `with` block runs.
    If the output is not a terminal, a line for each loop that is measured.
    """

    def __init__(self, label: str, console: Console | None = None) -> None:
        """A bar called `label`, on `console` or, for None, on standard error."""
        self._console = console or Console(stderr=True)
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[state]}", markup=False),
            TimeElapsedColumn(),
            console=self._console,
            disable=not self._console.is_interactive,
        )
        self._label, self._state, self._said = label, "", ""
        self._task: TaskID | None = None

    def __enter__(self) -> "ProgressBar":
        self._progress.start()
        if not self._console.is_interactive:
            self.note(f"{self._label}: preparing the run")
        self._task = self._progress.add_task(self._label, total=1.0, state="")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def stage(self, text: str) -> None:
        self._update(0.0, text)

    def moved(self, moment: Moment) -> None:
        left = _time_left(moment)
        worn = f"  {moment.energy_J:.3g} J  {moment.max_depth_um:.2f} µm deep" if moment.energy_J > 0.0 else ""
        self._update(
            moment.fraction,
            f"cycle {counted(moment.cycle)} of {counted(moment.cycles)}{worn}{f'  {left} left' if left else ''}",
        )

    def logged(self, result: object) -> None:  # noqa: ARG002
        if not self._console.is_interactive and self._state != self._said:
            self._said = self._state
            self.note(f"{self._label}: {self._state}")

    def note(self, sentence: str) -> None:
        self._console.print(f"wirewear: {sentence}", markup=False, highlight=False, soft_wrap=True)

    def _update(self, fraction: float, state: str) -> None:
        self._state = state
        if self._task is not None:
            self._progress.update(self._task, completed=fraction, state=state)


def _time_left(moment: Moment) -> str:
    if moment.fraction < 0.02 or moment.elapsed_s < 2.0:
        return ""
    seconds = moment.elapsed_s * (1.0 - moment.fraction) / moment.fraction
    return f"{seconds:.0f} s" if seconds < 100.0 else f"{seconds / 60.0:.0f} min"
