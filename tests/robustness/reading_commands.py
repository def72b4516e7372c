"""The commands that read inputs, with files as they should be.

Commands that simulate are stopped where that would begin: all that stands before it is what mutants are to get through.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
from click.testing import CliRunner

from studies.blind.commands import exam
from tests.robustness.commands import MAPPING, STUDY
from tests.robustness.readers import BATCH_LOG, OF_BATCH, Made, Reader, of_study
from tests.robustness.record_mutations import small_record
from wirewear import WirewearError, read_result
from wirewear.app.cli.commands import cli
from wirewear.base.hdf5 import sealed
from wirewear.results import RunResult
from wirewear.sweeps.running import JOURNAL

#: Of the trials of a reader that takes a hundredth of a second, those of one that takes a tenth, or a second.
DEAR, DEAREST = 0.1, 0.03

_BEGINS = "the simulation would begin."


def _begin(*_: object, **__: object) -> Any:
    raise WirewearError(_BEGINS)


#: Where commands begin to simulate.
BEGINNING = dict.fromkeys(
    (
        "wirewear.simulation.runs:cycle_through",
        "wirewear.simulation.point_runs:condense_bodies",
        "wirewear.diagnosis.fit.sensor_calibration:contact_problem",
        "wirewear.simulation.runs:run_side_by_side",
        "wirewear.base.engine:LocalProcesses.done",
    ),
    _begin,
)


def command(*arguments: str, of: click.Command = cli) -> Callable[[Path], object]:
    """What gives a command its arguments, with the folder in place of {}; a refusal is raised as an error."""

    def give(folder: Path) -> object:
        asked = [argument.replace("{}", str(folder)) for argument in arguments]
        ended = CliRunner().invoke(of, asked)
        if ended.exception is not None and not isinstance(ended.exception, SystemExit):
            raise ended.exception
        if ended.exit_code == 2:
            messages = [line for line in ended.stderr.splitlines() if line.startswith("wirewear: ")]
            if not messages or _BEGINS not in messages[-1]:
                raise WirewearError(messages[-1] if messages else "")
        return ended.output

    return give


def commands(made: Made) -> dict[str, Reader]:
    """Every command that reads inputs, by name."""
    return {f"wirewear {name}": reader for name, reader in {**_on_studies(made), **_on_records(made)}.items()} | {
        f"wirewear {name}": reader for name, reader in _on_results(made).items()
    }


def _running(files: dict[str, bytes], mutated: tuple[str, ...], *arguments: str, **more: Any) -> Reader:
    """A command that is stopped where it begins to simulate."""
    options = {"writes": ("out",), "share": DEAR, "stand_ins": BEGINNING, **more}
    return Reader(files, mutated, command(*arguments), **options)


def _on_studies(made: Made) -> dict[str, Reader]:
    wires, variants = {"study.toml": STUDY.encode()}, {"study.toml": of_study("steel_wires")}
    scattered = {"study.toml": STUDY.encode() + b"[scatter]\nfriction = 0.05\nnormal_load = 0.02\nwear = 0.2\n"}
    flat = {"study.toml": of_study("cylinder_on_flat")}
    sweep = {name: of_study("rig_sensitivity", name) for name in ("study.toml", "sweep.toml")}
    stopped = {
        f"out/{path.name}": path.read_bytes() for path in (made.base / "runs/stopped").iterdir() if path.is_file()
    }
    resumed = {**wires, **stopped}
    own = ("study.toml",)
    run = ("run", "{}/study.toml", "--fidelity", "quick", "--output", "{}/out", "--jobs", "1")
    refine = ("{}/study.toml", "--fidelity", "quick", "--output", "{}/out", "--jobs", "1")
    swept = ("sweep", "{}/sweep.toml", "--output", "{}/out", "--jobs", "1")
    journal = {f"out/{JOURNAL}": made.bytes_of(f"sweep/out/{JOURNAL}")}
    record = made.folder("runs/record", "record")
    logged = {**wires, **record}
    return {
        "run": _running(wires, own, *run, share=0.3),
        "run, variants": _running(variants, own, *run, share=0.3),
        "run, line contact": _running(flat, own, *run),
        "run --uncertain": _running(scattered, own, *run, "--uncertain"),
        "run --cycles-of": _running(logged, (*own, *record), *run, "--cycles-of", "{}/record"),
        "run --resume": _running(resumed, (*own, *stopped), *run, "--resume"),
        "run --resume, sealed": _running(resumed, ("out/checkpoint.h5", "out/result.h5"), *run, "--resume",
                                       finish=sealed),
        "converge": _running(wires, own, "converge", *refine),
        "sweep": _running(sweep, ("sweep.toml", "sweep.toml", "study.toml"), *swept),
        "sweep, gone on with": _running({**sweep, **journal}, tuple(journal), *swept),
        "mesh": Reader(wires, own, command("mesh", *refine[:-2]), ("out",), DEAREST),
        "calibrate": _running(wires, own, "calibrate", "{}/study.toml", "--fidelity", "quick"),
        "new": Reader(record, tuple(record), command("new", "x", "--from", "{}/record", "--output", "{}/out/x.toml"),
                      ("out",), 0.3),
    }  # fmt: skip


def _on_records(made: Made) -> dict[str, Reader]:
    record, batch = small_record(), made.batch
    own, line = made.folder("runs/record", "record"), made.folder("runs/line_record", "record")
    mapping = {"mapping.toml": MAPPING.encode(), "record/loops.csv": record["loops.csv"]}
    loops = {"l.csv": record["loops.csv"]}
    modelled, tables = {**own, "study.toml": STUDY.encode()}, tuple(own)

    nominal = read_result(made.base / "nominal")

    def known(*_: object, **__: object) -> RunResult:
        return nominal

    stand_ins = {"wirewear.diagnosis.surrogate.nominal:nominal_run": known}
    diagnose = command("diagnose", "{}/record", "--model", "{}/study.toml", "--output", "{}/out", "--jobs", "1")
    score = command("score", "{}/batch", "{}/diagnoses", "--key", "{}/batch.key", "--output", "{}/out", of=exam)
    fit = command("fit", "{}/record", "--check", "none", "--output", "{}/out")
    guess = command("new", "--mapping", "{}/l.csv", "--diameter", "0.45", "--output", "{}/m.toml")
    return {
        "check": Reader(record, tuple(record), command("check", "{}", "--json"), share=0.5),
        "check, line contact": Reader(line, tuple(line), command("check", "{}/record", "--json"), share=0.3),
        "import": Reader(mapping, tuple(mapping), command("import", "{}/mapping.toml", "--output", "{}/out/record"),
                         ("out",), 0.5),
        "new --mapping": Reader(loops, tuple(loops), guess, (".",), 0.3),
        "loops": Reader(loops, tuple(loops), command("loops", "{}/l.csv", "--json"), share=0.3),
        "fit": Reader(own, tables, fit, ("out",), DEAREST, stand_ins=stand_ins),
        "diagnose": Reader(modelled, (*tables, "study.toml"), diagnose, ("out",), DEAREST, stand_ins=stand_ins),
        "blind score": Reader(batch, (*OF_BATCH, BATCH_LOG, "diagnoses/case_001/diagnosis.json"), score, (".",),
                              DEAREST),
    }  # fmt: skip


def _on_results(made: Made) -> dict[str, Reader]:
    result, flat = {"result.h5": made.bytes_of("run/result.h5")}, {"result.h5": made.bytes_of("runs/planar/result.h5")}
    own, line = made.folder("runs/record", "record"), made.folder("runs/line_record", "record")
    both, both_flat = {**own, "result.h5": made.bytes_of("runs/result/result.h5")}, {**flat, **line}
    export = ("export", "{}", "--as-record", "{}/out/record", "--samples", "40")
    compare = command("compare", "{}", "{}/record", "--output", "{}/out")
    out = ("--output", "{}/out")

    def sealed_of(files: dict[str, bytes], share: float, *arguments: str) -> Reader:
        return Reader(files, ("result.h5",), command(*arguments), ("out",), share, sealed)

    return {
        "export": sealed_of(result, 0.3, *export),
        "export, line contact": sealed_of(flat, 0.3, *export, "--length", "5"),
        "show": sealed_of(result, DEAREST, "show", "{}", *out),
        "report": sealed_of(result, 0.3, "report", "{}", *out),
        "report, line contact": sealed_of(flat, 0.3, "report", "{}", *out),
        "fields": sealed_of(result, DEAR, "fields", "{}", "--cycle", "1", "--no-pictures", *out),
        "fields, line contact": sealed_of(flat, DEAREST, "fields", "{}", "--cycle", "1", *out),
        "strength": sealed_of(result, DEAREST, "strength", "{}", "--yield-strength", "400", *out),
        "maps": Reader(both, (*own, "result.h5"), command("maps", "{}/record", "{}", *out), ("out",), DEAREST),
        "compare": Reader(both, tuple(own), compare, ("out",), DEAREST),
        "compare, line contact": Reader(both_flat, tuple(line), compare, ("out",), DEAREST),
    }
