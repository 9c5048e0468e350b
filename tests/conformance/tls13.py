"""TLS 1.3 for both ends of a control connection, by Python's `ssl`. Certificates are made by Debian's package python3-cryptography."""
import datetime
import hashlib
import socket
import ssl
import tempfile
import warnings
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

TLS11, TLS12, TLS13 = ssl.TLSVersion.TLSv1_1, ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3


class Closed(Exception):
    """The other end closed the connection, or refused it."""


class Silent(Exception):
    """Nothing came within the socket's time."""


def _context(protocol, version):
    context = ssl.SSLContext(protocol)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of the old versions, which a server has to refuse
        context.minimum_version = context.maximum_version = version
    return context


class Identity:
    """A P-256 key and a certificate that it signed itself."""

    def __init__(self, name="model"):
        key, subject = ec.generate_private_key(ec.SECP256R1()), x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)])
        now, day = datetime.datetime.utcnow(), datetime.timedelta(days=1)
        certificate = (x509.CertificateBuilder().subject_name(subject).issuer_name(subject).public_key(key.public_key()).serial_number(1)
                       .not_valid_before(now - day).not_valid_after(now + day).sign(key, hashes.SHA256()))
        self.fingerprint = certificate.fingerprint(hashes.SHA256()).hex()
        self.pem = certificate.public_bytes(serialization.Encoding.PEM) + key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())

    def context(self, version):
        """The context of a server that gives out no tickets."""
        context = _context(ssl.PROTOCOL_TLS_SERVER, version)
        context.num_tickets = 0
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "identity.pem"
            file.write_bytes(self.pem)
            context.load_cert_chain(file)
        return context


class Tls:
    """One connection over a connected socket with a timeout. `identity` makes it the server's end; `version` is the only one offered."""

    def __init__(self, sock, identity=None, version=TLS13):
        if identity:
            context = identity.context(version)
        else:
            context = _context(ssl.PROTOCOL_TLS_CLIENT, version)
            context.check_hostname, context.verify_mode = False, ssl.CERT_NONE  # the fingerprint decides
        self.sock = self._try(lambda: context.wrap_socket(sock, server_side=identity is not None))

    @staticmethod
    def _try(call):
        try:
            return call()
        except (socket.timeout, ssl.SSLWantReadError, ssl.SSLWantWriteError) as error:
            raise Silent from error
        except (OSError, ValueError) as error:
            raise Closed from error

    def patience(self, seconds):
        self.sock.settimeout(seconds)

    def fingerprint(self):
        return hashlib.sha256(self.sock.getpeercert(binary_form=True)).hexdigest()

    def version(self):
        return self.sock.version()

    def has_ticket(self):
        """A ticket of the server came with what was read so far."""
        return self.sock.session.has_ticket

    def send(self, data):
        self._try(lambda: self.sock.sendall(data))

    def receive(self, size):
        """Exactly `size` bytes."""
        parts = b""
        while len(parts) < size:
            part = self._try(lambda: self.sock.recv(size - len(parts)))
            if not part:
                raise Closed
            parts += part
        return parts

    def close(self):
        try:
            self.sock.settimeout(0)
            self.sock.unwrap()  # says the end, and does not wait for the other one's
        except (OSError, ValueError):
            pass
        self.sock.close()
