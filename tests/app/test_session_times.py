"""Frame times reported by a session."""

import socket
import threading
from pathlib import Path

import pytest

from live.app.launch_options import LaunchOptions
from live.app.session import Session
from live.app.session_audio import AudioChoice
from live.supervisor.heartbeat import Heartbeat
from live.supervisor.line_channel import LineChannel
from live.supervisor.supervisor_link import SupervisorLink
from tests.end_to_end.conftest import PATCH


def make_session(folder: Path, lifeline: SupervisorLink | None = None) -> Session:
    patch = folder / "show.toml"
    patch.write_text(PATCH)
    options = LaunchOptions(patch=str(patch), seed=1, osc=("127.0.0.1", 0))
    return Session(options, options.load(), AudioChoice(), lifeline=lifeline)


def run_frame(session: Session, seconds: float) -> None:
    """One frame in which drawing waits for this many seconds."""
    started = session.clock.now()
    session.before_frame()
    session.engine.frame(lambda view: threading.Event().wait(seconds) and None)
    session.after_frame(started, started - 0.016)


@pytest.mark.long
def test_waiting_frame_takes_work_time_but_no_processor_time(tmp_path):
    session = make_session(tmp_path)
    with session.running():
        for _ in range(5):
            run_frame(session, 0.1)
        told = session.status.snapshot(session.clock.now())
    assert told["work_ms"]["p50"] >= 100.0
    assert 0.0 < told["cpu_ms"]["p50"] < 50.0


def test_late_modules_are_imported_once_beside_the_show_after_its_first_frame(tmp_path, monkeypatch):
    imports = []
    monkeypatch.setattr("live.app.session.import_late_modules", lambda: imports.append(threading.current_thread()))
    session = make_session(tmp_path)
    with session.running():
        assert imports == []
        run_frame(session, 0.0)
        session._late_imports.join()
        run_frame(session, 0.0)
    (thread,) = imports
    assert thread is session._late_imports is not threading.main_thread()


def test_overload_from_supervisor_is_reported_as_pressure(tmp_path):
    """From the supervisor's facts on the channel to the status and the renderer."""
    ours, theirs = socket.socketpair()
    supervisor, lifeline = LineChannel(ours), SupervisorLink(LineChannel(theirs), Heartbeat())
    session = make_session(tmp_path, lifeline)
    with session.running():
        assert session.overload == 0.0
        supervisor.send_json(alive="facts", facts={"overload": 0.8})
        run_frame(session, 0.0)
        run_frame(session, 0.0)
        told = session.status.snapshot(session.clock.now())
    assert session.overload == told["pressure"] == 0.8
    supervisor.close()
    lifeline.channel.close()
    lifeline.heartbeat.close()
