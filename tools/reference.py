"""The reference of the documentation, made from the code: keys, commands, effects, files and Python names."""

import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, get_args

import click
from pydantic import BaseModel, TypeAdapter
from pydantic.fields import FieldInfo

import wirewear
from studies.blind.commands import exam
from wirewear.app.cli import cli
from wirewear.base.units import UNIT_SYMBOLS, Quantity, unit_of, words_of
from wirewear.effects import Parameter, all_effects
from wirewear.records.contact_tables import RECORDS, LineRecordTables
from wirewear.records.importing.mapping import LineMapping
from wirewear.records.importing.mapping import Mapping as RecordMapping
from wirewear.records.tables import RecordTables
from wirewear.results import COLUMN_MEANINGS, EVOLUTION_COLUMNS, LATER_COLUMNS, hdf5
from wirewear.strand.tables import RopeTables
from wirewear.sweeps.tables import SweepTables, Vary
from wirewear.test.keys import quantity_of, table_of
from wirewear.test.lines import LineTables
from wirewear.test.points import BallOnFlatTables, PointTables
from wirewear.test.tables import StudyTables

#: Files that commands leave, and which page says more.
FILES = (
    ("`wirewear run`", "`report.html`", "the page of the run, or of all variants: open it in a browser"),
    ("", "`result.h5`", "everything computed, below"),
    ("", "`checkpoint.h5`", "where `--resume` goes on; gone once the run is complete"),
    ("", "`vtk/scar_<wire>.pvd`", "the worn surfaces over the cycles, for ParaView"),
    (
        "`wirewear show`",
        "`pictures/*.png`",
        "the pictures; `--format svg` or `pdf`, `--paper` for journals, `--animation`",
    ),
    ("`wirewear mesh`", "`moving.vtu`, `fixed.vtu`, `mesh.png`", "meshes with their named surfaces"),
    ("`wirewear compare`", "`comparison.html`", "simulation and experiment side by side, with its pictures"),
    ("", "`differences.csv`, `differences.json`", "every difference, in units and in scatters"),
    ("`wirewear diagnose`", "`report.html`, `diagnosis.json`", "the answer for people and for programs"),
    ("`wirewear export`", "a record, or tables", "[records](../records.md); CSV, Parquet or netCDF"),
    ("`wirewear import`", "a record", "[records](../records.md)"),
    ("`wirewear fit`", "`study.toml`, `stated.toml`, `run/`", "the fitted study, its `[stated]`, a run of it"),
    ("`wirewear maps`", "`maps.html`, `tests.csv`", "many tests on one page, and their table"),
    ("`wirewear sweep`", "`sweep.html`, `table.csv`, `table.parquet`", "the page of a sweep; a row for each run"),
    ("`wirewear strand`", "`strand.html`, `contacts.csv`, `section.png`", "contacts inside a rope, the worst first"),
    ("", "`studies/*.toml`", "a study of each contact"),
    ("`wirewear fields`", "`*.vtu`, `*.png`", "displacements and stresses inside the bodies"),
    ("`wirewear strength`", "`strength_*.vtu`, `strength_*.png`", "where wires yield, where cracks begin first"),
    ("`wirewear life`", "`life.html`, `life.json`, `life.csv`, `life_*.png`", "after how many cycles cracks begin"),
    ("`python -m studies.blind score`", "`score.html`, `score.json`", "how often diagnoses were right"),
    ("`wirewear converge`", "`convergence.csv`", "limits of all figures and their errors"),
)

#: TOML files beside studies: what each is, and its tables; the sweep's come last.
HEADS: tuple[tuple[str, str, type[BaseModel]], ...] = (
    ("experiment.toml", "The head of a record; [records](../records.md) says what lies beside it.", RecordTables),
    (
        "experiment.toml of a line contact",
        "The head of a line contact's record; [line contacts](../line_contacts.md) says what lies beside it.",
        LineRecordTables,
    ),
    (
        "experiment.toml of a ball on a flat",
        "The head of a record of a ball on a flat, and of a contact at a point but for the shapes of `[bodies]`.",
        RECORDS["ball-on-flat"],
    ),
    ("mapping.toml", "What `wirewear import` reads; [records](../records.md) has an example.", RecordMapping),
    (
        "mapping.toml of a line contact",
        "What `wirewear import` reads of a line contact; [records](../records.md#line-contacts) has an example.",
        LineMapping,
    ),
    (
        "rope.toml",
        "What `wirewear strand` reads; [from a rope to its contacts](../strand.md) has an example.",
        RopeTables,
    ),
    ("sweep.toml", "What `wirewear sweep` reads; [sweeps](../sweeps.md) has examples.", SweepTables),
)


def pages() -> dict[str, str]:
    """The text of each page by its file's name."""
    makers: Mapping[str, Callable[[], Iterator[str]]] = {
        "study.md": _study_page,
        "commands.md": _commands_page,
        "effects.md": _effects_page,
        "files.md": _files_page,
        "python.md": _python_page,
    }
    return {name: "\n".join(make()).rstrip() + "\n" for name, make in makers.items()}


def _study_page() -> Iterator[str]:
    yield "# Every key of a study"
    yield ""
    yield "A study is a TOML file. A key's name ends in its unit. What is required has no default."
    yield "A dash leaves the choice to the program."
    for title, tables in (
        ("Crossed wires", StudyTables),
        ("A ball on a flat", BallOnFlatTables),
        ("Contacts at a point", PointTables),
        ("Line contacts", LineTables),
    ):
        yield from ("", f"## {title}")
        yield from _tables(tables, "")
    yield from ("", "Tables `[variants.NAME.TABLE]` change keys of a study of crossed wires for one of its variants.")


def _tables(model: type[BaseModel], place: str) -> Iterator[str]:
    """The keys of a table, then the tables in it."""
    inner: list[tuple[str, type[BaseModel]]] = []
    rows = []
    for name, field in model.model_fields.items():
        table = table_of(field)
        if table is None:
            rows.append(_key_row(name, field))
        else:
            inner.append((name, table))
    if rows:
        yield from ("", f"### `[{place}]`" if place else "### At the head", "")
        yield from ("| key | unit | range | default | meaning |", "|---|---|---|---|---|", *rows)
    described: dict[type[BaseModel], str] = {}
    for name, held in inner:
        own = f"{place}.{name}" if place else name
        if held in described:
            yield from ("", f"### `[{own}]`", "", f"The same keys as `[{described[held]}]`.")
        else:
            described[held] = own
            yield from _tables(held, own)


def _key_row(name: str, field: FieldInfo) -> str:
    quantity = quantity_of(field)
    unit = "" if quantity is None else UNIT_SYMBOLS[quantity.unit].strip()
    default = "required" if field.is_required() else _shown(_written(field))
    return f"| `{name}` | {unit} | {_range(field, quantity)} | {default} | {_cell(field.description or '')} |"


def _range(field: FieldInfo, quantity: Quantity | None) -> str:
    if quantity is None:
        words = [word for part in (field.annotation, *get_args(field.annotation)) for word in get_args(part)]
        texts = [f'`"{word}"`' for word in words if isinstance(word, str)]
        texts += [f'`"{word}"`' for word in get_args(field.annotation) if isinstance(word, str)]
        return ", ".join(dict.fromkeys(texts))
    others = "".join(f', `"{word}"`' for word in quantity.words)
    multiple = f", multiples of {quantity.multiple_of}" if quantity.multiple_of > 1 else ""
    return f"{quantity.low:.12g} to {quantity.high:.12g}{multiple}{others}"


def _written(field: FieldInfo) -> Any:
    """A field's default as a file states it."""
    adapted: Any = Annotated[field.annotation, field]
    kind: TypeAdapter[Any] = TypeAdapter(adapted)
    return kind.dump_python(field.get_default(call_default_factory=True))


def _shown(value: Any) -> str:
    if value in (None, (), [], {}):
        return "–"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, int | float):
        return f"`{value:g}`"
    return f'`"{value}"`' if isinstance(value, str) else f'`"{getattr(value, "name", value)}"`'


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def _commands_page() -> Iterator[str]:
    yield "# Every command"
    yield ""
    yield "`wirewear COMMAND --help` prints the same. `python -m wirewear` is `wirewear`."
    context = click.Context(cli, info_name="wirewear")
    yield from _commands(cli, context)
    yield from _commands(exam, click.Context(exam, info_name="python -m studies.blind"))


def _commands(group: click.Group, context: click.Context) -> Iterator[str]:
    for name in group.list_commands(context):
        command = group.commands[name]
        own = click.Context(command, info_name=name, parent=context)
        if isinstance(command, click.Group):
            yield from _commands(command, own)
            continue
        usage = " ".join(command.collect_usage_pieces(own))
        yield from ("", f"## {own.command_path}", "", f"`{own.command_path} {usage}`", "")
        yield _cell(inspect.cleandoc(command.help or "")).replace("\\|", "|")
        options = [
            option.get_help_record(own) for option in command.get_params(own) if isinstance(option, click.Option)
        ]
        rows = [f"| `{record[0]}` | {_cell(record[1])} |" for record in options if record is not None]
        yield from ("", "| option | meaning |", "|---|---|", *(row.replace("`-h, --help`", "`--help`") for row in rows))


def _effects_page() -> Iterator[str]:
    yield "# Every effect"
    yield ""
    yield "[Effects](../effects.md) says how a study takes them. Each is a class in `wirewear/effects/`."
    for name, kind in all_effects().items():
        text = inspect.cleandoc(kind.__doc__ or "").split("\n\n", 1)
        yield from ("", f"## {name}", "", " ".join(text[0].split()))
        if len(text) > 1:
            yield from ("", " ".join(text[1].split()))
        yield from ("", f"It changes the {kind.seam.value}. In a record it shows as {kind.signature}.")
        if kind.confused_with:
            yield from ("", f"One record may take it for {', '.join(f'`{other}`' for other in kind.confused_with)}.")
        yield from ("", "| parameter | unit | range | easy, hard to see | meaning |", "|---|---|---|---|---|")
        yield from (_parameter_row(own, parameter) for own, parameter in kind.parameters().items())


def _parameter_row(name: str, parameter: Parameter) -> str:
    quantity = parameter.quantity
    share = f" × {parameter.share_of}" if parameter.share_of else ""
    words = "".join(f', `"{word}"`' for word in quantity.words)
    return (
        f"| `{name}` | {UNIT_SYMBOLS[quantity.unit].strip()} | {quantity.low:.12g} to {quantity.high:.12g}{words} | "
        f"{parameter.easy:g}, {parameter.hard:g}{share} | {_cell(parameter.meaning)} |"
    )


def _files_page() -> Iterator[str]:
    yield "# Every file"
    yield from ("", "## What commands leave", "", "| command | file | what it is |", "|---|---|---|")
    yield from (f"| {command} | {name} | {what} |" for command, name, what in FILES)
    yield from ("", "## result.h5", "", "```", *_layout(inspect.cleandoc(hdf5.__doc__ or "")), "```")
    yield from ("", "## Columns of the evolution", "", "| column | unit | what it is |", "|---|---|---|")
    for name in (*EVOLUTION_COLUMNS, *LATER_COLUMNS):
        yield f"| `{name}` | {unit_of(name)} | {COLUMN_MEANINGS.get(name, words_of(name))} |"
    for title, words, tables in HEADS:
        yield from ("", f"## {title}", "", words)
        yield from _tables(tables, "")
    yield from ("", "### `[[vary]]`", "", "| key | unit | range | default | meaning |", "|---|---|---|---|---|")
    yield from (_key_row(name, field) for name, field in Vary.model_fields.items())


def _layout(text: str) -> list[str]:
    return [line for line in text.split("\n") if line.startswith("    ") or not line.strip()][1:]


def _python_page() -> Iterator[str]:
    yield "# Every name from Python"
    yield ""
    yield "`import wirewear as ww`. [From Python](../python.md) shows them at work."
    for name in wirewear.__all__:
        if name == "__version__":
            yield from ("", "## `__version__`", "", "The version of the program.")
            continue
        own = getattr(wirewear, name)
        if inspect.ismodule(own):
            yield from ("", f"## `{name}`", "", _first(own.__doc__))
            continue
        yield from ("", f"## `{name}{_signature(own)}`", "", _first(own.__doc__))
        if inspect.isclass(own):
            yield from _members(own)


def _members(kind: type) -> Iterator[str]:
    """Public methods and properties that wirewear itself gives to a class."""
    rows = []
    for name, own in inspect.getmembers_static(kind):
        home = next((base for base in kind.__mro__ if name in vars(base)), kind)
        if name.startswith("_") or not home.__module__.startswith("wirewear"):
            continue
        plain = own.__func__ if isinstance(own, classmethod | staticmethod) else own
        if isinstance(plain, property):
            rows.append(f"| `{name}` | {_cell(_first(plain.__doc__))} |")
        elif inspect.isfunction(plain):
            rows.append(f"| `{name}{_signature(plain)}` | {_cell(_first(plain.__doc__))} |")
    if rows:
        yield from ("", "| name | what it is |", "|---|---|", *(_cell_signature(row) for row in rows))


def _cell_signature(row: str) -> str:
    head, _, rest = row.partition("` | ")
    return f"{head[:2]}{head[2:].replace('|', chr(92) + '|')}` | {rest}"


def _signature(own: Any) -> str:
    try:
        parameters = inspect.signature(own).parameters
    except (TypeError, ValueError):
        return ""
    if inspect.isclass(own) and issubclass(own, BaseException):
        return ""
    names = [_parameter(one) for name, one in parameters.items() if name != "self"]
    return f"({', '.join(names)})"


def _parameter(own: inspect.Parameter) -> str:
    stars = "*" if own.kind is own.VAR_POSITIONAL else "**" if own.kind is own.VAR_KEYWORD else ""
    default = "…" if inspect.isfunction(own.default) else repr(own.default)
    return f"{stars}{own.name}" + ("" if own.default is own.empty else f"={default}")


def _first(text: str | None) -> str:
    return " ".join(inspect.cleandoc(text or "").split("\n\n")[0].split())
