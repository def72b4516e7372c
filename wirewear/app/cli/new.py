"""Commands to start with: one writes a study or a mapping, one opens a workspace in a browser."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wirewear.app.cli.group import Given, OutputFile, OutputFolder, busy, cli, given
from wirewear.base import kinds
from wirewear.base.errors import RecordError, StudyError
from wirewear.base.files import is_special, parsed_toml
from wirewear.base.recognising import Held, recognised, require_no_other
from wirewear.base.words import as_sentence
from wirewear.base.writing import prepared_folder, usable_file, write_csv, write_text
from wirewear.kinds import any_study

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from wirewear.test.kinds import Kind


#: Keys of a record that options state.
_KEYS = {
    "diameter": "diameter_mm",
    "crossing_angle": "crossing_angle_deg",
    "length": "length_mm",
    "radius": "radius_mm",
    "face_half_width": "face_half_width_mm",
    "edge_radius": "edge_radius_mm",
    "normal_load": "normal_load_N",
    "amplitude": "displacement_amplitude_um",
    "frequency": "frequency_Hz",
    "cycles": "cycles",
}


@cli.command()
@click.argument("names", metavar="NAME | FILES... | FOLDER", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--kind", type=click.Choice([name for names in kinds.NAMES.values() for name in names]),
              default=kinds.CROSSED_WIRES, show_default=True, help="What is simulated.")  # fmt: skip
@click.option("--from", "record_path", metavar="RECORD", type=Given(), help="Take over its test.")
@click.option(
    "--mapping",
    is_flag=True,
    help="Guess a mapping for `wirewear import` from a logger's FILES, or for `wirewear lab` from a FOLDER of tests.",
)
@click.option("--output", metavar="FILE.toml", type=OutputFile(),
              help="[default: NAME.toml, or mapping.toml beside the files]")  # fmt: skip
@click.option("--diameter", metavar="MM", type=float, help="Of the wires, or the ball, for a mapping.")
@click.option("--length", metavar="MM", type=float, help="Of a line contact, for a mapping of one.")
@click.option("--radius", metavar="MM", type=float, help="Of a line contact's cylinder, for a mapping.")
@click.option("--face-half-width", metavar="MM", type=float, help="Of a flat pad's flat part, for a mapping.")
@click.option("--edge-radius", metavar="MM", type=float, help="Of a flat pad's rounded edges, for a mapping.")
@click.option("--crossing-angle", metavar="DEG", type=float, help="Between the wires, for a mapping.  [default: 90]")
@click.option("--material", metavar="NAME", help="Of both bodies, for a mapping.  [default: steel]")
@click.option("--pad-material", metavar="NAME", help="Of a line contact's pad, or of the ball.")
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
    material: str | None,
    pad_material: str | None,
    **stated: float | None,
) -> None:
    """Begin a study NAME, or with --mapping an import of a logger's FILES, or of a FOLDER of tests."""
    from wirewear.test.kinds import KINDS

    kind = next(name for name, names_of in kinds.NAMES.items() if kind in names_of)
    if not mapping:
        _new_study(names, kind, record_path, output)
        return
    if record_path is not None:
        raise RecordError("--from takes a study's values over from a record, and does not go with --mapping.")
    known = {_KEYS[option]: value for option, value in stated.items() if value is not None}
    lines = KINDS[kinds.LINE_CONTACT]
    by_options = not given("kind") and (pad_material is not None or known.keys() & lines.options)
    own = lines if by_options else KINDS[kind]
    foreign = {key for other in KINDS.values() for key in other.options & known.keys()} - own.options
    unfit = [option.replace("_", "-") for option, key in _KEYS.items() if key in foreign]
    for option in ["material"] * (material is not None and not own.body_names) + unfit:
        raise RecordError(f"--{option} does not go with the options of a {own.name}.")
    for option in (option for option, key in _KEYS.items() if key in known):
        _require_sensible(option, known[_KEYS[option]], own)
    _new_mapping(names, output, (material, pad_material or material), known, own)


def _require_sensible(option: str, value: float, kind: "Kind") -> None:
    """Check that an option lies in the range of its key in a mapping of this kind.

    Raises RecordError, naming the unit that the value seems to have, if it does not.
    """
    from wirewear.records.importing.mapping import MAPPINGS
    from wirewear.test.keys import Table, quantity_of, table_of

    def fields(table: type[Table]) -> "Iterator[FieldInfo]":
        for key, field in table.model_fields.items():
            yield from (field,) if key == _KEYS[option] else fields(own) if (own := table_of(field)) else ()

    try:
        for quantity in filter(None, map(quantity_of, fields(MAPPINGS[kind.name]))):
            quantity(value)
    except ValueError as problem:
        raise RecordError(as_sentence(f"--{option.replace('_', '-')} {problem}")) from None


def _new_study(names: tuple[Path, ...], kind: str, record_path: Path | None, output: Path | None) -> None:
    from wirewear.test.kinds import KINDS
    from wirewear.test.template import study_text

    if len(names) > 1:
        raise StudyError("a study has one name; --mapping guesses a mapping from several files.")
    if recognised(names[0]) == Held.NUMBERS:
        raise StudyError(f"{names[0]} holds numbers: `wirewear new --mapping {names[0]}` begins a mapping of it.")
    path = output or names[0].with_name(f"{names[0].name.removesuffix('.toml')}.toml")
    data = above = None
    if record_path is not None:
        data, above = _test_of(record_path, kind), f"The test of the record {record_path}."
        kind = str(data.pop("kind"))
    text = study_text(
        path.stem if path.stem != "study" else path.resolve().parent.name, KINDS[kind].template, data, above
    )
    any_study(parsed_toml(text, str(path), StudyError), str(path))
    _require_new(path)
    prepared_folder(path.parent)
    write_text(path, text)
    click.echo(path)


def _test_of(record_path: Path, kind: str) -> dict[str, Any]:
    """Tables of a study with the test of a record.

    Raises StudyError if --kind asks for another kind of contact than the record's.
    """
    from wirewear.diagnosis.fit.fit import tables_of_record
    from wirewear.records import read_record

    record = read_record(record_path)
    if given("kind") and kind != record.contact_kind:
        raise StudyError(
            f"{record_path} is a record of kind {record.contact_kind}, and gives no study of --kind {kind}."
        )
    return tables_of_record(record)


def _new_mapping(
    files: tuple[Path, ...],
    output: Path | None,
    materials: tuple[str | None, str | None],
    known: dict[str, Any],
    kind: "Kind",
) -> None:
    from wirewear.records.importing.campaign import MAPPING, TABLE, guessed_campaign
    from wirewear.records.importing.guessed_scars import Touching
    from wirewear.records.importing.guessing import guessed_mapping, mapping_text, with_files_from
    from wirewear.records.importing.text_reader import lines_to_fill_in
    from wirewear.test.bodies import OPEN

    # A pattern that names a whole folder also finds the mapping of an earlier try; two patterns may find the same file.
    files = tuple(dict.fromkeys(file for file in files if file.suffix != ".toml")) or files
    campaign = len(files) == 1 and files[0].is_dir()
    for file in files:
        require_no_other(file, RecordError, Held.FILES if campaign else Held.NUMBERS)
    path = output or usable_file((files[0] if campaign else files[0].parent) / MAPPING)
    if campaign and path.resolve().parent != files[0].resolve():
        raise RecordError(
            f"the mapping of a campaign stands in its folder: leave --output out, or give {files[0] / MAPPING}."
        )
    for place in (path, *([path.with_name(TABLE)] if campaign else [])):
        _require_new(place)
    own, pads = (
        _constants(option, name or "steel")
        for option, name in zip(("--material", "--pad-material"), materials, strict=True)
    )
    rows: list[dict[str, object]] = []
    with busy("reading the files"):
        touching = Touching.of(kind.name, known, own, pads)
        if campaign:
            guess, rows = guessed_campaign(files[0], known, touching)
        else:
            guess = guessed_mapping(files, known, touching)
    if output is not None and not campaign:
        guess = with_files_from(guess, files[0].parent, path.parent)
    if materials[0] is None and kind.body_names:
        modulus, ratio = own["youngs_modulus_MPa"], own["poissons_ratio"]
        assumed = f"the bodies are taken to be of steel, {modulus:g} MPa and {ratio:g}; --material says otherwise"
        guess = replace(guess, remarks=(assumed, *guess.remarks))
    prepared_folder(path.parent)
    text = mapping_text(guess)
    write_text(path, text)
    if rows:
        write_csv(path.with_name(TABLE), rows)
    for remark in guess.remarks:
        click.echo(as_sentence(remark))
    if left := lines_to_fill_in(text):
        click.echo(f'{path}\nfill in what stands as "{OPEN}" in {left}, then: wirewear import {path} --output RECORD')
        return
    then = f"lab {files[0]} --output CAMPAIGN" if campaign else f"import {path} --output RECORD"
    click.echo(f"{path}\nlook through it, then: wirewear {then}")


def _constants(option: str, name: str) -> dict[str, float]:
    from wirewear.test.materials import material_named

    try:
        elastic = material_named(name).elastic
    except ValueError as problem:
        raise RecordError(as_sentence(f"{option} {problem}")) from None
    return {"youngs_modulus_MPa": elastic.youngs_modulus_MPa, "poissons_ratio": elastic.poissons_ratio}


def _require_new(path: Path) -> None:
    if path.exists() and not is_special(path):
        raise StudyError(f"{path} exists already, and is not overwritten: choose another name, or remove it.")


@cli.command(name="open")
@click.argument("paths", metavar="[RECORD|RESULT|FILES]...", nargs=-1, type=Given())
@click.option("--output", metavar="DIR", type=OutputFolder(), default="runs/open", show_default=True,
              help="Where files and answers are kept; the same folder goes on.")  # fmt: skip
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="[default: any that is free]")
@click.option("--no-browser", is_flag=True, help="Print the address alone.")
def open_command(paths: tuple[Path, ...], output: Path, port: int, no_browser: bool) -> None:
    """Work in a browser: drop a logger's files, import, check, fit and diagnose them. Nobody else can see the pages."""
    import webbrowser

    from wirewear.app.web.server import WorkspaceServer
    from wirewear.app.web.workspace import Workspace
    from wirewear.base.locks import occupied

    with occupied(output, "open"):
        workspace = Workspace(output)
        for path in paths:
            workspace.take(path)
        with WorkspaceServer(workspace, port) as server:
            click.echo(f"Open this address in a browser: {server.url}\nKeep this running; Ctrl-C ends it.")
            try:
                if not no_browser:
                    webbrowser.open(server.door().as_uri())
                server.serve_forever()
            finally:
                workspace.stop()
