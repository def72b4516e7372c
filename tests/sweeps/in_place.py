"""An engine that does its tasks in this process."""

from collections.abc import Callable, Iterator, Sequence
from math import inf

from wirewear.base.engine import Done, Engine, Result


class InPlace(Engine):
    """Does tasks here, one after another, in any order, and stops after some."""

    words = "this process"

    @property
    def workers(self) -> int:
        return 2

    def __init__(self, most: float = inf, backwards: bool = False) -> None:
        self.most, self.backwards, self.started = most, backwards, 0

    def done(
        self,
        tasks: Sequence[Callable[[], Result]],
        until: float = inf,  # noqa: ARG002
    ) -> Iterator[Done[Result]]:
        for place in reversed(range(len(tasks))) if self.backwards else range(len(tasks)):
            if self.started >= self.most:
                raise KeyboardInterrupt
            self.started += 1
            yield Done(place, tasks[place]())
