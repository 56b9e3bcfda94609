"""Tests of leading a Link session: which changes are sent, how often, and without jumps for peers."""

import itertools

import pytest

from live.clock.timeline import Timeline
from live.control.link.link_sync import MAX_BEND, LinkLeader, LinkReading, phase_difference


def simulate_session(
    lead: LinkLeader, show: Timeline, *, peers: int, tempo: float, beat: float, seconds: float
) -> list[tuple[float, float, float, bool]]:
    """Simulates a session: (time, session tempo, phase error [s], jumped) at each of 50 updates a second."""
    rows = []
    for index in range(int(seconds * 50)):
        time = index / 50
        reading = LinkReading(time, peers, tempo, beat, 4)
        change = lead.next_change(reading, show, show.tempo)
        jumped = False
        if change is not None:
            tempo = change.tempo
            if change.phase is not None and (change.force or not peers):
                jumped = abs(phase_difference(change.phase, beat, 4)) > 1e-3
                beat = change.phase
        rows.append((time, tempo, phase_difference(show.phase_at(time), beat, 4) * 60.0 / show.tempo, jumped))
        beat += tempo / 60.0 / 50
    return rows


def test_session_without_peers_takes_show_beat_once() -> None:
    show = Timeline(tempo=97.3, beat_origin=1.7, measure_origin=1.0)
    lead = LinkLeader()
    rows = simulate_session(lead, show, peers=0, tempo=120.0, beat=0.0, seconds=20.0)
    assert max(abs(row[2]) for row in rows) < 0.003
    assert sum(row[3] for row in rows) <= 1


def test_peers_are_aligned_by_tempo_without_jumps() -> None:
    show = Timeline(tempo=120.0)
    rows = simulate_session(LinkLeader(), show, peers=1, tempo=120.0, beat=-0.4, seconds=20.0)  # 200 ms late
    assert not any(row[3] for row in rows)
    tempos = [row[1] for row in rows]
    assert max(tempos) <= 120.0 * (1.0 + MAX_BEND) + 1e-9
    assert abs(rows[-1][2]) < 0.005
    changes = [rows[i][0] for i in range(1, len(rows)) if tempos[i] != tempos[i - 1]]
    assert min(b - a for a, b in itertools.pairwise(changes)) >= 0.5 - 0.021  # a beat
    assert rows[-1][1] == pytest.approx(120.0, rel=0.003)


def test_manual_resync_moves_the_session_once() -> None:
    lead = LinkLeader()
    lead.resync()
    rows = simulate_session(lead, Timeline(tempo=120.0), peers=2, tempo=100.0, beat=1.5, seconds=10.0)
    assert [row[3] for row in rows].count(True) == 1
    assert rows[0][3]
    assert max(abs(row[2]) for row in rows) < 0.002


def test_fast_session_gets_show_tempo_first() -> None:
    change = LinkLeader().next_change(LinkReading(1.0, 1, 249.75, 3.0, 4, fold=4), Timeline(tempo=120.0), 120.0)
    assert change is not None
    assert (change.tempo, change.phase, change.force) == (120.0, None, False)
