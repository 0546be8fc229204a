"""Headless Chromium for tests of pages, led by its DevTools protocol over two pipes: no driver, no port, no package.

A page is loaded from its file. What it logs, throws and asks the network for is kept.
"""

from __future__ import annotations

import base64
import contextlib
import json
import os
import selectors
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
PATIENCE_S = 60.0
_FLAGS = (
    "--headless", "--no-sandbox", "--remote-debugging-pipe", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking", "--hide-scrollbars",
)  # fmt: skip


def found() -> str | None:
    """The browser of this machine; None where there is none."""
    return next((path for path in map(shutil.which, NAMES) if path), None)


class BrowserError(Exception):
    """The browser has ended, says nothing, or refuses."""


class Browser:
    """One page of one browser."""

    def __init__(self, program: str, folder: Path, flags: Sequence[str] = ()):
        self.logged: list[str] = []
        """Warnings, errors and exceptions of the page."""
        self.asked: list[str] = []
        """Addresses that the page has asked for, but for what it holds itself."""
        self._number = 0
        self._buffer = b""
        ours, theirs = os.pipe(), os.pipe()  # they read from the first, and write to the second
        self._out, self._in = ours[1], theirs[0]
        shell = ("bash", "-c", f'exec "$@" 3<&{ours[0]} 4>&{theirs[1]}', "-")  # the browser wants them as 3 and 4
        self._process = subprocess.Popen(
            [*shell, program, *_FLAGS, *flags, f"--user-data-dir={folder}"],
            pass_fds=(ours[0], theirs[1]), start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(ours[0])
        os.close(theirs[1])
        self._session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def open(self, page: Path, *, width: int = 1200, height: int = 900, dark: bool = False, part: str = "") -> None:
        """Load a page and wait until it says that it is ready.

        Args:
            page: its file.
            width: of the window [px].
            height: likewise.
            dark: the user prefers a dark background.
            part: behind # in its address.
        """
        self.resize(width, height)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=f"{page.resolve().as_uri()}{'#' if part else ''}{part}")
        self.wait("document.documentElement?.dataset.state === 'ready'")

    def resize(self, width: int, height: int) -> None:
        """Another size of the window [px]."""
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600
        )

    def wait(self, condition: str) -> None:
        """Wait until an expression is true.

        Raises:
            BrowserError: when it does not come true.
        """
        end = time.monotonic() + PATIENCE_S
        while not self.value(condition):
            if time.monotonic() > end:
                raise BrowserError(f"{condition} did not come true; the page says: {self.logged}")
            time.sleep(0.05)

    def value(self, expression: str) -> Any:
        """What an expression gives, a promise's result too."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise BrowserError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def key(self, key: str, code: str = "") -> None:
        """Press a key."""
        text = {"text": key} if len(key) == 1 else {}
        for kind in ("keyDown", "keyUp"):
            typed = text if kind == "keyDown" else {}
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code or key, **typed)

    def click(self, x: float, y: float) -> None:
        """Press and release the left button at a place of the window [px]."""
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def picture(self, path: Path | None = None, *, whole: bool = False) -> bytes:
        """A PNG of the window, or of the whole page."""
        self.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        shot = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole, **self._clip(whole))
        data = base64.b64decode(shot["data"])
        if path is not None:
            path.write_bytes(data)
        return data

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Ask the browser for something.

        Raises:
            BrowserError: when it refuses, ends, or does not answer.
        """
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + PATIENCE_S
        while True:
            answer = self._receive(end, method)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise BrowserError(f"{method}: {answer['error']}")
                return answer["result"]
            self._note(answer)

    def close(self) -> None:
        """End the browser with all its processes."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        os.close(self._out)
        os.close(self._in)

    def _clip(self, whole: bool) -> dict[str, Any]:
        if not whole:
            return {}
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        return {"clip": {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}}

    def _receive(self, end: float, method: str) -> dict[str, Any]:
        with selectors.DefaultSelector() as selector:
            selector.register(self._in, selectors.EVENT_READ)
            while b"\0" not in self._buffer:
                if not selector.select(max(end - time.monotonic(), 0.0)):
                    raise BrowserError(f"{method}: no answer within {PATIENCE_S:g} s")
                piece = os.read(self._in, 1 << 20)
                if not piece:
                    raise BrowserError(f"{method}: the browser has ended")
                self._buffer += piece
        line, _, self._buffer = self._buffer.partition(b"\0")
        return json.loads(line)

    def _note(self, event: dict[str, Any]) -> None:
        what, parameters = event.get("method"), event.get("params", {})
        if what == "Runtime.exceptionThrown":
            self.logged.append(str(parameters["exceptionDetails"]))
        elif what == "Runtime.consoleAPICalled" and parameters["type"] in ("warning", "error", "assert"):
            self.logged.append(str(parameters["args"]))
        elif what == "Log.entryAdded" and parameters["entry"]["level"] in ("warning", "error"):
            self.logged.append(parameters["entry"]["text"])
        elif what == "Network.requestWillBeSent":
            address = parameters["request"]["url"]
            if not address.startswith(("data:", "blob:", "file:", "about:")):
                self.asked.append(address)


@contextlib.contextmanager
def browser(program: str, folder: Path, *flags: str) -> Iterator[Browser]:
    """A browser that ends with the block.

    Args:
        program: its path.
        folder: for what it keeps.
        flags: of its command line, besides the usual ones.
    """
    made = Browser(program, folder, flags)
    try:
        yield made
    finally:
        made.close()
