"""What an engine is: it does tasks that do not depend on one another, and hands over each as it is done."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from typing import Generic, TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True)
class Done(Generic[Result]):
    """A task that came to its end: `place` among the tasks, and what it returned, or what it raised."""

    place: int
    result: Result | None = None
    error: BaseException | None = None

    def value(self) -> Result:
        """What it returned; raises what it raised."""
        if self.error is not None:
            raise self.error
        return self.result  # type: ignore[return-value]


class Engine(ABC):
    """Does tasks, each in a process that does nothing else meanwhile.

    A task is a function without arguments that can be pickled, as can what it returns. When its process is lost, it is
    begun once more; it is handed over once, however often it was begun.
    """

    #: In a message: what the engine works with.
    words: str

    @property
    @abstractmethod
    def workers(self) -> int:
        """How many tasks it does at a time.

        Raises:
            EngineError: there is nobody to do them.
        """

    @contextmanager
    def held(self) -> Iterator[None]:
        """Within, what is needed to reach those that do the tasks is set up once and kept."""
        yield

    @abstractmethod
    def done(self, tasks: Sequence[Callable[[], Result]], until: float = inf) -> Iterator[Done[Result]]:
        """Every task as it comes to its end; none is begun after `until` (of time.monotonic).

        When the caller stops asking, those that run come to their end, and no other is begun.

        Raises:
            EngineError: the cluster cannot be reached, or runs another program.
        """


def results_of(engine: Engine, tasks: Sequence[Callable[[], Result]]) -> list[Result]:
    """What the tasks return, in their order; raises the first error that one of them raised, once all are done."""
    every = sorted(engine.done(tasks), key=lambda one: one.place)
    return [one.value() for one in every]
