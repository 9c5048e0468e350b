#!/usr/bin/env python3
"""The memory of feltwire-server and feltwire-view under strangers that take what they can, beside their usual memory.

usage: memory.py PROGRAMS [--only WORD] [--most 1.5] [--times 400] [--brief]

For each attack a program of its own is started. Its usual memory is what it has after honest use: a hand that presses for two seconds,
and a viewer of the page. Then the attack begins, and its largest memory is read every 10 ms (VmRSS). Prints both and their ratio; the
exit status is 1 where a ratio is --most or above. The attackers come from many networks (127.N.0.1), as an owner of many would.

The page of an address of this machine alone has no TLS; "by TLS" is a page on every address. All traffic stays on this machine.
--brief: the attacks of each kind that take most, for a test.
"""

import argparse
import contextlib
import json
import os
import pathlib
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import threading
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
UPGRADE = ("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: {scheme}://127.0.0.1:{port}\r\nConnection: Upgrade\r\n"
           "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
           "Sec-WebSocket-Protocol: feltwire.live.v1\r\n\r\n")
KEPT = 4.0  # [s] of pings
AFTER = 1.0  # [s] the connections are kept once all are made; strangers have 5 s to show a token
BRIEF = {("server", "control", "a first message of 128 KiB"), ("server", "control", "TLS begun, and a record begun"),
         ("server", "control", "an observer's frames begun"), ("server", "both, TLS", "TLS begun, and a record begun"),
         ("gateway", "page by TLS", "TLS begun, and a record begun"), ("gateway", "page", "a stranger's pings")}


class Program:
    """A program that runs, with the ports that it prints."""

    def __init__(self, command):
        self.process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.control = None
        for text in self.process.stdout:
            if text.startswith("listening: control tcp "):
                self.control = int(text.split()[3].rstrip(","))
            if text.startswith("live page: "):
                self.page = int(text.rsplit(":", 1)[1].split("/")[0])
                return
        raise SystemExit(f"{command[0]} did not start")

    def memory(self):
        """[bytes] resident."""
        for line in pathlib.Path(f"/proc/{self.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) * 1024
        raise SystemExit("the program has ended")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


class Attacker:
    """One connection. It never waits for long, and never reads what it is not told to."""

    def __init__(self, port, number):
        self.line = socket.socket()
        self.line.settimeout(3)
        self.line.bind((f"127.{1 + number % 200}.0.1", 0))
        self.line.connect(("127.0.0.1", port))
        self.port = port
        self.tls = None

    def hello(self):
        """The first words of a client of TLS, as bytes."""
        self.incoming, self.outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
        self.tls = context.wrap_bio(self.incoming, self.outgoing)
        with contextlib.suppress(ssl.SSLWantReadError):
            self.tls.do_handshake()
        return self.outgoing.read()

    def handshake(self):
        self.line.sendall(self.hello())
        while True:
            try:
                self.tls.do_handshake()
                break
            except ssl.SSLWantReadError:
                came = self.line.recv(65536)
                if not came:
                    raise OSError("closed") from None
                self.incoming.write(came)
        self.line.sendall(self.outgoing.read())

    def send(self, data):
        if self.tls is None:
            self.line.sendall(data)
        else:
            self.tls.write(data)
            self.line.sendall(self.outgoing.read())

    def upgrade(self):
        scheme = "http" if self.tls is None else "https"
        self.send(UPGRADE.format(path="/live", port=self.port, scheme=scheme).encode())


def frame(opcode, payload):
    """Of a browser, with a mask of zeros."""
    size = bytes([0x80 | len(payload)]) if len(payload) < 126 else bytes([0x80 | 126]) + struct.pack(">H", len(payload))
    return bytes([0x80 | opcode]) + size + bytes(4) + payload


def silent(_):
    pass


def record_begun(attacker):
    """The first message is as long as one may be. Its last bytes do not come."""
    attacker.line.sendall(b"\x16\x03\x01\x1f\x04" + b"\x01\x00\x1f\x00\x03\x03" + bytes(7900))


def endless_hello(attacker):
    """The first message is 128 KiB long, in records of 16 KiB. The last byte does not come."""
    message = b"\x01\x02\x01\x00\x03\x03" + bytes(0x20100 - 2)
    for at in range(0, len(message) - 1, 0x4000):
        part = message[at:at + 0x4000]
        attacker.line.sendall(b"\x16\x03\x01" + struct.pack(">H", len(part)) + part[:-1 if at + 0x4000 >= len(message) else None])


def hello_only(attacker):
    attacker.line.sendall(attacker.hello())


def hello_and_record(attacker):
    """The server's answer is not taken, and a record of 16 KiB begins."""
    attacker.line.sendall(attacker.hello() + b"\x14\x03\x03\x00\x01\x01")
    time.sleep(0.01)
    attacker.line.sendall(b"\x17\x03\x03\x40\x11" + bytes(4000))


def handshake_only(attacker):
    attacker.handshake()


def handshake_and_record(attacker):
    attacker.handshake()
    attacker.line.sendall(b"\x17\x03\x03\x40\x11" + bytes(8000))


def token_begun(attacker):
    attacker.handshake()
    attacker.send(struct.pack("<I", 512) + bytes(500))


def authentication(token):
    """The control message (protocol/wire/control.fbs) that shows a token, as a frame."""
    kind = 10  # Authenticate in the union Body
    text = token.encode()
    message = struct.pack("<I 4H iIB3x 4H iI I", 12, 8, 12, 8, 4, 8, 16, kind, 6, 8, 4, 0, 8, 4, len(text)) + text
    message += bytes(4 - len(text) % 4)
    return struct.pack("<I", len(message)) + message


def frames_begun(token):
    """Of one who has a token: the longest frame that there is, but for the last byte."""
    def attack(attacker):
        attacker.handshake()
        attacker.send(authentication(token))
        attacker.line.recv(65536)
        attacker.send(struct.pack("<I", 65536) + bytes(65535))
    return attack


def head_begun(attacker):
    attacker.send(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + b"x" * 7000)


def head_begun_tls(attacker):
    attacker.handshake()
    head_begun(attacker)


def message_begun(attacker):
    attacker.upgrade()
    attacker.send(frame(1, bytes(4090))[:-1])


def message_begun_tls(attacker):
    attacker.handshake()
    message_begun(attacker)


def pings(attacker):
    """As fast as they are taken; no answer is read."""
    attacker.upgrade()
    many = frame(9, bytes(125)) * 500
    end = time.monotonic() + KEPT
    while time.monotonic() < end:
        attacker.send(many)


def pings_tls(attacker):
    attacker.handshake()
    pings(attacker)


def viewer_pings(token):
    def attack(attacker):
        attacker.upgrade()
        attacker.send(frame(1, json.dumps({"token": token}).encode()))
        many = frame(9, bytes(125)) * 500
        end = time.monotonic() + KEPT
        while time.monotonic() < end:
            attacker.send(many)
    return attack


def files_unread(attacker):
    """Asks for the page's files, and reads none."""
    attacker.send(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")


def files_unread_tls(attacker):
    attacker.handshake()
    files_unread(attacker)


def attack(program, ports, word, number):
    """Returns the largest memory [bytes] while `number` connections to each port do `word`, and how many were made."""
    made = []

    def work():
        busy = []
        for i in range(number * len(ports)):
            try:
                attacker = Attacker(ports[i % len(ports)], i // len(ports))
                made.append(attacker)
                if number > 8:
                    word(attacker)
                else:
                    busy.append(threading.Thread(target=safely, args=(word, attacker)))
                    busy[-1].start()
            except OSError:
                continue
        for thread in busy:
            thread.join()

    def safely(word, attacker):
        with contextlib.suppress(OSError):
            word(attacker)

    thread = threading.Thread(target=work)
    thread.start()
    largest, end = 0, None
    while end is None or time.monotonic() < end:
        largest = max(largest, program.memory())
        time.sleep(0.01)
        if end is None and not thread.is_alive():
            end = time.monotonic() + AFTER
    for attacker in made:
        attacker.line.close()
    return largest, len(made)


def look(port, token, scheme="http"):
    """An honest viewer, for two seconds."""
    viewer = Attacker(port, 0)
    if scheme == "https":
        viewer.handshake()
    viewer.upgrade()
    viewer.send(frame(1, json.dumps({"token": token}).encode()))
    end = time.monotonic() + 2
    viewer.line.settimeout(0.5)
    with contextlib.suppress(OSError):
        while time.monotonic() < end and viewer.line.recv(65536):
            pass
    viewer.line.close()


def press(programs, state, control):
    subprocess.run(
        [programs / "feltwire-client", "--connect", f"127.0.0.1:{control}", "--fingerprint-file", state / "fingerprint", "--token-file",
         state / "local.token", "--scene", "room", "--device", "simulated:path=press", "--duration", "2"],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)


def server(programs, state, web):
    return Program([programs / "feltwire-server", "--scene", SOURCE / "scenes" / "room.json", "--port", "0", "--web", web, "--state", state])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=pathlib.Path)
    parser.add_argument("--only", default="", help="attacks whose name has this")
    parser.add_argument("--most", type=float, default=1.5)
    parser.add_argument("--times", type=int, default=400, help="connections of an attack")
    parser.add_argument("--brief", action="store_true")
    args = parser.parse_args()
    silent_ones = [("silent", silent), ("a first message begun", record_begun), ("a first message of 128 KiB", endless_hello),
                   ("a first message, no more", hello_only), ("TLS begun, and a record begun", hello_and_record),
                   ("TLS, then silent", handshake_only), ("TLS, then a record begun", handshake_and_record)]
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        state, view_state = pathlib.Path(folder) / "server", pathlib.Path(folder) / "view"
        with server(args.programs, state, "0"):
            pass
        token = (state / "local.token").read_text().strip()

        def tokens(of, role):
            return subprocess.run([args.programs / "feltwire-server", "token", "add", "--state", of, "--client", role, "--scene", "room",
                                   "--role", role, "--expires", "1d"], capture_output=True, text=True, check=True).stdout.strip().split()[-1]
        eye = tokens(state, "observer")
        (state / "eye.token").write_text(eye + "\n")
        os.chmod(state / "eye.token", 0o600)

        def view(control, web):
            return Program([args.programs / "feltwire-view", "--connect", f"127.0.0.1:{control}", "--fingerprint-file", state / "fingerprint",
                            "--token-file", state / "eye.token", "--scene", SOURCE / "scenes" / "room.json", "--web", web, "--state", view_state])
        with server(args.programs, state, "0") as first, view(first.control, "0"):
            pass
        view_token = tokens(view_state, "observer")

        def page_attacks(own):
            plain = [("silent", silent, args.times), ("a head begun", head_begun, args.times), ("a message begun", message_begun, args.times),
                     ("files unread", files_unread, args.times), ("a stranger's pings", pings, 2),
                     ("an observer's pings", viewer_pings(own), 2)]
            by_tls = [(name, word, args.times) for name, word in silent_ones]
            by_tls += [("a head begun", head_begun_tls, args.times), ("a message begun", message_begun_tls, args.times),
                       ("files unread", files_unread_tls, args.times), ("a stranger's pings", pings_tls, 2)]
            return [("0", "page", *a) for a in plain] + [("0.0.0.0:0", "page by TLS", *a) for a in by_tls]

        rows = [("server", "0", "control", name, word, args.times) for name, word in silent_ones
                + [("TLS, then a token begun", token_begun), ("an observer's frames begun", frames_begun(eye))]]
        rows += [("server", "0.0.0.0:0", "both, TLS", *a, args.times) for a in silent_ones]
        rows += [("server", *row) for row in page_attacks(token)]
        rows += [("gateway", *row) for row in page_attacks(view_token)]
        print(f"{'program':8} {'port':12} {'attack':32} {'made':>5} {'usual':>7} {'largest':>8} [MB] {'ratio':>6}")
        for kind, web, port, name, word, number in rows:
            if args.only not in f"{kind} {port}: {name}" or (args.brief and (kind, port, name) not in BRIEF):
                continue
            scheme = "http" if web == "0" else "https"
            with contextlib.ExitStack() as stack:
                served = stack.enter_context(server(args.programs, state, web if kind == "server" else "0"))
                program = served if kind == "server" else stack.enter_context(view(served.control, web))
                press(args.programs, state, served.control)
                look(program.page, token if kind == "server" else view_token, scheme)
                usual = program.memory()
                ports = {"control": [program.control], "both, TLS": [program.control, program.page]}.get(port, [program.page])
                largest, made = attack(program, ports, word, number)
            ratio = largest / usual
            missed = ratio >= args.most
            failed = failed or missed
            print(f"{kind:8} {port:12} {name:32} {made:5} {usual / 1e6:7.1f} {largest / 1e6:8.1f}      {ratio:6.2f}"
                  + ("  MISSED" if missed else ""), flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
