"""Which engine does the tasks of a command."""

import os

from wirewear.base.cluster import DaskCluster
from wirewear.base.engine import Engine
from wirewear.base.local_processes import LocalProcesses


def engine_of(jobs: int | None = None, scheduler: str | None = None) -> Engine:
    """Processes of this machine, by default one a core, or the cluster whose scheduler is named."""
    if scheduler is not None:
        return DaskCluster(scheduler)
    return LocalProcesses(jobs or os.cpu_count() or 1)
