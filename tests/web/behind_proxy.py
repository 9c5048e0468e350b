"""The live page behind a proxy: the page of a whole host, and of a folder of a host. Each proxy has a script (check_nginx.py).

A real server and a real proxy run in a temporary folder, with free ports. A client of this file opens WebSockets over TLS; with a
browser (FELTWIRE_CHROMIUM), the page itself shows a hand under both addresses.
"""

import base64
import contextlib
import json
import os
import pathlib
import re
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import time

PROGRAMS, SOURCE = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
PATIENCE = 20  # [s]
READ_TIMEOUT = 3  # [s] that a proxy with such a limit waits for bytes of the server in these tests
HOSTS = {"view.example": "", "lab.example": "/feltwire"}  # the folder of the page at each host


def once(text, old, new):
    return every(text, old, new, 1)


def every(text, old, new, times):
    assert text.count(old) == times, f"the documented configuration has not {times} times: {old}"
    return text.replace(old, new)


class WebSocket:
    """The client's end of a WebSocket (RFC 6455) over a connection that has sent the head of its request."""

    def __init__(self, stream):
        self.stream = stream

    def send(self, message):
        data = json.dumps(message).encode()
        assert len(data) < 65536
        head = bytes([0x81, 0x80 | len(data)]) if len(data) < 126 else struct.pack(">BBH", 0x81, 0x80 | 126, len(data))
        self.stream.write(head + bytes(4) + data)  # masked by zero bytes
        self.stream.flush()

    def receive(self):
        """(opcode, bytes) of the next frame"""
        first, length = self.exactly(2)
        if length == 126:
            (length,) = struct.unpack(">H", self.exactly(2))
        elif length == 127:
            (length,) = struct.unpack(">Q", self.exactly(8))
        return first & 0x0F, self.exactly(length)

    def exactly(self, count):
        data = self.stream.read(count)
        if len(data) < count:
            raise EOFError("the connection was closed")
        return data

    def text(self, kind):
        """The next text message of this type"""
        while True:
            opcode, data = self.receive()
            if opcode == 8:
                raise EOFError(f"closed: {data[2:].decode()}")
            if opcode == 1 and (message := json.loads(data)).get("type", message.get("op")) == kind:
                return message


class BehindProxy:
    """The tests; a class with run_proxy() is a unittest.TestCase of it, too."""

    unknown_host = 403  # the status for a host that the configuration does not name

    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.addClassCleanup(cls.stack.close)
        cls.folder = pathlib.Path(cls.stack.enter_context(tempfile.TemporaryDirectory(prefix="feltwire-proxy-")))
        cls.start_server()
        cls.start_proxy()

    @classmethod
    def start(cls, command, **options):
        process = cls.stack.enter_context(subprocess.Popen([str(word) for word in command], text=True, **options))
        cls.stack.callback(process.terminate)
        return process

    @classmethod
    def start_server(cls):
        cls.state = cls.folder / "state"
        names = [word for host in HOSTS for word in ("--web-name", host)]
        log = cls.stack.enter_context((cls.folder / "server.log").open("w"))
        server = cls.start([PROGRAMS / "feltwire-server", "--scene", SOURCE / "scenes/room.json", "--port", "0", "--web", "0", "--state",
                            cls.state, *names], stdout=subprocess.PIPE, stderr=log)
        for line in server.stdout:
            if found := re.match(r"listening: control tcp (\d+)", line):
                cls.control = int(found[1])
            if found := re.match(r"live page: http://127\.0\.0\.1:(\d+)/", line):
                cls.web = int(found[1])
                break
        else:
            raise AssertionError((cls.folder / "server.log").read_text())
        cls.token = (cls.state / "local.token").read_text().strip()

    @classmethod
    def start_proxy(cls):
        cls.certificate, cls.key, cls.error_log = cls.folder / "cert.pem", cls.folder / "key.pem", cls.folder / "error.log"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", str(cls.key),
                        "-out", str(cls.certificate), "-days", "2", "-subj", "/CN=proxy", "-addext",
                        "subjectAltName=" + ",".join(f"DNS:{host}" for host in HOSTS)], check=True, stderr=subprocess.DEVNULL)
        cls.trust = ssl.create_default_context(cafile=str(cls.certificate))
        while not cls.proxy_runs():
            pass

    @classmethod
    def proxy_runs(cls):
        """Starts the proxy on a free port. False: another program was quicker to take the port."""
        with socket.create_server(("127.0.0.1", 0)) as free:
            cls.port = free.getsockname()[1]
        cls.error_log.write_text("")
        proxy = cls.run_proxy()
        deadline = time.monotonic() + PATIENCE
        while proxy.poll() is None and time.monotonic() < deadline:
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", cls.port), timeout=PATIENCE):
                return True
            time.sleep(0.02)
        wrong = cls.error_log.read_text()
        if "address already in use" not in wrong.lower():
            raise AssertionError(f"the proxy does not run: {wrong}")
        return False

    @classmethod
    def run_proxy(cls):
        """Starts the proxy on cls.port, with the documented configuration; its errors go to cls.error_log. Returns the process."""
        raise NotImplementedError

    @contextlib.contextmanager
    def connection(self, host):
        with socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE) as plain:
            with self.trust.wrap_socket(plain, server_hostname=host) as secure, secure.makefile("rwb") as stream:
                yield stream

    def ask(self, stream, host, path, **headers):
        """Sends a request. Returns the status and the head of the answer."""
        lines = [f"GET {path} HTTP/1.1", f"Host: {headers.pop('Host', f'{host}:{self.port}')}"]
        lines += [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
        stream.write(("\r\n".join(lines) + "\r\n\r\n").encode())
        stream.flush()
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            line = stream.readline()
            self.assertTrue(line, f"the proxy closed the connection: {self.error_log.read_text()}")
            head += line
        return int(head.split()[1]), head.decode()

    def get(self, host, path, **headers):
        """(status, head, bytes) of an answer"""
        with self.connection(host) as stream:
            status, head = self.ask(stream, host, path, Connection="close", **headers)
            return status, head, stream.read()

    def upgrade(self, stream, host, path, protocol, origin, **headers):
        status, _ = self.ask(stream, host, path, Connection="Upgrade", Upgrade="websocket", Sec_WebSocket_Version=13,
                             Sec_WebSocket_Key=base64.b64encode(bytes(16)).decode(), Sec_WebSocket_Protocol=protocol, Origin=origin, **headers)
        return status

    def test_the_page_and_its_files(self):
        for host, folder in HOSTS.items():
            for path in ("/", "/app.js", "/early.js", "/style.css", "/replay", "/health"):
                with self.subTest(host=host, path=path):
                    status, _, content = self.get(host, folder + path)
                    self.assertEqual(status, 200)
                    self.assertTrue(content)

    def test_a_folder_without_its_slash_leads_to_the_page(self):
        status, head, _ = self.get("lab.example", "/feltwire")
        self.assertIn(status, (301, 302))
        self.assertIn("/feltwire/\r\n", head)

    def test_the_counters_are_not_shown(self):
        for host, folder in HOSTS.items():
            for path in ("/metrics", "/metrics?a=b", "/%6detrics", "/./metrics", "//metrics", "/a/../metrics", "/metrics/", "/metrics;"):
                with self.subTest(host=host, path=path):
                    status, _, content = self.get(host, folder + path)
                    self.assertGreaterEqual(status, 400)
                    self.assertNotIn(b"feltwire_sessions", content)

    def test_the_page_gets_pictures_longer_than_the_proxy_waits(self):
        for host, folder in HOSTS.items():
            with self.subTest(host=host), self.connection(host) as stream:
                self.assertEqual(self.upgrade(stream, host, folder + "/live", "feltwire.live.v1", f"https://{host}:{self.port}"), 101)
                viewer = WebSocket(stream)
                viewer.send({"token": self.token})
                self.assertEqual(viewer.text("hello")["scenes"], ["room"])
                first = viewer.text("sessions")["time"]
                while viewer.text("sessions")["time"] < first + 2 * READ_TIMEOUT:
                    pass

    def test_pages_of_others_may_not_look_on(self):
        for host, folder in HOSTS.items():
            path = folder + "/live"
            for origin in ("https://evil.example", f"https://{host}.evil.example:{self.port}", f"https://{host}:{self.port + 1}",
                           f"https://127.0.0.1:{self.port}", f"http://127.0.0.1:{self.web}", "null"):
                with self.subTest(host=host, origin=origin), self.connection(host) as stream:
                    self.assertEqual(self.upgrade(stream, host, path, "feltwire.live.v1", origin), 403)
            with self.subTest(host=host, name="another"), self.connection(host) as stream:
                self.assertEqual(self.upgrade(stream, host, path, "feltwire.live.v1", "https://evil.example", Host="evil.example"), self.unknown_host)

    def test_a_ticket_has_the_address_of_the_proxy(self):
        for host, folder in HOSTS.items():
            with self.subTest(host=host):
                status, _, content = self.get(host, folder + "/ticket?scene=room", Authorization=f"Bearer {self.token}")
                self.assertEqual(status, 200)
                address = content.decode().strip()
                begin = f"wss://{host}:{self.port}{folder}/foxglove?ticket="
                self.assertTrue(address.startswith(begin), address.split("?")[0])
                with self.connection(host) as stream:
                    path = address.removeprefix(f"wss://{host}:{self.port}")
                    self.assertEqual(self.upgrade(stream, host, path, "foxglove.sdk.v1", "https://app.foxglove.dev"), 101)
                    self.assertEqual(WebSocket(stream).text("serverInfo")["op"], "serverInfo")

    def test_a_browser_shows_a_hand(self):
        chromium = os.environ.get("FELTWIRE_CHROMIUM")
        if not chromium:
            self.skipTest("no browser (FELTWIRE_CHROMIUM)")
        browser = self.folder / "browser"
        browser.write_text(f'#!/bin/sh\nexec "{chromium}" --ignore-certificate-errors --host-resolver-rules="MAP *.example 127.0.0.1" "$@"\n')
        browser.chmod(0o755)
        self.start([PROGRAMS / "feltwire-client", "--connect", f"127.0.0.1:{self.control}", "--fingerprint-file", self.state / "fingerprint",
                    "--token-file", self.state / "local.token", "--scene", "room", "--device", "simulated:path=slide"],
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for host, folder in HOSTS.items():
            with self.subTest(host=host):
                picture = self.folder / f"{host}.png"
                subprocess.run([SOURCE / "scripts/page-picture.mjs", f"https://{host}:{self.port}{folder}/#token={self.token}", picture, "1", "0"],
                               env={**os.environ, "FELTWIRE_CHROMIUM": str(browser)}, check=True, stdout=subprocess.DEVNULL)
                self.assertGreater(picture.stat().st_size, 0)
