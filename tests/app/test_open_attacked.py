"""`wirewear open` under attack: uploads that break off or race, requests that are none, other users, signals."""

import errno
import json
import os
import signal
import socket
import stat
import subprocess
import sys
import webbrowser
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest

from tests.app.workspaces import asked, ended, step
from tests.commands import wirewear
from wirewear.app.web import server as server_module
from wirewear.app.web import workspace as workspace_module
from wirewear.app.web.server import LOOPBACK, WorkspaceServer
from wirewear.app.web.workspace import AS_STEP, Workspace


def sent(server: WorkspaceServer, request: bytes, *, wait_s: float = 60.0) -> bytes:
    """What the server answers to bytes after which the client sends no more."""
    with socket.create_connection((LOOPBACK, server.server_address[1]), timeout=wait_s) as client:
        client.sendall(request)
        client.shutdown(socket.SHUT_WR)
        answer = b""
        while part := client.recv(65_536):
            answer += part
        return answer


def put(server: WorkspaceServer, place: str, *headers: str, body: bytes = b"", secret: str | None = None) -> bytes:
    lines = [
        f"PUT /{server.secret if secret is None else secret}/{place} HTTP/1.1",
        f"Host: {LOOPBACK}:{server.server_address[1]}",
        *headers,
    ]
    return sent(server, "\r\n".join([*lines, "", ""]).encode("latin-1") + body)


def kept(workspace: Workspace) -> list[bytes]:
    return sorted(path.read_bytes() for name in ("files", "earlier") for path in (workspace.folder / name).glob("*"))


def test_all_versions_of_files_that_come_at_once_are_kept(server: WorkspaceServer) -> None:
    versions = sorted(f"version {k}".encode() for k in range(60))
    with ThreadPoolExecutor(60) as pool:
        answers = list(pool.map(lambda version: asked(f"{server.url}files/a.csv", "PUT", version)[0], versions))
    assert answers == [200] * 60
    assert kept(server.workspace) == versions


def test_a_version_that_was_put_aside_is_never_overwritten(workspace: Workspace) -> None:
    for k in range(3):
        workspace.add("a.csv", b"%d" % k)
    (workspace.folder / "earlier" / "1_a.csv").unlink()
    for k in range(3, 6):
        workspace.add("a.csv", b"%d" % k)
    assert kept(workspace) == [b"1", b"2", b"3", b"4", b"5"]


@pytest.mark.parametrize(
    ("headers", "body"),
    [
        (["Content-Length: 1000"], b"1;2\n3;4\n"),
        (["Transfer-Encoding: chunked"], b"8\r\n1;2\n"),
        (["Transfer-Encoding: chunked", "Content-Length: 8"], b"1;2\n3;4\n"),
        (["Content-Length: abc"], b""),
        (["Content-Length: -1"], b""),
        (["Content-Length: 1_0"], b"1;2\n3;4\n5;"),
        (["Content-Length: 4", "Content-Length: 8"], b"1;2\n3;4\n"),
        (["Content-Length: 99999999999"], b""),
        ([], b""),
    ],
)
@pytest.mark.parametrize("place", ["files/x.csv", "mapping"])
def test_an_upload_that_is_not_whole_changes_nothing(
    server: WorkspaceServer, capfd: pytest.CaptureFixture[str], place: str, headers: list[str], body: bytes
) -> None:
    server.workspace.add("x.csv", b"whole")
    server.workspace.write_mapping("whole")
    assert put(server, place, *headers, body=body).startswith(b"HTTP/1.0 400 ")
    assert kept(server.workspace) == [b"whole"]
    assert (server.workspace.folder / "mapping.toml").read_text(encoding="utf-8") == "whole"
    assert not list(server.workspace.folder.glob(".*"))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["", ".", "%2F", "%5C", ".."])
def test_a_name_of_nothing_replaces_no_folder(server: WorkspaceServer, name: str) -> None:
    server.workspace.add("a.csv", b"whole")
    assert asked(f"{server.url}files/{name}", "PUT", b"torn")[0] == 409
    assert kept(server.workspace) == [b"whole"]


def test_what_a_system_hides_among_the_files_is_no_measurement(workspace: Workspace) -> None:
    workspace.add("a.csv", b"whole")
    (workspace.folder / "files" / ".DS_Store").write_bytes(b"Bud1")
    assert workspace.state()["files"] == ["a.csv"]


def test_a_mapping_that_does_not_fit_on_the_disk_leaves_the_one_before_in_its_place(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    workspace.write_mapping("whole")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        workspace.write_mapping("torn")
    assert [path.name for path in workspace.folder.iterdir()] == ["mapping.toml"]
    assert (workspace.folder / "mapping.toml").read_text(encoding="utf-8") == "whole"


@pytest.mark.parametrize("headers", [["Host: elsewhere"], ["Origin: http://elsewhere"], ["Origin: null"]])
def test_who_knows_the_address_must_come_from_its_page(server: WorkspaceServer, headers: list[str]) -> None:
    assert put(server, "mapping", *headers, "Content-Length: 1", body=b"x").startswith(b"HTTP/1.0 404 ")
    home = f"Origin: http://{LOOPBACK}:{server.server_address[1]}"
    assert put(server, "mapping", home, "Content-Length: 1", body=b"x").startswith(b"HTTP/1.0 200 ")


@pytest.mark.parametrize("address", ["http://[/", "a%00b", "l" * 300, "out/a%00b", f"out/{'l' * 300}", "%ff%fe"])
def test_an_address_that_is_none_is_answered_so(
    server: WorkspaceServer, capfd: pytest.CaptureFixture[str], address: str
) -> None:
    whole = address if address.startswith("http") else f"/{server.secret}/{address}"
    host = f"{LOOPBACK}:{server.server_address[1]}"
    for method in ("GET", "PUT"):
        answer = sent(server, f"{method} {whole} HTTP/1.1\r\nHost: {host}\r\nContent-Length: 0\r\n\r\n".encode())
        head, _, said = answer.partition(b"\r\n\r\n")
        assert head.startswith((b"HTTP/1.0 400 ", b"HTTP/1.0 404 "))
        assert head.startswith(b"HTTP/1.0 400 ") == (address != "%ff%fe")
        assert b"400" not in head[:13] or b"\n" not in said
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "options",
    [
        b"null", b"[1]", b"{", b"[" * 100_000, b'{"--diameter": 1}', b'{"--diameter": "0.45 mm"}',
        b'{"--diameter": {}}', b'{"--material": "a\\u0000b"}', b'{"--material": "\\ud800"}', b'{"--cycles": "-3"}',
        b"\xff",
    ],
)  # fmt: skip
def test_options_are_looked_at_before_anything_is_put_aside(
    server: WorkspaceServer, capfd: pytest.CaptureFixture[str], options: bytes
) -> None:
    server.workspace.add("x.csv", b"1;2\n")
    server.workspace.write_mapping("mine")
    status, said = asked(f"{server.url}steps/guess", "PUT", options)
    assert status == 400
    assert said.count(b"\n") == 0
    assert (server.workspace.folder / "mapping.toml").read_text(encoding="utf-8") == "mine"
    assert not (server.workspace.folder / "earlier").exists()
    assert capfd.readouterr() == ("", "")


def test_a_name_that_is_too_long_to_be_put_aside_is_refused(server: WorkspaceServer) -> None:
    assert asked(f"{server.url}files/{'l' * 300}.csv", "PUT", b"1")[0] == 400
    assert asked(f"{server.url}files/{'l' * 250}.csv", "PUT", b"1")[0] == 400
    assert asked(f"{server.url}files/{'l' * 150}.csv", "PUT", b"1")[0] == 200


def test_nothing_is_read_of_who_does_not_know_the_address(server: WorkspaceServer) -> None:
    """The answer comes while the body that was announced does not."""
    with socket.create_connection((LOOPBACK, server.server_address[1]), timeout=60.0) as client:
        host = f"{LOOPBACK}:{server.server_address[1]}"
        client.sendall(
            f"PUT /guessed/files/a.csv HTTP/1.1\r\nHost: {host}\r\nContent-Length: 499000000\r\n\r\n".encode()
        )
        assert client.recv(20).startswith(b"HTTP/1.0 404 ")


def test_who_sends_slowly_is_cut_off(server: WorkspaceServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server_module, "_HEAD_s", 0.3)

    def drip(client: socket.socket) -> None:
        for _ in range(100):
            client.sendall(b"X")
            sleep(0.05)

    with socket.create_connection((LOOPBACK, server.server_address[1])) as client, pytest.raises(ConnectionError):
        drip(client)
    assert asked(f"{server.url}state")[0] == 200


def test_who_knows_the_address_is_answered_however_many_wait_without_a_word(server: WorkspaceServer) -> None:
    with ExitStack() as all_open:
        place = LOOPBACK, server.server_address[1]
        idle = [all_open.enter_context(socket.create_connection(place, timeout=60.0)) for _ in range(210)]
        assert asked(f"{server.url}state")[0] == 200
        assert idle[0].recv(1) == b""


def test_a_port_that_is_taken_is_stated_in_one_sentence(server: WorkspaceServer, tmp_path: Path) -> None:
    words = ("open", "--no-browser", "--port", server.server_address[1], "--output", tmp_path / "other")
    said = wirewear(*words, code=2).stderr
    assert "cannot be used: address already in use; without --port any that is free is taken." in said
    assert said.count("\n") == 1


def test_a_step_that_is_stopped_while_it_starts_says_so(workspace: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    loading = "import time; print('loading'); time.sleep(20)"
    monkeypatch.setattr(workspace_module, "AS_STEP", AS_STEP.replace("from wirewear.app.cli import main", loading))
    workspace.add("a.csv", b"1;2\n")
    workspace.start("guess", {})
    while not step(workspace, "guess")["lines"]:
        sleep(0.02)
    workspace.stop()
    state = ended(workspace, "guess", 10.0)
    assert state["lines"] == ["loading", "wirewear: interrupted; nothing was written."]
    assert state["state"] == "failed"


def test_names_that_are_no_text_and_such_a_mapping_leave_the_page_as_it_is(server: WorkspaceServer) -> None:
    (server.workspace.folder / "files").mkdir()
    (server.workspace.folder / "files" / os.fsdecode(b"bad\xff.csv")).touch()
    (server.workspace.folder / "mapping.toml").write_bytes("# Messgröße\n".encode("latin-1"))
    assert "Messgr\ufffd" in json.loads(asked(f"{server.url}state")[1])["mapping"]
    assert asked(server.url)[0] == 200


def test_a_step_that_has_ended_is_sent_no_signal(workspace: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    """The system may have given its number to processes of somebody else."""
    monkeypatch.setattr(workspace_module, "AS_STEP", "print('done')")
    workspace.add("a.csv", b"1;2\n")
    workspace.start("guess", {})
    ended(workspace, "guess")
    sent_to: list[int] = []
    monkeypatch.setattr(os, "killpg", lambda group, _: sent_to.append(group))
    workspace.stop()
    assert sent_to == []


def test_a_look_whose_pictures_cannot_be_moved_ends(workspace: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workspace_module, "AS_STEP", "open('record_first_loop.png', 'w'); open('first_look', 'w')")
    workspace.write_mapping("")
    workspace.start("look", {})
    assert "its pictures stay in" in ended(workspace, "look", 20.0)["lines"][-1]
    assert step(workspace, "look")["state"] == "done"


def test_a_browser_is_given_a_file_of_its_owner_and_no_secret(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given: dict[str, Any] = {}

    def opened(url: str) -> bool:
        path = Path(url.removeprefix("file://"))
        given.update(url=url, text=path.read_text(encoding="utf-8"), mode=stat.S_IMODE(path.stat().st_mode))
        return True

    def interrupted(self: WorkspaceServer) -> None:
        given["secret"] = self.secret
        raise KeyboardInterrupt

    monkeypatch.setattr(webbrowser, "open", opened)
    monkeypatch.setattr(WorkspaceServer, "serve_forever", interrupted)
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    wirewear("open", "--output", tmp_path / "workspace", code=130)
    assert given["mode"] == 0o600
    assert given["secret"] in given["text"]
    assert given["secret"] not in given["url"]
    assert not list((tmp_path / "workspace").glob("*.html"))


@contextmanager
def opened(folder: Path, *words: str) -> "Iterator[tuple[subprocess.Popen[str], str]]":
    """A workspace as a process of its own, and its address."""
    command = [sys.executable, "-m", "wirewear", "open", *words, "--no-browser", "--output", str(folder)]
    environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
    try:
        assert process.stdout is not None
        yield process, process.stdout.readline().rpartition(" ")[2].strip()
    finally:
        process.kill()
        process.communicate()


@pytest.mark.seconds
def test_a_second_desk_is_refused_before_it_touches_the_folder(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.csv").write_text(f"1;{name}\n2;3\n", encoding="utf-8")
    with opened(tmp_path / "workspace", str(tmp_path / "one" / "a.csv")):
        refused = wirewear(
            "open", tmp_path / "two" / "a.csv", "--no-browser", "--output", tmp_path / "workspace", code=2
        )
        assert "another command is writing" in refused.stderr
        assert "one" in (tmp_path / "workspace" / "files" / "a.csv").read_text(encoding="utf-8")
        assert not (tmp_path / "workspace" / "earlier").exists()


@pytest.mark.seconds
@pytest.mark.parametrize("name", ["SIGKILL", "SIGTERM", pytest.param("SIGHUP", marks=pytest.mark.slow)])
def test_a_step_ends_with_the_desk(tmp_path: Path, name: str) -> None:
    with opened(tmp_path / "workspace", "no_gap") as (process, url):
        assert asked(f"{url}steps/diagnose", "PUT", b"{}")[0] == 200
        steps = Path(f"/proc/{process.pid}/task").glob("*/children")
        (step,) = {int(pid) for path in steps for pid in path.read_text(encoding="ascii").split()}
        assert json.loads(asked(f"{url}state")[1])["opened"]
        process.send_signal(signal.Signals[name])
        process.wait(10.0)
        began = monotonic()
        while Path(f"/proc/{step}/cmdline").exists() and Path(f"/proc/{step}/cmdline").read_bytes():
            assert monotonic() - began < 10.0
            sleep(0.05)
        assert process.stdout is not None
        assert "Traceback" not in process.stdout.read()


@pytest.mark.seconds
def test_a_step_ends_with_the_desk_though_it_is_in_a_compiled_function() -> None:
    """Which lets no other thread of Python run, and no signal's handler."""
    started = "from wirewear.app.web.workspace import end_with_input; end_with_input(); print('on', flush=True)"
    code = [sys.executable, "-c", f"{started}; sum(range(10**12))"]
    with subprocess.Popen(code, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True) as step:
        assert step.stdin is not None
        assert step.stdout is not None
        try:
            assert step.stdout.readline() == b"on\n"
            sleep(0.2)
            step.stdin.close()
            assert step.wait(10.0) == -signal.SIGKILL
        finally:
            step.kill()
