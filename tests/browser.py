"""A real browser without a screen: Chromium, driven over its DevTools protocol by websockets alone.

Chromium is looked for in SUREFOOT_CHROMIUM and on the path; WebGL is drawn in software, so that no graphics
card is needed, and the network is left to this machine.
"""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

SOFTWARE = "webgl-software-rendering"
"""Viser's note where WebGL is drawn in software."""
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = (
    "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1", "--remote-debugging-port=0",
)  # fmt: skip


def find_chromium() -> str | None:
    """Return the path of a Chromium, or None."""
    told = os.environ.get("SUREFOOT_CHROMIUM")
    return told if told else next((found for name in NAMES if (found := shutil.which(name))), None)


class Browser:
    """A Chromium of its own, with a profile that is thrown away.

    Parameters
    ----------
    program
        Path of Chromium.
    width, height
        Of the window [pixels].
    """

    def __init__(self, program: str, width: int = 1280, height: int = 720) -> None:
        self._profile = Path(tempfile.mkdtemp(prefix="surefoot-browser-"))
        self._process = subprocess.Popen(
            [
                program, *FLAGS, f"--user-data-dir={self._profile}", f"--window-size={width},{height}",
                "about:blank",
            ],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self.width, self.height = width, height
        file, patience = self._profile / "DevToolsActivePort", time.monotonic() + 60.0
        while not (file.exists() and file.read_text().count("\n")):
            if self._process.poll() is not None or time.monotonic() > patience:
                self.close()
                raise RuntimeError(f"{program} does not start")
            time.sleep(0.05)
        port, path = file.read_text().split("\n")[:2]
        self._socket = _connect(f"ws://127.0.0.1:{port}{path}")

    def open(self, url: str) -> Tab:
        """Return the browser's only tab with a page: one behind another would not be drawn."""
        patience = time.monotonic() + 30.0
        while True:
            found = self._call("Target.getTargets")["targetInfos"]
            pages = [target["targetId"] for target in found if target["type"] == "page"]
            if pages or time.monotonic() > patience:
                break
            time.sleep(0.05)
        session = self._call("Target.attachToTarget", targetId=pages[0], flatten=True)["sessionId"]
        tab = Tab(self, session)
        for domain in ("Page", "Network", "Runtime"):
            tab.call(f"{domain}.enable")
        tab.call("Page.navigate", url=url)
        return tab

    _number = 0

    def _post(self, method: str, session: str | None, parameters: dict[str, Any]) -> int:
        """Send a command and return its number."""
        self._number += 1
        told = {"id": self._number, "method": method, "params": parameters}
        self._socket.send(json.dumps(told | ({"sessionId": session} if session else {})))
        return self._number

    def _call(
        self, method: str, session: str | None = None, tab: Tab | None = None, **parameters: Any
    ) -> Any:
        """Return the answer to a command; what happens meanwhile is given to the tab."""
        number = self._post(method, session, parameters)
        while True:
            said = json.loads(self._socket.recv(timeout=60.0))
            if said.get("id") == number:
                if "error" in said:
                    raise RuntimeError(f"{method}: {said['error']['message']}")
                return said["result"]
            if tab is not None and "method" in said and said.get("sessionId") == session:
                tab.heard(said)

    def close(self) -> None:
        """End Chromium and delete its profile."""
        if hasattr(self, "_socket"):
            self._socket.close()
        self._process.terminate()
        try:
            self._process.wait(timeout=10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        shutil.rmtree(self._profile, ignore_errors=True)

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class Tab:
    """A page in the browser.

    Attributes
    ----------
    requests
        Addresses that the page asked for; what is part of the page itself is left out.
    errors
        What it wrote to its console as an error.
    """

    def __init__(self, browser: Browser, session: str) -> None:
        self._browser, self._session = browser, session
        self.requests: list[str] = []
        self.errors: list[str] = []

    def call(self, method: str, **parameters: Any) -> Any:
        """Return the answer to a command of the DevTools protocol."""
        return self._browser._call(method, self._session, self, **parameters)

    def heard(self, event: dict[str, Any]) -> None:
        """Count an event."""
        method, told = event["method"], event["params"]
        if method == "Network.requestWillBeSent":
            if not told["request"]["url"].startswith(("data:", "blob:")):
                self.requests.append(told["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.errors.append(str(told["exceptionDetails"].get("text")))
        elif method == "Runtime.consoleAPICalled" and told["type"] == "error":
            self.errors.append(
                " ".join(str(part.get("value", part.get("description"))) for part in told["args"])
            )

    def ask(self, script: str) -> Any:
        """Return the value of a JavaScript expression."""
        return self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)[
            "result"
        ].get("value")

    def wait_for(self, script: str, seconds: float = 30.0) -> Any:
        """Return a JavaScript expression's value as soon as it is truthy."""
        patience = time.monotonic() + seconds
        while not (value := self.ask(script)):
            if time.monotonic() > patience:
                raise TimeoutError(f"the page never had {script}")
            time.sleep(0.1)
        return value

    def press(self, key: str) -> None:
        """Press a key that is no letter, such as "ArrowRight"."""
        code = {"ArrowLeft": 37, "ArrowRight": 39, "ArrowDown": 40, "Enter": 13}[key]
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)

    def screenshot(self, path: Path) -> Path:
        """Write what the window shows as PNG; that there is no graphics card here is nobody's business."""
        self.ask(f"document.querySelectorAll('#{SOFTWARE}').forEach(note => note.style.display = 'none')")
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))
        return path


def _connect(url: str) -> Any:
    """Return a websocket to Chromium."""
    from websockets.sync.client import connect

    return connect(url, max_size=None, compression=None)
