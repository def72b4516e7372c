"""Commands on studies and results: list effects and materials, run, draw meshes and results, write pages."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from shutil import copytree, rmtree
from typing import TYPE_CHECKING, Any

import click

from wirewear.app.cli.group import Given, OutputFolder, beside, busy, cli, default_output, given, most_memory, paper
from wirewear.base.errors import ResultError, RunError, StudyError, WirewearError
from wirewear.base.writing import json_text, require_absent, usable_folder, writing
from wirewear.test import FIDELITIES

if TYPE_CHECKING:
    from wirewear.results import RunResult
    from wirewear.test import Study
    from wirewear.test.many_contacts import ManyContacts

#: Options that say what is plotted, how and where, and their parameters.
_OF_A_PLOT = {"--size": "size", "--study": "study_path", "--fidelity": "fidelity", "--output": "output"}


@cli.command(name="materials")
def materials_command() -> None:
    """List the materials that a study may name, where they yield, their fatigue, and friction and wear of pairs.

    Each value has its source, and says where we have not read it ourselves.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from wirewear.app.cli.consoles import wide_console
    from wirewear.test.materials import materials, rubbing_pairs

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("material", no_wrap=True)
    table.add_column("also", no_wrap=True)
    for heading in ("E [GPa]", "ν"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("source", overflow="fold")
    for item in materials():
        modulus, ratio = item.elastic.youngs_modulus_MPa, item.elastic.poissons_ratio
        source = item.source if item.verified else f"unverified: {item.source}"
        table.add_row(item.name, ", ".join(item.also), f"{1e-3 * modulus:.4g}", f"{ratio:g}", source)
        if item.fatigue:
            data = ", ".join(f"{key} = {value:g}" for key, value in item.fatigue)
            table.add_row("", "fatigue", "", "", f"{data}; {item.fatigue_note}")
        if item.yields:
            hardness = () if item.hardness_HV is None else (("hardness_HV", item.hardness_HV),)
            data = ", ".join(f"{key} = {value:g}" for key, value in item.yields + hardness)
            table.add_row(
                "", "yields", "", "", f"{data}; {'' if item.yields_verified else 'unread: '}{item.yields_source}"
            )
    pairs = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("pair", "conditions", "µ", "α [mm³/J]", "source"):
        pairs.add_column(Text(heading), overflow="fold", no_wrap=heading in ("µ", "α [mm³/J]"))
    for pair in rubbing_pairs():
        values = pair.friction, pair.energy_wear_coefficient_mm3_per_J
        source = f"{'' if pair.verified else 'unverified: '}{pair.source}{f'; {pair.how}' if pair.how else ''}"
        shown = ("; ".join(f"{one:g}" for one in own) for own in values)
        pairs.add_row(Text(pair.bodies), Text(pair.conditions), *shown, Text(source))
    for each in (table, pairs):
        wide_console(130).print(each)


@cli.command(name="effects")
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print all effects, or NAME alone, as JSON.")
@click.option("--plot", is_flag=True, help="Run the steel-wire test without and with NAME, and draw what differs.")
@click.option("--study", "study_path", metavar="STUDY.toml", type=Given(), help="Plot this one.")
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
@paper
def effects_command(
    name: str | None, as_json: bool, plot: bool, study_path: Path | None, size: str, fidelity: str, output: Path
) -> None:
    """List the effects that a study can have beyond the nominal model, or describe or draw the one called NAME."""
    from wirewear.app.cli.consoles import wide_console
    from wirewear.effects import effect_named
    from wirewear.effects.registry import effect_text, effects_json, effects_table

    for option, parameter in _OF_A_PLOT.items():
        if not plot and given(parameter):
            raise StudyError(f"{option} belongs to --plot: give both, or neither.")
    if plot:
        if as_json:
            raise StudyError("--json does not go with --plot, which draws.")
        if name is None:
            raise StudyError("--plot needs the name of an effect: `wirewear effects` lists them.")
        _plot_effect(name, study_path, size, fidelity, output)
    elif as_json:
        own = None if name is None else effect_named(name).name
        chosen = [effect for effect in effects_json() if own in (None, effect["name"])]
        click.echo(json_text(chosen))
    elif name is not None:
        click.echo(effect_text(effect_named(name)))
    else:
        console = wide_console(130)
        console.print(effects_table())


def _plot_effect(name: str, study_path: Path | None, size: str, fidelity: str, output: Path) -> None:
    from wirewear.effects import effect_named
    from wirewear.simulation import ProgressBar
    from wirewear.sweeps.signature import signature_of, signature_study
    from wirewear.test import load_study
    from wirewear.views.signature_picture import draw_signature

    study = signature_study() if study_path is None else load_study(study_path)
    if study.variants:
        raise StudyError(f"{study_path} has variants, but a signature needs a study without.")
    effect = effect_named(name).sized("hard" if size == "hard" else "easy", study.stated)
    signature = signature_of(effect, output, study=study, fidelity=fidelity, observer_of=ProgressBar)
    click.echo(draw_signature(signature, output / f"{name}.png"))


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Picture folder.  [default: beside it]")
@click.option("--format", "ending", type=click.Choice(["png", "svg", "pdf"]), default="png", show_default=True)
@click.option("--animation", is_flag=True, help="Draw loop and scar over the cycles as a GIF, too.")
@paper
def show(result_path: Path, output: Path | None, ending: str, animation: bool) -> None:
    """Draw the pictures of a result: a file, or the folder of a run."""
    from wirewear.kinds import contacts_of
    from wirewear.pictures import show as draw
    from wirewear.results import read_results

    with busy("drawing"):
        results = read_results(result_path)
        folder, drawn = output or beside(result_path) / "pictures", contacts_of(results[0]).drawings
        pictures = draw(results, folder, ending=ending, moving=animation, drawn=drawn)
    if not pictures:
        raise ResultError(f"nothing is logged yet at {result_path}, so there is nothing to draw")
    for picture in pictures:
        click.echo(picture)


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=Given())
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--variant", metavar="NAME", help="Run this variant of the study only.")
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Result folder.  [default: runs/<study>]")
@click.option("--resume", is_flag=True, help="Continue an interrupted run where its last checkpoint stands.")
@click.option("--overwrite", is_flag=True, help="Run again where a result stands.")
@click.option("--cycles-of", "record_path", metavar="RECORD", type=Given(),
              help="Log the loops of this record's cycles, to be compared with them.")  # fmt: skip
@click.option("--uncertain", is_flag=True, help="Give intervals for the scatter of inputs that the study states.")
@click.option("--jobs", type=click.IntRange(1), help="Variants to run side by side.  [default: one a core]")
@click.option("--json", "as_json", is_flag=True, help="Print what came out as JSON.")
@most_memory
def run(
    study_path: Path,
    fidelity: str,
    variant: str | None,
    output: Path | None,
    resume: bool,
    overwrite: bool,
    record_path: Path | None,
    uncertain: bool,
    jobs: int | None,
    as_json: bool,
) -> None:
    """Simulate a study, or each of its variants.

    With --uncertain, about thirty quick runs give the range in which 95 % of tests lie; the same command goes on.
    """
    from rich.console import Console

    from wirewear.kinds import contacts_of, load_any_study
    from wirewear.results.summary import summary
    from wirewear.simulation import ProgressBar, run_study
    from wirewear.test.many_contacts import many_contacts
    from wirewear.views.run_page import write_page
    from wirewear.views.run_words import runs_json, sentence

    folder = output or default_output(study_path)
    if uncertain:
        _refuse(record_path is not None, "--cycles-of does not go with --uncertain, which writes no run's loops.")
        _refuse(as_json, "--json does not go with --uncertain.")
        _refuse(overwrite, "--overwrite does not go with --uncertain, which goes on: choose another --output.")
        _refuse(
            fidelity != "quick" and given("fidelity"), f"--uncertain makes quick runs: leave --fidelity {fidelity} out."
        )
        _run_scattered(study_path, variant, folder / "uncertain", jobs)
        return
    if not resume and not overwrite:
        _require_nothing_lost(folder)
    if (several := many_contacts(study_path)) is not None:
        _refuse(bool(variant or record_path), "several contacts take no --variant and no --cycles-of.")
        _run_contacts(several, fidelity, folder, jobs or os.cpu_count() or 1, resume=resume, as_json=as_json)
        return
    study = load_any_study(study_path)
    if variant is None:
        for table, key, value in study.unused_values():
            said = f"[{table}] {key} = {value} is used by no variant, as each sets its own in [variants.*.{table}]."
            click.echo(f"wirewear: {said}", err=True)
    else:
        study = study.variant(variant)
    if record_path is not None:
        from wirewear.records import read_record

        last, measured = study.conditions.cycles, read_record(record_path).cycles
        study = study.logging(tuple(sorted({cycle for cycle in measured if 1 <= cycle <= last} | {last})))
    if not overwrite:
        _require_no_others_files(folder, study, resume=resume)
    contacts = contacts_of(study)
    results = run_study(
        study,
        fidelity=fidelity,
        output=folder,
        resume=resume,
        observer_of=ProgressBar,
        jobs=jobs or os.cpu_count() or 1,
    )
    contacts.write_beside(results, folder)
    if as_json:
        click.echo(runs_json(results))
    else:
        click.echo("\n".join(map(sentence, results)))
        Console().print(summary(results))
    page = write_page(results, folder)
    click.echo(f"the page of {'this run' if len(results) == 1 else 'these runs'} is {page}", err=as_json)


def _run_contacts(test: ManyContacts, fidelity: str, folder: Path, jobs: int, *, resume: bool, as_json: bool) -> None:
    from wirewear.simulation import ProgressBar, run_study
    from wirewear.sweeps.shared_load import shared_load
    from wirewear.test import Study
    from wirewear.views.contacts_page import contacts_json, sentence, write_contacts
    from wirewear.views.run_page import write_page

    # Runs of each round are kept, so that the same rounds are gone through again.
    rounds = folder / "rounds"
    if not resume:
        rmtree(rounds, ignore_errors=True)

    def simulate(studies: Mapping[str, Study], number: int) -> dict[str, RunResult]:
        tables = [study.tables for study in studies.values()]
        each = Study(tables[0], tuple(zip(studies, tables, strict=True)))
        own = run_study(
            each, fidelity=fidelity, output=rounds / str(number), resume=resume, observer_of=ProgressBar, jobs=jobs
        )
        return dict(zip(studies, own, strict=True))

    shared = shared_load(test, simulate)
    with writing(ResultError, f"cannot write to {folder}"):
        for label, result in shared.runs.items():
            copytree(rounds / str(shared.rounds) / label, folder / label, dirs_exist_ok=True)
            write_page([result], folder / label)
    page = write_contacts(shared, folder)
    click.echo(contacts_json(shared) if as_json else sentence(shared))
    click.echo(f"the page of these contacts is {page}", err=as_json)


def _run_scattered(study_path: Path, variant: str | None, folder: Path, jobs: int | None) -> None:
    from wirewear.app.cli.sweeps import run_scattered
    from wirewear.kinds import load_any_study
    from wirewear.test.kinds import kind_of

    study: Any = load_any_study(study_path)
    _refuse(not kind_of(study).scatters, f"--uncertain does not apply to {study_path}: it knows crossed wires only.")
    run_scattered(study, variant, folder, jobs)


def _require_nothing_lost(folder: Path) -> None:
    """Raise StudyError if the folder holds a readable result, complete or not, that a new run would replace."""
    from wirewear.results import RESULT_FILE_NAME

    # Of a run, its variants or contacts, or of rounds in which these were run.
    for path in (each for depth in ("", "*/", "rounds/*/*/") for each in sorted(folder.glob(depth + RESULT_FILE_NAME))):
        status = _status_of(path) if path.is_file() else None
        what, then = ("a complete result", "keep") if status == "complete" else ("an unfinished result", "go on with")
        _refuse(
            status is not None,
            f"{path} is {what}, and is not overwritten: choose another --output, {then} it with --resume, or replace "
            "it with --overwrite.",
        )


def _require_no_others_files(folder: Path, study: Any, *, resume: bool) -> None:
    """Raise RunError if a file that the runs would write or remove stands where no result does."""
    from wirewear.results import RESULT_FILE_NAME
    from wirewear.simulation import files_of_runs

    places = [folder / name for name in study.variant_names] or [folder]
    places = [place for place in places if not (place / RESULT_FILE_NAME).exists()] if resume else [folder, *places]
    for place in places:
        require_absent((path for pattern in files_of_runs(study) for path in sorted(place.glob(pattern))), RunError)


def _status_of(path: Path) -> str | None:
    from wirewear.results import read_result

    with suppress(WirewearError):
        return read_result(path).status
    return None


def _refuse(given: bool, sentence: str) -> None:
    if given:
        raise StudyError(sentence)


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=Given())
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Mesh folder.  [default: runs/<study>/mesh]")
@click.option(
    "--format",
    "ending",
    type=click.Choice(("vtu", "msh", "inp", "npz")),
    default="vtu",
    show_default=True,
    help="VTK's, gmsh's with physical groups, Abaqus' with element sets, or condensed stiffnesses.",
)
@most_memory
@paper
def mesh(study_path: Path, fidelity: str, output: Path | None, ending: str) -> None:
    """Mesh both bodies of a study, write the meshes to files and draw them and what holds them."""
    from wirewear.kinds import contacts_of, load_any_study

    folder = usable_folder(output or default_output(study_path) / "mesh")
    study = load_any_study(study_path)
    with busy("meshing and drawing"):
        written = list(contacts_of(study).write_meshes(study, fidelity, folder, ending))
    for path in written:
        click.echo(path)
