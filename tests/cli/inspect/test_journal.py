"""`live journal show | diff | export` and `live replay --from --to --render`, on the journal of a small show."""

import csv
import json
import math
import shutil

import av
import mido
import pytest

from live.base.event_queue import EventQueue
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.events import events
from live.show.engine import Engine
from live.show.journal.journal import JournalWriter
from live.show.loader import load_show
from live.show.patch.patch_search_path import find_patch
from live.show.view.status import Status
from tests.cli.command import run_live
from tests.show.journal.disk import wait_until_written

TEMPO = 120.0
SCRIPT = {
    60: events.PlaceElement(time=2.0, source="osc", kind="attract", points=((1.0, 0.5),), measures=2.0),
    95: events.BeatHeard(time=3.2, source="tap", beat_time=3.0, period=0.5, confidence=1.0),
    200: events.Blackout(time=6.7, source="key", on=True),
    230: events.Blackout(time=7.7, source="key", on=False),
}


@pytest.fixture(scope="module")
def show_journal(tmp_path_factory):
    """The journal of ten seconds at 120 bpm: five measures."""
    path = tmp_path_factory.mktemp("night") / "a.jsonl"
    loaded = load_show(find_patch("contemporary"))
    show, clock, inbox = loaded.start(tempo=TEMPO), ManualClock(), EventQueue()
    journal = JournalWriter(path, loaded.header(show, tempo=TEMPO))
    engine = Engine(
        show, clock=clock, inbox=inbox, status=Status(show, rejected=dict, memory=lambda: 0.0), journal=journal
    )
    for frame in range(1, 301):
        clock.set(frame / 30)
        if frame in SCRIPT:
            inbox.put(SCRIPT[frame])
        engine.frame(lambda view: None)
        if frame % 30 == 0:
            wait_until_written(journal)
    journal.close(engine.ticks.index)
    return path


def beats_per_measure(show_journal):
    """Beats of a measure of this show."""
    header = json.loads(show_journal.read_text().splitlines()[0])
    return header["patch"]["clock"]["beats_per_measure"]


def test_show_counts_events_by_source_and_kind(show_journal, tmp_path):
    told = run_live("journal", "show", str(show_journal), "--json", "--picture", str(tmp_path / "a.svg"))
    assert told.returncode == 0, told.stderr
    facts = json.loads(told.stdout)
    counts = {(row["source"], row["type"]): row["count"] for row in facts["events"]}
    assert counts == {("osc", "PlaceElement"): 1, ("tap", "BeatHeard"): 1, ("key", "Blackout"): 2}
    assert facts["complete"]
    assert facts["snapshots"]["measures"] == [2, 3, 4]
    assert facts["measures"] == 4  # the last had no time for one
    assert facts["bpm"] == pytest.approx([TEMPO, TEMPO], rel=0.01)
    picture = (tmp_path / "a.svg").read_text()
    assert picture.count("Blackout") == 1
    assert "BeatHeard · tap" in picture
    listed = run_live("journal", "show", str(show_journal), "--events").stdout
    assert "key        Blackout on=True" in listed
    assert run_live("journal", "show", str(show_journal), "--picture", str(tmp_path / "a.png")).returncode == 0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert run_live("journal", "show", str(show_journal), "--picture", "a.gif").returncode == 2


def test_diff_names_first_differing_event_and_state(show_journal, tmp_path):
    same = run_live("journal", "diff", str(show_journal), str(show_journal))
    assert (same.returncode, "the same show" in same.stdout) == (0, True)
    text = show_journal.read_text().replace('"on":true', '"on":false', 1)
    hashes = [row for row in text.splitlines() if '"hash"' in row]
    text = text.replace(hashes[2], hashes[2].replace('"hash":"', '"hash":"f'))
    (tmp_path / "b.jsonl").write_text(text)
    told = run_live("journal", "diff", str(show_journal), str(tmp_path / "b.jsonl"), "--json")
    assert told.returncode == 1
    facts = json.loads(told.stdout)
    assert facts["event"]["first"]["event"]["type"] == "Blackout"
    assert facts["event"]["first"]["tick"] == math.floor(199 / 30 / TICK) + 1  # a tick of lead
    assert facts["state"]["first"]["measure"] == json.loads(hashes[2])["measure"]
    assert facts["header"] == []


@pytest.mark.long
def test_midi_export_contains_beats_markers_and_steps(show_journal, tmp_path):
    out = tmp_path / "a.mid"
    assert run_live("journal", "export", str(show_journal), str(out)).returncode == 0
    file = mido.MidiFile(out)
    assert file.length == pytest.approx(10.0, abs=0.2)
    tempos = [round(mido.tempo2bpm(m.tempo)) for m in file.tracks[0] if m.type == "set_tempo"]
    assert set(tempos[1:-1]) == {round(TEMPO)}
    metres = [m.numerator for m in file.tracks[0] if m.type == "time_signature"]
    assert set(metres[1:-1]) == {beats_per_measure(show_journal)}
    markers, now = {}, 0
    for message in file.tracks[1]:
        now += message.time
        if message.type == "marker":
            markers.setdefault(message.text.split()[0], []).append(now / file.ticks_per_beat * 60.0 / TEMPO)
    assert markers["PlaceElement"] == pytest.approx([2.0], abs=0.05)
    assert markers["Blackout"] == pytest.approx([6.7, 7.7], abs=0.05)
    assert "BeatHeard" not in markers
    for track in file.tracks[2:]:
        kinds = [message.type for message in track]
        assert kinds.count("note_on") == kinds.count("note_off") >= 4


def test_csv_export_has_row_for_each_event_and_measure(show_journal, tmp_path):
    assert run_live("journal", "export", str(show_journal), str(tmp_path / "a.csv")).returncode == 0
    with (tmp_path / "a.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["kind"] for row in rows if row["kind"] != "measure"] == [
        "PlaceElement", "BeatHeard", "Blackout", "Blackout",
    ]  # fmt: skip
    assert run_live("journal", "export", str(show_journal), str(tmp_path / "a.xls")).returncode == 2


@pytest.mark.long
def test_replay_of_measure_range_verifies_and_renders_film(show_journal, tmp_path):
    told = run_live("replay", str(show_journal), "--verify", "--from", "3", "--to", "4", "--json")
    assert told.returncode == 0, told.stderr
    facts = json.loads(told.stdout)
    assert facts["measures"] == 2
    assert facts["from_tick"] > 0
    film = tmp_path / "b.mp4"
    made = run_live(
        "replay", str(show_journal), "--from", "4", "--to", "4", "--render", str(film), "--size", "64x36", "--fps", "10"
    )
    assert made.returncode == 0, made.stderr
    with av.open(str(film)) as container:
        video = container.streams.video[0]
        assert (video.width, video.height) == (64, 36)
        assert float(video.duration * video.time_base) == pytest.approx(
            beats_per_measure(show_journal) * 60.0 / TEMPO, abs=0.25
        )
    assert run_live("replay", str(show_journal), "--from", "5", "--to", "2").returncode == 2
    missing = run_live("replay", str(show_journal), "--from", "99", "--render", str(film))
    assert (missing.returncode, "has no measure 99" in missing.stderr) == (2, True)


def test_damaged_journal_is_reported_and_fails_verification(show_journal, tmp_path):
    for file in (show_journal, show_journal.with_name("a.jsonl.snap")):
        shutil.copy(file, tmp_path / file.name)
    path = tmp_path / "a.jsonl"
    path.write_text(path.read_text().replace('"PlaceElement"', '"Attrakt"'))
    told = run_live("replay", str(path), "--verify", "--json")
    assert told.returncode == 1
    facts = json.loads(told.stdout)
    assert "unknown event type 'Attrakt'" in facts["problems"][0]
    assert facts["different"] == []
    assert "unknown event type" in run_live("journal", "show", str(path)).stdout
    other = tmp_path / "old.jsonl"
    other.write_text('{"journal": 7}\n')
    refused = run_live("journal", "show", str(other))
    assert (refused.returncode, "format 1 or 2 or 3 expected" in refused.stderr) == (2, True)
