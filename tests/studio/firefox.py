"""Firefox by WebDriver BiDi, without a driver; it has WebGL only on a screen of Xvfb."""

import base64
import itertools
import json
import os
import re
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.studio.pointing import PATIENCE_S, element, settled

#: WebGL by software too, and no requests at the start.
PREFERENCES = {
    "webgl.force-enabled": True,
    "browser.shell.checkDefaultBrowser": False,
    "app.normandy.enabled": False,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "datareporting.policy.dataSubmissionEnabled": False,
    "browser.startup.page": 0,
}


class Firefox:
    def __init__(self, socket: Any) -> None:
        self._socket = socket
        self._numbers = itertools.count(1)
        self.complaints: list[str] = []
        self.asked: list[str] = []
        self._do("session.new", capabilities={})
        self._do("session.subscribe", events=["log.entryAdded", "network.beforeRequestSent"])
        self._page = self._do("browsingContext.create", type="tab")["context"]
        self._do("browsingContext.setViewport", context=self._page, viewport={"width": 1280, "height": 800})

    def open(self, address: str) -> None:
        self._do("browsingContext.navigate", context=self._page, url=address, wait="complete")

    def value(self, expression: str) -> Any:
        """Return an expression's value as JSON."""
        asked = f"Promise.resolve({expression}).then(value => JSON.stringify(value ?? null))"
        result = self._do("script.evaluate", expression=asked, target={"context": self._page}, awaitPromise=True)
        assert result["type"] == "success", result
        return json.loads(result["result"]["value"])

    def until(self, expression: str) -> None:
        until_s = time.monotonic() + PATIENCE_S
        while not self.value(expression):
            assert time.monotonic() < until_s, f"never came true: {expression}"
            time.sleep(0.05)

    def drag(self, *places: tuple[float, float]) -> None:
        """Drag the mouse from the first place to the last."""
        moves = [{"type": "pointerMove", "x": round(x), "y": round(y), "duration": 50} for x, y in places]
        steps = [moves[0], {"type": "pointerDown", "button": 0}, *moves[1:], {"type": "pointerUp", "button": 0}]
        self._act({"type": "pointer", "id": "mouse", "actions": steps})

    def click(self, script: str) -> None:
        self.value(f"{script}.scrollIntoView({{block: 'center'}})")
        self.drag(settled(self.value, element(script), "true"))

    def type(self, words: str) -> None:
        keys = [{"type": action, "value": letter} for letter in words for action in ("keyDown", "keyUp")]
        self._act({"type": "key", "id": "keys", "actions": keys})

    def picture(self) -> bytes:
        return base64.b64decode(self._do("browsingContext.captureScreenshot", context=self._page)["data"])

    def _act(self, source: dict[str, Any]) -> None:
        self._do("input.performActions", context=self._page, actions=[source])

    def _do(self, method: str, **params: Any) -> Any:
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        until_s = time.monotonic() + PATIENCE_S
        while (left_s := until_s - time.monotonic()) > 0:  # whatever else it tells meanwhile
            message = json.loads(self._socket.recv(timeout=left_s))
            if message.get("id") == number:
                assert message["type"] == "success", message
                return message["result"]
            if message.get("method") == "log.entryAdded" and message["params"]["level"] in ("error", "warn"):
                self.complaints.append(message["params"]["text"])
            if message.get("method") == "network.beforeRequestSent":
                self.asked.append(message["params"]["request"]["url"])
        raise TimeoutError(f"{method}: no answer")


@contextmanager
def screen(xvfb: str | None) -> Iterator[dict[str, str]]:
    """Return the environment of a screen, or None."""
    if xvfb is None:
        yield {"MOZ_HEADLESS": "1"}
        return
    command = [xvfb, "-displayfd", "1", "-screen", "0", "1400x1000x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        try:
            yield {"DISPLAY": f":{process.stdout.readline().strip()}", "LIBGL_ALWAYS_SOFTWARE": "1"}
        finally:
            process.terminate()


@contextmanager
def firefox(program: str, folder: Path, xvfb: str | None) -> Iterator[Firefox]:
    from websockets.sync.client import connect

    lines = [f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in PREFERENCES.items()]
    (folder / "user.js").write_text("\n".join(lines), encoding="utf-8")
    command = [program, "--no-remote", "--profile", str(folder), "--remote-debugging-port", "0"]
    with (
        screen(xvfb) as where,
        subprocess.Popen(command, env=os.environ | where, stderr=subprocess.PIPE, text=True) as process,
    ):
        assert process.stderr is not None
        address = next(match[0] for line in process.stderr if (match := re.search(r"ws://127\.0\.0\.1:\d+", line)))
        threading.Thread(target=process.stderr.read, daemon=True).start()  # else it stands still when the pipe is full
        try:
            with connect(f"{address}/session", max_size=None) as socket:
                yield Firefox(socket)
        finally:
            process.terminate()
