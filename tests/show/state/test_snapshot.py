"""Snapshots: a restored show continues bit-identically, and damage is reported."""

import json
from pathlib import Path

import pytest

from live.base.compression import compress_text
from live.base.picture_parameters import CUSTOM_PASS_SLICE
from live.clock.ticks import TICK
from live.control.events import events
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch_reader import parse_patch, read_patch
from live.show.patch.patch_search_path import find_patch
from live.show.patch.patch_update import patch_version, split_deferred
from live.show.patch.table_batches import patch_json
from live.show.state.snapshot import FORMAT, SnapshotError, Snapshotter, at_rest, restore, snapshot, snapshot_header
from tests.fixtures.mostly_long import mostly_long
from tests.show.desk.desk_show import DESK
from tests.show.made_show import GRAPH, PATCH
from tests.show.patch.test_custom_passes import PICTURE, WAVES

MADE = LoadedShow(Path("test.toml"), parse_patch(PATCH.replace("reserve = 0", "reserve = 2"), "test.toml"), GRAPH)
SCRIPT = {
    20: events.PlaceElement(time=0.3, source="osc", kind="attract", points=((1.0, 0.5),), measures=3.0),
    150: events.Tap(time=2.34, source="key"),
    182: events.Tap(time=2.85, source="key"),
    215: events.Tap(time=3.36, source="key"),
    230: events.SetParameter(time=3.5, source="osc", address="/dance/motion/warp", value=(0.4,), group="*"),
    260: events.Evolve(time=4.0, source="osc", formation="circle", group="front", measures=2.0),
    300: events.StepNow(time=4.7, source="osc", name="spin", group="back"),
    330: events.PlaceElement(
        time=5.1, source="osc", kind="flow", points=((-2.0, 0.0), (0.0, 1.0), (2.0, 0.0)), measures=4.0
    ),
    400: events.One(time=6.2, source="key"),
    440: events.Enter(time=6.9, source="osc"),
    460: events.Blackout(time=7.2, source="key", on=True),
    520: events.SetStage(time=8.0, source="osc", width=9.0, depth=7.0),
    560: events.PlaceElement(time=8.8, source="osc", kind="spread"),
    640: events.BeatHeard(time=10.0, source="audio", beat_time=9.9, period=0.51, confidence=0.8),
    700: events.CountIn(time=11.0, source="key", measures=1),
    760: events.Clear(time=11.9, source="osc"),
}


def run(show, first, last, script=SCRIPT):
    """Runs ticks `first` to `last`, events first; returns hashes at measure lines and in the last quarter second."""
    hashes = []
    for tick in range(first, last + 1):
        if tick in script:
            show.apply(script[tick])
        if show.tick(tick * TICK) or last - tick < 16:
            hashes.append((tick, show.state_hash()))
    return hashes


def capture_from(show, tick, script=SCRIPT):
    """Runs on from `tick` until a snapshot can be captured: its tick and the snapshot."""
    source = Snapshotter(show)
    while (taken := source.capture(tick)) is None:
        tick += 1
        run(show, tick, tick, script)
    return tick, taken.seal()


@mostly_long("tick", [10, 137, 216, 262, 290, 304, 350, 410, 480, 530, 600, 703, 770], quick=[10])
def test_restored_show_continues_bit_identically(tick):
    """During fades, cuts, taps, evolutions, entrances, a count-in and drawn flows."""
    show = MADE.start()
    run(show, 1, tick)
    at, data = capture_from(show, tick)
    restored = restore(MADE, data)
    assert restored.state_hash() == show.state_hash()
    assert run(restored, at + 1, at + 200) == run(show, at + 1, at + 200)
    assert at - tick <= 64


def test_show_with_a_pass_of_its_own_is_restored(tmp_path):
    (tmp_path / "passes").mkdir()
    (tmp_path / "passes" / "waves.glsl").write_text(WAVES)
    (tmp_path / "a.toml").write_text(PATCH + PICTURE)
    loaded = LoadedShow(tmp_path / "a.toml", read_patch(tmp_path / "a.toml"), GRAPH)
    script = {
        at: events.SetPass(time=at * TICK, source="osc", name="waves", parameter="speed", amount=3.0, measures=1.0)
        for at in (40, 120)
    }
    show = loaded.start()
    run(show, 1, 60, script)
    at, data = capture_from(show, 60, script)
    restored = restore(loaded, data)
    assert run(restored, at + 1, at + 100, script) == run(show, at + 1, at + 100, script)
    level = [each.desk.parameters.value[CUSTOM_PASS_SLICE][1] for each in (show, restored)]
    assert level[0] == level[1] > 1.0  # where it began


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["first_show", "samba", "tap", "contemporary", "ballet", "formations", "pairs", "cues", "score"]
)
def test_every_project_patch_is_restored_from_snapshot(name):
    loaded = load_show(find_patch(None if name == "first_show" else name))
    show = loaded.start(seed=5)
    run(show, 1, 330, {})
    at, data = capture_from(show, 330, {})
    assert len(data) < 80_000
    restored = restore(loaded, data)
    again = restore(loaded, snapshot(restored, at))  # and what was restored can be taken again
    then = run(show, at + 1, at + 256, {})
    assert len(then) > 16
    assert run(restored, at + 1, at + 256, {}) == then
    assert run(again, at + 1, at + 256, {}) == then


@pytest.mark.long
def test_capture_does_not_change_the_show():
    show, watched = MADE.start(), MADE.start()
    source = Snapshotter(watched)
    for tick in range(1, 300):
        run(show, tick, tick)
        run(watched, tick, tick)
        source.capture(tick)
    assert watched.state_hash() == show.state_hash()


def test_clock_listener_is_not_restored():
    show, told = MADE.start(), []
    show.seed_tracker(told.append)
    run(show, 1, 10)
    restored = restore(MADE, capture_from(show, 10)[1])
    assert show.follower.on_hint is not None
    assert restored.follower.on_hint is None


def test_flipped_bit_or_truncation_is_refused():
    show = MADE.start()
    run(show, 1, 20)
    _, data = capture_from(show, 20)
    assert snapshot_header(data)["tick"] >= 20
    for place in (0, 15, 100, data.index(b"\n") + 1, len(data) // 2, len(data) - 1):
        broken = bytearray(data)
        broken[place] ^= 4
        with pytest.raises(SnapshotError):
            restore(MADE, bytes(broken))
    for length in (0, 10, data.index(b"\n"), len(data) - 1):
        with pytest.raises(SnapshotError):
            restore(MADE, data[:length])


def test_other_patch_steps_or_version_is_refused_by_name():
    show = MADE.start()
    run(show, 1, 20)
    _, data = capture_from(show, 20)
    other = LoadedShow(MADE.path, parse_patch(PATCH, "test.toml"), GRAPH)
    with pytest.raises(SnapshotError, match="other patch"):
        restore(other, data)
    with pytest.raises(SnapshotError, match="other steps"):
        restore(load_show(find_patch(None)), data)
    line, _, packed = data.partition(b"\n")
    old = json.dumps(json.loads(line) | {"version": "0.0.1"}).encode() + b"\n" + packed
    with pytest.raises(SnapshotError, match=r"version 0\.0\.1"):
        restore(MADE, old)
    strange = json.dumps(json.loads(line) | {"snapshot": FORMAT + 1}).encode() + b"\n" + packed
    with pytest.raises(SnapshotError, match=f"format {FORMAT + 1}"):
        restore(MADE, strange)


@mostly_long("tick", [70, 100, 131, 190, 230], quick=[3])
def test_fades_count_ins_jumps_and_undo_continue_after_restore(tick):
    desk = LoadedShow(Path("desk.toml"), parse_patch(PATCH + DESK, "desk.toml"), GRAPH)
    script = {
        40: events.RecallScene(time=0.6, source="key", name="low", measures=2.0),
        60: events.StoreScene(time=0.9, source="key", name="mine"),
        65: events.FadePicture(time=1.0, source="key", level=0.2, beats=12.0),
        68: events.AllowFlashes(time=1.1, source="key", on=True),
        90: events.Go(time=1.4, source="key"),
        120: events.GiveCue(time=1.9, source="key", name="solo"),
        180: events.SetParameter(time=2.8, source="osc", address="/dance/light/level", value=(0.9,), measures=3.0),
        200: events.RecallView(time=3.1, source="osc", name="side", measures=2.0),
        300: events.Undo(time=4.7, source="key"),
        330: events.RecallScene(time=5.1, source="key", name="mine", measures=1.0),
        370: events.JumpTo(time=5.8, source="key", section="verse", measure=2, when="measure"),
        400: events.Redo(time=6.2, source="key"),
    }
    show = desk.start()
    run(show, 1, tick, script)
    at, data = capture_from(show, tick, script)
    restored = restore(desk, data)
    assert run(restored, at + 1, 480, script) == run(show, at + 1, 480, script)
    for each in (show, restored):
        each.view_now = each.view()
        each.fill(each.view_now, 480 * TICK)
    assert restored.view_now.picture.tobytes() == show.view_now.picture.tobytes()
    assert restored.view_now.brightness == show.view_now.brightness < 0.5
    assert restored.view_now.flash_limit_lifted
    assert restored.desk.facts(480.0) == show.desk.facts(480.0)


@mostly_long("stage", ["selection", "tick"], quick=[1])
def test_tripped_stage_does_not_prevent_snapshots(stage):
    """Otherwise the work that it had begun would never end."""
    show = MADE.start()
    run(show, 1, 75)
    assert not at_rest(show)
    show.apply(events.BreakerTripped(time=75 * TICK, source="heir", name=stage, why="made by a test"))
    assert at_rest(show)
    waited = longest = 0
    for now in range(76, 400):
        run(show, now, now)
        waited = 0 if at_rest(show) else waited + 1
        longest = max(longest, waited)
    assert longest * TICK < 2.2  # a measure
    at, data = capture_from(show, 400)
    assert run(restore(MADE, data), at + 1, at + 60) == run(show, at + 1, at + 60)


def test_edit_with_tripped_edit_stage_does_not_prevent_snapshots():
    show = MADE.start()
    run(show, 1, 40)
    show.apply(events.BreakerTripped(time=40 * TICK, source="heir", name="edits", why="made by a test"))
    edited = PATCH.replace("reserve = 0", "reserve = 2").replace("bpm = 120", "bpm = 120\n[motion]\namplitude = 0.3")
    text = patch_json(split_deferred(parse_patch(edited, "edit"), show.patch)[0])
    show.apply(
        events.PatchChanged(time=40 * TICK, source="patch", patch=compress_text(text), version=patch_version(text))
    )
    assert not at_rest(show), show.refusals.last_reason
    run(show, 41, 300)
    assert at_rest(show)
