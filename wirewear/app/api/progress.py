"""Progress bars for notebooks and terminals."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from types import TracebackType
from typing import TYPE_CHECKING

from wirewear.base.words import counted
from wirewear.simulation import Moment, Observer, ProgressBar

if TYPE_CHECKING:
    from IPython.display import DisplayHandle

LEAST_PAUSE_s = 0.3  #: Seconds between two drawings of the bar.


def in_notebook() -> bool:
    """True if the program runs in a notebook's kernel."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return type(shell).__name__ == "ZMQInteractiveShell"


class NotebookBar(Observer):
    """Observer that shows a run's progress as a bar that is redrawn in place in a notebook; used as a context
    manager.
    """

    def __init__(self, label: str) -> None:
        """Prepare a bar with this label; it appears when the context is entered."""
        self._label, self._notes = label, list[str]()
        self._handle: DisplayHandle | None = None
        self._drawn = -LEAST_PAUSE_s
        self._last = (0.0, "")

    def __enter__(self) -> NotebookBar:
        from IPython.display import HTML, display

        self._handle = display(HTML(self.html()), display_id=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._draw()

    def stage(self, text: str) -> None:
        self._last = (0.0, text)
        self._draw()

    def moved(self, moment: Moment) -> None:
        """Show cycle, energy and depth, at most once in LEAST_PAUSE_s."""
        depth = f"{moment.max_depth_um:.2f} µm deep"
        self._last = (
            moment.fraction,
            f"cycle {counted(moment.cycle)} of {counted(moment.cycles)}, {moment.energy_J:.3g} J, {depth}",
        )
        if time.monotonic() - self._drawn >= LEAST_PAUSE_s:
            self._draw()

    def logged(self, result: object) -> None:
        """Do nothing: logged results are not shown."""

    def note(self, sentence: str) -> None:
        self._notes.append(sentence)
        self._draw()

    def html(self) -> str:
        """HTML of the bar in its present state."""
        share, state = self._last
        notes = "".join(f"<br><small>{escape(note)}</small>" for note in self._notes)
        return f"{escape(self._label)} <progress value='{share:.4f}' max='1'></progress> {escape(state)}{notes}"

    def _draw(self) -> None:
        from IPython.display import HTML

        self._drawn = time.monotonic()
        if self._handle is not None:
            self._handle.update(HTML(self.html()))


@contextmanager
def watched(label: str, *, shown: bool) -> Iterator[Observer]:
    """Context that yields the observer of a run: a notebook's or a terminal's progress bar, or one that shows nothing
    if not `shown`.
    """
    if not shown:
        yield Observer()
    elif in_notebook():
        with NotebookBar(label) as bar:
            yield bar
    else:
        with ProgressBar(label) as terminal:
            yield terminal
