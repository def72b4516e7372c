"""Settings common to all tests."""

import gc
import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tools.examined import is_examined

# A busy machine is not a failure: examples are judged by what they return, not by how long they took.
settings.register_profile("wirewear", deadline=None, suppress_health_check=[HealthCheck.too_slow])
# As many examples as a campaign over night takes: pytest tests/robustness --hypothesis-profile campaign.
settings.register_profile("campaign", settings.get_profile("wirewear"), max_examples=10_000)
settings.load_profile("wirewear")


# Commands in processes of their own say the same on a busy machine as on an idle one.
os.environ.setdefault("WIREWEAR_QUIET", "1")

#: Files of tests that are the exam alone begin with one of these.
EXAM = ("test_blind_", "test_frozen_blind")


def pytest_addoption(parser: pytest.Parser) -> None:
    """What `make test-all` asks for."""
    parser.addoption("--all", action="store_true", help="the exam of the diagnosis too, where its code is unchanged")


def pytest_report_header() -> str | None:
    """What is due before a release."""
    return None if is_examined() else "the diagnosis has changed since it passed its exam: `make test-all` is due"


def pytest_itemcollected(item: pytest.Item) -> None:
    """Of a law whose cases are long the first is tried with every change, all of them before a release."""
    if item.get_closest_marker("first_case") and any(item.callspec.indices.values()):  # type: ignore[attr-defined]
        item.add_marker("slow")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Files of some minutes first, those with most that is slow, then large ones: processes end together.

    The exam is left out where all that it examines is as it was when it was last passed.
    """
    if not config.getoption("--all") and is_examined():
        config.hook.pytest_deselected(items=[item for item in items if item.path.name.startswith(EXAM)])
        items[:] = [item for item in items if not item.path.name.startswith(EXAM)]
    minutes, slow, count = Counter[Path](), Counter[Path](), Counter[Path]()
    for item in items:
        marker = item.get_closest_marker("slow")
        minutes[item.path] += 0 if marker is None else marker.kwargs.get("minutes", 0)
        slow[item.path] += marker is not None
        count[item.path] += 1
    items.sort(key=lambda item: (-minutes[item.path], -slow[item.path], -count[item.path], item.path))


def pytest_configure() -> None:
    """What is loaded for the tests stays: looking for garbage in it again and again took a tenth of their time."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Collect garbage once after loading, and leave what is loaded out of later collections."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(10_000, 20, 10)
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Iterator[None]:
    """Condensed bodies are shared by all processes of a test session, and never taken from the user's cache."""
    session: Path = tmp_path_factory.getbasetemp()
    if hasattr(request.config, "workerinput"):
        session = session.parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WIREWEAR_CACHE", str(session / "cache"))
        yield
