"""What a session says of the time that its frames take."""

import socket
import threading
from pathlib import Path

from live.app.launch_options import LaunchOptions
from live.app.session import Session
from live.app.session_audio import AudioChoice
from live.supervisor.heartbeat import Heartbeat
from live.supervisor.line_channel import LineChannel
from live.supervisor.supervisor_link import SupervisorLink
from tests.end_to_end.conftest import PATCH


def made_session(folder: Path, lifeline: SupervisorLink | None = None) -> Session:
    patch = folder / "show.toml"
    patch.write_text(PATCH)
    options = LaunchOptions(patch=str(patch), seed=1, osc=("127.0.0.1", 0))
    return Session(options, options.load(), AudioChoice(), lifeline=lifeline)


def frame(session: Session, seconds: float) -> None:
    """One frame in which drawing waits for so long."""
    started = session.clock.now()
    session.before_frame()
    session.engine.frame(lambda view: threading.Event().wait(seconds) and None)
    session.after_frame(started, started - 0.016)


def test_a_frame_that_waits_takes_time_but_none_of_the_processor(tmp_path):
    session = made_session(tmp_path)
    with session.running():
        for _ in range(5):
            frame(session, 0.1)
        told = session.status.snapshot(session.clock.now())
    assert told["work_ms"]["p50"] >= 100.0
    assert 0.0 < told["cpu_ms"]["p50"] < 50.0


def test_what_the_supervisor_says_of_the_machine_is_pressure(tmp_path):
    """From its facts on the wire to the status and to whoever draws."""
    ours, theirs = socket.socketpair()
    supervisor, lifeline = LineChannel(ours), SupervisorLink(LineChannel(theirs), Heartbeat())
    session = made_session(tmp_path, lifeline)
    with session.running():
        assert session.overload == 0.0
        supervisor.send_json(alive="facts", facts={"overload": 0.8})
        frame(session, 0.0)
        frame(session, 0.0)
        told = session.status.snapshot(session.clock.now())
    assert session.overload == told["pressure"] == 0.8
    supervisor.close()
    lifeline.channel.close()
    lifeline.heartbeat.close()
