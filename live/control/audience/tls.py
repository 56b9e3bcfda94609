"""TLS for phones: what the gateway serves with, and what a certificate is tried with before."""

import ssl
import tempfile


def server_context(certificate: bytes, key: bytes) -> ssl.SSLContext:
    """TLS 1.2 or 1.3 with a certificate (with those that vouch for it behind it) and its key, both PEM."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    with tempfile.NamedTemporaryFile() as chain, tempfile.NamedTemporaryFile() as secret:  # mode 600; it takes no bytes
        for file, text in ((chain, certificate), (secret, key)):
            file.write(text)
            file.flush()
        context.load_cert_chain(chain.name, secret.name)
    return context
