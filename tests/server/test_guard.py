"""Who may ask: the host by its exact name, from its own page, with the token once and then the cookie."""

from __future__ import annotations

import pytest

from hexwar_sb3.server.guard import Guard
from hexwar_sb3.server.pages import headers_of

PORT = 4321
HOST = (b"host", b"127.0.0.1:4321")
ORIGIN = (b"origin", b"http://127.0.0.1:4321")


@pytest.fixture
def guard() -> Guard:
    return Guard(PORT)


def cookie(guard: Guard) -> tuple[bytes, bytes]:
    return b"cookie", guard.cookie.partition(";")[0].encode()


@pytest.mark.parametrize(
    "host",
    [
        *(
            b"127.evil.example:4321",
            b"127.0.0.1",
            b"127.0.0.1:43210",
            b"127.0.0.1:4321.evil.example",
            b"evil.example",
        ),
        *(
            b"localhost.evil.example:4321",
            b"[::1]:4321",
            b"127.0.0.1:4321 ",
            b"LOCALHOST@evil:4321",
            b"",
            b"0.0.0.0:4321",
        ),
    ],
)
def test_a_host_that_is_not_this_one_is_refused(guard: Guard, host: bytes) -> None:
    origin = (b"origin", b"http://" + host)

    assert not guard.may_pass("GET", "/", [(b"host", host)])
    assert not guard.may_connect("/socket", [(b"host", host), origin, cookie(guard)])


@pytest.mark.parametrize("host", [b"127.0.0.1:4321", b"localhost:4321"])
def test_this_host_is_not(guard: Guard, host: bytes) -> None:
    headers = [(b"host", host), (b"origin", b"http://" + host), cookie(guard)]

    assert guard.may_pass("GET", "/", headers)
    assert guard.may_connect("/socket", headers)


def test_two_hosts_are_refused(guard: Guard) -> None:
    assert not guard.may_pass("GET", "/", [HOST, (b"host", b"evil.example")])
    assert not guard.may_pass("GET", "/", [])


@pytest.mark.parametrize(
    "origin",
    [
        [],
        [b"null"],
        [b"http://localhost:4321"],
        [b"https://127.0.0.1:4321"],
        [b"http://evil.example"],
        [ORIGIN[1]] * 2,
    ],
)
def test_a_post_and_a_socket_come_from_this_page(guard: Guard, origin: list[bytes]) -> None:
    headers = [HOST, cookie(guard), *((b"origin", one) for one in origin)]

    assert not guard.may_pass("POST", "/enter", headers)
    assert not guard.may_connect("/socket", headers)
    assert guard.may_pass("POST", "/enter", [HOST, ORIGIN])


@pytest.mark.parametrize("path", ["/rules", "/after", "/replay"])
def test_all_else_needs_the_cookie(guard: Guard, path: str) -> None:
    wrong = (b"cookie", b"hexwar_4321=" + b"A" * 43)

    assert guard.may_pass("GET", path, [HOST, cookie(guard)])
    assert not guard.may_pass("GET", path, [HOST])
    assert not guard.may_pass("GET", path, [HOST, wrong])
    assert not guard.may_pass("GET", path, [HOST, (b"cookie", b'hexwar_4321="; \xff')])
    assert not guard.may_pass("POST", path, [HOST, ORIGIN, cookie(guard)])
    assert not guard.may_connect("/socket", [HOST, ORIGIN, wrong])


@pytest.mark.parametrize(
    ("method", "path"), [("GET", "/enter"), ("HEAD", "/"), ("GET", "/socket"), ("GET", "/../x"), ("PUT", "/")]
)
def test_other_methods_and_addresses_are_refused(guard: Guard, method: str, path: str) -> None:
    assert not guard.may_pass(method, path, [HOST, ORIGIN, cookie(guard)])


def test_the_token_is_exchanged_once(guard: Guard) -> None:
    token = guard.token.encode()

    assert not guard.enter(b"", [HOST])
    assert not guard.enter(token[:-1], [HOST])
    assert guard.enter(token, [HOST])
    assert not guard.enter(token, [HOST])
    assert guard.enter(b"", [HOST, cookie(guard)])


def test_token_and_cookie_are_secrets_of_their_own(guard: Guard) -> None:
    assert len(guard.token) >= 43  # 32 bytes
    assert guard.token not in guard.cookie
    assert guard.address == f"http://127.0.0.1:4321/#{guard.token}"
    assert guard.cookie.endswith("; HttpOnly; SameSite=Strict; Path=/")
    assert len({Guard(PORT).token for _ in range(20)}) == 20


def test_the_policy_names_what_stands_in_the_page() -> None:
    page = '<style>a</style><script>1</script><script type="text/plain" id="x">2</script>'
    policy = headers_of(page, connects=True)["content-security-policy"]

    assert policy.count("sha256-") == 2
    assert "script-src 'sha256-a4ayc/80/OGda4BO/1o/V0etpOqiLx1JwB5S3beHW0s='" in policy  # of "1"
    assert "default-src 'none'" in policy
    assert "connect-src 'self'" in policy
    assert "connect-src 'none'" in headers_of(page)["content-security-policy"]
