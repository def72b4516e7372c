"""A Dask cluster on SLURM: prints the scheduler's address and stays until it is interrupted.

    python -m studies.rig_sensitivity.slurm_cluster --jobs 20 --queue normal
    wirewear sweep studies/rig_sensitivity/sweep.toml --output DIR --scheduler ADDRESS     # elsewhere on that machine

Each SLURM job has one worker with one core. DIR must be on a disk that all nodes see.
"""

import signal
import threading

import click

from studies.study_script import StudyScript


@click.command(cls=StudyScript, help=__doc__)
@click.option("--jobs", type=click.IntRange(1), default=2, show_default=True, help="SLURM jobs, one worker each.")
@click.option("--queue", default="normal", show_default=True, help="Partition.")
@click.option("--memory", default="3GB", show_default=True, help="Of one job.")
@click.option("--walltime", default="04:00:00", show_default=True, help="Of one job.")
@click.option("--interface", help="Network interface that nodes reach this machine by, such as ib0.")
def main(jobs: int, queue: str, memory: str, walltime: str, interface: str | None) -> None:
    """Start the jobs and wait."""
    from dask_jobqueue.slurm import SLURMCluster

    stop = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    with SLURMCluster(
        queue=queue,
        cores=1,
        processes=1,
        memory=memory,
        walltime=walltime,
        interface=interface,
        job_script_prologue=["export OPENBLAS_NUM_THREADS=1"],
        scheduler_options={"dashboard_address": None},
    ) as cluster:
        cluster.scale(jobs=jobs)
        click.echo(cluster.scheduler_address)
        stop.wait()


if __name__ == "__main__":
    main()
