# SPDX-License-Identifier: LGPL-3.0-or-later
"""Chromium without a window, spoken to through a pipe (DevTools protocol): what a page asks for, says and shows."""
import json
import os
import select
import shutil
import subprocess
import time

FLAGS = ["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--disable-extensions", "--disable-dev-shm-usage",
         "--proxy-server=127.0.0.1:9", "--remote-debugging-pipe", "about:blank"]  # what is not local goes nowhere


def found():
    return shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Browser:
    """One page. `requests` (URLs), `statuses` (URL to HTTP status) and `errors` (console, exceptions) since they were
    last emptied."""

    def __init__(self, profile):
        (theirs_in, self.out), (self.into, theirs_out) = os.pipe(), os.pipe()
        command = f'exec "$@" 3<&{theirs_in} 4>&{theirs_out}'
        self.process = subprocess.Popen(
            ["bash", "-c", command, "-", found(), f"--user-data-dir={profile}", *FLAGS],
            pass_fds=(theirs_in, theirs_out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(theirs_in)
        os.close(theirs_out)
        self.number, self.rest, self.answers, self.session = 0, b"", {}, None
        self.requests, self.statuses, self.errors, self.loaded = [], {}, [], False
        pages = [t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page"]
        self.session = self.call("Target.attachToTarget", targetId=pages[0]["targetId"], flatten=True)["sessionId"]
        self.watch(self.session)
        self.call("Log.enable")
        self.call("Page.enable")
        self.call("Target.setAutoAttach", autoAttach=True, waitForDebuggerOnStart=True, flatten=True)

    def watch(self, session):
        for domain in ("Network", "Runtime"):
            self.call(domain + ".enable", session=session)

    def call(self, method, session=None, timeout=60, **parameters):
        self.number += 1
        number, message = self.number, {"id": self.number, "method": method, "params": parameters}
        if session or self.session:
            message["sessionId"] = session or self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + timeout
        while number not in self.answers:
            if not self.read(until - time.monotonic()):
                raise TimeoutError(f"{method}: no answer in {timeout} s")
        answer = self.answers.pop(number)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def read(self, seconds):
        """Takes the next message, an answer or an event; false if none comes in that time."""
        until = time.monotonic() + seconds
        while b"\0" not in self.rest:
            left = until - time.monotonic()
            if left <= 0 or not select.select([self.into], [], [], left)[0]:
                return False
            got = os.read(self.into, 1 << 20)
            if not got:
                raise RuntimeError("the browser has ended")
            self.rest += got
        text, _, self.rest = self.rest.partition(b"\0")
        message = json.loads(text)
        if "method" in message:
            self.event(message["method"], message["params"])
        else:
            self.answers[message["id"]] = message
        return True

    def event(self, method, p):
        if method == "Network.requestWillBeSent":
            self.requests.append(p["request"]["url"])
        elif method == "Network.responseReceived":
            self.statuses[p["response"]["url"]] = p["response"]["status"]
        elif method == "Runtime.exceptionThrown":
            details = p["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and p["type"] in ("error", "assert"):
            self.errors.append(" ".join(str(a.get("value", a.get("description"))) for a in p["args"]))
        elif method == "Log.entryAdded" and p["entry"]["level"] == "error":
            self.errors.append(p["entry"]["text"] + " " + p["entry"].get("url", ""))
        elif method == "Page.loadEventFired":
            self.loaded = True
        elif method == "Target.attachedToTarget" and p["waitingForDebugger"]:  # a worker, which waits to be watched
            self.watch(p["sessionId"])
            self.call("Runtime.runIfWaitingForDebugger", session=p["sessionId"])

    def open(self, url, timeout=60):
        self.loaded = False
        self.call("Page.navigate", url=url)
        until = time.monotonic() + timeout
        while not self.loaded:
            if not self.read(until - time.monotonic()):
                raise TimeoutError(f"{url} has not loaded in {timeout} s")

    def ask(self, code, timeout=60):
        """The value of a JavaScript expression; a promise is awaited."""
        r = self.call("Runtime.evaluate", expression=code, returnByValue=True, awaitPromise=True, userGesture=True,
                      timeout=timeout)
        if "exceptionDetails" in r:
            raise RuntimeError(f"{r['exceptionDetails']}")
        return r["result"].get("value")

    def width(self, pixels, phone=False):
        self.call("Emulation.setDeviceMetricsOverride", width=pixels, height=850, deviceScaleFactor=1,
                  mobile=phone)

    def close(self):
        """Asks it to end; what does not within some seconds is ended."""
        try:
            os.write(self.out, json.dumps({"id": 0, "method": "Browser.close"}).encode() + b"\0")
            self.process.wait(10)
        except (OSError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
