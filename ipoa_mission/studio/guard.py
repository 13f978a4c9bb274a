"""Admit only the page served by this studio, with the token of its address.

Another page in the browser cannot read the token, and has its own origin. DNS rebinding fails by the host name.
"""

from collections.abc import Callable, Iterable

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; "
    "connect-src 'self'; worker-src 'self' blob:; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'; require-trusted-types-for 'script'; trusted-types default"
)


def policy_for(origin: str | None) -> str:
    """Return the policy, with images of the user's tile server."""
    if origin is None:
        return POLICY
    return POLICY.replace("img-src 'self'", f"img-src 'self' {origin}").replace(
        "connect-src 'self'", f"connect-src 'self' {origin}"
    )


HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
    "Permissions-Policy": "geolocation=(), camera=(), microphone=()",
}


class Guard:
    """Refuse foreign requests, and send security headers; `knows` checks a token."""

    def __init__(self, app: ASGIApp, knows: Callable[[str], bool], hosts: Iterable[str], policy: str) -> None:
        self._app = app
        self._knows = knows
        self._hosts = frozenset(hosts)
        self._origins = frozenset(f"http://{host}" for host in self._hosts)
        self._policy = policy

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            return await self._app(scope, receive, send)
        if not self._allowed(scope):
            if scope["type"] == "websocket":
                return await send({"type": "websocket.close", "code": 1008})
            return await PlainTextResponse("Forbidden", 403)(scope, receive, self._with_headers(send))
        return await self._app(scope, receive, self._with_headers(send))

    def _allowed(self, scope: Scope) -> bool:
        headers = Headers(scope=scope)
        origin = headers.get("origin")
        if headers.get("host") not in self._hosts or (origin is not None and origin not in self._origins):
            return False
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            return False
        must_say_origin = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD")
        if must_say_origin and origin is None:
            return False
        first = scope["path"].lstrip("/").split("/", 1)[0]
        return self._knows(first)

    def _with_headers(self, send: Send) -> Send:
        async def dressed(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = HEADERS | {"Content-Security-Policy": self._policy}
                message["headers"] = [
                    *message.get("headers", []),
                    *((key.lower().encode(), value.encode()) for key, value in headers.items()),
                ]
            await send(message)

        return dressed
