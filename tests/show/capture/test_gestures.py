"""Tests of gestures in a show: signals and reactions, learning, replay, snapshots, the patch's errors and its files."""

import math
from pathlib import Path

import numpy as np
import pytest

from live.app.services.gesture_service import GestureService
from live.clock.ticks import TICK
from live.control.events import events
from live.motion.capture.packed_pose import pack_pose, pack_poses, unpack_pose
from live.motion.clip import Clip
from live.motion.formats.bvh_writer import write_bvh
from live.motion.recognition import gesture_examples
from live.motion.recognition.gesture_examples import ExampleMatcher
from live.show.capture import gesture_learning
from live.show.loader import LoadedShow
from live.show.patch import gesture_files
from live.show.patch.patch_reader import PatchError, parse_patch, read_patch
from live.show.state.snapshot import Snapshotter, restore
from tests.fixtures.mostly_long import mostly_long
from tests.motion.recognition.test_gestures import DOWN, body, raised, wave
from tests.show.made_show import GRAPH, PATCH

GESTURES = """
[[mocap]]
name = "anna"
[[mocap]]
name = "ben"
[[gesture]]
name = "up"
movement = "both arms up"
performer = "anna"
[[react]]
on = "up"
call = "/dance/light/rim"
values = [0.25]
when = "now"
[[react]]
to = "mocap:anna/energy"
sets = "/dance/light/key"
beats = 0
"""


def loaded(text=GESTURES):
    return LoadedShow(Path("test.toml"), parse_patch(PATCH + text, "test.toml"), GRAPH)


def up(time):
    return body(*[raised(time, 2.0)] * 2)


def dance(show, first, last, poses=up, name="anna", extra=()):
    """Run these ticks with poses at 32 Hz; return the state hash after each tick that has none."""
    hashes = []
    for tick in range(first, last + 1):
        for at, event in extra:
            if at == tick:
                assert show.apply(event)
        if tick % 2:
            time = tick * TICK - 0.004
            show.apply(events.MocapFrame(time=time, source="vmc", performer=name, pose=pack_pose(*poses(time))))
        show.tick(tick * TICK)
        hashes.append((show.state_hash(), dict(show.score_runner.signals), str(show.gestures.facts())))
    return hashes


def test_a_gesture_gives_its_signal_and_what_reacts_to_it():
    show = loaded().start()
    heard = []
    show.frame.router.observers.append(lambda event, now: heard.append(event))
    dance(show, 1, 256)
    assert show.score_runner.signals == {"up": 1}
    told = show.gestures.facts()["last"]
    assert [(one["name"], one["performer"]) for one in told] == [("up", "anna")]
    rims = [event for event in heard if getattr(event, "address", "") == "/dance/light/rim"]
    assert len(rims) == 1
    keys = [event.value[0] for event in heard if getattr(event, "address", "") == "/dance/light/key"]
    assert len(keys) > 20
    assert min(keys) < 0.2 < 0.8 < max(keys)


def test_the_gesture_of_another_performer_gives_none():
    show = loaded().start()
    dance(show, 1, 256, name="ben")
    assert show.score_runner.signals == {}


def learn(tick, **keys):
    return tick, events.LearnGesture(time=tick * TICK, source="osc", name="figure", **keys)


def figure(time):
    return body(DOWN, max(wave(time, 1.0), wave(time, 6.0, 1.2, 0.95)), yaw=0.3 * math.sin(time))


def test_a_learned_gesture_is_found_soon_and_a_replay_is_the_same():
    script = [learn(193, beats=4.0)]  # 3.0 s: the figure began at 1.0 s, four beats are two seconds
    first, second = loaded().start(), loaded().start()
    assert dance(first, 1, 640, figure, extra=script) == dance(second, 1, 640, figure, extra=script)
    assert first.score_runner.signals == {"figure": 1}
    assert first.gestures.facts()["last"][0]["time"] > 7.0


@mostly_long("tick", [150, 194, 200, 204, 230, 460, 500], quick=[3])
def test_a_show_with_gestures_continues_from_a_snapshot(tick):
    script = [learn(193, beats=4.0)]
    show = loaded().start()
    source = Snapshotter(show)
    dance(show, 1, tick, figure, extra=script)
    while (taken := source.capture(tick)) is None:
        tick += 1
        dance(show, tick, tick, figure, extra=script)
    restored = restore(loaded(), taken.seal())
    assert dance(restored, tick + 1, 640, figure, extra=script) == dance(show, tick + 1, 640, figure, extra=script)
    assert restored.score_runner.signals == {"figure": 1}


@pytest.mark.long
def test_learning_is_spread_over_ticks_of_little_work_each(monkeypatch):
    work = []

    class Counted(ExampleMatcher):
        def step(self, feature):
            work[-1] += (len(self._bank.moment) + gesture_examples.STEP_CELLS) / gesture_examples.CELLS_PER_PIECE
            super().step(feature)

    def packed(hips, rotation):
        work[-1] += len(hips) / gesture_learning.POSES_PER_PIECE
        return pack_poses(hips, rotation)

    def unpacked(pose):
        work[-1] += 1.0 / gesture_files.POSES_PER_PIECE
        return unpack_pose(pose)

    monkeypatch.setattr(gesture_examples, "ExampleMatcher", Counted)
    monkeypatch.setattr(gesture_learning, "pack_poses", packed)
    monkeypatch.setattr(gesture_files, "unpack_pose", unpacked)
    show = loaded().start()
    dance(show, 1, 1100, figure)
    for beats in (16.0, 16.0, 4.0):
        work.append(0.0)
        assert show.apply(events.LearnGesture(time=1100 * TICK, source="osc", name="figure", beats=beats))
        assert work[-1] == 0.0  # the event itself only notes what is to be learned
    for tick in range(1101, 3000):
        work.append(0.0)
        show.tick(tick * TICK)
        if not show.gestures.facts()["learning"]:
            break
    assert show.gestures.learned_count == 3
    assert sum(work) > 100.0
    assert max(work) < 2.1  # the end of one motion and the beginning of the next one
    assert len(work) < 1200


@pytest.mark.long
def test_an_edit_of_the_patch_while_a_gesture_is_learned_begins_the_lesson_anew():
    show = loaded().start()
    dance(show, 1, 200, figure, extra=[learn(193, beats=4.0)])
    assert show.gestures.facts()["learning"] == ["figure"]
    edited = loaded(GESTURES + '[[gesture]]\nname = "low"\nmovement = "crouch"\n').start()
    show.gestures.apply_patch(edited.gestures)
    assert show.gestures.facts()["learning"] == ["figure"]
    dance(show, 201, 640, figure)
    assert show.gestures.learned_count == 1
    assert show.score_runner.signals["figure"] == 1
    show.gestures.apply_patch(loaded().start().gestures)  # the learned one is not written yet: it stays
    assert show.gestures.facts()["learning"] == []
    dance(show, 641, 800, figure)
    assert [one.name for one in show.gestures.learned] == ["figure"]


def test_learning_needs_a_performer_who_was_seen():
    show = loaded().start()
    assert not show.apply(events.LearnGesture(time=0.0, source="osc", name="figure"))
    assert "no performer is seen" in show.refusals.last_reason
    dance(show, 1, 40)
    assert not show.apply(events.LearnGesture(time=0.6, source="osc", name="figure", performer="carla"))
    assert "no performer is called 'carla' (there are: anna)" in show.refusals.last_reason
    assert not show.apply(events.LearnGesture(time=0.6, source="osc", name="figure", beats=16.0))
    assert "was seen for 0." in show.refusals.last_reason


def test_what_was_learned_is_written_and_read_as_a_part_of_the_patch(tmp_path):
    patch = tmp_path / "night.toml"
    patch.write_text(PATCH + GESTURES)
    show = loaded().start()
    service = GestureService(show, patch)
    dance(show, 1, 320, figure, extra=[learn(193, beats=4.0)])
    service.frame()
    service.stop()
    assert "saved in" in service.message
    written = read_patch(patch)
    assert [one.name for one in written.gesture] == ["up", "figure"]
    assert len(written.gesture[1].poses) == 32
    again = LoadedShow(patch, written, GRAPH).start()
    dance(again, 1, 640, figure)
    assert again.score_runner.signals["figure"] == 2


def bvh(tmp_path, poses, rate=30.0):
    root, rotation = (np.array(each, np.float32) for each in zip(*poses, strict=True))
    clip = Clip("wave", root, rotation, rate, np.ones((len(root), 2), np.bool_))
    (tmp_path / "wave.bvh").write_text(write_bvh(clip, rate=None))


@pytest.mark.long
def test_an_example_from_a_file(tmp_path):
    bvh(tmp_path, [body(DOWN, wave(number / 30.0, 1.0)) for number in range(120)])
    patch = tmp_path / "night.toml"
    patch.write_text(PATCH + '[[gesture]]\nname = "figure"\nexample = "wave.bvh"\nspan_s = [1.0, 3.0]\n')
    read = read_patch(patch)
    assert len(read.gesture[0].poses) == 32
    show = LoadedShow(patch, read, GRAPH).start()
    dance(show, 1, 640, figure, name="live")
    assert show.score_runner.signals["figure"] == 2


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[[gesture]]\nname = "a"\nmovement = "fly"\n', "movement"),
        ('[[gesture]]\nname = "a"\n', "either movement, or example"),
        ('[[gesture]]\nname = "a"\nmovement = "clap"\nperformer = "carla"\n', "there are: live"),
        ('[[gesture]]\nname = "a"\nposes = ["x"]\n', "192"),
        ('[[gesture]]\nname = "a"\nexample = "none.bvh"\n', "there is no file 'none.bvh'"),
        ('[[gesture]]\nname = "a"\nexample = "wave.bvh"\nspan_s = [0, 900]\n', "span_s ends at 900 s"),
        ('[[gesture]]\nname = "a"\nexample = "wave.bvh"\nspan_s = [3, 1]\n', "span_s"),
        ('[[gesture]]\nname = "a"\nexample = "broken.bvh"\n', "broken.bvh"),
        (
            '[[react]]\nto = "mocap:carla/energy"\nsets = "strength"\n',
            "no performer is called 'carla'; there are: live",
        ),
        ('[[react]]\nto = "mocap:size of it"\nsets = "strength"\n', "there are: energy, size, speed, hands, tempo"),
        ('[[gesture]]\nname = "a"\nmovement = "clap"\n' * 1000, "at most 64"),
    ],
)
def test_errors_name_file_line_and_remedy(tmp_path, text, words):
    bvh(tmp_path, [body(DOWN, wave(number / 30.0, 1.0)) for number in range(120)])
    (tmp_path / "broken.bvh").write_bytes(b"HIERARCHY\nROOT \x00\xff")
    patch = tmp_path / "night.toml"
    patch.write_text(PATCH + text)
    with pytest.raises(PatchError) as refused:
        read_patch(patch)
    assert words in str(refused.value)
    assert "night.toml, line " in str(refused.value)


def test_damaged_poses_are_refused_with_their_place():
    poses = ", ".join(['"' + "!" * 192 + '"'] * 8)
    text = f'[[gesture]]\nname = "a"\nposes = [{poses}]\n'
    with pytest.raises(Exception, match="gesture 'a': the example cannot be read") as refused:
        loaded(text).start()
    assert "gesture 1" in str(refused.value) or "gesture" in str(refused.value)
