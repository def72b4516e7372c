"""A workspace that is open in a browser."""

import json
import urllib.error
import urllib.request
from time import monotonic, sleep
from typing import Any

from wirewear.app.web.workspace import Workspace


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
