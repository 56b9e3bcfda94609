"""Parts beside a show: an error of one, when it starts, in a frame or when it ends, is its own."""

import pytest

from live.app.service_registry import ServiceRegistry
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from tests.control.waiting import wait_for


class Device:
    """A part that fails where it is told to."""

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
    """Another one, so that it has another name."""


@pytest.fixture(autouse=True)
def alone():
    """What is left out here is of no other test."""
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


def test_a_part_that_fails_in_each_frame_is_left_out_and_the_others_are_not(parts):
    before = FAULTS.total
    for _ in range(300):
        parts.before_frame()
        parts.frame()
    assert parts.good.done.count("frame") == parts.good.done.count("early") == 300
    assert 3 <= parts.bad.done.count("frame") < 10
    assert FAULTS.total - before == parts.bad.done.count("frame") + parts.bad.done.count("early")
    assert "device" in FAULTS.problem()


def test_one_that_cannot_end_keeps_nobody_else_from_it(parts):
    parts.stop()
    assert parts.good.done == ["stop"]


def test_one_that_cannot_start_ends_a_start_but_not_a_show_that_is_gone_on_with():
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
    """Its port is somebody else's for a while."""

    def __init__(self, tries):
        super().__init__()
        self.tries = tries

    def start(self):
        super().start()
        if self.done.count("start") < self.tries:
            raise PersonError("the port is in use", "choose another port")


def test_one_whose_port_is_taken_starts_as_soon_as_it_is_free(monkeypatch):
    monkeypatch.setattr("live.app.service_registry.FIRST_RETRY_DELAY", 0.01)
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


def test_one_that_never_starts_keeps_no_show_from_its_end():
    parts, page = ServiceRegistry(), Page(10**9)
    parts.add(page)
    parts.start(tolerant=True)
    parts.stop()
    assert "frame" not in page.done
