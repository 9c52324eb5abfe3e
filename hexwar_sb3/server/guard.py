"""Who may ask the server anything: one browser on this machine, which was given the token (SECURITY.md).

Other programs and pages of the same machine can reach the port, too. A page from elsewhere cannot say that it comes from
here (`Origin`), a name that leads here is not ours (`Host`), and neither knows the token or has the cookie.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Sequence
from http.cookies import CookieError, SimpleCookie

HOSTS = ("127.0.0.1", "localhost")
USUAL_PORT = 80  # which browsers leave out
TOKEN_BYTES = 32
OPEN = frozenset({("GET", "/"), ("POST", "/enter")})  # without the cookie
WITH_COOKIE = frozenset({("GET", "/rules"), ("GET", "/after"), ("GET", "/replay")})
SOCKET = "/socket"

Headers = Sequence[tuple[bytes, bytes]]  # names in lower case


class Guard:
    """The token of one server, the cookie that it is exchanged for, and what a request must have.

    Args:
        port: that the server listens on.
    """

    def __init__(self, port: int) -> None:
        self.port = port
        self.token = secrets.token_urlsafe(TOKEN_BYTES)
        self.cookie_name = f"hexwar_{port}"
        self._secret = secrets.token_urlsafe(TOKEN_BYTES)
        self._entered = False

    @property
    def address(self) -> str:
        """Of the page, with the token where no request carries it."""
        return f"http://{HOSTS[0]}:{self.port}/#{self.token}"

    @property
    def cookie(self) -> str:
        """Value of the header that sets the cookie."""
        return f"{self.cookie_name}={self._secret}; HttpOnly; SameSite=Strict; Path=/"

    def may_pass(self, method: str, path: str, headers: Headers) -> bool:
        """Whether a request may be answered."""
        if not self._is_here(headers) or (method == "POST" and not self._is_from_here(headers)):
            return False
        return (method, path) in OPEN or ((method, path) in WITH_COOKIE and self.has_cookie(headers))

    def may_connect(self, path: str, headers: Headers) -> bool:
        """Whether a socket may be opened."""
        here = self._is_here(headers) and self._is_from_here(headers)
        return here and path == SOCKET and self.has_cookie(headers)

    def enter(self, token: bytes, headers: Headers) -> bool:
        """Whether the token is right, once; later only who has the cookie may."""
        if self.has_cookie(headers):
            return True
        right = hmac.compare_digest(token, self.token.encode()) and not self._entered
        self._entered = self._entered or right
        return right

    def has_cookie(self, headers: Headers) -> bool:
        """Whether the cookie of this server is there."""
        cookies = SimpleCookie()
        for value in _all(headers, b"cookie"):
            try:
                cookies.load(value.decode("latin-1"))
            except CookieError:
                return False
        found = cookies.get(self.cookie_name)
        return found is not None and hmac.compare_digest(found.value.encode(), self._secret.encode())

    def _names(self) -> set[bytes]:
        ends = (f":{self.port}", "") if self.port == USUAL_PORT else (f":{self.port}",)
        return {f"{host}{end}".encode() for host in HOSTS for end in ends}

    def _is_here(self, headers: Headers) -> bool:
        """The request names this very host, once."""
        hosts = _all(headers, b"host")
        return len(hosts) == 1 and hosts[0] in self._names()

    def _is_from_here(self, headers: Headers) -> bool:
        """The page that asks was loaded from the host that is asked."""
        return _all(headers, b"origin") == [b"http://" + host for host in _all(headers, b"host")]


def _all(headers: Headers, name: bytes) -> list[bytes]:
    return [value for key, value in headers if key == name]
