"""The documentation: a site that builds whole, short pages, a reference of everything, and lines that run."""

import inspect
import json
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click
import pytest
from pydantic import BaseModel

import wirewear
from studies.blind.commands import exam
from tests.house.project import ODD
from tools.pictures import commands_of, every_picture
from tools.reference import pages
from wirewear.app.cli import cli
from wirewear.effects import all_effects
from wirewear.kinds import load_any_study
from wirewear.records.contact_tables import LineRecordTables
from wirewear.records.importing.mapping import LineMapping
from wirewear.records.importing.mapping import Mapping as RecordMapping
from wirewear.records.tables import RecordTables
from wirewear.strand.tables import RopeTables, load_rope
from wirewear.sweeps.tables import SweepTables, Vary
from wirewear.test.keys import table_of
from wirewear.test.lines import LineTables
from wirewear.test.many_contacts import many_contacts
from wirewear.test.tables import StudyTables

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs").rglob("*.md"))
READ_BY_PEOPLE = [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
MOST_WORDS = 1500
#: Of the whole site, with code and tables.
MOST_WORDS_OF_ALL = 21_000
#: Tables whose keys stand in the page of files.
IN_FILES = (RecordTables, LineRecordTables, RecordMapping, LineMapping, RopeTables, SweepTables, Vary)
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)


@pytest.mark.slow
def test_the_site_is_built_without_a_warning_and_without_the_network(tmp_path: Path) -> None:
    """Strict: a link or an anchor that leads nowhere, or a page that the menu lacks, stops it."""
    pytest.importorskip("material", reason="no MkDocs: pip install 'wirewear[docs]'")
    # Whatever asks for a connection fails.
    program = (
        "import socket, sys\n"
        "def refuse(*_): raise OSError('no network')\n"
        "socket.socket.connect = refuse\n"
        "from mkdocs.__main__ import cli\n"
        "cli(['build', '--strict', '--site-dir', sys.argv[1]])\n"
    )
    command = [sys.executable, "-c", program, str(tmp_path / "site")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NO_MKDOCS_2_WARNING": "1"}
    run = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert "WARNING" not in run.stderr
    site = tmp_path / "site"
    assert "Every key of a study" in (site / "reference" / "study.html").read_text(encoding="utf-8")
    loaded = re.findall(r"(?:src|href)=\"(https?://[^\"]+\.(?:js|css|woff2?))", (site / "index.html").read_text())
    assert loaded == []


@pytest.mark.parametrize("page", READ_BY_PEOPLE, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_is_read_in_a_few_minutes(page: Path) -> None:
    """Words of prose: code, tables and pictures are looked up, not read."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    prose = [line for line in text.splitlines() if not line.lstrip().startswith(("|", "!["))]
    assert len(" ".join(prose).split()) < MOST_WORDS


def test_all_pages_are_read_in_an_afternoon() -> None:
    """A word has a letter or a figure: the bars of tables are none."""
    site = [page for page in PAGES if page.parent.name != "paper"]
    words = [word for page in site for word in page.read_text(encoding="utf-8").split()]
    assert sum(any(map(str.isalnum, word)) for word in words) <= MOST_WORDS_OF_ALL


@pytest.mark.parametrize("page", READ_BY_PEOPLE, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_is_in_plain_english(page: Path) -> None:
    text = re.sub(r"`[^`]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))
    assert ODD.findall(text) == []


def test_the_limit_of_pairs_stands_wherever_an_answer_is_explained() -> None:
    for page in ("README.md", "docs/tutorial.md", "docs/diagnosis.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        assert re.search(r"[Tt]wo (effects|causes) at once", re.sub(r"\s+", " ", text)), page


@pytest.mark.parametrize("page", READ_BY_PEOPLE, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_links_to_exists(page: Path) -> None:
    links = re.findall(r"\]\(([^)#\s]+)", FENCE.sub("", page.read_text(encoding="utf-8")))
    targets = [(page.parent / link).resolve() for link in links if not link.startswith(("http", "mailto"))]
    assert [str(target) for target in targets if not target.exists()] == []


def keys(model: type[BaseModel], place: str = "") -> Iterator[tuple[str, str]]:
    """Every key of tables with its meaning."""
    for name, field in model.model_fields.items():
        table = table_of(field)
        if table is None:
            yield f"{place}{name}", field.description or ""
        else:
            yield from keys(table, f"{place}{name}.")


@pytest.mark.parametrize("model", [StudyTables, LineTables, *IN_FILES])
def test_every_key_has_a_meaning_and_stands_in_the_reference(model: type[BaseModel]) -> None:
    found = dict(keys(model))
    assert len(found) > 4
    assert [key for key, meaning in found.items() if not meaning] == []
    text = pages()["files.md" if model in IN_FILES else "study.md"]
    assert [key for key in found if f"`{key.rpartition('.')[2]}`" not in text] == []


def commands(group: click.Group, place: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    for name, command in group.commands.items():
        if isinstance(command, click.Group):
            yield from commands(command, (*place, name))
        else:
            yield (*place, name), command


EVERY_COMMAND = [
    (program, *found)
    for program, group in (("wirewear", cli), ("python -m studies.blind", exam))
    for found in commands(group)
]


def test_every_command_and_effect_stands_in_the_reference_and_says_what_it_does() -> None:
    made = pages()
    for program, place, command in EVERY_COMMAND:
        assert f"## {program} {' '.join(place)}\n" in made["commands.md"]
        assert command.help
        for option in (one for one in command.params if isinstance(one, click.Option)):
            assert all(flag in made["commands.md"] for flag in option.opts)
    for name in all_effects():
        assert f"## {name}\n" in made["effects.md"]


def test_every_public_name_has_a_docstring_and_stands_in_the_reference() -> None:
    text = pages()["python.md"]
    for name in wirewear.__all__:
        assert f"## `{name}" in text
        own = getattr(wirewear, name)
        assert name == "__version__" or inspect.getdoc(own)
        methods = inspect.getmembers(own, inspect.isfunction) if inspect.isclass(own) else []
        for method, function in methods:
            if not method.startswith("_") and function.__module__.startswith("wirewear"):
                assert function.__doc__, f"{name}.{method}"
                assert f"`{method}(" in text


def test_every_picture_is_shown_and_drawn_by_commands_of_its_own() -> None:
    """`tools/pictures.py` or the gallery has them; `make pictures` runs them."""
    shown = {
        str((page.parent / link).resolve().relative_to(ROOT / "docs"))
        for page in [*READ_BY_PEOPLE, *(ROOT / "studies").rglob("README.md")]
        for link in re.findall(r"!\[[^\]]*\]\(([^)#\s]+)", page.read_text(encoding="utf-8"))
    }
    kept = {str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.png")}
    assert kept == shown == set(every_picture())
    assert all(commands_of(picture)[-1].partition("  #")[2] for picture in kept)


def test_every_study_of_the_gallery_has_its_file_and_its_commands() -> None:
    _, *studies = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8").split("\n## ")
    assert len(studies) == 17
    for text in studies:
        if (rope := re.search(r"\[Rope\]\(\.\./([^)]+)\)", text)) is not None:
            load_rope(ROOT / rope[1])
            assert f"wirewear strand {rope[1]} " in text
            continue
        path = re.search(r"\[Study\]\(\.\./([^)]+)\)", text)
        assert path is not None
        assert many_contacts(ROOT / path[1]) or load_any_study(ROOT / path[1])
        assert f"wirewear run {path[1]} " in text


@pytest.mark.parametrize(("page", "load"), [("studies.md", load_any_study), ("strand.md", load_rope)])
def test_the_whole_study_and_rope_of_a_page_are_read(page: str, load: Callable[[Path], object], tmp_path: Path) -> None:
    blocks = FENCE.findall((ROOT / "docs" / page).read_text(encoding="utf-8"))
    (text,) = (block for language, block in blocks if language == "toml" and block.startswith("format = 1"))
    (path := tmp_path / "file.toml").write_text(text, encoding="utf-8")
    assert load(path)


EXAMS = tuple(f"python -m studies.blind {name}" for name in exam.commands)


def lines_of_commands() -> Iterator[tuple[str, str]]:
    """Every line of a block of code that calls wirewear or the exam, with its page; sketches are left out."""
    for page in READ_BY_PEOPLE:
        for language, block in FENCE.findall(page.read_text(encoding="utf-8")):
            if language in ("python", "toml"):
                continue
            for line in block.splitlines():
                written = line.split("  #")[0].strip().removeprefix(".venv/bin/")
                is_sketch = set(written) & set("[]…<>") or "..." in written
                if written.startswith(("wirewear ", *EXAMS)) and not is_sketch:
                    yield page.name, written


def test_every_command_in_the_docs_is_one_that_wirewear_takes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Names of commands, options and their values; whether the files exist is asked when it runs."""
    # Outputs are tried below the present folder.
    monkeypatch.chdir(tmp_path)
    written = sorted(set(lines_of_commands()))
    assert len(written) > 25
    refused = []
    for page, line in written:
        names = shlex.split(line)[len(EXAMS[0].split()) - 1 if line.startswith(EXAMS) else 1 :]
        try:
            context: click.Context | None = None
            command: click.Command = exam if line.startswith(EXAMS) else cli
            while isinstance(command, click.Group):
                context = click.Context(command, info_name=names[0], parent=context)
                command, names = command.commands[names[0]], names[1:]
            with command.make_context(command.name or "", names, parent=context):
                pass
        except (KeyError, click.UsageError, click.exceptions.Exit) as problem:
            refused.append(f"{page}: {line}: {problem!r}")
    assert refused == []


def test_every_program_that_a_page_names_exists() -> None:
    """Targets of make, modules, scripts and commands, in lines and within sentences."""
    named = re.compile(
        r"(?:^(?!wirewear)|`)(?:\.venv/bin/)?(make|python -m|python|wirewear) ([a-z_0-9./]*[a-z_0-9])", re.MULTILINE
    )
    targets = (ROOT / "Makefile").read_text(encoding="utf-8")
    known: dict[str, Callable[[str], object]] = {
        "make": lambda name: f"\n{name}:" in targets,
        "python -m": find_spec,
        "python": lambda name: (ROOT / name).exists(),
        "wirewear": cli.commands.get,
    }
    pages = [*READ_BY_PEOPLE, *(ROOT / "studies").rglob("README.md")]
    found = {(page, *one) for page in pages for one in named.findall(page.read_text(encoding="utf-8"))}
    assert len(found) > 50
    assert [one for one in found if not known[one[1]](one[2])] == []


@pytest.fixture
def coarse_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Runs of one cycle on a mesh coarser than any level, for code whose words matter and not its figures."""
    real = wirewear.run

    def run(study: wirewear.Study, **options: Any) -> wirewear.Run:
        coarse = {"conditions.cycles": 1, "log.loop_cycles": [1], "fidelity.quick.contact_mesh_um": 20}
        return real(study.with_values(coarse), **options, progress=False)

    monkeypatch.setattr(wirewear, "run", run, raising=False)
    (tmp_path / "studies").symlink_to(ROOT / "studies")
    monkeypatch.chdir(tmp_path)


@pytest.mark.slow
@pytest.mark.usefixtures("coarse_runs")
@pytest.mark.parametrize("page", ["README.md", "docs/python.md"])
def test_python_in_the_docs_runs(page: str, tmp_path: Path) -> None:
    blocks = [
        block for language, block in FENCE.findall((ROOT / page).read_text(encoding="utf-8")) if language == "python"
    ]
    assert blocks
    names: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    assert isinstance(names["run"], wirewear.Run)
    assert {path.name for path in tmp_path.iterdir()} <= {"studies", "run.nc"}


@pytest.mark.slow
@pytest.mark.usefixtures("coarse_runs")
def test_the_notebook_runs_and_shows_what_it_makes() -> None:
    notebook = json.loads((ROOT / "docs" / "first_run.ipynb").read_text(encoding="utf-8"))
    names: dict[str, Any] = {}
    shown = []
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            *before, last = "".join(cell["source"]).rstrip().split("\n")
            exec("\n".join(before), names)
            shown.append(eval(last, names))
            assert cell["outputs"] == []
    forms = [{name for name in ("_repr_html_", "_repr_png_") if hasattr(value, name)} for value in shown]
    assert all(forms)
    assert "<table" in shown[0]._repr_html_()
    assert shown[2]._repr_png_().startswith(b"\x89PNG")
