"""Access control: origin, token and cookie of requests.

A page of another site in the same browser can send requests to this server, or resolve its own host
name to this machine (DNS rebinding). Both kinds of requests name a foreign host or origin.
"""

from __future__ import annotations

import hmac
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode, urlsplit

from tornado import web
from tornado.httputil import HTTPHeaders, HTTPServerRequest
from tornado.routing import AnyMatches, Matcher, Rule, RuleRouter

from roughcontact import errors

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
"""Host names of this machine."""

TOKEN, WORK = "token", "work"
"""Query parameters: the token, and the key of a project."""

# Public files of Bokeh and Panel: a page in a frame requests them without the cookie.
_PUBLIC_PREFIX = "/static/"
_COOKIE_VALUE = b"let in"
_COOKIE_DAYS = 31
# A page loads nothing from other origins, whichever content it has. Bokeh compiles functions from
# text. A notebook on this machine may show the page in a frame.
_POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob:; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
    "connect-src 'self' blob: ws: wss:; worker-src 'self' blob:; object-src 'none'; "
    "base-uri 'self'; "
    "form-action 'self'; frame-ancestors http://127.0.0.1:* http://localhost:*"
)


@dataclass(frozen=True)
class AccessPolicy:
    """Rules of access to the server: origins, token and cookie."""

    origins: tuple[str, ...]
    token: str  # Secret that a browser presents once
    secret: bytes  # Signs the cookie
    port: int  # In the cookie name: all ports of a machine share cookies

    @property
    def cookie(self) -> tuple[str, str]:
        """Name and value of the cookie of a browser that has presented the token."""
        name = f"roughcontact-desk-{self.port}"
        return name, web.create_signed_value(self.secret, name, _COOKIE_VALUE).decode("ascii")

    def refusal(self, request: HTTPServerRequest) -> str:
        """Return the reason for rejecting a request; empty if it is accepted."""
        host = request.host.lower()
        allowed = [urlsplit(origin).netloc for origin in self.origins]
        if _name(host) not in LOOPBACK and host not in allowed:
            return f"{host!r} is not a name of this server; allow it with --allow-origin"
        headers = request.headers
        origin = headers.get("Origin") or headers.get("Sec-Websocket-Origin")
        own = (f"http://{host}", f"https://{host}") if _name(host) in LOOPBACK else ()
        if origin is not None and origin.lower() not in (*own, *self.origins):
            return f"a page of {origin!r} may not use this server"
        # Requests of other sites may have no origin, for example those of images.
        site = headers.get("Sec-Fetch-Site", "none")
        if site not in ("none", "same-origin") and headers.get("Sec-Fetch-Mode") != "navigate":
            return "a page of another site may not use this server"
        if not self._knows_token(request):
            return "open the address that the command printed, with its token"
        return ""

    def _knows_token(self, request: HTTPServerRequest) -> bool:
        if request.path.startswith(_PUBLIC_PREFIX):
            return True
        name, _ = self.cookie
        cookie = request.cookies.get(name)
        if (
            cookie is not None
            and web.decode_signed_value(self.secret, name, cookie.value, max_age_days=_COOKIE_DAYS)
            == _COOKIE_VALUE
        ):
            return True
        shown = request.arguments.get(TOKEN, [])
        return any(hmac.compare_digest(word, self.token.encode()) for word in shown)


def _name(host: str) -> str:
    """Return the name of a host without its port."""
    end = host.rpartition("]")
    return f"{end[0]}]" if end[1] else host.partition(":")[0]


def guard_application(
    door: AccessPolicy, find: Callable[[str], bool], create: Callable[[], str], app: Any
) -> Any:
    """Return a wrapper of a Tornado application that admits authorized requests only."""

    def guarded(handler: type[web.RequestHandler], **more: Any) -> web.Application:
        return web.Application(
            [(r".*", handler, {"door": door, **more})],
            transforms=[GuardedApplication],
            log_function=log_nothing,
        )

    refusing = guarded(_RefusedHandler)
    entrance = guarded(_EntryHandler, find=find, create=create)
    return RuleRouter(
        [
            Rule(_Matching(lambda request: bool(door.refusal(request))), refusing),
            Rule(_Matching(lambda request: _needs_redirect(request, find)), entrance),
            Rule(AnyMatches(), app),
        ]
    )


class GuardedApplication(web.OutputTransform):
    """Output transform that adds security headers to every response."""

    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        """Add the security headers to the first chunk."""
        headers["Content-Security-Policy"] = _POLICY
        headers["X-Content-Type-Options"] = "nosniff"
        headers["Referrer-Policy"] = "no-referrer"
        headers["Cross-Origin-Resource-Policy"] = "same-origin"
        return status_code, headers, chunk


class _Matching(Matcher):
    def __init__(self, fits: Callable[[HTTPServerRequest], bool]) -> None:
        self._fits = fits

    def match(self, request: HTTPServerRequest) -> dict[str, Any] | None:
        return {} if self._fits(request) else None


def _needs_redirect(request: HTTPServerRequest, find: Callable[[str], bool]) -> bool:
    """Return whether a request needs a redirect: no project, or a token in the address."""
    is_framed = request.headers.get("Sec-Fetch-Dest") in ("iframe", "frame")
    put_away = TOKEN in request.arguments and not is_framed
    return request.path == "/" and (put_away or not find(work_key(request)))


def work_key(request: Any) -> str:
    """Return the project key of a request; empty if it has none."""
    return query_value(request, WORK)


def query_value(request: Any, name: str) -> str:
    """Return a query parameter of a request; empty if it has none."""
    return next((word.decode("ascii", "replace") for word in request.arguments.get(name, [])), "")


class _RefusedHandler(web.RequestHandler):
    def initialize(self, door: AccessPolicy) -> None:
        self._door = door

    def prepare(self) -> None:
        self.set_status(403)
        self.set_header("Content-Type", "text/plain; charset=UTF-8")
        self.finish(
            f"roughcontact desk: {errors.shorten_message(self._door.refusal(self.request))}\n"
        )


class _EntryHandler(web.RequestHandler):
    """Handler that redirects to the requested project, or to a new one."""

    def initialize(
        self, door: AccessPolicy, find: Callable[[str], bool], create: Callable[[], str]
    ) -> None:
        self._door, self._find, self._create = door, find, create

    def get(self) -> None:
        name, value = self._door.cookie
        self.set_cookie(
            name, value, expires_days=_COOKIE_DAYS, httponly=True, samesite="Lax", path="/"
        )
        key = work_key(self.request)
        if key and not self._find(key):
            self.set_status(404)
            self.set_header("Content-Type", "text/html; charset=UTF-8")
            self.finish(
                "<!doctype html><html lang='en'><title>roughcontact desk</title><body style='font: "
                "14px system-ui; margin: 4em'><p>This project no longer exists. <a href='/'>Start "
                "a new one.</a></body></html>"
            )
            return
        self.set_header("Cache-Control", "no-store")
        self.redirect(f"/?{urlencode({WORK: key or self._create()})}")


def log_nothing(handler: web.RequestHandler) -> None:
    """Log nothing."""
