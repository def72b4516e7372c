"""The workers of a Dask cluster, wherever they are, and the choice between them and processes of this machine."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import inf
from secrets import token_hex
from typing import TYPE_CHECKING, Any

from wirewear.base.engine import Done, Engine, LocalProcesses, Result
from wirewear.base.errors import EngineError, LostTaskError
from wirewear.base.identity import code_hash

if TYPE_CHECKING:
    from distributed import Client

PATIENCE_s = 20.0  #: How long a scheduler may take to answer, and its first worker to come.
AHEAD = 2  #: Tasks that are sent ahead for each worker, so that none waits for the next.


def engine_of(jobs: int | None = None, scheduler: str | None = None) -> Engine:
    """Processes of this machine, by default one a core, or the cluster whose scheduler is named."""
    if scheduler is not None:
        return DaskCluster(scheduler)
    return LocalProcesses(jobs or os.cpu_count() or 1)


class DaskCluster(Engine):
    """A cluster by the address of its scheduler, such as tcp://10.0.0.1:8786.

    Its workers must run the same program, one thread each: gmsh knows one mesh a process.
    """

    def __init__(self, address: str) -> None:
        """Nothing is reached before it is needed."""
        self.address = address
        self.words = f"the Dask cluster at {address}"
        self._kept: Client | None = None

    @property
    def workers(self) -> int:
        """The number of workers there are now."""
        with self._client() as client:
            return len(_workers(client))

    def done(self, tasks: Sequence[Callable[[], Result]], until: float = inf) -> Iterator[Done[Result]]:
        """Every task as it comes to its end; see `Engine.done`."""
        from distributed import as_completed
        from distributed.client import FutureCancelledError
        from distributed.scheduler import KilledWorker

        with self._client() as client:
            batch = token_hex(4)
            waiting = deque(range(len(tasks)))
            places: dict[Any, int] = {}
            completed = as_completed(loop=client.loop, raise_errors=False)
            while True:
                most = AHEAD * max(len(_workers(client)), 1)
                while waiting and len(places) < most and time.monotonic() < until:
                    place = waiting.popleft()
                    future = client.submit(tasks[place], key=f"wirewear-{batch}-{place}", pure=False)
                    places[future] = place
                    completed.add(future)
                if not places:
                    return
                future = next(completed)
                place = places.pop(future)
                try:
                    yield Done(place, future.result())
                except KilledWorker as problem:
                    yield Done(place, error=LostTaskError(f"every worker that took it was lost: {problem}."))
                except FutureCancelledError:
                    yield Done(place, error=EngineError(f"{self.words} was closed."))
                except Exception as error:  # noqa: BLE001 - whatever a task raises is handed over
                    yield Done(place, error=error)
                finally:
                    future.release()

    @contextmanager
    def held(self) -> Iterator[None]:
        """Within, the cluster is connected to and asked for its program once."""
        if self._kept is not None:
            yield
            return
        with self._connected() as client:
            self._kept = client
            try:
                yield
            finally:
                self._kept = None

    @contextmanager
    def _client(self) -> Iterator[Client]:
        if self._kept is not None:
            yield self._kept
            return
        with self._connected() as client:
            yield client

    @contextmanager
    def _connected(self) -> Iterator[Client]:
        try:
            from distributed import Client
            from distributed.comm.addressing import get_address_host_port
        except ImportError:
            raise EngineError(
                "clusters are reached by Dask, which is not installed: pip install 'wirewear[cluster]'."
            ) from None
        try:
            # A client that is refused its address is not closed before long, and with a traceback.
            if not self.address.startswith("inproc"):
                get_address_host_port(self.address)
            client = Client(self.address, timeout=PATIENCE_s, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as problem:
            raise EngineError(f"no Dask scheduler answers at {self.address!r} ({_first_line(problem)}).") from None
        with client:
            self._require_fit(client)
            yield client

    def _require_fit(self, client: Client) -> None:
        try:
            client.wait_for_workers(1, timeout=PATIENCE_s)
        except TimeoutError:
            raise EngineError(f"{self.words} has no workers: start some by `dask worker {self.address}`.") from None
        threads = {worker["nthreads"] for worker in _workers(client).values()}
        if threads != {1}:
            raise EngineError(
                f"workers of {self.words} have {max(threads)} threads, where gmsh needs processes of their own: start "
                "them with --nthreads 1, and --nworkers for more of them."
            )
        programs = client.run(_program, on_error="return")
        others = [worker for worker, program in programs.items() if program != _program()]
        if others:
            raise EngineError(
                f"{len(others)} of {len(programs)} workers of {self.words} run another version of wirewear, or none "
                f"(first: {others[0]}): install this one there."
            )


def _workers(client: Client) -> dict[str, Any]:
    found: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return found


def _program() -> str:
    return code_hash()


def _first_line(problem: BaseException) -> str:
    return next(iter(str(problem).splitlines()), type(problem).__name__)
