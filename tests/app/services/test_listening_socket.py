"""A listening port that is kept through the death of an engine."""

import os
import signal
import socket
import urllib.error
import urllib.request

import pytest

from live.app.services.http_services import HttpService
from live.app.services.listening_socket import listening_socket
from live.base.errors import PersonError
from live.clock.time_source import SystemClock
from tests.control.waiting import wait_for


def make_service(port: int) -> HttpService:
    plan = {
        "key": "k" * 16,
        "osc": ("127.0.0.1", 9010),
        "name": "Live test",
        "names": {},
        "half": (6.0, 4.0),
        "hosts": [],
    }
    return HttpService(("127.0.0.1", port), "--web", "live.control.web.web_server", lambda: plan, SystemClock())


def answers(port: int) -> bool:
    """Whether the port answers an HTTP request with any status."""
    try:
        urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=5.0).close()
    except urllib.error.HTTPError:
        return True
    except OSError:
        return False
    return True


def test_resumed_engine_listens_at_once_while_old_processes_hold_port():
    """The old processes get no processor and do not notice the end of their engine: here they are stopped."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    before, after, other = make_service(port), make_service(port), make_service(port)
    before.start()
    try:
        assert wait_for(lambda: answers(port), 20)
        assert before.pid is not None
        os.kill(before.pid, signal.SIGSTOP)
        assert before._socket is not None
        before._socket.close()  # as the system closes it with the engine
        with pytest.raises(PersonError, match="in use"):
            other.start()  # another show gets no part of it
        after.resumes = True
        after.start()
        os.kill(before.pid, signal.SIGKILL)
        assert wait_for(lambda: answers(port), 20)
    finally:
        for part in (before, after, other):
            part.stop()


@pytest.mark.parametrize("goes_on", [False, True])
def test_port_of_another_program_is_refused(goes_on):
    with socket.create_server(("127.0.0.1", 0)) as other, pytest.raises(OSError, match="in use"):
        listening_socket(("127.0.0.1", other.getsockname()[1]), 8, resumes=goes_on)
