"""A web server on loopback that writes down what is posted, and answers as a test wants."""

import json
import ssl
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Condition, Thread


class WebServer:
    """Answers with `statuses` in turn, then with 200."""

    def __init__(self, statuses=(), port=0, certificate=None, location=None):
        self.posts, self._statuses, self._location = [], list(statuses), location
        self._changed = Condition()
        self._server = ThreadingHTTPServer(("127.0.0.1", port), self._handler())
        scheme = "http"
        if certificate is not None:
            context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            context.load_cert_chain(*certificate)
            self._server.socket = context.wrap_socket(self._server.socket, server_side=True)
            scheme = "https"
        self.port = self._server.server_port
        self.url = f"{scheme}://127.0.0.1:{self.port}/hook"
        self._thread = Thread(target=self._server.serve_forever, args=(0.02,))

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def wait_for(self, count):
        """The documents of so many posts."""
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.posts) >= count, 60), self.posts
            return [document for document, _ in self.posts]

    def _handler(owner):  # noqa: N805
        class Handler(BaseHTTPRequestHandler):
            def do_POST(self):
                document = json.loads(self.rfile.read(int(self.headers["Content-Length"] or 0)) or "null")
                with owner._changed:
                    owner.posts.append((document, dict(self.headers)))
                    status = owner._statuses.pop(0) if owner._statuses else 200
                    owner._changed.notify()
                self.send_response(status)
                if owner._location:
                    self.send_header("Location", owner._location)
                self.end_headers()

            do_GET = do_POST  # noqa: N815

            def log_message(self, *_):
                pass

        return Handler
