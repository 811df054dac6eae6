"""Headless Chromium over its pipe of debugging (Chrome DevTools Protocol), without another package."""

import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
NO_CHROMIUM = "Chromium is not installed (Debian: apt-get install chromium)"
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--remote-debugging-pipe",
)  # fmt: skip
PATIENCE_S = 120


class Browser:
    """One page. `events` are all that it told."""

    def __enter__(self) -> "Browser":
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        commands, self.out = os.pipe()
        self.back, answers = os.pipe()

        def as_3_and_4() -> None:
            # Copies first: either may have the other's number.
            first, second = os.dup(commands), os.dup(answers)
            os.dup2(first, 3)
            os.dup2(second, 4)

        self.process = subprocess.Popen(
            [CHROMIUM, *FLAGS, f"--user-data-dir={self.profile.name}", "about:blank"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            preexec_fn=as_3_and_4, close_fds=False,
        )  # fmt: skip
        os.close(commands)
        os.close(answers)
        os.set_blocking(self.back, False)
        self.buffer, self.events, self.number, self.session = b"", [], 0, None
        try:
            page = next(t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page")
            attach = {"targetId": page["targetId"], "flatten": True}
            self.session = self.call("Target.attachToTarget", **attach)["sessionId"]
            for domain in ("Page", "Runtime", "Log", "Network"):
                self.call(f"{domain}.enable")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self.out)
        os.close(self.back)
        self.profile.cleanup()

    def open(self, page: Path) -> None:
        """Loads a file, and returns once all of it is there."""
        self.call("Page.navigate", url=page.as_uri())
        self._wait(lambda message: message.get("method") == "Page.loadEventFired")

    def evaluate(self, expression: str) -> object:
        """The value of an expression in the page; promises are waited for."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise AssertionError(answer["exceptionDetails"])
        return answer["result"].get("value")

    def call(self, method: str, **parameters: object) -> dict:
        """Sends a command and returns its result."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session is not None:
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        answer = self._wait(lambda message: message.get("id") == self.number)
        if "error" in answer:
            raise AssertionError(answer["error"])
        return answer["result"]

    def _wait(self, is_wanted) -> dict:
        ends = time.monotonic() + PATIENCE_S
        while time.monotonic() < ends:
            while b"\0" in self.buffer:
                message, self.buffer = self.buffer.split(b"\0", 1)
                message = json.loads(message)
                self.events.append(message)
                if is_wanted(message):
                    return message
            try:
                part = os.read(self.back, 1 << 16)
            except BlockingIOError:
                time.sleep(0.01)
                continue
            if not part:
                break
            self.buffer += part
        raise AssertionError(f"Chromium said nothing for {PATIENCE_S} s, or ended ({self.process.poll()})")
