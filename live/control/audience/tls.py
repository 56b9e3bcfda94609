"""TLS context of the gateway, also used to check a certificate beforehand."""

import ssl
import tempfile


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
