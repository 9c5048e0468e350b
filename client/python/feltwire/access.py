"""The server, and the credentials for it."""
from __future__ import annotations

import os
from typing import Any, Optional

from .values import Path, path_or_none

def set_access(given: Any, server: str, token_file: Optional[Path], fingerprint: Optional[str], fingerprint_file: Optional[Path],
               ca_file: Optional[Path], certificate_file: Optional[Path] = None, key_file: Optional[Path] = None) -> None:
    """Sets the server and the credentials of options, as feltwire.join() describes them. Only options of an observer, an admin or a
    follower have fields for a certificate of the client."""
    if fingerprint is None and fingerprint_file is None and ca_file is None:
        fingerprint_file = os.environ.get("FELTWIRE_FINGERPRINT_FILE")
    if token_file is None:
        token_file = os.environ.get("FELTWIRE_TOKEN_FILE")
    given.server, given.fingerprint, given.ca_file = path_or_none(server), path_or_none(fingerprint), path_or_none(ca_file)
    given.fingerprint_file, given.token_file = path_or_none(fingerprint_file), path_or_none(token_file)
    if certificate_file is not None or key_file is not None:
        given.certificate_file, given.key_file = path_or_none(certificate_file), path_or_none(key_file)
