# SPDX-License-Identifier: LGPL-3.0-or-later
"""The page and its data, for this machine alone."""
import json
import os
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

HERE = ("127.0.0.1", "localhost")
POLICY = ("default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; connect-src 'self'; "
          "img-src data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'")


def page():
    """The page with its scripts: it asks for nothing but /data."""
    folder = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(folder, "page.html"), encoding="utf-8") as f:
        text = f.read()
    with open(os.path.join(folder, "..", "files", "plots.js"), encoding="utf-8") as f:
        return text.replace("/*plots.js*/", f.read()).encode()


class Server(ThreadingHTTPServer):
    """Bound to 127.0.0.1. `data` is what /data tells; `asked` when it was last asked for, `told_over` whether a page
    has heard of the end."""
    daemon_threads = True

    def __init__(self, port):
        super().__init__(("127.0.0.1", port), Handler)
        self.page, self.data, self.asked, self.told_over = page(), {"over": False}, 0.0, False

    @property
    def address(self):
        return f"http://127.0.0.1:{self.server_address[1]}/"

    def begin(self):
        threading.Thread(target=self.serve_forever, args=(0.1,), daemon=True).start()


class Handler(BaseHTTPRequestHandler):
    """GET / and /data; pages of other sites, which reach this machine by a name of theirs, are told nothing."""
    server_version, sys_version = "grus", ""
    server: Server

    def do_GET(self):
        if self.headers.get("Host", "").rpartition(":")[0] not in HERE:
            return self.send_error(403)
        path = self.path.partition("?")[0]
        if path == "/":
            return self.answer(self.server.page, "text/html; charset=utf-8")
        if path == "/data":
            self.server.asked = time.monotonic()
            data = self.server.data
            self.answer(json.dumps(data, allow_nan=False).encode(), "application/json")
            self.server.told_over |= data["over"]
            return None
        return self.send_error(404)

    def answer(self, body, kind):
        self.send_response(200)
        for name, value in (("Content-Type", kind), ("Content-Length", str(len(body))), ("Cache-Control", "no-store"),
                            ("Content-Security-Policy", POLICY), ("X-Content-Type-Options", "nosniff")):
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass
