"""One engine for many tasks: processes of this machine, or the workers of a Dask cluster."""

from wirewear.engine.choice import engine_of
from wirewear.engine.engine import Done, Engine, results_of
from wirewear.engine.processes import LocalProcesses

__all__ = ["Done", "Engine", "LocalProcesses", "engine_of", "results_of"]
