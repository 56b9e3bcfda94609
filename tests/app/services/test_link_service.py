"""`live play --link`: invalid values, and a machine without Link."""

import sys

import pytest
from rich.console import Console

from live.app.services.click_service import make_link
from live.base.event_queue import EventQueue
from live.clock.time_source import ManualClock
from tests.cli.command import run_live
from tests.show.made_show import made_show


def test_invalid_link_value_is_refused_in_one_line() -> None:
    done = run_live("play", "--link", "yes")
    assert done.returncode == 2
    assert "--link yes: one of follow, lead, off expected" in done.stderr


def test_show_continues_without_link_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "link", None)
    show, console = made_show(), Console(record=True, width=200)
    assert make_link("follow", show, EventQueue(), ManualClock(), console) is None
    assert "Ableton Link is not installed" in console.export_text()
    assert make_link(None, show, EventQueue(), ManualClock(), console) is None
    assert console.export_text() == ""
