"""The speed printed by `live replay`."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from live.cli.replay import _print_result


@pytest.mark.parametrize(("speed", "words"), [(0.048, "0.05 times"), (3.96, "3.96 times"), (38.2, "38 times")])
def test_replay_slower_than_real_time_prints_nonzero_speed(capsys, speed, words):
    journal = cast(Any, SimpleNamespace(complete=True, problems=()))
    result = SimpleNamespace(
        ticks=640, first_tick=0, measures=5, different=0, differences=(), failed=0, problems=(), not_compared=()
    )
    _print_result(journal, cast(Any, result), speed)
    assert f"; {words} real time" in " ".join(capsys.readouterr().out.split())
