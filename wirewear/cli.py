"""The command line: ``wirewear run`` and ``wirewear show``."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from geometry import GeometryError
from solvers import SolverError
from wirewear import __version__
from wirewear.errors import RecordError, ResultError, StudyError, WirewearError
from wirewear.study import FIDELITIES, load_study

INTERRUPTED = 130  # what shells report for a program ended by Ctrl-C


class _OneSentence(click.ClickException):
    """An error of ours, shown without usage or traceback."""

    exit_code = 2

    def show(self, file: object = None) -> None:  # noqa: ARG002
        """Print the sentence on standard error."""
        click.echo(f"wirewear: {self.message}", err=True)


class _Commands(click.Group):
    """Commands whose foreseeable errors end in one sentence and an exit code."""

    def invoke(self, ctx: click.Context) -> object:
        """Run the command that was asked for."""
        try:
            return super().invoke(ctx)
        except (WirewearError, GeometryError, SolverError) as error:
            raise _OneSentence(str(error)) from error
        except KeyboardInterrupt:
            click.echo("wirewear: interrupted; the same command with --resume continues a run.", err=True)
            ctx.exit(INTERRUPTED)


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="wirewear")
def cli() -> None:
    """Simulate the crossed-wire fretting test: contact, friction, wear and the compliance of the rig."""


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--variant", metavar="NAME", help="Run this variant of the study only.")
@click.option(
    "--output", metavar="DIR", type=click.Path(path_type=Path), help="Result folder.  [default: runs/<study>]"
)
@click.option("--resume", is_flag=True, help="Continue an interrupted run where its last checkpoint stands.")
@click.option("--jobs", type=click.IntRange(1), help="Variants to run side by side.  [default: one a core]")
def run(
    study_path: Path, fidelity: str, variant: str | None, output: Path | None, resume: bool, jobs: int | None
) -> None:
    """Simulate a study, or each of its variants; planar studies always run from the start."""
    from wirewear.planar import is_planar_study
    from wirewear.rig_stiffness import is_rig_stiffness_study

    for belongs, run_one in ((is_planar_study, _run_planar), (is_rig_stiffness_study, _run_rig_stiffness)):
        if belongs(study_path):
            _require_plain_run(study_path, variant, resume=resume)
            run_one(study_path, fidelity, output or default_output(study_path))
            return
    study = load_study(study_path)
    if variant is not None:
        study = study.variant(variant)

    from rich.console import Console

    from wirewear.observers import ProgressBar
    from wirewear.results.vtk import FOLDER_NAME, write_time_series
    from wirewear.simulate import run_study
    from wirewear.summary import summary

    results = run_study(
        study,
        fidelity=fidelity,
        output=output or default_output(study_path),
        resume=resume,
        observer_of=ProgressBar,
        jobs=jobs or os.cpu_count() or 1,
    )
    Console().print(summary(results))
    for result in results:
        if result.path is not None:
            write_time_series(result, result.path.parent / FOLDER_NAME)


def _require_plain_run(study_path: Path, variant: str | None, *, resume: bool) -> None:
    if variant is not None or resume:
        option = "--resume" if resume else "--variant"
        raise StudyError(f"{option} does not apply to {study_path}: a planar study has no variants and no checkpoints.")


def _run_rig_stiffness(study_path: Path, fidelity: str, output: Path) -> None:
    """Simulate a rig stiffness study with a progress bar and say where its results are."""
    from rich.console import Console
    from rich.progress import Progress

    from wirewear.rig_stiffness import load_rig_stiffness_study, run_rig_stiffness_study
    from wirewear.rig_stiffness.summary import rig_stiffness_summary

    study = load_rig_stiffness_study(study_path)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(study.name, total=1.0)
        result = run_rig_stiffness_study(
            study,
            fidelity=fidelity,
            output=output,
            progress=lambda share, text: bar.update(task, completed=share, description=f"{study.name}: {text}"),
        )
    console = Console()
    # The tables need this much also where no terminal states its width.
    console.width = max(console.width, 110)
    console.print(rig_stiffness_summary(result))
    click.echo(f"results and pictures are in {output}")


def _run_planar(study_path: Path, fidelity: str, output: Path) -> None:
    """Simulate a planar study with a progress bar and say where its results are."""
    from rich.console import Console
    from rich.progress import Progress

    from wirewear.planar import load_planar_study, run_planar_study
    from wirewear.planar.summary import planar_summary

    study = load_planar_study(study_path)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(study.name, total=1.0)
        result = run_planar_study(
            study,
            fidelity=fidelity,
            output=output,
            progress=lambda share, text: bar.update(task, completed=share, description=f"{study.name}: {text}"),
        )
    Console().print(planar_summary(result))
    click.echo(f"results and pictures are in {output}")


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--variant", metavar="NAME", help="The variant of the study to refine, if it has variants.")
@click.option(
    "--output", metavar="DIR", type=click.Path(path_type=Path), help="Result folder.  [default: runs/<study>/converge]"
)
@click.option("--jobs", type=click.IntRange(1), help="Runs side by side.  [default: one a core]")
def converge(study_path: Path, fidelity: str, variant: str | None, output: Path | None, jobs: int | None) -> None:
    """Run a study again with mesh, increments and cycle jumps refined, and print what that changes."""
    study = load_study(study_path)
    if variant is not None:
        study = study.variant(variant)

    from rich.console import Console

    from wirewear.convergence import converge as run_refined
    from wirewear.convergence import convergence_table
    from wirewear.observers import ProgressBar

    rows = run_refined(
        study,
        fidelity=fidelity,
        output=output or default_output(study_path) / "converge",
        observer_of=ProgressBar,
        jobs=jobs or os.cpu_count() or 1,
    )
    Console().print(convergence_table(rows))


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", type=click.Path(path_type=Path), help="Picture folder.  [default: beside it]")
def show(result_path: Path, output: Path | None) -> None:
    """Draw the pictures of a result: a file, or the folder of a run."""
    from wirewear.pictures import show as draw

    for picture in draw(result_path, output):
        click.echo(picture)


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option(
    "--output", metavar="DIR", type=click.Path(path_type=Path), help="Mesh folder.  [default: runs/<study>/mesh]"
)
def mesh(study_path: Path, fidelity: str, output: Path | None) -> None:
    """Mesh both wires of a study, write them as VTU files and draw them."""
    from wirewear.meshes import write_meshes

    folder = output or default_output(study_path) / "mesh"
    for path in write_meshes(load_study(study_path), fidelity, folder):
        click.echo(path)


@cli.command()
@click.option("--quick", is_flag=True, help="Coarse meshes and wider tolerances.")
@click.option(
    "--json",
    "json_path",
    metavar="FILE",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the table there too.",
)
@click.pass_context
def verify(context: click.Context, quick: bool, json_path: Path | None) -> None:
    """Solve the reference problems and compare with closed forms; exit code 1 if any check fails."""
    from rich.console import Console
    from rich.progress import Progress

    from wirewear.study_script import wide_console
    from wirewear.verification import FULL, QUICK, table, write_json
    from wirewear.verification import verify as solve

    if json_path is not None and not json_path.parent.is_dir():
        raise ResultError(f"cannot write '{json_path}': the folder '{json_path.parent}' does not exist")
    level = QUICK if quick else FULL
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=1.0)

        def show_stage(title: str, done: int, of: int) -> None:
            progress.update(task, description=title, completed=done / of)

        rows = solve(level, show_stage)
    wide_console(132).print(table(rows))
    if json_path is not None:
        write_json(json_path, level.name, rows)
    if not all(row.passed for row in rows):
        context.exit(1)


@cli.command()
@click.argument("record_path", metavar="RECORD", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
@click.pass_context
def check(context: click.Context, record_path: Path, as_json: bool) -> None:
    """Check an experiment record and say what it can and cannot support; exit code 1 if it has problems."""
    import json

    from rich.console import Console

    from wirewear.records import check_record, read_record
    from wirewear.records.printing import report_text

    with _busy("reading and checking the record"):
        report = check_record(read_record(record_path))
    if as_json:
        click.echo(json.dumps(report.to_json(), indent=2, ensure_ascii=False))
    else:
        Console().print(report_text(report))
    if report.problems:
        context.exit(1)


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.option("--as-record", "folder", metavar="DIR", required=True, type=click.Path(path_type=Path))
@click.option("--variant", metavar="NAME", help="Which run, where RESULT holds several.")
@click.option("--repeats", type=click.IntRange(1, 1000), default=1, show_default=True, help="Tests that are read anew.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the noise.")
@click.option("--samples", type=click.IntRange(16, 100_000), help="Samples a loop.  [default: the simulation's]")
@click.option("--noise", metavar="LIST", default="", help="displacement_um=0.15,tangential_force_N=0.008,depth_um=0.05")
@click.option("--gain", metavar="LIST", default="", help="displacement=1.02,tangential_force=0.98,normal_force=1")
@click.option("--sensor", "sensor_list", metavar="LIST", default="", help="linear_um_per_N=0.5,lag_s=1e-4,...")
def export(
    result_path: Path,
    folder: Path,
    variant: str | None,
    repeats: int,
    seed: int,
    samples: int | None,
    noise: str,
    gain: str,
    sensor_list: str,
) -> None:
    """Write a simulation as an experiment record, as the rig's sensors would read it."""
    from wirewear.records import record_of_result, write_record
    from wirewear.records.exporting import chosen_run, parse_channels
    from wirewear.results import read_results
    from wirewear.sensor import Sensor, SensorNoise
    from wirewear.sensor.sensor import OTHER_NUMBERS

    channels = ("displacement_um", "tangential_force_N", "normal_force_N", "depth_um")
    noises = parse_channels(noise, channels, "--noise")
    gains = parse_channels(gain, ("displacement", "tangential_force", "normal_force"), "--gain")
    depth_noise = noises.pop("depth_um", 0.0)
    numbers: dict[str, Any] = {f"{name}_gain": value for name, value in gains.items()}
    numbers |= parse_channels(sensor_list, OTHER_NUMBERS, "--sensor", signed=True)
    sensor = Sensor(**numbers, noise=SensorNoise(**noises))
    result = chosen_run(read_results(result_path), variant, result_path)
    with _busy("exporting the record"):
        record = record_of_result(
            result,
            sensor=sensor,
            depth_noise_um=depth_noise,
            repeats=repeats,
            seed=seed,
            samples=samples,
        )
        click.echo(write_record(folder, record))


@cli.command(name="import")
@click.argument("mapping_path", metavar="MAPPING.toml", type=click.Path(path_type=Path))
@click.option("--output", metavar="RECORD", required=True, type=click.Path(path_type=Path))
@click.option("--dry-run", is_flag=True, help="Show the first loop and draw it beside RECORD; write no record.")
def import_command(mapping_path: Path, output: Path, dry_run: bool) -> None:
    """Turn a laboratory's files into an experiment record, as a mapping file describes them."""
    from wirewear.records import write_record
    from wirewear.records.importing import import_record
    from wirewear.records.importing.first_loop import draw_first_loop, first_loop_text

    with _busy("reading the files"):
        record = import_record(mapping_path)
    click.echo(first_loop_text(record))
    if dry_run:
        click.echo(draw_first_loop(record, output.with_name(f"{output.name}_first_loop.png")))
    else:
        click.echo(write_record(output, record))


@cli.command(name="compare")
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.argument("record_path", metavar="RECORD", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", required=True, type=click.Path(path_type=Path))
@click.option("--variant", metavar="NAME", help="Which run, where RESULT holds several.")
def compare_command(result_path: Path, record_path: Path, output: Path, variant: str | None) -> None:
    """Set a simulation beside an experiment record: loops, evolution, scars, and a table of differences."""
    from rich.console import Console

    from wirewear.comparison import compare, write_comparison
    from wirewear.comparison.printing import differences_table
    from wirewear.records import read_record
    from wirewear.records.exporting import chosen_run
    from wirewear.results import read_results

    result = chosen_run(read_results(result_path), variant, result_path)
    with _busy("comparing"):
        comparison = compare(result, read_record(record_path))
        written = write_comparison(comparison, output)
    console = Console()
    # The table needs this much also where no terminal states its width.
    console.width = max(console.width, 100)
    console.print(differences_table(comparison))
    for path in written:
        click.echo(path)


@cli.command(name="diagnose")
@click.argument("record_path", metavar="RECORD", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", required=True, type=click.Path(path_type=Path))
@click.option(
    "--model", metavar="STUDY.toml", type=click.Path(path_type=Path), help="[default: what the record states]"
)
@click.option("--confirm", is_flag=True, help="Run the full simulation with the leading effects, too.")
@click.option("--without", metavar="EFFECT", multiple=True, help="An effect not to be considered; may be repeated.")
@click.option("--jobs", type=click.IntRange(1), help="Cores for linear algebra.  [default: all]")
def diagnose_command(
    record_path: Path, output: Path, model: Path | None, confirm: bool, without: tuple[str, ...], jobs: int | None
) -> None:
    """Say why a record and its model disagree: where, by which effect, and how far the gap shrinks with it."""
    from threadpoolctl import threadpool_limits

    from wirewear.diagnosis import confirmed, diagnose, ten_lines, write_diagnosis
    from wirewear.observers import ProgressBar
    from wirewear.records import read_record

    study = None if model is None else load_study(model)
    with _busy("reading the record"):
        record = read_record(record_path)
    with threadpool_limits(limits=jobs, user_api="blas"):
        diagnosed = diagnose(record, model=study, observer_of=ProgressBar, left_out=without, stage=_busy)
        if confirm:
            diagnosed = confirmed(diagnosed, observer_of=ProgressBar)
    with _busy("writing the report"):
        written = write_diagnosis(diagnosed, output)
    click.echo(ten_lines(diagnosed.diagnosis))
    for path in written:
        click.echo(path)


@cli.command(name="loops")
@click.argument("path", metavar="FILE_OR_RECORD", type=click.Path(path_type=Path))
@click.option("--cycle", type=click.IntRange(0), help="This cycle only.  [default: all]")
@click.option("--variant", metavar="NAME", help="Which run, where a result holds several.")
@click.option("--displacement", metavar="COLUMN[:UNIT]", help="Column of a CSV file.  [default: by its name]")
@click.option("--force", metavar="COLUMN[:UNIT]", help="Column of a CSV file.  [default: by its name]")
@click.option("--normal-load", metavar="COLUMN[:UNIT]|N", help="Column of a CSV file, or one number in newtons.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON; a picture only with --output.")
@click.option("--output", metavar="PNG", type=click.Path(dir_okay=False, path_type=Path), help="Picture.")
def loops_command(path: Path, cycle: int | None, as_json: bool, output: Path | None, **chosen: str | None) -> None:
    """Analyse the loops of a CSV file, a record or a result: amplitudes, stiffness, friction, energy, regime."""
    import json

    from rich.console import Console

    from wirewear.loop_report import analyse_loops, draw_loops, loops_json, loops_table, read_loops, remarks

    with _busy("analysing the loops"):
        analysed = analyse_loops(read_loops(path, cycle=cycle, **chosen))
        if output is None and not as_json:
            output = default_output(path) / "loops.png"
        picture = None if output is None else draw_loops(analysed, output)
    if as_json:
        click.echo(json.dumps(loops_json(str(path), analysed), indent=2, ensure_ascii=False))
        return
    console = Console()
    # The table needs this much also where no terminal states its width.
    console.width = max(console.width, 150)
    console.print(loops_table(analysed))
    for remark in remarks(analysed):
        click.echo(remark)
    click.echo(picture)


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.option(
    "--loads", metavar="LIST", default="", help="Normal loads in newtons.  [default: 0.5, 1, 1.5 × the study's]"
)
@click.option(
    "--near", metavar="POINT", default="moving-wire", show_default=True, help="Or between-wires, between-holders."
)
@click.option("--remote-compliance", metavar="UM_PER_N", type=click.FloatRange(0.0), default=0.0, show_default=True,
              help="From the sensor's point to the moving wire's holder.")  # fmt: skip
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--variant", metavar="NAME", help="Which variant of the study.")
@click.option("--record", "record_path", metavar="RECORD", type=click.Path(path_type=Path), help="To be corrected.")
@click.option("--output", metavar="DIR", type=click.Path(path_type=Path), help="Where the corrected record goes.")
@click.option("--json", "as_json", is_flag=True, help="Print the calibration as JSON.")
def calibrate(study_path: Path, loads: str, near: str, remote_compliance: float, fidelity: str, variant: str | None,
              record_path: Path | None, output: Path | None, as_json: bool) -> None:  # fmt: skip
    """Calibrate a remote displacement sensor by simulation under a range of loads, and correct a record with it."""
    import json

    from rich.console import Console
    from rich.progress import Progress

    from wirewear.calibration import calibrate as solve
    from wirewear.calibration import corrected_record, parse_loads, parse_near
    from wirewear.calibration.report import calibration_json, calibration_text
    from wirewear.records import read_record, write_record

    if (record_path is None) != (output is None):
        raise RecordError("--record and --output belong together: which record, and where it goes when corrected.")
    study = load_study(study_path)
    study = study if variant is None else study.variant(variant)
    record = None if record_path is None else read_record(record_path)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(study.name, total=1.0)
        calibration = solve(
            study,
            normal_loads_N=parse_loads(loads),
            near=parse_near(near),
            remote_compliance_um_per_N=remote_compliance,
            fidelity=fidelity,
            progress=lambda share, text: bar.update(task, completed=share, description=text),
        )
    correction = None if record is None else corrected_record(record, calibration.polynomial)
    if correction is not None and output is not None:
        write_record(output, correction.record)
    if as_json:
        click.echo(json.dumps(calibration_json(study.name, calibration, correction), indent=2, ensure_ascii=False))
        return
    Console().print(calibration_text(calibration, correction))
    if output is not None:
        click.echo(output)


@cli.command()
@click.argument("path", metavar="FILE.csv", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print the rows as JSON.")
def tribometers(path: Path, as_json: bool) -> None:
    """Say for each tribometer whether compliance explains the displacement that it loses."""
    import json

    from rich.console import Console
    from rich.progress import Progress

    from wirewear.tribometers import read_tribometers, tribometers_json, tribometers_table, verdicts_table

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("contact stiffness")
        rows = read_tribometers(path, lambda done, of: bar.update(task, completed=done, total=of))
    if as_json:
        click.echo(json.dumps(tribometers_json(rows), indent=2, ensure_ascii=False))
        return
    console = Console()
    console.width = max(console.width, 132)
    console.print(tribometers_table(rows), verdicts_table(rows))


@cli.command(name="effects")
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print all effects as JSON.")
@click.option("--plot", is_flag=True, help="Run the steel-wire test without and with NAME, and draw what differs.")
@click.option("--study", "study_path", metavar="STUDY.toml", type=click.Path(path_type=Path), help="Plot this one.")
@click.option("--size", type=click.Choice(["easy", "hard"]), default="easy", show_default=True, help="Size to plot.")
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="quick", show_default=True)
@click.option(
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path),
    default=Path("runs/effects"),
    show_default=True,
    help="Of runs and pictures; finished runs there are used again.",
)
def effects_command(
    name: str | None, as_json: bool, plot: bool, study_path: Path | None, size: str, fidelity: str, output: Path
) -> None:
    """List the effects that a study can have beyond the nominal model, or describe or draw the one called NAME."""
    import json

    from rich.console import Console

    from wirewear.effects import effect_named
    from wirewear.effects.listing import effect_text, effects_json, effects_table

    if plot:
        if name is None:
            raise StudyError("--plot needs the name of an effect: `wirewear effects` lists them.")
        _plot_effect(name, study_path, size, fidelity, output)
    elif as_json:
        click.echo(json.dumps(effects_json(), indent=2, ensure_ascii=False))
    elif name is not None:
        click.echo(effect_text(effect_named(name)))
    else:
        console = Console()
        console.width = max(console.width, 130)
        console.print(effects_table())


def _plot_effect(name: str, study_path: Path | None, size: str, fidelity: str, output: Path) -> None:
    """Run a study without and with an effect, and draw its signature."""
    from wirewear.effects import effect_named
    from wirewear.effects.signature import signature_of, signature_study
    from wirewear.effects.signature_picture import draw_signature
    from wirewear.observers import ProgressBar

    study = signature_study() if study_path is None else load_study(study_path)
    if study.variants:
        raise StudyError(f"{study_path} has variants, but a signature needs a study without.")
    effect = effect_named(name).sized("hard" if size == "hard" else "easy", study)
    signature = signature_of(effect, output, study=study, fidelity=fidelity, observer_of=ProgressBar)
    click.echo(draw_signature(signature, output / f"{name}.png"))


@cli.group()
def blind() -> None:
    """Records whose effect is withheld, and the scoring of diagnoses made of them."""


@blind.command(name="make")
@click.argument("output", metavar="OUT_DIR", type=click.Path(path_type=Path))
@click.option("--cases", type=click.IntRange(1), required=True, help="Records to make.")
@click.option("--seed", type=click.IntRange(0), required=True, help="Seed of everything that is drawn; keep it secret.")
@click.option("--tier", type=click.Choice(("T0", "T1", "T2")), default="T2", show_default=True)
@click.option("--law", default="dahl", show_default=True, help="Friction law of the tier T2.")
@click.option(
    "--tests", type=click.IntRange(1), default=6, show_default=True, help="Different nominal tests among them."
)
@click.option(
    "--key", "key_path", metavar="FILE", type=click.Path(path_type=Path), help="Key file.  [default: OUT_DIR.key]"
)
@click.option("--jobs", type=click.IntRange(1), help="Records to make side by side.  [default: one a core]")
def blind_make(
    output: Path, cases: int, seed: int, tier: str, law: str, tests: int, key_path: Path | None, jobs: int | None
) -> None:
    """Make a batch of records, their key sealed; the same command continues one that was interrupted."""
    from rich.console import Console
    from rich.progress import MofNCompleteColumn, Progress

    from wirewear.blind import default_key_path, generator_of, make_batch

    generator = generator_of(tier, law=law)
    with Progress(
        *Progress.get_default_columns(), MofNCompleteColumn(), console=Console(stderr=True), transient=True
    ) as bar:
        task = bar.add_task("records", total=cases)
        manifest = make_batch(
            output,
            cases=cases,
            seed=seed,
            generator=generator,
            tests=tests,
            key_path=key_path,
            jobs=jobs or os.cpu_count() or 1,
            progress=lambda done, _: bar.update(task, completed=done),
        )
    click.echo(f"{cases} records and {manifest}; keep {key_path or default_key_path(output)} apart from them.")


@blind.command(name="score")
@click.argument("batch", metavar="OUT_DIR", type=click.Path(path_type=Path))
@click.argument("diagnoses", metavar="DIAGNOSES_DIR", type=click.Path(path_type=Path))
@click.option("--key", "key_path", metavar="FILE", type=click.Path(path_type=Path), required=True, help="Key file.")
@click.option(
    "--output", metavar="DIR", type=click.Path(path_type=Path), help="Of the report.  [default: DIAGNOSES_DIR]"
)
def blind_score(batch: Path, diagnoses: Path, key_path: Path, output: Path | None) -> None:
    """Verify a batch, score the diagnoses of its records (DIAGNOSES_DIR/<record>/diagnosis.json), and log the run."""
    from rich.console import Console

    from wirewear.blind import score_batch, score_table

    score = score_batch(batch, diagnoses, key_path=key_path, output=output)
    console = Console()
    console.width = max(console.width, 120)
    console.print(score_table(score.report))
    click.echo(f"score.json and score.html are in {output or diagnoses}")


@contextmanager
def _busy(doing: str) -> Iterator[None]:
    """Say on a terminal's standard error what is going on, for as long as it does."""
    from rich.console import Console

    with Console(stderr=True).status(doing):
        yield


def default_output(study_path: Path) -> Path:
    """Where a study's results go: into runs/, under the file's name, or its folder's if that name is study.toml."""
    full = study_path.resolve()
    return Path("runs") / (full.parent.name if full.stem == "study" and full.parent.name else full.stem)


def main() -> None:
    """Entry point of the console script."""
    cli(prog_name="wirewear")
