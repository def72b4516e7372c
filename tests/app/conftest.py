"""Fixtures of tests of the applications."""

from collections.abc import Iterator
from pathlib import Path
from threading import Thread

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
