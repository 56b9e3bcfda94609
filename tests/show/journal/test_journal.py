"""Tests of journal and replay: all input is recorded, and a replay gives the same states."""

import json

import pytest

from live.base.event_queue import EventQueue
from live.clock.time_source import ManualClock
from live.control.events import events
from live.control.events.audience import VoiceLight, VoicePlace
from live.control.events.elements import Points
from live.control.events.event_json import event_from_json, event_to_json, field_types
from live.show.engine import Engine
from live.show.journal.journal import JournalError, JournalWriter, read_journal
from live.show.journal.replay import replay
from live.show.view.status import Status
from tests.show.made_show import made_show


def record_show(path, seconds=17.0, fps=50):
    """A show with a journal, events of all kinds and a stall."""
    show, clock, inbox = made_show(), ManualClock(), EventQueue()
    writer = JournalWriter(path, {"seed": 3})
    status = Status(show, rejected=dict, memory=lambda: 0.0)
    engine = Engine(show, clock=clock, inbox=inbox, status=status, journal=writer)
    script = {
        100: events.PlaceElement(time=2.0, source="osc", kind="attract", points=((0.1 + 0.2, 1 / 3),), strength=0.7),
        150: events.Tap(time=3.01, source="key"),
        180: events.Tap(time=3.53, source="key"),
        205: events.Tap(time=4.04, source="key"),
        300: events.One(time=6.0, source="key"),
        400: events.CallStep(time=8.0, source="osc", name="spin"),
        500: events.BeatHeard(time=10.0, source="audio", beat_time=9.9, period=0.51, confidence=0.8),
        600: events.PlaceElement(time=12.0, source="osc", kind="spread"),
        620: events.SetParameter(time=12.4, source="osc", address="/dance/motion/warp", value=(0.4,), group="*"),
        640: events.SetParameter(
            time=12.8, source="osc", address="/dance/motion/warp_sequence", value=(1.0,), group="front"
        ),
        650: events.SetStage(time=13.0, source="osc", width=9.7, depth=7.0),
        660: events.SetParameter(time=13.2, source="osc", address="/dance/motion/mix", value=(0.7,), group="*"),
    }
    for frame in range(1, round(seconds * fps) + 1):
        if 700 <= frame < 725:  # the machine stands still for half a second
            continue
        clock.set(frame / fps)
        if frame in script:
            inbox.put(script[frame])
        engine.frame(lambda view: None)
    writer.close(engine.ticks.index)
    return show, status


@pytest.mark.long
def test_replay_is_bit_identical(tmp_path):
    show, status = record_show(tmp_path / "a.jsonl")
    assert status.skipped_ticks > 20
    journal = read_journal(tmp_path / "a.jsonl")
    assert journal.complete
    fresh = made_show()
    result = replay(fresh, journal)
    assert result.measures >= 7
    assert result.differences == ()
    assert fresh.state_hash() == show.state_hash()


def test_each_event_class_is_registered_for_reading():
    # by name: a dataclass with slots is made twice
    kinds = {kind.__name__ for kind in events.ControlEvent.__subclasses__() if kind.__module__.startswith("live.")}
    assert len(kinds) > 40
    assert kinds == set(events.EVENT_TYPES)


@pytest.mark.long
def test_replay_detects_changed_event(tmp_path):
    path = tmp_path / "a.jsonl"
    record_show(path, seconds=6.0)
    rows = path.read_text().splitlines()
    for number, row in enumerate(rows):
        if '"PlaceElement"' in row:
            value = json.loads(row)
            value["event"]["points"][0][0] += 1e-3
            rows[number] = json.dumps(value)
    path.write_text("\n".join(rows) + "\n")
    result = replay(made_show(), read_journal(path))
    assert result.differences
    assert min(measure for measure, *_ in result.differences) >= 2


@pytest.mark.long
def test_truncated_journal_is_replayed_up_to_last_whole_line(tmp_path):
    path = tmp_path / "a.jsonl"
    record_show(path, seconds=8.0)
    text = path.read_text()
    path.write_text(text[: (text.index("\n") + len(text)) // 2])  # the first line is the longest
    journal = read_journal(path)
    assert not journal.complete
    assert not replay(made_show(), journal).differences


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "line 1: not a JSON object"),
        ("[]\n", "line 1: a JSON object expected"),
        ('{"a": 1}\n', "no 'journal' key"),
        ('{"journal": 99}\n', "format 99"),
        ('{"journal": 1}\n{"tick": 3, "end": true}\n{"tick": 2, "end": true}\n', "line 3: 'tick' must be"),
        ('{"journal": 1}\n{"tick": true}\n', "line 2: 'tick'"),
        ('{"journal": 1}\n{"tick": 1, "measure": "x", "hash": "a"}\n', "'measure' must be a whole number"),
        ("[" * 50_000 + "\n", "line 1: not a JSON object"),
        ('{"journal": 1}\nnonsense\n', "line 2: not a JSON object"),
        ('{"journal": 1}\n{"tick": 1, "event": {"type": "Nuke"}}\n', "unknown event type 'Nuke'"),
        ('{"journal": 1}\n{"tick": 1, "event": 5}\n', "line 2"),
        (
            '{"journal": 1}\n{"tick": 1, "event": {"type": "Tap", "time": NaN, "source": "x"}}\n',
            "field 'time' cannot be nan",
        ),
        ('{"journal": 1}\n{"tick": 1, "event": {"type": "Tap", "time": 1.0, "source": "x", "y": 1}}\n', "field 'y'"),
        ('{"journal": 1}\n{"tick": 1, "event": {"type": "Attract", "time": 1.0, "source": "x"}}\n', "missing"),
    ],
)
def test_broken_journal_error_names_file_line_and_fault(tmp_path, text, what):
    path = tmp_path / "b.jsonl"
    path.write_text(text)
    with pytest.raises(JournalError) as error:
        list(read_journal(path).lines)
    assert str(path) in str(error.value)
    assert what in str(error.value)


def test_binary_or_missing_journal_is_refused(tmp_path):
    (tmp_path / "c").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(JournalError, match="not text"):
        read_journal(tmp_path / "c")
    with pytest.raises(JournalError, match="cannot read"):
        read_journal(tmp_path / "nothing")
    with pytest.raises(JournalError, match="cannot write"):
        JournalWriter(tmp_path / "no folder" / "j", {})


def test_each_event_survives_json_round_trip_exactly():
    for name, cls in events.EVENT_TYPES.items():
        values = {
            "x": 0.1 + 0.2, "z": -1e-17, "name": "pas de bourrée", "tempo": 100 / 3, "on": True, "beat_time": 1 / 7,
            "period": 0.3, "confidence": 1.0, "state": "lost", "count": 3,
            "parameter": "amount", "value": 2 / 7, "group": "front", "steps": "a, é x2, *",
            "clips": "a\nb", "library": "0f", "kind": "flow", "formation": "star:6",
            "gate": "left", "dancers": "ember & left", "x2": 1e300, "z2": 5e-324, "strength": -1 / 3,
        }  # fmt: skip
        kinds = {
            float: 0.1 + 0.7, str: "é", bool: True, int: 7, tuple[float, ...]: (2 / 7, -1e-17),
            Points: ((2 / 7, -1e-17), (0.0, 1.0)), tuple[VoicePlace, ...] | None: ((1, -2, 3, 2),),
            tuple[VoiceLight, ...] | None: (), tuple[int, ...] | None: (7, 0, 100),
        }  # fmt: skip
        fields = {
            key: kinds[kind] if kind not in (float, str) else values.get(key, kinds[kind])
            for key, kind in field_types(name).items()
        }
        fields = {key: value for key, value in fields.items() if key not in ("time", "source")}
        event = cls(time=2 / 3, source="test", **fields)
        data = json.loads(json.dumps(event_to_json(event)))
        assert data["type"] == name
        assert event_from_json(data) == event


def test_existing_journals_of_same_name_are_kept(tmp_path):
    path = tmp_path / "night.jsonl"
    for night in range(3):
        writer = JournalWriter(path, {"night": night})
        writer.close(0)
    nights = [json.loads(p.read_text().splitlines()[0])["night"] for p in (path, path.with_name("night.jsonl.1"))]
    assert nights == [2, 0]
    assert writer.older_journal == path.with_name("night.jsonl.2")


@pytest.mark.long
def test_implausible_tick_is_reported_and_skipped(tmp_path):
    path = tmp_path / "a.jsonl"
    record_show(path, seconds=4.0)
    path.write_text(path.read_text() + '{"tick":100000000000,"end":true}\n')
    result = replay(made_show(), read_journal(path))
    assert "damaged" in result.problems[0]
    assert f"line {len(path.read_text().splitlines())}" in result.problems[0]
    assert not result.different


def test_frequent_events_are_stored_as_rows_exactly(tmp_path):
    said = events.BeatHeard(
        time=1 / 3, source="audio", beat_time=2 / 7, period=0.51, confidence=0.1 + 0.2, beat=2, anchored=False
    )
    path = tmp_path / "a.jsonl"
    writer = JournalWriter(path, {})
    plain = events.BeatHeard(time=1.5, source="midi", beat_time=1.5, period=0.5, confidence=1.0)
    writer.record_event(3, said)
    writer.record_event(4, plain)
    writer.close(5)
    rows = path.read_text().splitlines()
    assert json.loads(rows[2])["event"] == ["BeatHeard", 1.5, "midi", 1.5, 0.5, 1.0]
    assert [line.event for line in read_journal(path).lines][:2] == [said, plain]


def test_rows_are_read_by_columns_in_journal_header(tmp_path):
    path = tmp_path / "a.jsonl"
    columns = {"Performer": ["source", "time", "name", "z", "x"]}
    path.write_text(
        json.dumps({"journal": 2, "columns": columns}) + '\n{"tick":1,"event":["Performer","osc",0.5,"anna",2.0,1.0]}\n'
    )
    (line,) = read_journal(path).lines
    assert (line.event.name, line.event.x, line.event.z) == ("anna", 1.0, 2.0)
    path.write_text('{"journal": 2}\n{"tick":1,"event":["Performer","osc",0.5,"anna",2.0,1.0,3,4,5,6,7]}\n')
    with pytest.raises(JournalError, match="line 2: event Performer: 10 values"):
        list(read_journal(path).lines)


def old_form(event):
    """An event as journals of format 1 and 2 had it."""
    if event["type"] == "PlaceElement" and event["kind"] in ("attract", "spread"):
        kept = {key: event[key] for key in ("time", "source", "measures", "group", "next")}
        x, z = event["points"][0]
        return {**kept, "type": "Spread"} if event["kind"] == "spread" else {
            **kept, "type": "Attract", "x": x, "z": z, "strength": event["strength"], "drag": event["drag"],
        }  # fmt: skip
    return event


@pytest.mark.long
def test_journal_of_format_1_is_read(tmp_path):
    path = tmp_path / "a.jsonl"
    record_show(path, seconds=6.0)
    rows = [json.loads(row) for row in path.read_text().splitlines()]
    rows[0] = {"journal": 1, "seed": 3}
    for row in rows[1:]:
        if "event" in row:
            row["event"] = old_form(event_to_json(event_from_json(row["event"])))
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    result = replay(made_show(), read_journal(path))
    assert result.measures >= 2
    assert not result.different
