"""Services beside a show: an error of one at start, in a frame or at its end does not affect the others."""

import pytest

from live.app.services.service_registry import ServiceRegistry
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from tests.control.waiting import wait_for


class Device:
    """A service that fails in the given calls."""

    def __init__(self, *fails):
        self.fails, self.done = fails, []

    def _do(self, what):
        self.done.append(what)
        if what in self.fails:
            raise IndexError(f"made by a test: {what}")

    def start(self):
        self._do("start")

    def stop(self):
        self._do("stop")

    def frame(self):
        self._do("frame")

    def early(self):
        self._do("early")

    def status(self):
        return {}


class Lamp(Device):
    """A second class, for a second name."""


@pytest.fixture(autouse=True)
def reset_faults():
    """Clears the skipped services of a test for the next one."""
    yield
    FAULTS.skipped.clear()


@pytest.fixture
def parts():
    made = ServiceRegistry()
    made.bad, made.good = Device("frame", "early", "stop"), Lamp()
    for part in (made.bad, made.good):
        made.add(part)
        made.before_frame_calls.append(part.early)
    return made


def test_service_failing_each_frame_is_skipped_and_others_continue(parts):
    before = FAULTS.total
    for _ in range(300):
        parts.before_frame()
        parts.frame()
    assert parts.good.done.count("frame") == parts.good.done.count("early") == 300
    assert 3 <= parts.bad.done.count("frame") < 10
    assert FAULTS.total - before == parts.bad.done.count("frame") + parts.bad.done.count("early")
    assert "device" in FAULTS.problem()


def test_failing_stop_does_not_prevent_other_stops(parts):
    parts.stop()
    assert parts.good.done == ["stop"]


def test_failing_start_ends_new_show_but_not_resumed_show():
    for forgiving in (False, True):
        parts, bad, good = ServiceRegistry(), Device("start"), Lamp()
        parts.add(bad)
        parts.add(good)
        if not forgiving:
            with pytest.raises(IndexError):
                parts.start()
            continue
        parts.start(tolerant=True)
        parts.frame()
        assert bad.done == ["start", "stop"]
        assert good.done == ["start", "frame"]


class Page(Device):
    """A service whose port is in use for a while."""

    def __init__(self, tries):
        super().__init__()
        self.tries = tries

    def start(self):
        super().start()
        if self.done.count("start") < self.tries:
            raise PersonError("the port is in use", "choose another port")


def test_service_with_busy_port_starts_once_port_is_free(monkeypatch):
    monkeypatch.setattr("live.app.services.service_registry.FIRST_RETRY_DELAY", 0.01)
    parts, page, good = ServiceRegistry(), Page(4), Lamp()
    parts.add(page)
    parts.add(good)
    parts.start(tolerant=True)
    assert "retried until it works" in FAULTS.problem()
    assert wait_for(lambda: page.done.count("start") == 4 and not FAULTS.problem(), 10.0)
    parts.frame()
    assert page.done[-1] == good.done[-1] == "frame"
    parts.stop()
    assert page.done[-1] == good.done[-1] == "stop"


def test_service_that_never_starts_does_not_delay_end_of_show():
    parts, page = ServiceRegistry(), Page(10**9)
    parts.add(page)
    parts.start(tolerant=True)
    parts.stop()
    assert "frame" not in page.done
