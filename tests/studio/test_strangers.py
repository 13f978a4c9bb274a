import pytest
from starlette.websockets import WebSocketDisconnect

from tests.studio.conftest import HOST, TOKEN, Studio

OURS = {"host": HOST, "origin": f"http://{HOST}"}
STRANGERS = {
    "another origin": OURS | {"origin": "http://evil.example"},
    "no origin": {"host": HOST},
    "a sandboxed page": OURS | {"origin": "null"},
    "another port of this machine": OURS | {"origin": "http://127.0.0.1:1"},
    "a name that leads here": {"host": "evil.example:8123", "origin": "http://evil.example:8123"},
    "localhost by another name": {"host": "localhost:8123", "origin": "http://localhost:8123"},
    "a frame of another site": OURS | {"sec-fetch-site": "cross-site"},
}


@pytest.mark.parametrize("headers", STRANGERS.values(), ids=STRANGERS.keys())
def test_a_stranger_cannot_talk(running: Studio, headers: dict[str, str]) -> None:
    with pytest.raises(WebSocketDisconnect), running.client.websocket_connect(f"/{TOKEN}/talk", headers=headers):
        pass


@pytest.mark.parametrize("token", ["", "x", TOKEN[:-1], TOKEN + "x", TOKEN.upper()])
def test_a_guessed_address_is_refused(running: Studio, token: str) -> None:
    with pytest.raises(WebSocketDisconnect), running.client.websocket_connect(f"/{token}/talk", headers=OURS):
        pass
    answer = running.client.get(f"/{token}/index.html")
    assert (answer.status_code, answer.text) == (403, "Forbidden")


def test_the_page_is_given_to_its_user_and_to_no_other_site(running: Studio) -> None:
    assert running.client.get(f"/{TOKEN}/").status_code == 200
    assert running.client.get(f"/{TOKEN}/", headers={"host": "evil.example"}).status_code == 403
    assert running.client.get(f"/{TOKEN}/", headers={"sec-fetch-site": "cross-site"}).status_code == 403
    assert running.client.get(f"/{TOKEN}/", headers={"origin": "http://evil.example"}).status_code == 403
    assert running.client.post(f"/{TOKEN}/").status_code == 403


@pytest.mark.parametrize("path", ["../campus.toml", "..%2Fcampus.toml", "%2e%2e/campus.toml", "nothing.js"])
def test_no_other_file_is_given_out(running: Studio, path: str) -> None:
    assert running.client.get(f"/{TOKEN}/{path}").status_code in (403, 404)


def test_the_browser_is_told_to_load_nothing_from_elsewhere(running: Studio) -> None:
    headers = running.client.get(f"/{TOKEN}/").headers
    policy = dict(part.strip().split(" ", 1) for part in headers["content-security-policy"].split(";"))
    assert policy["default-src"] == "'none'"
    assert policy["script-src"] == policy["style-src"] == policy["connect-src"] == "'self'"
    assert policy["frame-ancestors"] == policy["form-action"] == "'none'"
    assert policy["require-trusted-types-for"] == "'script'"  # text never becomes markup
    assert headers["referrer-policy"] == "no-referrer"  # the token is in the address
    assert headers["cross-origin-resource-policy"] == "same-origin"
