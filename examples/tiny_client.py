#!/usr/bin/env python3
"""A whole feltwire client without feltwire: joins a server, presses a simulated hand on a surface, and prints the force.

    tiny_client.py HOST:PORT SCENE FINGERPRINT TOKEN_FILE [SECONDS]

It needs Debian's python3-cryptography, and follows protocol/PROTOCOL.md. It prints forces and moves no device: beside the server's bound
a device needs an account of energy and the safety limits of the hand, which are not here ("A client must").
"""
import functools
import hashlib
import hmac
import math
import select
import socket
import ssl
import struct
import sys
import time

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305

VERSION, SAMPLES, GOODBYE = 2, 1, 3  # of the protocol; kinds of datagrams
JOIN, ACCEPTED, REFUSED, AUTHENTICATE, AUTHENTICATED = 1, 2, 9, 10, 11  # places in the union `Body` of control.fbs, from 1
PERIOD, HOLD, DEPTH, SWING = 0.002, 0.1, 0.01, 2.0  # [s] of the servo, [s] age at which a command is zero, [m] and [s] of the movement


def build(table):
    """A FlatBuffer. `table`: slot -> (struct format, numbers...), a text, (count, bytes) as a vector of structs, or another table."""
    out = bytearray(4)

    def put(value, place):
        if not isinstance(value, dict):
            count, data = value if isinstance(value, tuple) else (len(value.encode()), value.encode() + b"\0")
            out.extend(bytes(-(len(out) + 4) % 8))
            struct.pack_into("<I", out, place, len(out) - place)
            return out.extend(struct.pack("<I", count) + data)
        slots = 1 + max(value, default=-1)
        out.extend(bytes(-(len(out) + 2 * slots) % 4))
        vtable, start = len(out), len(out) + 4 + 2 * slots
        struct.pack_into("<I", out, place, start - place)
        out.extend(bytes(4 + 2 * slots) + struct.pack("<i", start - vtable))
        later = []
        for slot, part in value.items():
            number = isinstance(part, tuple) and isinstance(part[0], str)
            data = struct.pack("<" + part[0], *part[1:]) if number else bytes(4)
            out.extend(bytes(-len(out) % min(len(data), 8)))
            struct.pack_into("<H", out, vtable + 4 + 2 * slot, len(out) - start)
            if not number:
                later.append((part, len(out)))
            out.extend(data)
        struct.pack_into("<HH", out, vtable, start - vtable, len(out) - start)
        for part, at in later:
            put(part, at)
    put(table, 0)
    return bytes(out)


def get(data, table, slot, form, default=0):
    """A field: a number or a struct by its format, the bytes of a text or of a vector, or the place of a table."""
    vtable = table - struct.unpack_from("<i", data, table)[0]
    known = 4 + 2 * slot < struct.unpack_from("<H", data, vtable)[0]
    at = table + struct.unpack_from("<H", data, vtable + 4 + 2 * slot)[0] if known else table
    if at == table:
        return default
    found = struct.unpack_from("<" + {"bytes": "I", "table": "I"}.get(form, form), data, at)
    if form == "bytes":
        return data[at + found[0] + 4:][:struct.unpack_from("<I", data, at + found[0])[0]]
    return at + found[0] if form == "table" else found if found[1:] else found[0]


def ask(tls, kind, request, wanted):
    """The answer of this kind to a request: the message, and where its table is."""
    message = build({0: ("B", kind), 1: request})
    tls.sendall(struct.pack("<I", len(message)) + message)
    stream = tls.makefile("rb")
    data = stream.read(struct.unpack("<I", stream.read(4))[0])
    root = struct.unpack_from("<I", data)[0]
    body, answered = get(data, root, 1, "table"), get(data, root, 0, "B")
    if answered != wanted:
        raise SystemExit("refused: " + get(data, body, 1, "bytes").decode() if answered == REFUSED else f"an answer of kind {answered}")
    return data, body


@functools.lru_cache(maxsize=4)
def cipher(secret, generation):
    """The key of a generation of 2^22 packets (HKDF-Expand, SHA-256)."""
    for label in [b"feltwire key update"] * generation + [b"feltwire key"]:
        secret = hmac.new(secret, label + b"\x01", hashlib.sha256).digest()
    return ChaCha20Poly1305(secret)


def main(address, scene, fingerprint, token_file, seconds="5"):
    host, port = address.rsplit(":", 1)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.minimum_version, context.check_hostname, context.verify_mode = ssl.TLSVersion.TLSv1_3, False, ssl.CERT_NONE
    tls = context.wrap_socket(socket.create_connection((host, int(port)), timeout=10))
    if hashlib.sha256(tls.getpeercert(binary_form=True)).hexdigest() != fingerprint:  # it decides, before a byte is sent
        raise SystemExit("this is not the server whose fingerprint was given")
    with open(token_file, encoding="ascii") as file:
        data, body = ask(tls, AUTHENTICATE, {0: file.read().strip(), 1: ("H", VERSION), 2: ("H", VERSION)}, AUTHENTICATED)
    if not get(data, body, 4, "H", 1) <= VERSION <= get(data, body, 3, "H", 1):
        raise SystemExit(f"the server speaks version {get(data, body, 3, 'H', 1)} of the protocol, this client version {VERSION}")
    device = {0: "tiny", 4: ("d", 5.0), 6: ("d", 0.1), 9: ("d", 8.0), 10: ("d", 3.0)}  # damping [N s/m], mass [kg], forces [N]
    parameters = {3: ("B", 0), 4: ("d", PERIOD), 5: ("B", 0), 8: ("d", HOLD)}  # the server bounds; no sample is repeated
    data, body = ask(tls, JOIN, {0: "tiny client", 1: scene, 2: device, 3: parameters}, ACCEPTED)
    session, silence, up, down = (get(data, body, slot, form) for slot, form in ((0, "Q"), (3, "d"), (15, "bytes"), (16, "bytes")))
    if not (up and down and len(up) == len(down) == 32 and up != down and get(data, body, 9, "B", 2) == 2):
        raise SystemExit("the server gave no good secrets for ChaCha20-Poly1305")
    start, normal = get(data, body, 6, "3d", (0, 0, 0)), get(data, body, 7, "3d", (0, 0, 1))
    udp = socket.socket(tls.family, socket.SOCK_DGRAM)
    udp.connect((tls.getpeername()[0], int(port) + get(data, body, 1, "H")))

    def send(kind, packet, table):
        header = struct.pack("<2sBBIQQ", b"FW", 1, kind, 0, session, packet)
        udp.send(header + cipher(up, packet >> 22).encrypt(bytes(4) + header[16:], build(table), header))
    begin = alive = time.monotonic()
    packet, highest, force, depths = 0, 0, (0.0, 0.0, 0.0), {}
    while time.monotonic() < begin + float(seconds):
        now, packet = time.monotonic(), packet + 1
        share = min(1.0, max(0.0, 2.0 - 2.0 * (now - alive) / HOLD))  # without answers the force fades
        depths[packet] = DEPTH * math.sin(2 * math.pi * (now - begin) / SWING)
        position = (s - n * depths[packet] for s, n in zip(start, normal))
        sample = struct.pack("<Qq3d3f3f", packet, int(now * 1e9), *position, *(share * part for part in force), 0, 0, 0)
        send(SAMPLES, packet, {0: (1, sample)})
        while select.select([udp], [], [], 0)[0]:
            try:
                datagram = udp.recv(2048)
                magic, version, kind, reserved, to, number = struct.unpack_from("<2sBBIQQ", datagram)
                if (magic, version, reserved, to) != (b"FW", 1, 0, session) or number <= highest:
                    continue
                data = cipher(down, number >> 22).decrypt(bytes(4) + datagram[16:24], datagram[24:], datagram[:24])
            except (OSError, struct.error, InvalidTag):
                continue  # nobody listens, or a stranger's datagram
            highest, alive, table = number, now, struct.unpack_from("<I", data)[0]
            if kind == GOODBYE:
                raise SystemExit(f"the server ended the session, reason {get(data, table, 0, 'B')}")
            force = [sum(parts) for parts in zip(get(data, table, 4, "3d"), get(data, table, 5, "3d"))]  # elastic, frictional
            if packet % 50 == 0:
                print(f"{1000 * depths[get(data, table, 0, 'Q')]:.4f} mm deep: {math.hypot(*force):.4f} N", flush=True)
        if now - alive > silence:
            raise SystemExit(f"no answer for {silence} s")
        time.sleep(max(0.0, begin + packet * PERIOD - time.monotonic()))
    for number in (1, 2, 3):  # goodbyes, because one may be lost
        send(GOODBYE, packet + number, {})


if __name__ == "__main__":
    main(*sys.argv[1:]) if len(sys.argv) in (5, 6) else sys.exit(__doc__)
