"""Serve the page under a secret path, and a WebSocket."""

import asyncio
import json
import re
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import uvicorn
from pydantic import ValidationError
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware import Middleware
from starlette.requests import HTTPConnection, Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from ipoa_mission import BadInput, MissionError
from ipoa_mission.studio.answers import Tiles, Trouble
from ipoa_mission.studio.dropped import LARGEST, keep, use_of
from ipoa_mission.studio.requests import REQUESTS
from ipoa_mission.studio.sessions import Host, Lobby, Sessions
from ipoa_mission.studio.vocabulary import Window, as_json

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; "
    "connect-src 'self'; worker-src 'self' blob:; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'; require-trusted-types-for 'script'; trusted-types default"
)
HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
    "Permissions-Policy": "geolocation=(), camera=(), microphone=()",
}
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}


def policy_for(tiles: Tiles | None) -> str:
    if tiles is None:
        return POLICY
    origin = origin_of(tiles.address)
    own_pictures = POLICY.replace("img-src 'self'", f"img-src 'self' {origin}")
    return own_pictures.replace("connect-src 'self'", f"connect-src 'self' {origin}")


def origin_of(address: str) -> str:
    parts = urlsplit(address)
    return f"{parts.scheme}://{parts.netloc}"


def tiles_at(address: str, attribution: str | None = None) -> Tiles:
    """`address`: with {z}, {x} and {y}, or WMTS' names for them."""
    for wmts, ours in (("{TileMatrix}", "{z}"), ("{TileCol}", "{x}"), ("{TileRow}", "{y}")):
        address = address.replace(wmts, ours)
    parts = urlsplit(address)
    has_keys = all(key in address for key in ("{z}", "{x}", "{y}"))
    if not has_keys or not re.fullmatch(r"https?://[A-Za-z0-9.-]+(:\d+)?", origin_of(address)):
        words = "expected http(s)://HOST/... with {z}, {x} and {y} in it"
        raise BadInput(words, hint="a server of tiles on this machine serves files", place=f"--tiles: {address}")
    is_vector = parts.path.rpartition(".")[2].lower() in ("pbf", "mvt")
    deepest = 14 if is_vector else 22  # zoom; the page enlarges vector tiles beyond
    return Tiles(address=address, attribution=attribution or parts.netloc, max_zoom=deepest, vector=is_vector)


@dataclass(frozen=True)
class Guard:
    """Refuse foreign requests, and send security headers; `knows` checks a token."""

    app: ASGIApp
    knows: Callable[[str], bool]
    host: str
    policy: str

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            return await self.app(scope, receive, send)
        if not self._allowed(scope):
            if scope["type"] == "websocket":
                return await send({"type": "websocket.close", "code": 1008})
            return await PlainTextResponse("Forbidden", 403)(scope, receive, self._with_headers(send))
        return await self.app(scope, receive, self._with_headers(send))

    def _allowed(self, scope: Scope) -> bool:
        headers = Headers(scope=scope)
        origin = headers.get("origin")
        if headers.get("host") != self.host or origin not in (None, f"http://{self.host}"):
            return False
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            return False
        must_say_origin = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD")
        if must_say_origin and origin is None:
            return False
        return self.knows(scope["path"].lstrip("/").split("/", 1)[0])

    def _with_headers(self, send: Send) -> Send:
        headers = HEADERS | {"Content-Security-Policy": self.policy}

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(headers)
            await send(message)

        return send_with_headers


@dataclass(frozen=True)
class _Handlers:
    sessions: Sessions
    bundle: Path
    tiles: Tiles | None

    def _at(self, request: HTTPConnection) -> Host:
        host = self.sessions.at(request.path_params["token"])
        assert host is not None, "the guard lets nobody else pass"
        return host

    async def page(self, request: Request) -> Response:
        name = request.path_params.get("name") or "index.html"
        file = self.bundle / name
        if Path(name).name != name or not file.is_file() or file.suffix not in TYPES:
            return PlainTextResponse("Not found", 404)
        return FileResponse(file, media_type=TYPES[file.suffix])

    async def drop(self, request: Request) -> Response:
        content = bytearray()
        async for chunk in request.stream():
            content += chunk
            if len(content) > LARGEST:
                return JSONResponse({"message": f"expected a file of at most {LARGEST // 1_000_000} MB"}, 413)
        host = self._at(request)
        name = request.path_params["name"]
        try:
            if isinstance(host, Lobby):
                return JSONResponse({"address": await asyncio.to_thread(host.take, name, bytes(content))})
            file = await asyncio.to_thread(keep, name, bytes(content), host.folder)
            return JSONResponse(await asyncio.to_thread(use_of, file, host.document.text))
        except MissionError as error:
            return JSONResponse({"message": str(error)}, 400)

    async def talk(self, socket: WebSocket) -> None:
        await socket.accept()
        window: Window = asyncio.Queue()
        host = self._at(socket)
        sending = asyncio.create_task(_send(socket, window))
        if self.tiles is not None:
            window.put_nowait(as_json(self.tiles))
        host.join(window)
        try:
            while True:
                text = await socket.receive_text()
                try:
                    request = REQUESTS.validate_json(text)
                except ValidationError as error:
                    words = f"expected a valid message: {error.error_count()} errors"
                    window.put_nowait(as_json(Trouble(of="edit", message=words)))
                else:
                    await host.handle(request, window)
        except WebSocketDisconnect:
            pass
        finally:
            host.leave(window)
            sending.cancel()

    @asynccontextmanager
    async def alive(self, app: Starlette) -> AsyncIterator[None]:
        running = asyncio.create_task(self.sessions.run())
        yield
        running.cancel()
        with suppress(asyncio.CancelledError):
            await running


def application(sessions: Sessions, bundle: Path, host: str, tiles: Tiles | None = None) -> Starlette:
    handlers = _Handlers(sessions, bundle, tiles)
    routes: list[BaseRoute] = [
        WebSocketRoute("/talk", handlers.talk),
        Route("/drop/{name}", handlers.drop, methods=["POST"]),
        Route("/", handlers.page),
        Route("/{name}", handlers.page),
    ]
    policy = policy_for(tiles)
    guard = Middleware(Guard, knows=lambda token: sessions.at(token) is not None, host=host, policy=policy)
    return Starlette(routes=[Mount("/{token}", routes=routes)], middleware=[guard], lifespan=handlers.alive)


@dataclass(frozen=True)
class ServerOptions:
    """`bundle`: folder of the built page; port 0: any."""

    bundle: Path
    port: int
    seed: int
    tiles: Tiles | None = None


def serve(
    path: Path | None, options: ServerOptions, tell_address: Callable[[str], None], world: Path | None = None
) -> None:
    """Serve the studio, with a log's mission, on this machine until Ctrl-C; `tell_address` gets its address."""
    with _listen(options.port) as listener:
        number = listener.getsockname()[1]
        sessions = Sessions(options.seed)
        lobby = Lobby(Path.cwd(), sessions.open_file)
        token = sessions.add(lobby) if path is None else lobby.opened(path, world)
        host = f"127.0.0.1:{number}"
        app = application(sessions, options.bundle, host, options.tiles)
        limit = 4_000_000  # of a message [bytes]
        config = uvicorn.Config(app, log_level="warning", access_log=False, server_header=False, ws_max_size=limit)
        tell_address(f"http://{host}/{token}/")
        uvicorn.Server(config).run(sockets=[listener])


def _listen(port: int) -> socket.socket:
    try:
        return socket.create_server(("127.0.0.1", port))
    except OSError as error:
        words = f"expected a free port: {error.strerror}"
        raise BadInput(words, hint="leave --port out", place=f"--port {port}") from error


async def _send(socket: WebSocket, window: Window) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):
        while True:
            await socket.send_text(json.dumps(await window.get(), allow_nan=False))
