"""A page in Chromium without a window, driven over its own pipe (the DevTools protocol, no other package needed)."""

import base64
import contextlib
import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(
    (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None
)
needs_browser = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium: apt-get install --no-install-recommends chromium"
)
OPTIONS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-extensions",
    "--no-first-run", "--disable-background-networking", "--hide-scrollbars", "--remote-debugging-pipe",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)  # fmt: skip

#: Elements that reach beyond the screen, apart from those within something that scrolls.
TOO_WIDE = """[...document.querySelectorAll("section *, p, h2, table")]
    .filter(e => e.getBoundingClientRect().right > innerWidth + 1 && !e.closest(".scroll, clipPath, [clip-path]"))
    .map(e => e.outerHTML.slice(0, 80))"""


@dataclass
class Page:
    """One page; `problems` are what it wrote to the console as errors, and what it failed to load."""

    _write: int
    _read: int
    _session: str = ""
    _number: int = 0
    _left: bytes = b""
    problems: list[str] = field(default_factory=list)

    def call(self, method: str, **values: Any) -> dict[str, Any]:
        """Ask the browser for something; problems of the page that come in between are kept."""
        self._number += 1
        asked = {"id": self._number, "method": method, "params": values}
        os.write(
            self._write, json.dumps(asked | ({"sessionId": self._session} if self._session else {})).encode() + b"\0"
        )
        while True:
            reply = self._next()
            if reply.get("id") == self._number:
                assert "error" not in reply, reply["error"]
                return dict(reply["result"])
            self._take(reply)

    def attach(self) -> None:
        """Open a page and listen to it."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def open(self, path: Path | str, width: int = 1100, height: int = 900, *, phone: bool = False) -> None:
        """Load a file, or an address of this machine, into a window of that size."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)
        self.call("Page.navigate", url=path if isinstance(path, str) else path.resolve().as_uri())
        self.value(
            "new Promise(done => document.readyState === 'complete' ? done() : addEventListener('load', () => done()))"
        )

    def value(self, expression: str) -> Any:
        """What an expression comes to in the page."""
        reply = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in reply, reply
        return reply["result"].get("value")

    def drag(self, selector: str, by: tuple[float, float]) -> None:
        """Press the mouse on the middle of an element, move it and let go."""
        found = f"document.querySelector('{selector}')"
        self.value(f"{found}.scrollIntoView({{block: 'center'}})")
        box = self.value(f"(b => [b.x + b.width / 2, b.y + b.height / 2])({found}.getBoundingClientRect())")
        for kind, share in (("mousePressed", 0.0), ("mouseMoved", 0.5), ("mouseMoved", 1.0), ("mouseReleased", 1.0)):
            x, y = (at + share * part for at, part in zip(box, by, strict=True))
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)
        self.settle()

    def settle(self) -> None:
        """Wait for two frames to be drawn."""
        self.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done())))")

    def picture(self, path: Path, *, whole: bool = False) -> Path:
        """A screenshot of what is seen, or of the whole page."""
        reply = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(reply["data"]))
        return path

    def _take(self, reply: dict[str, Any]) -> None:
        values = reply.get("params", {})
        match reply.get("method"):
            case "Runtime.exceptionThrown":
                self.problems.append(str(values["exceptionDetails"].get("exception", {}).get("description", values)))
            case "Runtime.consoleAPICalled" if values["type"] in ("error", "warning", "assert"):
                self.problems.append(str(values["args"]))
            case "Log.entryAdded" if values["entry"]["level"] == "error":
                self.problems.append(values["entry"]["text"])
            case "Network.requestWillBeSent" if not values["request"]["url"].startswith(
                ("file:", "data:", "blob:", "about:", "http://127.0.0.1:")
            ):
                self.problems.append(f"asks the network for {values['request']['url']}")

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._left:
            read = os.read(self._read, 1 << 20)
            assert read, "Chromium has ended"
            self._left += read
        reply, self._left = self._left.split(b"\0", 1)
        return dict(json.loads(reply))


@contextlib.contextmanager
def browser() -> Iterator[Page]:
    """A page of a Chromium that ends with it."""
    assert CHROMIUM is not None
    to_read, to_write = os.pipe(), os.pipe()
    with tempfile.TemporaryDirectory(prefix="wirewear_chromium_", ignore_cleanup_errors=True) as profile:
        # The protocol's pipes are descriptors 3 and 4.
        redirected = f'exec "$@" 3<&{to_read[0]} 4>&{to_write[1]}'
        process = subprocess.Popen(
            ["bash", "-c", redirected, "bash", CHROMIUM, *OPTIONS, f"--user-data-dir={profile}"],
            pass_fds=(to_read[0], to_write[1]),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read[0])
        os.close(to_write[1])
        page = Page(to_read[1], to_write[0])
        try:
            page.attach()
            yield page
        finally:
            with contextlib.suppress(OSError, AssertionError):
                page._session = ""
                page.call("Browser.close")
            os.close(to_read[1])
            os.close(to_write[0])
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def page_faults(path: Path) -> list[str]:
    """What is wider than a desktop's or a phone's screen on a page, or goes wrong there; unknown without a Chromium."""
    if CHROMIUM is None:
        return []
    with browser() as page:
        found: list[str] = []
        for width in (1200, 390):
            page.open(path, width, 844, phone=width < 500)
            found += page.value(TOO_WIDE)
        return found + page.problems
