"""Supervision parts one by one: heartbeats, restart limits, line channels, the recovery log, pressure."""

import json
import math
import os
import select
import socket
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.system.shared_page import SharedPage
from live.show.view.status import FULL_PRESSURE_SHARE, HALFLIFE, Pressure
from live.supervisor.engine_deaths import DeathHistory
from live.supervisor.heartbeat import Heartbeat, Phase
from live.supervisor.line_channel import ChannelError, LineChannel
from live.supervisor.recovery_log import RecoveryLog
from live.supervisor.restart_policy import SETTLED, Backoff, RestartLimit
from tests.control.waiting import wait_for


def test_second_mapping_of_page_contains_beat():
    mine = Heartbeat()
    theirs = Heartbeat(SharedPage.of_descriptor(os.dup(mine.page.descriptor)))
    assert (mine.last, mine.phase) == (0.0, Phase.STARTING)
    before = time.monotonic()
    theirs.beat(1234, Phase.RUNNING)
    assert (mine.tick, mine.phase) == (1234, Phase.RUNNING)
    assert before <= mine.last <= time.monotonic()
    mine.close()
    theirs.close()


@given(st.lists(st.floats(0.0, 40.0), min_size=1, max_size=40))
def test_restart_exceeds_limit_exactly_if_three_others_lie_within_thirty_seconds(gaps):
    limit, times = RestartLimit(), []
    for gap in gaps:
        now = (times[-1] if times else 100.0) + gap
        assert limit.record(now) == (sum(now - earlier < 30.0 for earlier in times) >= 3)
        times.append(now)
    assert limit.count == len(times)


def test_deaths_on_overloaded_machine_count_only_when_repeated_in_same_tick():
    deaths = DeathHistory()
    for now in range(10):
        outside = deaths.record(now, 100 + now, 0, blamed=False)
        within = deaths.record(now, 100 + now, 5, blamed=False)
        assert (outside.calm, within.trip) == (False, False)
        assert (outside.stage, within.stage, within.times) == (0, 5, 1)
    assert deaths.count == 20
    assert deaths.record(10, 109, 5, blamed=False).times == 2
    assert [deaths.record(now, 200, 0).calm for now in range(11, 15)] == [False, False, False, True]


@given(st.lists(st.floats(0.0, 50.0), min_size=1, max_size=40))
def test_start_delays_grow_to_ceiling_and_reset_after_settling(lives):
    backoff, now, waits = Backoff(free=2, first=1.0, most=30.0), 0.0, []
    for seconds in lives:
        now += seconds  # it ran for so long
        waits.append(backoff.next_delay(now))
        now += waits[-1]
    assert waits == [0.0, 0.0, 1.0, 2.0, 4.0, 8.0, 16.0, *[30.0] * len(lives)][: len(lives)]
    assert backoff.next_delay(now + SETTLED + 1.0) == 0.0


def channel_pair(**how: int) -> tuple[LineChannel, LineChannel]:
    mine, theirs = socket.socketpair()
    return LineChannel(mine, **how), LineChannel(theirs)


@given(st.lists(st.text(st.characters(blacklist_characters="\n", blacklist_categories=("Cs",)), max_size=200)))
def test_lines_arrive_whole_in_order_and_before_end(lines):
    here, there = channel_pair()
    for line in lines:
        here.send_line(line)
    here.close()
    found = []
    while not there.ended:
        found += there.read_lines()
    assert found == lines
    there.close()


def test_stalled_reader_is_not_waited_for_and_lost_lines_are_counted():
    here, there = channel_pair(backlog=100_000)
    line = "x" * 9_999
    for _ in range(2_000):  # 20 MB: more than the system holds and the backlog together
        here.send_line(line)
    assert here.dropped > 0
    assert here.pending_bytes <= 100_000
    read = 0
    while not here.flush() or not read:
        read += len(there.read_lines())
    read += len(there.read_lines())
    assert read + here.dropped == 2_000
    there.close()
    here.send_line("to nobody")
    assert here.ended
    here.close()


def test_last_lines_are_read_while_peer_keeps_sending():
    """Over TCP: a send to a closed stream reports it broken, and lines received before would not be read."""
    with socket.create_server(("127.0.0.1", 0)) as there:
        mine = LineChannel(socket.create_connection(there.getsockname()))
        theirs = LineChannel(there.accept()[0])
    theirs.send_line("a line of the show")
    mine.send_line("I cannot")
    parting = threading.Thread(target=mine.drain_and_close, args=(20.0,))
    parting.start()
    assert wait_for(lambda: bool(select.select([theirs], [], [], 0)[0]), 5)
    for _ in range(100):
        theirs.send_line("a line of the show")
    assert not theirs.ended
    assert theirs.read_lines()[:1] == ["I cannot"]
    theirs.close()
    parting.join(5)
    assert not parting.is_alive()


def test_endless_line_is_protocol_error(monkeypatch):
    monkeypatch.setattr("live.supervisor.line_channel.MAX_LINE_BYTES", 100)
    here, there = channel_pair()
    here._send_data(b"y" * 200)
    with pytest.raises(ChannelError):
        there.read_lines()
    here.close()
    there.close()


def test_log_keeps_only_lines_after_snapshot():
    log = RecoveryLog()
    header = '{"journal": 2}'
    event = '{"tick": %d, "event": {"type": "Tap"}}'
    assert log.add_line(header)
    assert not log.add_line(header)  # of the engine that went on
    for tick in (5, 9, 10, 10):
        assert log.add_line(event % tick)
    assert log.add_line('{"tick": 10, "measure": 2, "hash": "aa"}')
    assert not log.add_line('{"tick": 14}')
    assert log.add_line('{"tick": 10, "snapshot": "c3RhdGU="}')
    log.add_line(event % 15)
    assert [json.loads(line) for line in log.replay_lines()] == [
        {"journal": 2},
        {"tick": 10, "snapshot": "c3RhdGU="},
        *[{"tick": 10, "event": {"type": "Tap"}}] * 2,
        {"tick": 15, "event": {"type": "Tap"}},
        {"tick": 15},
    ]


def test_patch_change_keeps_snapshot_before_and_all_lines_since():
    log = RecoveryLog()
    for line in (
        '{"journal": 2}',
        '{"tick": 10, "snapshot": "b2xk"}',
        '{"tick": 11, "event": {"type": "PatchChanged"}}',
    ):
        log.add_line(line)
    log.add_line('{"tick": 20, "snapshot": "bmV3"}')
    assert [json.loads(line).get("snapshot", "") for line in log.replay_lines()] == ["", "b2xk", "", ""]


@pytest.mark.parametrize("line", ["", "nonsense", "[]", "7", '{"tick": "x"}', '{"no": 1}', '{"tick": null}'])
def test_invalid_show_line_is_refused(line):
    log = RecoveryLog()
    assert not log.add_line(line)
    assert list(log.replay_lines()) == []


def test_pressure_is_share_of_recent_late_frames():
    pressure, late = Pressure(), 0
    for frame in range(600):  # one of twenty is late
        late += frame % 20 == 0
        pressure.frame(late, 1 / 60)
    assert pressure.value == pytest.approx(0.05 / FULL_PRESSURE_SHARE, rel=0.1)
    for _ in range(60):
        late += 1
        pressure.frame(late, 1 / 60)
    assert pressure.value == 1.0
    share = 1.0
    for _ in range(int(60 * HALFLIFE * math.log2(10 / FULL_PRESSURE_SHARE))):  # until even that is forgotten
        pressure.frame(late, 1 / 60)
        share *= 0.5 ** (1 / 60 / HALFLIFE)
    assert pressure.value <= share / FULL_PRESSURE_SHARE * 1.01


def test_overload_is_pressure_before_frame_is_late():
    pressure = Pressure()
    pressure.frame(0, 1 / 60, 0.7)
    assert pressure.value == 0.7
    pressure.frame(0, 1 / 60)
    assert pressure.value == 0.0
