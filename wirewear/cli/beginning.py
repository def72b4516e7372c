"""Commands that begin: a study or a mapping to start from, and parameters fitted to a record."""

from pathlib import Path
from typing import Any

import click

from wirewear.cli.group import busy, cli, most_memory
from wirewear.errors import RecordError, StudyError
from wirewear.study import FIDELITIES


@cli.command()
@click.argument("names", metavar="NAME | FILES...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--kind", type=click.Choice(("crossed-wires", "line-contact", "rig-stiffness")), default="crossed-wires",
              show_default=True, help="What is simulated.")  # fmt: skip
@click.option("--from", "record_path", metavar="RECORD", type=click.Path(path_type=Path), help="Take over its test.")
@click.option("--mapping", is_flag=True, help="Guess a mapping for `wirewear import` from a logger's FILES.")
@click.option("--output", metavar="FILE.toml", type=click.Path(path_type=Path, dir_okay=False),
              help="[default: NAME.toml, or mapping.toml beside the files]")  # fmt: skip
@click.option("--diameter", metavar="MM", type=float, help="Of the wires, for a mapping.")
@click.option("--material", metavar="NAME", default="steel", show_default=True, help="Of the wires, for a mapping.")
@click.option("--normal-load", metavar="N", type=float, help="For a mapping.  [default: the measured one]")
@click.option("--amplitude", metavar="UM", type=float, help="Half the stroke asked for.  [default: the measured one]")
@click.option("--frequency", metavar="HZ", type=float, help="For a mapping.  [default: by the column of time]")
@click.option("--cycles", type=click.IntRange(1), help="Length of the test.  [default: the last cycle logged]")
def new(
    names: tuple[Path, ...],
    kind: str,
    record_path: Path | None,
    mapping: bool,
    output: Path | None,
    diameter: float | None,
    material: str,
    normal_load: float | None,
    amplitude: float | None,
    frequency: float | None,
    cycles: int | None,
) -> None:
    """Begin a study NAME, or with --mapping an import of a logger's FILES."""
    if not mapping:
        _new_study(names, kind, record_path, output)
        return
    if record_path is not None:
        raise RecordError("--from takes a study's values over from a record, and does not go with --mapping.")
    known = {
        "diameter_mm": diameter,
        "normal_load_N": normal_load,
        "displacement_amplitude_um": amplitude,
        "frequency_Hz": frequency,
        "cycles": cycles,
    }
    _new_mapping(names, output, material, {key: value for key, value in known.items() if value is not None})


def _new_study(names: tuple[Path, ...], kind: str, record_path: Path | None, output: Path | None) -> None:
    from wirewear.cli.study_kinds import TEMPLATES, any_study
    from wirewear.files import prepared_folder, write_text
    from wirewear.files.toml import parsed_toml
    from wirewear.study.template import study_text

    if len(names) > 1:
        raise StudyError("a study has one name; --mapping guesses a mapping from several files.")
    path = output or names[0].with_name(f"{names[0].name.removesuffix('.toml')}.toml")
    data = above = None
    if record_path is not None and kind != "crossed-wires":
        raise StudyError(f"--from takes over a test of crossed wires, and does not go with --kind {kind}.")
    if record_path is not None:
        from wirewear.fitting.study_of_record import tables_of_record
        from wirewear.records import read_record

        data, above = tables_of_record(read_record(record_path)), f"The test of the record {record_path}."
    text = study_text(path.stem if path.stem != "study" else path.resolve().parent.name, data, above, TEMPLATES[kind])
    any_study(parsed_toml(text, str(path), StudyError), str(path))
    _require_new(path)
    prepared_folder(path.parent)
    write_text(path, text)
    click.echo(path)


def _new_mapping(files: tuple[Path, ...], output: Path | None, material: str, known: dict[str, Any]) -> None:
    from wirewear.files import write_text
    from wirewear.materials import material_named
    from wirewear.records.importing.guessing import guessed_mapping, with_files_from
    from wirewear.records.importing.mapping_text import mapping_text

    try:
        elastic = material_named(material).elastic
    except ValueError as problem:
        raise RecordError(f"--material {problem}.") from None
    known |= {"youngs_modulus_MPa": elastic.youngs_modulus_MPa, "poissons_ratio": elastic.poissons_ratio}
    with busy("reading the files"):
        guess = guessed_mapping(files, known)
    path = output or files[0].parent / "mapping.toml"
    if output is not None:
        guess = with_files_from(guess, files[0].parent, path.parent)
    _require_new(path)
    write_text(path, mapping_text(guess))
    for remark in guess.remarks:
        click.echo(f"{remark}.")
    click.echo(f"{path}\nlook through it, then: wirewear import {path} --output RECORD")


def _require_new(path: Path) -> None:
    if path.exists():
        raise StudyError(f"{path} exists already, and is not overwritten: choose another name, or remove it.")


@cli.command()
@click.argument("record_path", metavar="RECORD", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", required=True, type=click.Path(path_type=Path), help="Study, table, run.")
@click.option("--check", "fidelity", type=click.Choice(("none", *FIDELITIES)), default="quick", show_default=True,
              help="Check the fit by a run.")  # fmt: skip
@click.option("--wear-coefficient", metavar="mm3/J", type=click.FloatRange(0.0, 1.0, min_open=True),
              help="Of both wires together, where no scars were measured.")  # fmt: skip
@click.option("--worn-volume", metavar="mm3", type=click.FloatRange(0.0, 1e3, min_open=True),
              help="Of both wires at the end of a test, where no scars were measured.")  # fmt: skip
@click.option("--into-record", is_flag=True, help="Write the fitted values into the record's [stated], too.")
@click.option("--json", "as_json", is_flag=True, help="Print the fit as JSON.")
@most_memory
def fit(
    record_path: Path,
    output: Path,
    fidelity: str,
    wear_coefficient: float | None,
    worn_volume: float | None,
    into_record: bool,
    as_json: bool,
) -> None:
    """Fit friction, rig stiffness, play and wear coefficients to a record, each with its interval.

    Loops tell friction, rig and play. The wear coefficient takes a scar's volume, measured or given, as well.
    """
    import json

    from wirewear.files.locks import occupied
    from wirewear.fitting import GivenWear, check_by_run, fit_record
    from wirewear.fitting.report import check_table, fit_json, fit_table, write_fit, write_stated
    from wirewear.records import read_record
    from wirewear.report import write_page
    from wirewear.simulation import ProgressBar
    from wirewear.study_script import wide_console

    if wear_coefficient is not None and worn_volume is not None:
        raise click.UsageError("give either --wear-coefficient or --worn-volume: each follows from the other.")
    given = GivenWear(wear_coefficient, worn_volume)
    with busy("reading the record"):
        record = read_record(record_path)
    with occupied(output, f"fit {record_path}"):
        fitted = fit_record(
            record,
            given=None if given == GivenWear() else given,
            observer_of=lambda name: ProgressBar(f"{name}, first estimate"),
            stage=busy,
        )
        written = write_fit(fitted, output)
    checked = None
    if fidelity != "none":
        checked = check_by_run(fitted, output / "run", fidelity, lambda name: ProgressBar(f"{name}, fitted"))
        written.append(write_page([checked.result], output / "run"))
    if into_record:
        written.append(write_stated(fitted))
    if as_json:
        click.echo(json.dumps(fit_json(fitted, checked), indent=2, ensure_ascii=False))
        return
    console = wide_console(100)
    console.print(fit_table(fitted))
    if checked is not None:
        console.print(check_table(checked))
    for note in fitted.notes:
        click.echo(f"– {note}")
    for path in written:
        click.echo(path)
