"""The server of `wirewear open`: pages of a workspace on this machine alone, for people who do not type.

Other users of the machine reach the port too. What they do not know is the address, as its path is a secret that stands
on no command line: a browser is given a file that only its owner can read and that leads there. Nothing is read of a
request's body before its address is known to be right.
"""

import json
import mimetypes
import os
import re
import secrets
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from html import escape
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from shutil import copyfileobj
from threading import BoundedSemaphore, Timer
from urllib.parse import unquote, urlsplit

from wirewear.app.web.workspace import CHUNK, Workspace
from wirewear.base.errors import RunError, WirewearError
from wirewear.base.frame import embedded, rendered, script
from wirewear.base.units import FIELD_UNITS
from wirewear.base.writing import writing

LOOPBACK = "127.0.0.1"
#: Of one file that is dropped: what an import reads at most; and of what a page sends itself.
_MOST_BYTES, _MOST_TEXT = 500_000_000, 10_000_000
#: Until a request's head is there, and the whole of it; for a single read or write; to read what nobody asked for.
_HEAD_s, _WHOLE_s, _STEP_s, _REST_s = 10.0, 600.0, 30.0, 1.0
Request = socket.socket | tuple[bytes, socket.socket]  #: As the standard library hands them over.
_DOOR = "open_in_browser.html"
_HERE = Path(__file__).parent
#: What a column may be in, by the unit that ends its name in a record: one spelling of each.
_MENUS = {
    unit: [*{factor: name for name, factor in reversed(known.items())}.values()][::-1]
    for unit, known in FIELD_UNITS.items()
}


class WorkspaceServer(ThreadingHTTPServer):
    """Server of one workspace on the loopback interface, below a path that only its owner knows."""

    daemon_threads = True
    request_queue_size = 128

    def __init__(self, workspace: Workspace, port: int = 0) -> None:
        """Listen on a port, 0 for any free one. Raises RunError if it cannot be had."""
        self.workspace = workspace
        with writing(
            RunError, f"port {port} of this machine cannot be used", "without --port any that is free is taken"
        ):
            super().__init__((LOOPBACK, port), _Handler)
        self.secret = secrets.token_urlsafe(16)
        self._free = BoundedSemaphore(200)
        #: Whoever has not yet said the address, the first to come first.
        self.strangers: dict[_Handler, None] = {}

    @property
    def url(self) -> str:
        """Address of the workspace's page, with its secret path."""
        return f"http://{LOOPBACK}:{self.server_address[1]}/{self.secret}/"

    def door(self) -> Path:
        """Write a file that leads a browser to the page, and that only its owner can read; return its path. Raises
        OSError if it cannot be written.
        """
        path = self.workspace.folder / _DOOR
        path.unlink(missing_ok=True)
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(f'<!DOCTYPE html><meta http-equiv="refresh" content="0; url={escape(self.url)}">\n')
        return path

    def server_close(self) -> None:
        """Close the port and delete the file that leads a browser here."""
        super().server_close()
        with suppress(OSError):
            (self.workspace.folder / _DOOR).unlink(missing_ok=True)

    def process_request(self, request: Request, client_address: object) -> None:
        """Answer a request in a thread; if too many are being answered, the oldest that has not stated the address is
        cut off, or this one is refused.
        """
        if not self._free.acquire(blocking=False):
            for waiting in [*self.strangers][:1]:
                waiting.cut()
            if not self._free.acquire(timeout=_REST_s):
                self.shutdown_request(request)
                return
        super().process_request(request, client_address)

    def process_request_thread(self, request: Request, client_address: object) -> None:
        """Answer a request, and then let another one be answered."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, request: Request, client_address: object) -> None:
        """Print a fault of the program in one sentence; a broken connection is not one."""
        del request, client_address
        error = sys.exception()
        if not isinstance(error, OSError):
            sys.stderr.write(f"wirewear: a request could not be answered ({type(error).__name__}: {error}).\n")


class _Handler(BaseHTTPRequestHandler):
    server: WorkspaceServer
    timeout = _STEP_s

    def setup(self) -> None:
        """Give the client a while to say what it wants."""
        super().setup()
        self._unread = 0
        self._clock = self._cut_after(_HEAD_s)
        self.server.strangers[self] = None

    def finish(self) -> None:
        """Let the client read the answer before the connection is closed, also where its body was not read."""
        self._clock.cancel()
        self._clock = self._cut_after(_HEAD_s)
        with suppress(OSError):
            super().finish()
            if self._unread:
                self.connection.shutdown(socket.SHUT_WR)
                self.connection.settimeout(_REST_s)
                # Browsers read no answer before they have sent all of their request.
                while self.connection.recv(CHUNK):
                    pass
        self._clock.cancel()
        self.server.strangers.pop(self, None)

    def do_GET(self) -> None:
        """The page, its state, or a file of the folder."""
        self._answered(self._get)

    def do_PUT(self) -> None:
        """A file that was dropped, the mapping as it was edited, or a step to be started."""
        # Until it is read.
        self._unread = 1
        self._answered(self._put)

    def log_message(self, *_: object) -> None:
        """Nothing: the terminal shows the address alone."""

    def _answered(self, answer: Callable[[list[str]], None]) -> None:
        """Answer whoever knows the address; a fault in what is asked is answered by one sentence."""
        try:
            asked = self._asked()
            self._clock.cancel()
            if asked is None:
                self.send_error(HTTPStatus.NOT_FOUND)
                return
            self.server.strangers.pop(self, None)
            self._clock = self._cut_after(_WHOLE_s)
            answer(asked)
        except WirewearError as problem:
            self._send_text(str(problem), HTTPStatus.CONFLICT)
        except ValueError as problem:
            self._send_text(" ".join(str(problem).split()), HTTPStatus.BAD_REQUEST)
        except TimeoutError:
            self._send_text("The rest of the request did not come.", HTTPStatus.REQUEST_TIMEOUT)
        except OSError as problem:
            self._send_text(f"{problem.strerror or problem}.", HTTPStatus.CONFLICT)

    def _get(self, asked: list[str]) -> None:
        match asked:
            case [""]:
                data = self.server.workspace.state() | {"units": _MENUS}
                values = {"script": script(_HERE / "open.js"), "data": embedded(data)}
                self._send(rendered(_HERE / "open.html", values).encode("utf-8", "replace"), "text/html; charset=utf-8")
            case ["state"]:
                self._send_state()
            case ["out", *places] if (found := self.server.workspace.served("/".join(places))) is not None:
                self._send_file(found)
            case _:
                self.send_error(HTTPStatus.NOT_FOUND)

    def _put(self, asked: list[str]) -> None:
        workspace = self.server.workspace
        match asked:
            case ["files" | "campaign" as where, name]:
                workspace.add(name, self._body(_MOST_BYTES), of_campaign=where == "campaign")
            case ["mapping"]:
                workspace.write_mapping(b"".join(self._body(_MOST_TEXT)).decode("utf-8"))
            case ["steps", name]:
                try:
                    chosen = json.loads(b"".join(self._body(_MOST_TEXT)) or b"{}")
                except RecursionError:
                    raise ValueError("The options are nested too deep.") from None
                workspace.start(name, chosen)
            case ["stop"]:
                workspace.stop()
            case _:
                self.send_error(HTTPStatus.NOT_FOUND)
                return
        self._send_state()

    def _asked(self) -> list[str] | None:
        """The address's parts behind the secret; None if the secret is wrong, or the request came by another name of
        this machine or from another page.
        Raises ValueError if it is no address.
        """
        secret, *places = [unquote(part) for part in urlsplit(self.path).path.split("/")[1:]] or [""]
        home = f"{LOOPBACK}:{self.server.server_address[1]}"
        at_home = self.headers.get_all("Host") == [home]
        # Browsers name the page that sends what changes something.
        at_home &= self.headers.get("Origin") in (None, f"http://{home}")
        if not at_home or not secrets.compare_digest(secret.encode(), self.server.secret.encode()):
            return None
        if any("\0" in part or len(part.encode()) > 255 for part in places):
            raise ValueError("The address holds a name that no file can have.")
        return places

    def _body(self, most: int) -> Iterator[bytes]:
        """The body of a request, part by part. Raises ValueError unless all of it comes, and its size is stated."""
        stated = self.headers.get_all("Content-Length") or []
        if self.headers.get("Transfer-Encoding") or len(stated) != 1 or not re.fullmatch(r"[0-9]{1,18}", stated[0]):
            raise ValueError("A request must state its size in one Content-Length.")
        left = int(stated[0])
        if left > most:
            raise ValueError(f"A file of {left} bytes is too large: {most} at most.")
        while left:
            part = self.rfile.read(min(left, CHUNK))
            if not part:
                raise ValueError("The request ended before all of it had come: nothing is changed.")
            left -= len(part)
            yield part
        self._unread = 0

    def _cut_after(self, seconds: float) -> Timer:
        """Break the connection off after so long, unless that is cancelled."""
        clock = Timer(seconds, self.cut)
        clock.daemon = True
        clock.start()
        return clock

    def cut(self) -> None:
        """Break the connection off."""
        with suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)

    def _send_state(self) -> None:
        self._send(json.dumps(self.server.workspace.state()).encode(), "application/json")

    def _send_text(self, text: str, status: HTTPStatus) -> None:
        with suppress(OSError):
            self._send(text.encode("utf-8", "replace"), "text/plain; charset=utf-8", status)

    def _send_file(self, path: Path) -> None:
        with path.open("rb") as file:
            self._begin(
                os.fstat(file.fileno()).st_size, mimetypes.guess_type(path.name)[0] or "application/octet-stream"
            )
            copyfileobj(file, self.wfile, CHUNK)

    def _send(self, content: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self._begin(len(content), kind, status)
        self.wfile.write(content)

    def _begin(self, size: int, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self.send_response(status)
        for name, value in (
            ("Content-Type", kind), ("Content-Length", str(size)), ("Cache-Control", "no-store"),
            ("Referrer-Policy", "no-referrer"), ("X-Content-Type-Options", "nosniff"),
        ):  # fmt: skip
            self.send_header(name, value)
        self.end_headers()
