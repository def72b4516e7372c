"""What reads inputs by itself, with files as they should be."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from studies.blind import generator_of, make_batch
from studies.blind.scoring.answers import read_answer
from studies.blind.scoring.history import LOG
from studies.blind.scoring.score import verified
from tests.robustness.commands import LINE_MAPPING, MAPPING, STUDY
from tests.robustness.made_files import ANSWER, made_runs, scored
from tests.robustness.record_mutations import small_record
from wirewear import check_record, parse_study, read_record, read_results, run_study, write_result
from wirewear.base.hdf5 import sealed
from wirewear.diagnosis.surrogate.nominal import nominal_run
from wirewear.kinds import load_any_study
from wirewear.records.importing import import_record
from wirewear.records.importing.loop_sources import read_loops
from wirewear.results import read_results as read_runs
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.store import CHECKPOINT_FILE_NAME, read_checkpoint
from wirewear.sweeps import load_sweep
from wirewear.sweeps.running import Journal
from wirewear.sweeps.sweep import SweepRow
from wirewear.views.loops_report import analyse_loops

STUDIES = Path(__file__).parents[2] / "studies"

Files = Mapping[str, bytes]


@dataclass(frozen=True)
class Reader:
    """Files as they should be, which of them are mutated, and what reads them in a folder.

    writes: where in the folder it may write (blind scores are logged beside batch and key).  share: of the trials of
    the others.  finish: what is done to mutants so that they get further.  stand_ins: what stands in for parts of the
    program, named as module:name, that would simulate for longer than a mutant is worth.  usual: what it starts and
    loads with files as they should be.
    """

    files: Files
    mutated: Sequence[str]
    read: Callable[[Path], object]
    writes: tuple[str, ...] = ()
    share: float = 1.0
    finish: Callable[[bytes], bytes] | None = None
    stand_ins: Mapping[str, object] = field(default_factory=dict)
    usual: frozenset[str] = frozenset()


def studied(folder: Path) -> object:
    """A study of wires, as far as its plan and what that takes."""
    study = parse_study((folder / "study.toml").read_text(encoding="utf-8", errors="surrogateescape"), "study.toml")
    plans = [PointRun.of(one, "quick") for one in [study.variant(name) for name in study.variant_names] or [study]]
    for plan in plans:
        plan.require_affordable()
    return plans


def unsealed(data: bytes) -> bytes:
    """A record's file without the lines of checksums, so that mutants get further."""
    return b"".join(line for line in data.splitlines(keepends=True) if not line.startswith(b"# sha256 "))


def of_study(name: str, file: str = "study.toml") -> bytes:
    """A file of one of the studies."""
    return (STUDIES / name / file).read_bytes()


@dataclass(frozen=True)
class Made:
    """The files that `make` has left in a folder."""

    base: Path

    def bytes_of(self, place: str) -> bytes:
        """A file of the folder."""
        return (self.base / place).read_bytes()

    def folder(self, place: str, name: str) -> dict[str, bytes]:
        """The files of a folder, in a folder of that name, without the checksums of records."""
        files = (path for path in (self.base / place).iterdir() if path.is_file())
        return {f"{name}/{path.name}": unsealed(path.read_bytes()) for path in files}

    @property
    def batch(self) -> dict[str, bytes]:
        """A small batch of blind records, with an answer to one: its files by their place."""
        files = (path for path in (self.base / "blind").rglob("*") if path.is_file())
        return {path.relative_to(self.base / "blind").as_posix(): path.read_bytes() for path in files}


def make(base: Path) -> None:
    """Make what readers are to read: runs, records, a batch, a sweep under way, a nominal run."""
    made_runs(base / "runs")
    study = parse_study(STUDY, "study.toml")
    once = study.changed({"conditions": {"cycles": 1}, "log": {"loop_cycles": (1,)}})
    run_study(once, fidelity="quick", output=base / "run")
    write_result(base / "nominal" / "result.h5", nominal_run(study))
    _make_batch(base / "blind")
    _begin_sweep(base / "sweep")


def _make_batch(folder: Path) -> None:
    make_batch(folder / "batch", cases=2, tests=1, seed=4, generator=generator_of("T2"))
    (folder / "diagnoses" / "case_001").mkdir(parents=True)
    (folder / "diagnoses" / "case_001" / "diagnosis.json").write_text(json.dumps(ANSWER))
    scored(folder)


def _begin_sweep(folder: Path) -> None:
    """The rows of a sweep, some of which are there."""
    folder.mkdir()
    for name in ("study.toml", "sweep.toml"):
        (folder / name).write_bytes(of_study("rig_sensitivity", name))
    (folder / "out").mkdir()
    journal = Journal(folder / "out", load_sweep(folder / "sweep.toml").identity)
    journal.rows_so_far()
    with journal.open() as file:
        for number in (1, 2):
            journal.add(file, SweepRow(number, {"max_pressure_MPa": 400.0}, cpu_s=1.0, peak_bytes=10**8))
        journal.add(file, SweepRow(3, None, "the contact did not converge"))


#: A batch's files whose mutants are of interest.
OF_BATCH = ("batch/manifest.json", "batch/key.json.enc", "batch.key", "batch/case_001/loops.csv")
BATCH_LOG = f"batch/{LOG}"


def readers(made: Made) -> dict[str, Reader]:
    """Every reader, by name."""
    record, batch = small_record(), made.batch
    study = {"study.toml": of_study("steel_wires")}
    sweep = {name: of_study("rig_sensitivity", name) for name in ("study.toml", "sweep.toml")}
    planar = {"s.toml": of_study("cylinder_on_flat")}
    mapping = {"mapping.toml": MAPPING.encode(), "record/loops.csv": record["loops.csv"]}
    loops, answer = {"l.csv": record["loops.csv"]}, {"d.json": batch["diagnoses/case_001/diagnosis.json"]}
    result, flat = {"result.h5": made.bytes_of("run/result.h5")}, {"result.h5": made.bytes_of("runs/planar/result.h5")}
    stopped = {CHECKPOINT_FILE_NAME: made.bytes_of(f"runs/stopped/{CHECKPOINT_FILE_NAME}")}
    line = made.folder("runs/line_record", "record")
    profiles = {"mapping.toml": LINE_MAPPING.encode()}
    profiles |= {name: line[name] for name in ("record/loops.csv", "record/profile_specimen.csv")}
    return {
        "study": Reader(study, tuple(study), studied),
        "planar study": Reader(planar, tuple(planar), lambda at: load_any_study(at / "s.toml")),
        "sweep": Reader(sweep, ("sweep.toml", *sweep), lambda at: load_sweep(at / "sweep.toml").identity,
                        share=0.3),
        "record": Reader(record, tuple(record), lambda at: check_record(read_record(at)).to_json()),
        "line record": Reader(line, tuple(line), lambda at: check_record(read_record(at / "record"))),
        "mapping": Reader(mapping, tuple(mapping), lambda at: import_record(at / "mapping.toml")),
        "line mapping": Reader(profiles, tuple(profiles), lambda at: import_record(at / "mapping.toml")),
        "loops": Reader(loops, tuple(loops), lambda at: analyse_loops(read_loops(at / "l.csv")[:3])),
        "answer": Reader(answer, tuple(answer), lambda at: read_answer(at / "d.json")),
        "batch": Reader(batch, OF_BATCH, lambda at: verified(at / "batch", at / "batch.key")),
        "log": Reader(batch, (BATCH_LOG,), scored, (".",)),
        "result": Reader(result, tuple(result), read_results),
        "sealed result": Reader(result, tuple(result), read_results, finish=sealed),
        "checkpoint": Reader(stopped, tuple(stopped), read_checkpoint, finish=sealed),
        "planar result": Reader(flat, tuple(flat), read_runs, finish=sealed),
    }  # fmt: skip
