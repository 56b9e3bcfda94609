"""Telemetry of a running show against the show's own arrays."""

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.motion.skeleton import SKELETON
from live.show.dancers.footfalls import FootfallDetector
from live.show.view.telemetry import Telemetry
from tests.show.made_show import made_show


@pytest.fixture(scope="module")
def telemetry_rows():
    """Four measures of a show: all sent (time, what, value), with the show's own steps and positions."""
    show = made_show(reserve=2)
    view, outgoing, rows, seen = show.view(), Telemetry(show, positions=8.0), [], []
    footfalls = FootfallDetector(show)
    for tick in range(1, 16 * 32 + 1):
        time = tick * TICK
        show.tick(time)
        if tick % 2:
            continue
        show.fill(view, time)
        rows += [(time, *one) for one in outgoing.frame(view)]
        library = show.graph.library
        names = [library.steps[k] for k in library.node_step[show.dancers.node]]
        seen.append((time, names, footfalls.detect(view), view.joint_position.copy()))
    return show, rows, seen


def test_measures_and_timeline_are_sent_when_they_change(telemetry_rows):
    show, rows, _ = telemetry_rows
    measures = [value for _, what, value in rows if what == "measure"]
    assert [number for number, _ in measures] == list(range(5))
    assert [end for _, end in measures] == [4.0, 8.0, 12.0, 16.0, 20.0]
    timelines = [value for _, what, value in rows if what == "timeline"]
    assert timelines[-1][0] == show.timeline.tempo
    assert len(timelines) < 5


def test_every_step_is_sent_once_when_it_begins(telemetry_rows):
    show, rows, seen = telemetry_rows
    now = {}
    for time, what, value in rows:
        if what == "news":
            for name, (dancer, step, group) in [(n, v[:3]) for n, v in value if n == "step"]:
                assert name == "step"
                assert now.get(dancer) != step
                now[dancer] = step
                assert group == show.patch.group[show.group[dancer - 1]].name
                danced = next(steps for at, steps, *_ in seen if at == time)
                assert danced[dancer - 1] == step
    present = np.flatnonzero(show.motion.present) + 1
    assert set(now) == set(present.tolist())
    assert all(now[dancer] == seen[-1][1][dancer - 1] for dancer in now)


def test_footfalls_are_sent(telemetry_rows):
    _, rows, seen = telemetry_rows
    fell = [value for _, what, news in rows if what == "news" for name, value in news if name == "foot"]
    assert {side for _, side, *_ in fell} == {"left", "right"}
    known = [(fall.dancer + 1, fall.foot, fall.part) for _, _, falls, _ in seen for fall in falls]
    assert [(dancer, ("left", "right").index(side), part) for dancer, side, *_, part in fell] == known
    assert len(known) > 10
    assert all(0.0 < strength <= 1.0 and part in (0, 1, 2) for *_, strength, part in fell)


def test_positions_are_sent_at_the_given_rate(telemetry_rows):
    show, rows, seen = telemetry_rows
    told_places = [(time, value) for time, what, value in rows if what == "positions"]
    places = [(time, np.frombuffer(value, np.float32).reshape(-1, 4)) for time, value in told_places]
    assert len(places) == pytest.approx(8.0 * 16 / 2, abs=2)
    assert all(len(rows) == show.motion.present.sum() for _, rows in places)
    joints = {entry[0]: entry[3] for entry in seen}
    left, right = SKELETON.index("leftUpperLeg"), SKELETON.index("rightUpperLeg")
    for time, told_then in places:
        who = told_then[:, 0].astype(int) - 1
        hips = joints[time][who, 0]
        assert told_then[:, 1:3] == pytest.approx(hips[:, (0, 2)], abs=1e-6)
        across = joints[time][who, left] - joints[time][who, right]  # to her left, which is +x for who faces 0
        turn = told_then[:, 3] - np.arctan2(-across[:, 2], across[:, 0])
        assert np.angle(np.exp(1j * turn)) == pytest.approx(np.zeros(len(who)), abs=0.02)
