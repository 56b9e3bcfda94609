"""How others in the network reach this machine."""

import contextlib
import socket


def own_address() -> str:
    """This machine's address in its network: that from which it would send (nothing is sent), or, where no way leads
    out of the hall, the first that it has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking, contextlib.suppress(OSError):
        asking.connect(("192.0.2.1", 9))
        return str(asking.getsockname()[0])
    with contextlib.suppress(ImportError, OSError):
        import ifaddr

        found = [str(ip.ip) for adapter in ifaddr.get_adapters() for ip in adapter.ips if ip.is_IPv4]
        return next((address for address in found if not address.startswith("127.")), "127.0.0.1")
    return "127.0.0.1"
