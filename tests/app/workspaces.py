"""A workspace that is open in a browser."""

import json
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from threading import Thread
from time import monotonic, sleep
from typing import Any

import pytest

from wirewear.app.web.server import WorkspaceServer
from wirewear.app.web.workspace import Workspace


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    made = Workspace(tmp_path / "workspace")
    yield made
    made.stop()


@pytest.fixture
def server(workspace: Workspace) -> Iterator[WorkspaceServer]:
    with WorkspaceServer(workspace) as made:
        Thread(target=made.serve_forever, args=(0.02,), daemon=True).start()
        yield made
        made.shutdown()


def asked(url: str, method: str = "GET", body: bytes = b"", **headers: str) -> tuple[int, bytes]:
    request = urllib.request.Request(url, body if method == "PUT" else None, headers, method=method)
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


def step(workspace: Workspace, name: str) -> dict[str, Any]:
    return next(one for one in json.loads(json.dumps(workspace.state()))["steps"] if one["name"] == name)


def ended(workspace: Workspace, name: str, most_s: float = 200.0) -> dict[str, Any]:
    began = monotonic()
    while step(workspace, name)["state"] == "running" and monotonic() - began < most_s:
        sleep(0.1)
    return step(workspace, name)
