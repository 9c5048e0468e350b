"""Datagrams: the header, the keys by packet number, sealing and opening (PROTOCOL.md, "Sealing")."""
import hashlib
import hmac
import struct

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM, ChaCha20Poly1305

SAMPLES, REPLY, GOODBYE = 1, 2, 3
UP, DOWN = 0, 1
CIPHERS = {1: AESGCM, 2: ChaCha20Poly1305}
SECRET = 32  # [bytes]
GENERATION = 1 << 22  # datagrams with one key


def expand(secret, label):
    """HKDF-Expand of RFC 5869 with SHA-256, 32 bytes."""
    return hmac.new(secret, label + b"\x01", hashlib.sha256).digest()


def header(kind, session, packet, magic=b"FW", version=1, reserved=0):
    return struct.pack("<2sBBIQQ", magic, version, kind, reserved, session, packet)


class Keys:
    """One direction of a session."""

    def __init__(self, suite, secret):
        self.suite, self.secrets, self.made = suite, [secret], {}

    def key(self, generation):
        while len(self.secrets) <= generation:
            self.secrets.append(expand(self.secrets[-1], b"feltwire key update"))
        if generation not in self.made:
            self.made[generation] = expand(self.secrets[generation], b"feltwire key")
        return self.made[generation]

    @staticmethod
    def nonce(packet):
        return bytes(4) + struct.pack("<Q", packet)

    def seal(self, head, payload, nonce=None):
        packet = struct.unpack_from("<Q", head, 16)[0]
        return head + CIPHERS[self.suite](self.key(packet >> 22)).encrypt(nonce or self.nonce(packet), payload, head)

    def open(self, datagram):
        """The payload; None if the seal is wrong."""
        packet = struct.unpack_from("<Q", datagram, 16)[0]
        try:
            return CIPHERS[self.suite](self.key(packet >> 22)).decrypt(self.nonce(packet), datagram[24:], datagram[:24])
        except InvalidTag:
            return None


def keys_of(joined):
    """(up, down) of a session, by its JoinAccepted."""
    return Keys(joined.suite, bytes(joined.secret_up)), Keys(joined.suite, bytes(joined.secret_down))


class Head:
    """What the first 24 bytes of a datagram say."""

    def __init__(self, datagram):
        self.magic, self.version, self.kind, self.reserved, self.session, self.packet = struct.unpack_from("<2sBBIQQ", datagram)
