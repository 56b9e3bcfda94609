"""Tests of the OSC input port: taken, foreign, opened and closed."""

import threading
from pathlib import Path

import pytest

from live.base.event_queue import PriorityQueue
from live.clock.time_source import ManualClock
from live.control.osc.osc_server import OscInput
from live.control.osc.osc_socket import CannotListen, PortBusy
from tests.control.osc.osc_stage import TAP, Stage


def test_busy_port_error_names_the_remedy(stage):
    second = OscInput("127.0.0.1", stage.osc.port, PriorityQueue(), ManualClock())
    with pytest.raises(PortBusy) as caught:
        second.start()
    assert f"127.0.0.1:{stage.osc.port}" in str(caught.value)
    assert "--osc HOST:PORT" in str(caught.value)
    second.stop()


@pytest.mark.parametrize(("host", "port"), [("192.0.2.1", 0), ("127.0.0.1", 70_000), ("not a host", 9010)])
def test_foreign_address_is_a_clear_error(host, port):
    with pytest.raises(CannotListen, match="--osc HOST:PORT"):
        OscInput(host, port, PriorityQueue(), ManualClock()).start()


def test_start_and_stop_leave_no_thread_and_no_open_file():
    def open_files():
        return len(list(Path("/proc/self/fd").iterdir()))

    if not Path("/proc/self/fd").is_dir():
        pytest.skip("counts open files through /proc, which this system does not have")
    stage = Stage()
    with stage:
        stage.send(TAP)
    threads, files = threading.active_count(), open_files()
    for _ in range(20):
        with stage.osc:
            assert stage.osc.port > 0
    stage.osc.stop()
    assert (threading.active_count(), open_files()) == (threads, files)
    assert stage.osc.handler.accepted == 1
