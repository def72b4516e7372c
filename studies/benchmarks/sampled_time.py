"""Where a program's CPU time goes, by looking at its stack every few milliseconds.

A profiler that follows every call would weigh on functions that are called often; this one costs next to nothing.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Mapping
from types import FrameType, TracebackType

#: A function: end of its file's path, and its name.
Function = tuple[str, str]

_PERIOD_s = 0.002


class SampledTime:
    """Context manager that gives CPU time of this thread to parts of the program; in the main thread, on Unix only.

    parts: functions of each part. Time goes to the innermost function that is named, and what belongs to none to
    "rest". A sample counts with the CPU time since the one before, as signals wait while compiled code runs.
    """

    def __init__(self, parts: Mapping[str, tuple[Function, ...]]) -> None:
        """Nothing is sampled before the context is entered."""
        self._part = {function: part for part, functions in parts.items() for function in functions}
        self._names = {name for _, name in self._part}
        self._seconds: dict[str, float] = dict.fromkeys([*parts, "rest"], 0.0)
        self._known: dict[tuple[str, str], str | None] = {}
        self._last = 0.0

    @property
    def seconds(self) -> dict[str, float]:
        """CPU seconds of each part and of the rest."""
        return dict(self._seconds)

    def __enter__(self) -> SampledTime:
        self._last = time.process_time()
        self._before = signal.signal(signal.SIGPROF, self._sample)
        signal.setitimer(signal.ITIMER_PROF, _PERIOD_s, _PERIOD_s)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, self._before)

    def _sample(self, _signal: int, frame: FrameType | None) -> None:
        now = time.process_time()
        self._seconds[self._part_of(frame)] += now - self._last
        self._last = now

    def _part_of(self, frame: FrameType | None) -> str:
        while frame is not None:
            if frame.f_code.co_name in self._names:
                part = self._named(frame.f_code.co_filename, frame.f_code.co_name)
                if part is not None:
                    return part
            frame = frame.f_back
        return "rest"

    def _named(self, file: str, name: str) -> str | None:
        if (file, name) not in self._known:
            found = (part for (end, function), part in self._part.items() if function == name and file.endswith(end))
            self._known[file, name] = next(found, None)
        return self._known[file, name]
