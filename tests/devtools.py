"""A headless Chromium without a network, driven by its DevTools protocol: JSON messages, ended by NUL, in two pipes."""

import json
import os
import re
import select
import shutil
import subprocess
import time
from pathlib import Path

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

FLAGS = """--headless --no-sandbox --disable-gpu --disable-dev-shm-usage --disable-background-networking
    --disable-component-update --disable-sync --no-first-run --no-default-browser-check --hide-scrollbars
    --remote-debugging-pipe"""

# Chromium reads commands from file descriptor 3 and writes answers and events to 4: our ends are its stdin and stdout.
LAUNCH = 'exec "$0" "$@" 3<&0 4>&1 0</dev/null 1>&2'

# Two frames, in which events of media and size reach the page; then the end of the transitions that they began.
DRAWN = """(async () => {
  for (let i = 0; i < 2; i++) await new Promise(requestAnimationFrame);
  const transitions = document.getAnimations().filter(a => a instanceof CSSTransition);
  await Promise.allSettled(transitions.map(a => a.finished));
  return true;
})()"""


class Browser:
    """One tab. ``open`` a page, ``evaluate`` expressions in it, then ask for its ``complaints``."""

    def __init__(self, profile: Path):
        command = [CHROMIUM, *FLAGS.split(), "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={profile}"]
        self._process = subprocess.Popen(
            ["sh", "-c", LAUNCH, *command, "about:blank"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._buffer, self._last, self._session, self.events = b"", 0, None, []
        tab = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._call("Target.attachToTarget", targetId=tab, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self._call(f"{domain}.enable")
        self._call("Page.setLifecycleEventsEnabled", enabled=True)

    def close(self) -> None:
        self._process.terminate()
        self._process.communicate(timeout=20)

    def open(self, url: str, scheme: str = "light", width: int = 1280) -> None:
        """Load a page anew and wait until its scripts, MathJax among them, have done their work."""
        self.events.clear()
        self._emulate(scheme, width)
        loader = self._call("Page.navigate", url=url)["loaderId"]
        if not any(_loaded(event, loader) for event in self.events):
            self._wait(lambda message: _loaded(message, loader))
        self.evaluate("Promise.resolve(window.MathJax && MathJax.startup && MathJax.startup.promise).then(() => true)")
        self.evaluate("new Promise(done => setTimeout(done, 150))")

    def show(self, scheme: str = "light", width: int = 1280) -> None:
        """Change colour scheme and width under the open page and wait until it is drawn anew, transitions included."""
        self._emulate(scheme, width)
        self.evaluate(DRAWN)

    def _emulate(self, scheme: str, width: int) -> None:
        self._call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self._call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)

    def evaluate(self, script: str):
        """Value of an expression in the page; a promise is awaited."""
        result = self._call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def complaints(self) -> list[str]:
        """All that was written to the console, and all that was asked of another host, since the page was opened."""
        said = []
        for event in self.events:
            method, params = event["method"], event["params"]
            if method == "Runtime.consoleAPICalled":
                words = [argument.get("value", argument.get("description")) for argument in params["args"]]
                said.append(f"console.{params['type']}: {words}")
            elif method == "Runtime.exceptionThrown":
                said.append(f"exception: {params['exceptionDetails']}")
            elif method == "Log.entryAdded":
                said.append(f"log: {params['entry'].get('text')} {params['entry'].get('url', '')}")
            elif method == "Network.requestWillBeSent":
                url = params["request"]["url"]
                said += [] if re.match("(file|data|blob|about):", url) else [f"request: {url}"]
        return said

    def _call(self, method: str, **params) -> dict:
        self._last += 1
        message = {"id": self._last, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        self._process.stdin.write(json.dumps(message).encode() + b"\0")
        self._process.stdin.flush()
        answer = self._wait(lambda received: received.get("id") == message["id"])
        assert "error" not in answer, answer
        return answer["result"]

    def _wait(self, wanted, timeout: float = 60.0) -> dict:
        deadline = time.monotonic() + timeout
        while message := self._receive(deadline):
            if "method" in message:
                self.events.append(message)
            if wanted(message):
                return message
        raise TimeoutError("Chromium did not answer")

    def _receive(self, deadline: float) -> dict | None:
        stdout = self._process.stdout.fileno()
        while b"\0" not in self._buffer:
            if not select.select([stdout], [], [], max(0.0, deadline - time.monotonic()))[0]:
                return None
            data = os.read(stdout, 1 << 16)
            assert data, "Chromium has ended"
            self._buffer += data
        message, _, self._buffer = self._buffer.partition(b"\0")
        return json.loads(message)


def _loaded(message: dict, loader: str) -> bool:
    params = message.get("params", {})
    return message.get("method") == "Page.lifecycleEvent" and params["name"] == "load" and params["loaderId"] == loader
