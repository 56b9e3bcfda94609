"""TLS contexts: that of servers for everybody, and TLS 1.3 (RFC 8446) between machines of one show.

Machines of a show pin each other's certificates, and OpenSSL trusts only these. Expiry is not checked, because a show
must not end on a date: the pin decides.
"""

import ssl
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Final

NO_CHECK_TIME: Final = 0x200000
"""X509_V_FLAG_NO_CHECK_TIME of OpenSSL, for which Python has no name."""


def tls13(kind: int) -> ssl.SSLContext:
    """Return a context for TLS 1.3 only, without tickets, so that every connection shows its certificates."""
    context = ssl.SSLContext(kind)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    if kind == ssl.PROTOCOL_TLS_SERVER:
        context.num_tickets = 0
    return context


def pinned_context(kind: int, identity: Path | bytes, peers: Iterable[bytes]) -> ssl.SSLContext:
    """Return a context for a machine's key and certificate (a PEM file, or its content) and the certificates (DER) of
    the machines that it trusts."""
    context = tls13(kind)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_REQUIRED
    context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN | ssl.VerifyFlags(NO_CHECK_TIME)
    if isinstance(identity, bytes):
        with tempfile.NamedTemporaryFile() as file:  # mode 600; `ssl` reads files only
            file.write(identity)
            file.flush()
            context.load_cert_chain(file.name)
    else:
        context.load_cert_chain(identity)
    context.load_verify_locations(cadata=b"".join(peers))
    return context


def server_context(certificate: bytes, key: bytes) -> ssl.SSLContext:
    """Return a TLS 1.2/1.3 context for a PEM certificate, followed by its intermediate certificates, and
    its PEM key."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    with tempfile.NamedTemporaryFile() as chain, tempfile.NamedTemporaryFile() as secret:  # mode 600; needs files
        for file, text in ((chain, certificate), (secret, key)):
            file.write(text)
            file.flush()
        context.load_cert_chain(chain.name, secret.name)
    return context
