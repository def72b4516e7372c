"""`wirewear open`: a workspace's steps are commands, pages are its owner's alone, and nothing that was made is lost."""

import json
from collections.abc import Iterator
from pathlib import Path
from time import monotonic, sleep

import pytest

import wirewear.app.cli.commands
from tests.app.workspaces import asked, ended, step
from tests.browser import TOO_WIDE, Page, browser, needs_browser
from wirewear.app.cli import cli
from wirewear.app.web.server import LOOPBACK, WorkspaceServer
from wirewear.app.web.workspace import STEPS, Workspace
from wirewear.base.errors import RunError
from wirewear.base.recognising import example

__all__ = ["wirewear"]
RECORD = example("no_gap")
HEADER = "Time (s);Displacement (um);Force (N)\n"


@pytest.fixture(scope="module")
def chromium() -> Iterator[Page]:
    with browser() as page:
        yield page


@pytest.fixture
def page(chromium: Page, server: WorkspaceServer) -> Iterator[Page]:
    """Of one browser for all tests; it asks the server no more when that ends."""
    chromium.problems.clear()
    yield chromium
    assert not chromium.problems
    chromium.open("about:blank")


def logged() -> str:
    """One cycle of the example, as a logger writes it."""
    assert RECORD is not None
    rows = [line.split(",") for line in (RECORD / "loops.csv").read_text(encoding="utf-8").splitlines()[1:]]
    return HEADER + "".join(
        f"{t};{x};{q}\n" for repeat, cycle, _, t, x, q, *_ in rows if (repeat, cycle) == ("1", "100")
    )


def test_every_step_is_a_command_and_its_options_are_the_commands_own() -> None:
    for one in STEPS:
        flags = {flag for parameter in cli.commands[one.command].params for flag in parameter.opts}
        assert {option["flag"] for option in one.options} <= flags


@pytest.mark.parametrize("secret", ["", "guessed"])
def test_who_does_not_know_the_address_sees_nothing(server: WorkspaceServer, secret: str) -> None:
    host = server.url.removesuffix(f"{server.secret}/")
    assert asked(f"{host}{secret}/state")[0] == 404
    assert asked(f"{server.url}state", Host="elsewhere.example")[0] == 404
    assert server.server_address[0] == LOOPBACK


def test_nothing_outside_the_folder_is_served_or_written(server: WorkspaceServer, tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("mine", encoding="utf-8")
    (server.workspace.folder / "link").symlink_to(tmp_path / "secret.txt")
    for place in ("out/%2e%2e/secret.txt", "out/..%2fsecret.txt", "out/link", "out//etc/passwd"):
        assert asked(server.url + place)[0] == 404
    assert asked(server.url + "files/..%2F..%2Fescaped.csv", "PUT", b"1")[0] == 200
    assert not (tmp_path / "escaped.csv").exists()
    assert (server.workspace.folder / "files" / "escaped.csv").read_bytes() == b"1"
    assert asked(server.url + "files/..", "PUT", b"1")[0] == 409


def test_what_is_made_again_is_put_aside_and_a_step_waits_for_what_it_needs(workspace: Workspace) -> None:
    for text in ("first", "second", "third"):
        workspace.write_mapping(text)
    workspace.add("a.csv", b"1")
    workspace.add("a.csv", b"2")
    kept = sorted(path.read_text(encoding="utf-8") for path in (workspace.folder / "earlier").iterdir())
    assert kept == ["1", "first", "second"]
    assert workspace.state()["mapping"] == "third"
    assert not step(workspace, "check")["ready"]
    with pytest.raises(RunError, match="record is not there yet"):
        workspace.start("check", {})
    with pytest.raises(RunError, match="no step"):
        workspace.start("destroy", {})


def test_what_is_nothing_of_ours_is_refused(workspace: Workspace, tmp_path: Path) -> None:
    with pytest.raises(RunError, match="no record, result or file"):
        workspace.take(tmp_path)


@pytest.mark.seconds
def test_a_record_that_was_opened_is_checked_where_it_lies(server: WorkspaceServer) -> None:
    assert RECORD is not None
    server.workspace.take(RECORD)
    status, answer = asked(f"{server.url}steps/check", "PUT", json.dumps({"--no-such": "1"}).encode())
    assert status == 200
    assert json.loads(answer)["opened"] == {"record": str(RECORD)}
    state = ended(server.workspace, "check")
    assert state["state"] == "done"
    assert any("Nothing odd was found" in line for line in state["lines"])


@pytest.mark.seconds
@needs_browser
def test_a_bar_shows_how_far_a_step_is(server: WorkspaceServer, page: Page) -> None:
    """Of a run the decades of its cycles, of other work that it goes on: then it has no value, and is at -1."""
    page.open(server.url, 390, 800, phone=True)
    page.value("const given = JSON.parse(find('data').textContent), one = given.steps.find(s => s.name === 'diagnose')")
    places = []
    for line in ("steel: cycle 100 of 100\u2009000  0.02 J", "searching for causes"):
        # In one go: the page asks every second for what there is.
        place, said = page.value(
            f"one.state = 'running'; one.lines.push('wirewear: {line}'); show(given);"
            "[find('step-diagnose').querySelector('progress').position,"
            " find('step-diagnose').querySelector('.note').textContent]"
        )
        places.append(place)
        assert line in said
    assert places == [pytest.approx(0.4), -1]
    assert page.value(TOO_WIDE) == []


@pytest.mark.slow
@needs_browser
def test_files_that_are_dropped_become_a_record_in_the_browser(server: WorkspaceServer, page: Page) -> None:
    workspace = server.workspace
    page.open(server.url)
    dropped = json.dumps(logged())
    page.value(f"put([new File([{dropped}], 'cycle100.csv')])")
    choose_kind(page, "crossed-wires")
    for flag, value in (("diameter", "0.45"), ("normal-load", "2"), ("cycles", "100")):
        page.value(f"document.querySelector('#step-guess [data-flag=\"--{flag}\"]').value = '{value}'")
    for name in ("guess", "look", "import", "check", "loops"):
        start(page, workspace, name)
    assert step(workspace, "loops")["left"] == ["loops.png"]
    wait_for(page, "document.querySelector('#step-loops img')?.naturalWidth > 100")
    assert "diameter_mm = 0.45" in page.value("document.querySelector('textarea').value")
    page.open(server.url, 390, 800, phone=True)
    assert page.value(TOO_WIDE) == []
    assert (workspace.folder / "record" / "experiment.toml").is_file()


@pytest.mark.seconds
@needs_browser
def test_values_come_in_units_of_menus_and_a_columns_unit_is_written_into_the_mapping(
    server: WorkspaceServer, page: Page
) -> None:
    workspace = server.workspace
    workspace.add("test.csv", HEADER.encode())
    workspace.write_mapping('[loops.columns]\ndisplacement_um = { column = "Weg", unit = "mm" }\n')
    page.open(server.url)
    choose_kind(page, "ball-on-flat")
    for flag, value, unit in (("diameter", "500", "µm"), ("normal-load", "1,5", "kgf"), ("amplitude", "30", "µm")):
        page.value(
            f"(field => {{ field.value = '{value}'; [...field.parentElement.querySelectorAll('.unit option')]"
            f".find(one => one.textContent === '{unit}').selected = true; }})"
            f"(document.querySelector('#step-guess [data-flag=\"--{flag}\"]'))"
        )
    chosen = json.loads(page.value("chosen(find('step-guess'))"))
    asked_for = {flag: chosen[f"--{flag}"] for flag in ("diameter", "normal-load", "amplitude")}
    assert asked_for == {"diameter": "0.5", "normal-load": "14.709975", "amplitude": "30"}
    menu = "document.querySelector('#step-look .options select')"
    wait_for(page, f"{menu} !== null")
    page.value(f"{menu}.value = 'nm'; {menu}.dispatchEvent(new Event('change', {{bubbles: true}}))")
    page.value("save(shown.get('look'))")
    assert 'unit = "nm"' in str(workspace.state()["mapping"])


@pytest.mark.slow
@needs_browser
def test_a_folder_is_a_campaign_and_what_a_step_leaves_may_be_saved(server: WorkspaceServer, page: Page) -> None:
    workspace = server.workspace
    page.open(server.url)
    assert not page.value("find('step-lab')")
    names = ["A/raw.csv", "B/raw.csv", ".DS_Store"]
    page.value(f"putFolder({json.dumps(names)}.map(name => [name, new File([{json.dumps(logged())}], 'raw.csv')]))")
    files = workspace.folder / "campaign"
    assert sorted(path.relative_to(files).as_posix() for path in files.rglob("*.csv")) == names[:2]
    choose_kind(page, "crossed-wires", "guess_all")
    for flag, value in (("diameter", "0.45"), ("normal-load", "2")):
        page.value(f"document.querySelector('#step-guess_all [data-flag=\"--{flag}\"]').value = '{value}'")
    for name in ("guess_all", "lab"):
        start(page, workspace, name)
    wait_for(page, "document.querySelector('#step-lab a[download=\"lab_lab.csv\"]') !== null")
    assert page.value("find('steps').firstChild.id") == "step-guess_all"
    assert "2 tests: 2 good." in page.value("document.querySelector('#step-lab pre').textContent")
    for name in ("campaign/..%2Fescaped.csv", "campaign/%2Fescaped.csv", "campaign/.hidden%2Fa.csv"):
        assert asked(server.url + name, "PUT", b"1")[0] == 409


def choose_kind(page: Page, kind: str, step: str = "guess") -> None:
    chosen = f"document.querySelector('#step-{step} [data-flag=\"--kind\"]')"
    page.value(f"{chosen}.value = '{kind}'; {chosen}.dispatchEvent(new Event('change', {{bubbles: true}}))")


@pytest.mark.seconds
@needs_browser
def test_the_page_presets_no_kind_names_units_and_mentions_no_command_options(
    server: WorkspaceServer, page: Page
) -> None:
    server.workspace.add("test.csv", HEADER.encode())
    go, labels = "document.querySelector('#step-guess button')", "[...document.querySelectorAll('#step-guess label')]"
    visible = f"{labels}.filter(one => !one.hidden).map(one => one.textContent)"
    page.open(server.url)
    assert page.value(f"{go}.disabled")
    choose_kind(page, "ball-on-flat")
    wait_for(page, f"!{go}.disabled")
    shown = page.value(visible)
    assert any("mm" in one and "diameter" in one for one in shown)
    assert not any("length" in one for one in shown)
    page.value("document.querySelectorAll('#step-guess .kind')[2].click()")
    wait_for(page, f"{visible}.some(one => one.includes('length'))")
    assert page.value(f"{go}.parentElement.querySelector('[aria-pressed=true]').textContent") == "cylinder on flat"
    assert not any("diameter" in one for one in page.value(visible))
    assert "--" not in page.value("document.body.innerText")
    assert page.value("forPage('say --pad-material NAME')") == "say “pad material” NAME"
    assert page.value("forPage('then: wirewear fit record --output DIR')") == "then: “Fit friction, rig and wear”"


@pytest.mark.seconds
@needs_browser
def test_refusals_stay_on_the_page_and_unsaved_edits_in_their_field(server: WorkspaceServer, page: Page) -> None:
    page.open(server.url)
    page.value("put([new File(['1'], '.hidden'), new File(['1;2'], 'a.csv')])")
    wait_for(page, "find('files').textContent.includes('a.csv')")
    page.value("ask('GET', 'state')")
    assert "no name of a file" in page.value("find('problem').hidden ? '' : find('problem').textContent")
    # A folder that is dropped, which cannot be read, keeps no other file from being put.
    page.value(
        "window.was = fetch; window.fetch = (to, how) => to.includes('folder') ? Promise.reject() : was(to, how)"
    )
    page.value("put([new File([''], 'folder'), new File(['3;4'], 'b.csv')])")
    assert "folder was not taken" in page.value("find('problem').textContent")
    assert (server.workspace.folder / "files" / "b.csv").is_file()
    page.value("window.fetch = (to, how) => how.method === 'PUT' ? Promise.reject() : was(to, how)")
    page.value(
        "window.edit = document.querySelector('textarea'); edit.value = 'mine'; edit.oninput(); save(shown.get('look'))"
    )
    server.workspace.write_mapping("of another tab")
    page.value("ask('GET', 'state')")
    assert page.value("edit.value") == "mine"
    # The browser itself says of a refusal that it is one.
    page.problems.clear()


def start(page: Page, workspace: Workspace, name: str) -> None:
    wait_for(page, f"!document.querySelector('#step-{name} button').disabled")
    page.value(f"document.querySelector('#step-{name} button').click()")
    began = monotonic()
    while step(workspace, name)["state"] == "idle" and monotonic() - began < 20.0:
        sleep(0.1)
    state = ended(workspace, name)
    assert state["state"] == "done", state["lines"]
    wait_for(page, f"document.querySelector('#step-{name} .note').textContent.startsWith('done')")


def wait_for(page: Page, what: str) -> None:
    began = monotonic()
    while not page.value(what):
        assert monotonic() - began < 20.0, what
        sleep(0.1)
