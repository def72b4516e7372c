"""The example for SLURM, with a stand-in for SLURM's own commands that starts each job on this machine."""

import operator
import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from wirewear.base.cluster import engine_of
from wirewear.base.engine import results_of

ROOT = Path(__file__).resolve().parent.parent

#: Starts what is in the job's script, and tells the job's number as SLURM does.
SBATCH = """#!/bin/sh
cp "$1" "{folder}/job.sh"
setsid sh "{folder}/job.sh" > "{folder}/job.log" 2>&1 &
echo "Submitted batch job $!"
"""
SCANCEL = """#!/bin/sh
kill -- -"$1" 2> /dev/null
"""


@pytest.mark.slow
def test_tasks_are_done_by_jobs_of_slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # On a busy machine a worker may take long to come.
    monkeypatch.setattr("wirewear.base.cluster.PATIENCE_s", 600.0)
    for name, text in {"sbatch": SBATCH.format(folder=tmp_path), "scancel": SCANCEL}.items():
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(0o755)
    environment = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    command = [
        sys.executable,
        str(ROOT / "studies/rig_sensitivity/slurm_cluster.py"),
        "--jobs",
        "1",
        "--queue",
        "short",
    ]
    with subprocess.Popen(command, env=environment, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as cluster:
        assert cluster.stdout is not None
        try:
            address = cluster.stdout.readline().strip()
            assert results_of(engine_of(scheduler=address), [partial(operator.index, 7)]) == [7]
        finally:
            cluster.send_signal(signal.SIGTERM)
    script = (tmp_path / "job.sh").read_text()
    assert "#SBATCH -p short" in script
    assert "--nthreads 1" in script
