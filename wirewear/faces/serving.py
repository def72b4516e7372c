"""`wirewear open`: pages of a desk on this machine alone, for people who do not type."""

import json
import mimetypes
import secrets
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from wirewear.base.errors import WirewearError
from wirewear.base.frame import embedded, rendered, script
from wirewear.faces.desk import Desk

LOOPBACK = "127.0.0.1"
_MOST_BYTES = 500_000_000  #: Of one file that is dropped: what an import reads at most.
_HERE = Path(__file__).parent


class DeskServer(ThreadingHTTPServer):
    """Serves one desk on the loopback interface, below a path that only its owner was told."""

    daemon_threads = True

    def __init__(self, desk: Desk, port: int = 0) -> None:
        """On a port, any free one by default."""
        super().__init__((LOOPBACK, port), _Handler)
        self.desk = desk
        self.secret = secrets.token_urlsafe(16)

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://{LOOPBACK}:{self.server_address[1]}/{self.secret}/"


class _Handler(BaseHTTPRequestHandler):
    server: DeskServer

    def do_GET(self) -> None:
        """The page, its state, or a file of the folder."""
        match self._asked():
            case [""]:
                values = {"script": script(_HERE / "open.js"), "data": embedded(self.server.desk.state())}
                self._send(rendered(_HERE / "open.html", values).encode(), "text/html; charset=utf-8")
            case ["state"]:
                self._send_state()
            case ["out", *places] if (found := self.server.desk.served("/".join(places))) is not None:
                self._send(found.read_bytes(), mimetypes.guess_type(found.name)[0] or "application/octet-stream")
            case _:
                self.send_error(HTTPStatus.NOT_FOUND)

    def do_PUT(self) -> None:
        """A file that was dropped, the mapping as it was edited, or a step to be begun."""
        asked = self._asked()
        size = int(self.headers.get("Content-Length") or 0)
        if not 0 <= size <= _MOST_BYTES:
            self.send_error(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
            return
        content, desk = self.rfile.read(size), self.server.desk
        try:
            match asked:
                case ["files", name]:
                    desk.add(name, content)
                case ["mapping"]:
                    desk.write_mapping(content.decode("utf-8"))
                case ["steps", name]:
                    desk.start(name, json.loads(content or b"{}"))
                case ["stop"]:
                    desk.stop()
                case _:
                    self.send_error(HTTPStatus.NOT_FOUND)
                    return
        except (WirewearError, ValueError, OSError) as problem:
            self._send(str(problem).encode(), "text/plain; charset=utf-8", HTTPStatus.CONFLICT)
            return
        self._send_state()

    def log_message(self, *_: Any) -> None:
        """Nothing: the terminal shows the address alone."""

    def _asked(self) -> list[str] | None:
        """What stands behind the secret; None of who does not know it, or comes by another name of this machine."""
        secret, *places = [unquote(part) for part in urlsplit(self.path).path.split("/")[1:]]
        at_home = self.headers.get("Host") == f"{LOOPBACK}:{self.server.server_address[1]}"
        return places if at_home and secrets.compare_digest(secret.encode(), self.server.secret.encode()) else None

    def _send_state(self) -> None:
        self._send(json.dumps(self.server.desk.state()).encode(), "application/json")

    def _send(self, content: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self.send_response(status)
        for name, value in (
            ("Content-Type", kind), ("Content-Length", str(len(content))), ("Cache-Control", "no-store"),
            ("Referrer-Policy", "no-referrer"), ("X-Content-Type-Options", "nosniff"),
        ):  # fmt: skip
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)
