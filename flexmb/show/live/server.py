"""Server of a live page on this machine alone: hosts, origins, token, rates and sizes of messages."""

import asyncio
import hmac
import json
import socket
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import parse_qs

import uvicorn
from starlette.applications import Starlette
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request, cookie_parser
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from flexmb.errors import USER_ERRORS, InputError
from flexmb.show.live.knobs import LABEL
from flexmb.show.live.page import NAMES, Files, answer

LOOPBACK = "127.0.0.1"
HOSTS = (LOOPBACK, "localhost")
MOST_CLIENTS = 16  # connections of browsers at a time
MOST_BYTES = 1 << 16  # size of a message from a browser [bytes]
# Messages of a browser in a second, on average; messages at once. A browser that sends more is disconnected.
RATE, BURST = 100.0, 300.0
STARTED = 10.0  # longest time for which the start of the server is waited for [s on the clock]
POLICY_VIOLATION, TRY_LATER = 1008, 1013  # codes with which a connection is closed

HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}

Heard = Callable[[Any], None]


class Guard:
    """Layer around the application that refuses requests of others: foreign hosts and origins, no token."""

    def __init__(self, app: ASGIApp, port: int, token: str) -> None:
        self.app, self.token, self.cookie = app, token, f"flexmb_{port}"
        self.hosts = {f"{host}:{port}" for host in HOSTS}
        self.origins = {f"http://{host}" for host in self.hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See ASGI."""
        fault = self._fault(scope)

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                cookie = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
                more = {**HEADERS, **({"Set-Cookie": cookie} if scope["path"] == "/" else {})}
                pairs = [(name.lower().encode(), value.encode()) for name, value in more.items()]
                message = {**message, "headers": [*message.get("headers", ()), *pairs]}
            await send(message)

        if not fault:
            await self.app(scope, receive, with_headers)
        elif scope["type"] == "http":
            await PlainTextResponse(f"flexmb: {fault}\n", 403, HEADERS)(scope, receive, send)
        else:
            await receive()
            await send({"type": "websocket.close", "code": POLICY_VIOLATION, "reason": fault[:100]})

    def _fault(self, scope: Scope) -> str:
        """Reason why a request is refused; "" for none."""
        headers = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        if headers.get("host", "").lower() not in self.hosts:
            return "another host than this machine."
        if "origin" in headers and headers["origin"].lower() not in self.origins:
            return "a request of another site."
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        given = given or cookie_parser(headers.get("cookie", "")).get(self.cookie, "")
        if not hmac.compare_digest(given.encode(), self.token.encode()):
            return "the token is missing or wrong. Open the whole address that flexmb has printed, with ?token=."
        return ""


class Client:
    """A browser: of each kind of message the newest one waits to be sent, so that a slow one costs no memory."""

    def __init__(self, connection: WebSocket) -> None:
        self.connection = connection
        self.waiting: dict[str, str] = {}
        self.filled = asyncio.Event()
        self.credit, self.counted = BURST, time.monotonic()

    def put(self, kind: str, text: str) -> None:
        """Send a message soon, in place of an older one of its kind."""
        self.waiting[kind] = text
        self.filled.set()

    def may_speak(self) -> bool:
        """Whether a message is within the rate."""
        now = time.monotonic()
        self.credit, self.counted = min(BURST, self.credit + RATE * (now - self.counted)) - 1.0, now
        return self.credit >= 0.0

    async def send_all(self) -> None:
        """Send all waiting messages, for ever."""
        while True:
            await self.filled.wait()
            self.filled.clear()
            while self.waiting:
                kind = next(iter(self.waiting))
                await self.connection.send_text(self.waiting.pop(kind))


class Server:
    """Server of one page, in a thread; messages are heard as plain values, and refused by errors."""

    # In: text of the page for a port and a token; what hears messages; messages by kind for a new browser; files by the
    # path of a request; token of requests; number of the port, None: a free one.
    def __init__(
        self, page: Callable[[int, str], str], heard: Heard, greeting: Callable[[], Mapping[str, str]], files: Files,
        token: str, port: int | None = None,
    ) -> None:  # fmt: skip
        self.heard, self.greeting, self.files, self.token = heard, greeting, files, token
        self.clients: set[Client] = set()
        self.loop: asyncio.AbstractEventLoop | None = None
        try:
            self.socket = socket.create_server((LOOPBACK, port or 0))
        except OSError as error:
            raise InputError(f"{LABEL}: port {port} is not free ({error.strerror}). Give another one.") from error
        self.port = int(self.socket.getsockname()[1])
        self.text = page(self.port, token)
        routes = [Route("/", self._page), WebSocketRoute("/ws", self._talk)]
        routes += [Route(f"/{name}", self._file) for name in NAMES]
        self.app = Guard(Starlette(routes=routes), self.port, token)
        config = uvicorn.Config(
            self.app, log_level="critical", access_log=False, lifespan="off", server_header=False,
            ws="websockets-sansio",
            ws_max_size=MOST_BYTES, limit_concurrency=4 * MOST_CLIENTS, timeout_graceful_shutdown=1,
        )  # fmt: skip
        self.server = uvicorn.Server(config)
        self.thread = threading.Thread(target=lambda: asyncio.run(self._serving()), name="flexmb server", daemon=True)

    def start(self) -> None:
        """Begin to serve; returns when the server answers."""
        self.thread.start()
        end = time.monotonic() + STARTED
        while not self.server.started and self.thread.is_alive() and time.monotonic() < end:
            time.sleep(0.005)

    def close(self) -> None:
        """End the server and free its port."""
        self.server.should_exit = True
        if self.thread.is_alive():
            self.thread.join(STARTED)
        self.socket.close()

    def tell(self, kind: str, text: str) -> None:
        """Send a message to all browsers, from any thread."""
        if self.loop is not None and not self.loop.is_closed():
            self.loop.call_soon_threadsafe(self._put, kind, text)

    def _put(self, kind: str, text: str) -> None:
        for client in self.clients:
            client.put(kind, text)

    async def _serving(self) -> None:
        self.loop = asyncio.get_running_loop()
        await self.server.serve(sockets=[self.socket])

    async def _page(self, _: Request) -> Response:
        return HTMLResponse(self.text)

    async def _file(self, request: Request) -> Response:
        """A file of the newest run, written for this request."""
        folder = TemporaryDirectory(prefix="flexmb-live-")
        try:
            path = await run_in_threadpool(self.files.written, request.url.path.lstrip("/"), Path(folder.name))
        except USER_ERRORS as error:
            folder.cleanup()
            return PlainTextResponse(f"flexmb: {error}\n", 409)
        return FileResponse(path, filename=path.name, background=BackgroundTask(folder.cleanup))

    async def _talk(self, connection: WebSocket) -> None:
        """Talk with a browser until it leaves."""
        await connection.accept()
        if len(self.clients) >= MOST_CLIENTS:
            await connection.close(TRY_LATER, f"There are {MOST_CLIENTS} browsers already.")
            return
        client = Client(connection)
        self.clients.add(client)
        self.loop = asyncio.get_running_loop()
        sender = asyncio.create_task(client.send_all())
        try:
            for kind, text in self.greeting().items():
                client.put(kind, text)
            await self._listen(client)
        except (WebSocketDisconnect, RuntimeError):  # gone, also while something was sent
            pass
        finally:
            self.clients.discard(client)
            sender.cancel()

    async def _listen(self, client: Client) -> None:
        while True:
            text, given = await client.connection.receive_text(), None
            if not client.may_speak():
                await client.connection.close(POLICY_VIOLATION, "Too many messages.")
                return
            with suppress(ValueError, RecursionError):  # None where there are no plain values
                given = json.loads(text) if len(text) <= MOST_BYTES else None
            if refused := answer(self.heard, given):
                client.put("refused", refused)
