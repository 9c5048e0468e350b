"""TLS 1.3 with the exporter of keying material, and the two ciphers of datagrams, by the system's OpenSSL 3.

Python's `ssl` has no exporter, so this calls libssl itself. It needs no package but Python.
"""
import ctypes
import hashlib

SSL = ctypes.CDLL("libssl.so.3")
CRYPTO = ctypes.CDLL("libcrypto.so.3")
TLS12, TLS13 = 0x0303, 0x0304
WANT_READ, WANT_WRITE = 2, 3
POINTER = ctypes.c_void_p
TICKET = ctypes.CFUNCTYPE(ctypes.c_int, POINTER, POINTER)


def _declare():
    pointers = {SSL: ("TLS_client_method TLS_server_method SSL_CTX_new SSL_new SSL_get1_peer_certificate",),
                CRYPTO: ("EVP_PKEY_Q_keygen X509_new X509_get_serialNumber X509_getm_notBefore X509_getm_notAfter X509_gmtime_adj "
                         "X509_get_subject_name EVP_sha256 EVP_CIPHER_CTX_new EVP_aes_256_gcm EVP_chacha20_poly1305",)}
    for library, (names,) in pointers.items():
        for name in names.split():
            getattr(library, name).restype = POINTER


_declare()


def _p(value):
    return POINTER(value)


class Identity:
    """A P-256 key and a certificate that it signed itself."""

    def __init__(self, name=b"model"):
        self.key = CRYPTO.EVP_PKEY_Q_keygen(None, None, b"EC", b"P-256")
        self.certificate = CRYPTO.X509_new()
        x509 = _p(self.certificate)
        CRYPTO.X509_set_version(x509, ctypes.c_long(2))
        CRYPTO.ASN1_INTEGER_set(_p(CRYPTO.X509_get_serialNumber(x509)), ctypes.c_long(1))
        CRYPTO.X509_gmtime_adj(_p(CRYPTO.X509_getm_notBefore(x509)), ctypes.c_long(-3600))
        CRYPTO.X509_gmtime_adj(_p(CRYPTO.X509_getm_notAfter(x509)), ctypes.c_long(86400))
        CRYPTO.X509_set_pubkey(x509, _p(self.key))
        subject = _p(CRYPTO.X509_get_subject_name(x509))
        CRYPTO.X509_NAME_add_entry_by_txt(subject, b"CN", 0x1001, name, -1, -1, 0)
        CRYPTO.X509_set_issuer_name(x509, subject)
        if not CRYPTO.X509_sign(x509, _p(self.key), _p(CRYPTO.EVP_sha256())):
            raise OSError("no certificate")
        self.fingerprint = hashlib.sha256(_der(self.certificate)).hexdigest()


def _der(certificate):
    size = CRYPTO.i2d_X509(_p(certificate), None)
    data = ctypes.create_string_buffer(size)
    end = ctypes.c_void_p(ctypes.addressof(data))
    CRYPTO.i2d_X509(_p(certificate), ctypes.byref(end))
    return data.raw


class Closed(Exception):
    """The other end closed the connection, or refused it."""


class Silent(Exception):
    """Nothing came within the socket's time."""


class Tls:
    """One connection over a connected, blocking socket. `identity` makes it the server's end; `version` is the only one offered."""

    def __init__(self, sock, identity=None, version=TLS13):
        self.sock, self.tickets = sock, 0
        self.context = _p(SSL.SSL_CTX_new(_p(SSL.TLS_server_method() if identity else SSL.TLS_client_method())))
        for command in (123, 124):  # the lowest and the highest version
            SSL.SSL_CTX_ctrl(self.context, command, ctypes.c_long(version), None)
        if identity:
            SSL.SSL_CTX_set_num_tickets(self.context, ctypes.c_size_t(0))
            SSL.SSL_CTX_use_certificate(self.context, _p(identity.certificate))
            SSL.SSL_CTX_use_PrivateKey(self.context, _p(identity.key))
        else:
            self._count = TICKET(self._ticket)
            SSL.SSL_CTX_ctrl(self.context, 44, ctypes.c_long(1), None)  # a cache of sessions, so that tickets are told
            SSL.SSL_CTX_sess_set_new_cb(self.context, self._count)
        self.ssl = _p(SSL.SSL_new(self.context))
        SSL.SSL_set_fd(self.ssl, sock.fileno())
        done = (SSL.SSL_accept if identity else SSL.SSL_connect)(self.ssl)
        if done != 1:
            self._fail(done)

    def _ticket(self, _ssl, _session):
        self.tickets += 1
        return 0

    def _fail(self, result):
        error = SSL.SSL_get_error(self.ssl, result)
        CRYPTO.ERR_clear_error()
        if error in (WANT_READ, WANT_WRITE):
            raise Silent()
        raise Closed()

    def fingerprint(self):
        return hashlib.sha256(_der(SSL.SSL_get1_peer_certificate(self.ssl))).hexdigest()

    def version(self):
        return SSL.SSL_version(self.ssl)

    def send(self, data):
        if data:
            done = SSL.SSL_write(self.ssl, data, len(data))
            if done <= 0:
                self._fail(done)

    def receive(self, size):
        """Exactly `size` bytes."""
        parts = b""
        while len(parts) < size:
            buffer = ctypes.create_string_buffer(size - len(parts))
            done = SSL.SSL_read(self.ssl, buffer, size - len(parts))
            if done <= 0:
                self._fail(done)
            parts += buffer.raw[:done]
        return parts

    def export(self, label, context, size):
        """Keying material of RFC 8446, 7.5."""
        out = ctypes.create_string_buffer(size)
        done = SSL.SSL_export_keying_material(self.ssl, out, ctypes.c_size_t(size), label, ctypes.c_size_t(len(label)), context,
                                              ctypes.c_size_t(len(context)), 1)
        if done != 1:
            raise OSError("no keying material")
        return out.raw

    def close(self):
        if self.ssl:
            SSL.SSL_shutdown(self.ssl)
            CRYPTO.ERR_clear_error()
            SSL.SSL_free(self.ssl)
            SSL.SSL_CTX_free(self.context)
            self.ssl = None
        self.sock.close()


_CIPHERS = {1: CRYPTO.EVP_aes_256_gcm(), 2: CRYPTO.EVP_chacha20_poly1305()}


def seal(suite, key, nonce, associated, plain):
    """Ciphertext and tag."""
    return _crypt(suite, key, nonce, associated, plain, None)


def open_sealed(suite, key, nonce, associated, sealed):
    """The plain text; None if the tag is wrong."""
    return _crypt(suite, key, nonce, associated, sealed[:-16], sealed[-16:])


def _crypt(suite, key, nonce, associated, data, tag):
    context = _p(CRYPTO.EVP_CIPHER_CTX_new())
    length, out = ctypes.c_int(), ctypes.create_string_buffer(len(data) + 16)
    enc = 1 if tag is None else 0
    try:
        CRYPTO.EVP_CipherInit_ex(context, _p(_CIPHERS[suite]), None, key, nonce, enc)
        CRYPTO.EVP_CipherUpdate(context, None, ctypes.byref(length), associated, len(associated))
        CRYPTO.EVP_CipherUpdate(context, out, ctypes.byref(length), data, len(data))
        if tag is not None:
            CRYPTO.EVP_CIPHER_CTX_ctrl(context, 0x11, 16, ctypes.c_char_p(tag))
        if CRYPTO.EVP_CipherFinal_ex(context, ctypes.create_string_buffer(16), ctypes.byref(length)) != 1:
            return None
        result = out.raw[:len(data)]
        if tag is None:
            CRYPTO.EVP_CIPHER_CTX_ctrl(context, 0x10, 16, out)
            result += out.raw[:16]
        return result
    finally:
        CRYPTO.EVP_CIPHER_CTX_free(context)
