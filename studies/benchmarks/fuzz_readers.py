"""What reads inputs: every reader by itself, and the commands, each with files as they should be."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from click.testing import CliRunner

from wirewear import WirewearError, check_record, parse_study, read_record, read_results, run_study
from wirewear.blind import generator_of, make_batch
from wirewear.blind.scoring.answers import read_answer
from wirewear.blind.scoring.history import LOG
from wirewear.blind.scoring.score import verified
from wirewear.cli.commands import cli
from wirewear.cli.study_kinds import load_any_study
from wirewear.files.hdf5 import sealed
from wirewear.loops.loop_report import analyse_loops, read_loops
from wirewear.planar.results import read_planar_result
from wirewear.records.importing import import_record
from wirewear.simulation.budget import require_affordable
from wirewear.simulation.checkpoint import CHECKPOINT_FILE_NAME, read_checkpoint
from wirewear.simulation.plan import RunPlan
from wirewear.tribometers.rows import read_rows

from .flipped_bits import ANSWER, made_runs, scored
from .hard_pressed import MAPPING, STUDY
from .record_mutations import small_record

STUDIES = Path(__file__).parent.parent

#: Of the trials of a reader that takes a hundredth of a second, those of one that draws or simulates.
DEAR = 0.03


@dataclass(frozen=True)
class Reader:
    """Files as they should be, which of them are mutated, and what reads them in a folder.

    writes: where in the folder it may write (blind scores are logged beside batch and key).  share: of the trials of
    the others.  finish: what is done to mutants so that they get further.
    """

    files: Mapping[str, bytes]
    mutated: Sequence[str]
    read: Callable[[Path], object]
    writes: tuple[str, ...] = ()
    share: float = 1.0
    finish: Callable[[bytes], bytes] | None = None


def command(*arguments: str) -> Callable[[Path], object]:
    """What gives a command its arguments, with the folder in place of {}; a refusal is raised as an error."""

    def give(folder: Path) -> object:
        asked = [argument.replace("{}", str(folder)) for argument in arguments]
        ended = CliRunner().invoke(cli, asked)
        if ended.exception is not None and not isinstance(ended.exception, SystemExit):
            raise ended.exception
        if ended.exit_code == 2:
            told = [line for line in ended.stderr.splitlines() if line.startswith("wirewear: ")]
            raise WirewearError(told[-1] if told else "")
        return ended.output

    return give


def studied(folder: Path) -> object:
    """A study of wires, as far as its plan and what that takes."""
    study = parse_study((folder / "study.toml").read_text(encoding="utf-8", errors="surrogateescape"), "study.toml")
    plans = [RunPlan.of(one, "quick") for one in [study.variant(name) for name in study.variant_names] or [study]]
    for plan in plans:
        require_affordable(plan)
    return plans


def made_batch(folder: Path) -> dict[str, bytes]:
    """A small batch of blind records, with an answer to one: its files by their place."""
    make_batch(folder / "batch", cases=2, tests=1, seed=4, generator=generator_of("T2"))
    (folder / "diagnoses" / "case_001").mkdir(parents=True)
    (folder / "diagnoses" / "case_001" / "diagnosis.json").write_text(json.dumps(ANSWER))
    scored(folder)
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def made_result(folder: Path) -> bytes:
    """A short run's result."""
    study = parse_study(STUDY, "study.toml").changed({"conditions": {"cycles": 1}, "log": {"loop_cycles": (1,)}})
    run_study(study, fidelity="quick", output=folder)
    return (folder / "result.h5").read_bytes()


def unsealed(data: bytes) -> bytes:
    """A record's file without the lines of checksums, so that mutants get further."""
    return b"".join(line for line in data.splitlines(keepends=True) if not line.startswith(b"# sha256 "))


def readers(base: Path) -> dict[str, Reader]:
    """Every reader and command, by name."""
    record = small_record()
    batch = made_batch(base / "made")
    made_runs(base / "runs")
    planar = {"s.toml": (STUDIES / "cylinder_on_flat" / "study.toml").read_bytes()}
    rig = {"s.toml": (STUDIES / "rig_stiffness_2d" / "study.toml").read_bytes()}
    study = {"study.toml": (STUDIES / "steel_wires" / "study.toml").read_bytes()}
    tribometers = {"t.csv": (STUDIES / "tribometers" / "tribometers.csv").read_bytes()}
    mapping = {"mapping.toml": MAPPING.encode(), "record/loops.csv": record["loops.csv"]}
    loops, answer = {"l.csv": record["loops.csv"]}, {"d.json": batch["diagnoses/case_001/diagnosis.json"]}
    result = {"result.h5": made_result(base / "run")}
    stopped = {CHECKPOINT_FILE_NAME: (base / "runs" / "stopped" / CHECKPOINT_FILE_NAME).read_bytes()}
    flat = {"result.h5": (base / "runs" / "planar" / "result.h5").read_bytes()}
    own = {f"record/{path.name}": unsealed(path.read_bytes()) for path in (base / "runs" / "record").iterdir()}
    both = {**own, "result.h5": (base / "runs" / "result" / "result.h5").read_bytes()}
    modelled = {**own, "study.toml": STUDY.encode()}
    of_batch = ("batch/manifest.json", "batch/key.json.enc", "batch.key", "batch/case_001/loops.csv")
    log = f"batch/{LOG}"
    tables = [*own]
    diagnose = command("diagnose", "{}/record", "--model", "{}/study.toml", "--output", "{}/out", "--jobs", "1")
    score = command("blind", "score", "{}/batch", "{}/diagnoses", "--key", "{}/batch.key", "--output", "{}/out")
    return {
        "study": Reader(study, tuple(study), studied),
        "planar study": Reader(planar, tuple(planar), lambda at: load_any_study(at / "s.toml")),
        "rig study": Reader(rig, tuple(rig), lambda at: load_any_study(at / "s.toml")),
        "record": Reader(record, tuple(record), lambda at: check_record(read_record(at)).to_json()),
        "mapping": Reader(mapping, tuple(mapping), lambda at: import_record(at / "mapping.toml")),
        "loops": Reader(loops, tuple(loops), lambda at: analyse_loops(read_loops(at / "l.csv")[:3])),
        "tribometers": Reader(tribometers, tuple(tribometers), lambda at: read_rows(at / "t.csv")),
        "answer": Reader(answer, tuple(answer), lambda at: read_answer(at / "d.json")),
        "batch": Reader(batch, of_batch, lambda at: verified(at / "batch", at / "batch.key")),
        "log": Reader(batch, (log,), scored, (".",)),
        "result": Reader(result, tuple(result), read_results),
        "sealed result": Reader(result, tuple(result), read_results, finish=sealed),
        "checkpoint": Reader(stopped, tuple(stopped), read_checkpoint, finish=sealed),
        "planar result": Reader(flat, tuple(flat), read_planar_result, finish=sealed),
        "wirewear check": Reader(record, tuple(record), command("check", "{}", "--json"), share=0.5),
        "wirewear import": Reader(
            mapping, tuple(mapping), command("import", "{}/mapping.toml", "--output", "{}/out"), ("out",), 0.5
        ),
        "wirewear loops": Reader(loops, tuple(loops), command("loops", "{}/l.csv", "--json"), share=0.3),
        "wirewear tribometers": Reader(
            tribometers, tuple(tribometers), command("tribometers", "{}/t.csv", "--json"), share=DEAR
        ),
        "wirewear export": Reader(
            result, tuple(result), command("export", "{}", "--as-record", "{}/out", "--samples", "40"), ("out",), 0.3,
            sealed,
        ),
        "wirewear blind score": Reader(batch, (*of_batch, log, "diagnoses/case_001/diagnosis.json"), score,
                                       (".",), DEAR),
        "wirewear mesh": Reader(modelled, ("study.toml",),
                                command("mesh", "{}/study.toml", "--fidelity", "quick", "--output", "{}/out"),
                                ("out",), DEAR),
        "wirewear show": Reader(result, tuple(result), command("show", "{}", "--output", "{}/out"), ("out",), DEAR,
                                sealed),
        "wirewear compare": Reader(both, tables, command("compare", "{}", "{}/record", "--output", "{}/out"), ("out",),
                                   DEAR),
        "wirewear diagnose": Reader(modelled, (*tables, "study.toml"), diagnose, ("out",), DEAR),
    }  # fmt: skip
