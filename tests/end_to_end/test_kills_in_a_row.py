"""Engines that are killed one after another, sooner than a spare has begun to prepare itself."""

import os
import signal
import time
from pathlib import Path

from tests.control.waiting import BUSY, wait_for
from tests.end_to_end.test_alive import children, until_spare, verified


def test_three_kills_half_a_second_apart_cost_no_more_than_three_seconds(play, patch: Path, tmp_path: Path):
    """Kill to dance: the engines that come after the spare come out of the nursery, with everything loaded."""
    journal = tmp_path / "j.jsonl"
    running = play(str(patch), "--bpm", "150", "--headless", "--osc", "127.0.0.1:0", "--journal", str(journal))
    until_spare(running)
    engine, nursery, spare = children(running, "engine_process")
    killed: list[int] = []
    for number in range(3):
        if number:
            time.sleep(0.5)  # what is tested is how soon it comes, and whatever is there then is killed
        assert wait_for(lambda: bool(dancing(running, nursery, killed)), 5)
        killed.append(dancing(running, nursery, killed)[0])
        os.kill(killed[-1], signal.SIGKILL)
    assert killed[:2] == [engine, spare]
    line = running.wait_for(lambda line: line["alive"].get("restarts") == 3 and line["alive"]["takeover_s"], 20)
    assert line["alive"]["takeover_s"] < 3.0 * BUSY  # since the first of them
    assert not line["alive"]["calm"]
    running.wait_for(lambda now: now["alive"].get("spare", False) and now["measure"] > line["measure"] + 1, 20)
    assert nursery in children(running, "engine_process")
    assert "Traceback" not in running.stop()
    assert wait_for(lambda: not children(running, "engine_process"), 5)
    assert verified(journal)["complete"]


def dancing(running, nursery: int, killed: list[int]) -> list[int]:
    """Engines that live, the oldest first."""
    return [pid for pid in children(running, "engine_process") if pid not in (nursery, *killed)]
