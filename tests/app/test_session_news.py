"""Messages of the parts of a show to an operator without the overlay."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from live.app.session import make_notifier


def test_refusals_and_problems_of_all_parts_are_printed_once(capsys: pytest.CaptureFixture[str]) -> None:
    show = SimpleNamespace(refusals=SimpleNamespace(last_reason=""))
    refused = ""
    osc = SimpleNamespace(refusal=lambda: refused)
    listens = SimpleNamespace(status=lambda: {"problem": problem})
    problem = ""
    watch = SimpleNamespace(problem="", message="")
    news = make_notifier(cast(Any, show), cast(Any, osc), cast(Any, listens), None, cast(Any, watch), None, None)
    news.check()
    assert capsys.readouterr().err == ""
    problem = "stage box is not there"
    refused = "an OSC packet: too long"
    news.check()
    news.check()
    told = capsys.readouterr().err
    assert told.count("sound: stage box is not there") == 1
    assert told.count("an OSC packet: too long") == 1
    assert news.refused == "an OSC packet: too long"
