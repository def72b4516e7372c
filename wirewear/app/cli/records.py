"""Commands on records: check, export, import, compare, diagnose."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wirewear.app.cli.group import (
    Finite,
    Given,
    OutputFile,
    OutputFolder,
    a_list,
    busy,
    cli,
    most_memory,
    of_block,
    overwrite_record,
    paper,
    stage,
)
from wirewear.base.errors import RecordError
from wirewear.base.recognising import Held, recognised
from wirewear.base.writing import json_text, require_absent

if TYPE_CHECKING:
    from wirewear.results import RunResult


@cli.command(name="diagnose")
@click.argument("record_path", metavar="RECORD", type=Given())
@click.option("--output", metavar="DIR", required=True, type=OutputFolder())
@click.option(
    "--model", metavar="STUDY.toml", type=click.Path(path_type=Path), help="[default: what the record states]"
)
@click.option("--next", "further", metavar="RECORD2", multiple=True, type=click.Path(path_type=Path),
              help="A further measurement of the same rig, which updates the answer; may be repeated.")  # fmt: skip
@of_block
@click.option("--confirm", is_flag=True, help="Run the full simulation with the leading effects, too.")
@click.option("--without", metavar="EFFECT", multiple=True, help="An effect not to be considered; may be repeated.")
@click.option("--jobs", type=click.IntRange(1), help="Cores for linear algebra.  [default: all]")
@most_memory
def diagnose_command(
    record_path: Path,
    output: Path,
    model: Path | None,
    further: tuple[Path, ...],
    block: int | None,
    confirm: bool,
    without: tuple[str, ...],
    jobs: int | None,
) -> None:
    """Say why a record and its model disagree: where, by which effect, and how far the gap shrinks with it."""
    from threadpoolctl import threadpool_limits

    from wirewear.base.locks import occupied
    from wirewear.diagnosis import confirmed, diagnose_prepared, prepared
    from wirewear.kinds import load_any_study
    from wirewear.records import read_record
    from wirewear.simulation import ProgressBar
    from wirewear.views.diagnosis_page import ten_lines, write_diagnosis

    study = None if model is None else load_any_study(model)
    with busy("reading the record"):
        record = read_record(record_path)
        record = record if block is None else record.of_block(block)
        # Before a folder is made that nothing would come into.
        records = prepared(record, study, [read_record(path) for path in further])
    if records[0].assumed:
        click.echo(f"wirewear: {records[0].assumed}", err=True)
    with occupied(output, f"diagnose {record_path}"):
        with threadpool_limits(limits=None if jobs is None else min(jobs, os.cpu_count() or 1), user_api="blas"):
            diagnosed = diagnose_prepared(records, observer_of=ProgressBar, left_out=without, stage=stage)
            if confirm:
                diagnosed = confirmed(diagnosed, observer_of=ProgressBar)
        with busy("writing the report"):
            written = write_diagnosis(diagnosed, output)
    click.echo(ten_lines(diagnosed.diagnosis))
    for path in written:
        click.echo(path)


@cli.command()
@click.argument("record_path", metavar="RECORD", type=Given())
@of_block
@click.option("--json", "as_json", is_flag=True, help="Print the report as JSON.")
@click.pass_context
def check(context: click.Context, record_path: Path, block: int | None, as_json: bool) -> None:
    """Check an experiment record and say what it can and cannot support; exit code 1 if it has problems."""
    from rich.console import Console

    from wirewear.records import check_record, read_record
    from wirewear.records.checking import report_text

    with busy("reading and checking the record"):
        report = check_record(read_record(record_path).of_block(block))
    if as_json:
        click.echo(json_text(report.to_json()))
    else:
        Console().print(report_text(report))
    if report.problems:
        context.exit(1)


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.option("--as-record", "folder", metavar="DIR", type=OutputFolder(of_record=True),
              help="An experiment record.")  # fmt: skip
@click.option("--as-heights", "heights", metavar="DIR", type=OutputFolder(),
              help="Loops, and worn bodies as a profilometer sees them.")  # fmt: skip
@click.option("--as-tables", "tables", metavar="DIR", type=OutputFolder(), help="Evolution, loops, scars.")
@click.option(
    "--format", "form", type=click.Choice(["csv", "parquet", "netcdf"]), default="csv", show_default=True,
    help="Of tables; netcdf is one file with units.",
)  # fmt: skip
@click.option("--as-deck", "deck", metavar="FILE.inp", type=OutputFile(),
              help="The worn contact at a recorded cycle, moved once to and fro, for another program.")  # fmt: skip
@click.option("--for", "dialect", type=click.Choice(["abaqus", "calculix"]), default="abaqus", show_default=True,
              help="Program that reads the deck.")  # fmt: skip
@click.option("--cycle", type=click.IntRange(1), help="Of a deck.  [default: the last recorded one]")
@click.option("--variant", metavar="NAME", help="Which run, where RESULT holds several.")
@click.option("--length", "length_mm", type=Finite(0.05, 500.0), help="Of a line contact, mm.")
@click.option("--repeats", type=click.IntRange(1, 1000), default=1, show_default=True, help="Repeats of the test.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the noise.")
@click.option("--samples", type=click.IntRange(16, 100_000), help="Samples a loop.  [default: the simulation's]")
@overwrite_record
@a_list("--noise", form="displacement_um=0.15,tangential_force_N=0.008,depth_um=0.05")
@a_list("--gain", form="displacement=1.02,tangential_force=0.98,normal_force=1")
@a_list("--sensor", "sensor_list", form="linear_um_per_N=0.5,lag_s=1e-4,...")
@most_memory
def export(
    result_path: Path,
    folder: Path | None,
    heights: Path | None,
    tables: Path | None,
    form: str,
    deck: Path | None,
    dialect: str,
    cycle: int | None,
    variant: str | None,
    repeats: int,
    seed: int,
    samples: int | None,
    noise: str,
    gain: str,
    sensor_list: str,
    length_mm: float | None,
    overwrite: bool,
) -> None:
    """Write a simulation as an experiment record or files of a laboratory, as sensors would read it, or as tables."""
    from wirewear.kinds import contacts_of
    from wirewear.records import check_record, record_of_result, require_place, write_record
    from wirewear.records.exporting import write_as_heights

    chosen = [one for one in (folder, heights, tables, deck) if one is not None]
    if len(chosen) > 1:
        raise RecordError("--as-record, --as-heights, --as-tables and --as-deck exclude one another: export again.")
    if not chosen:
        raise RecordError("say where to: --as-record DIR, --as-heights DIR, --as-tables DIR, or --as-deck FILE.inp.")
    if deck is not None:
        require_absent((deck,) if not overwrite else (), RecordError)
        result = _run_at(result_path, variant)
        with busy("meshing both bodies"):
            last = result.loops[-1].cycle
            _echo([contacts_of(result).write_deck(result, deck, last if cycle is None else cycle, dialect)])
        return
    if tables is not None:
        _export_tables(_run_at(result_path, variant), tables, form, overwrite=overwrite)
        return
    sensor, depth_noise = _sensor_of(noise, gain, sensor_list)
    reading: dict[str, Any] = {"sensor": sensor, "depth_noise_um": depth_noise, "repeats": repeats}
    reading |= {"seed": seed, "samples": samples}
    place: dict[str, Any] = {"made_of": [result_path], "overwrite": overwrite}
    if folder is not None:
        require_place(folder, **place)
    with busy("exporting the record"):
        result = _run_at(result_path, variant)
        record = record_of_result(result, length_mm=length_mm, **reading)
        problems = [problem.text for problem in check_record(record).problems]
        if result.status != "complete":
            problems.insert(0, f"The run {result.label!r} is not complete ({result.message}).")
        if heights is None:
            written = [write_record(folder or Path(), record, **place)]
        else:
            surfaces = contacts_of(result).surfaces(result, depth_noise, seed)
            written = write_as_heights(heights, record.loops, surfaces, repeats, overwrite=overwrite)
    for sentence in problems:
        click.echo(f"wirewear: {sentence}", err=True)
    _echo(written)


def _run_at(path: Path, variant: str | None) -> RunResult:
    """The only run at a path, or that of the variant. Raises RecordError if there are several and none is chosen."""
    from wirewear.records.exporting import chosen_run
    from wirewear.results import read_results

    return chosen_run(read_results(path), variant, path)


def _echo(paths: Sequence[Path]) -> None:
    for path in paths:
        click.echo(path)


def _sensor_of(noise: str, gain: str, others: str) -> tuple[Any, float]:
    """Sensor from the option texts of noise, gains and other numbers, and the noise of depths in µm."""
    from wirewear.loops.sensor import OTHER_NUMBERS, Sensor, SensorNoise
    from wirewear.records.exporting import parse_channels

    channels = ("displacement_um", "tangential_force_N", "normal_force_N", "depth_um")
    noises = parse_channels(noise, channels, "--noise")
    gains = parse_channels(gain, ("displacement", "tangential_force", "normal_force"), "--gain")
    depth_noise = noises.pop("depth_um", 0.0)
    numbers: dict[str, Any] = {f"{name}_gain": value for name, value in gains.items()}
    numbers |= parse_channels(others, OTHER_NUMBERS, "--sensor", signed=True)
    return Sensor(**numbers, noise=SensorNoise(**noises)), depth_noise


def _export_tables(result: Any, folder: Path, form: str, *, overwrite: bool) -> None:
    from wirewear.results.export import write_flat_tables, write_netcdf

    with busy("writing tables"):
        written = (
            [write_netcdf(result, folder / "run.nc", overwrite=overwrite)]
            if form == "netcdf"
            else write_flat_tables(result, folder, form, overwrite=overwrite)
        )
    _echo(written)


@cli.command(name="import")
@click.argument("mapping_path", metavar="MAPPING.toml", type=click.Path(path_type=Path))
@click.option("--output", metavar="RECORD", required=True, type=OutputFolder(of_record=True))
@overwrite_record
@click.option(
    "--dry-run",
    is_flag=True,
    help="Show the first loop, draw it (RECORD_first_loop.png) and worn surfaces; write no record.",
)
@click.pass_context
def import_command(context: click.Context, mapping_path: Path, output: Path, overwrite: bool, dry_run: bool) -> None:
    """Turn a laboratory's files into an experiment record, as a mapping file describes them.

    With --dry-run, the exit code is 1 where the record has problems such as a wrong unit.
    """
    from wirewear.records import check_record, require_place, write_record
    from wirewear.records.importing import import_record
    from wirewear.records.importing.importing import inputs_of
    from wirewear.records.importing.preview import draw_import, import_text

    place: dict[str, Any] = {"made_of": inputs_of(mapping_path), "overwrite": overwrite}
    if not dry_run:
        require_place(output, **place)
    with busy("reading the files"):
        record = import_record(mapping_path)
        problems = check_record(record).problems
    click.echo(import_text(record))
    for problem in problems:
        click.echo(f"wirewear: {problem.topic}: {problem.text}", err=True)
    if dry_run:
        _echo(draw_import(record, output))
    else:
        click.echo(write_record(output, record, **place))
    if dry_run and problems:
        context.exit(1)


@cli.command(name="compare")
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.argument("record_path", metavar="RECORD", type=Given())
@click.option("--output", metavar="DIR", required=True, type=OutputFolder())
@click.option("--variant", metavar="NAME", help="Which run, where RESULT holds several.")
@paper
def compare_command(result_path: Path, record_path: Path, output: Path, variant: str | None) -> None:
    """Set a simulation beside an experiment record: loops, evolution, scars, and a table of differences."""
    from wirewear.app.cli.consoles import wide_console
    from wirewear.base.locks import occupied
    from wirewear.comparison.comparison import compare
    from wirewear.records import read_record
    from wirewear.views.comparison_page import differences_table, write_comparison

    if (recognised(result_path), recognised(record_path)) == (Held.RECORD, Held.RUN):
        click.echo(f"wirewear: {result_path} is a record and {record_path} a run: they are exchanged.", err=True)
        result_path, record_path = record_path, result_path
    with busy("comparing"):
        record = read_record(record_path)
        comparison = compare(_run_at(result_path, variant).of_kind(record.contact_kind), record)
        with occupied(output, f"compare {record_path}"):
            written = write_comparison(comparison, output)
    if comparison.unlike:
        click.echo(f"wirewear: {comparison.unlike}", err=True)
    wide_console(100).print(differences_table(comparison))
    _echo(written)
