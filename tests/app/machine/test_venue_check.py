"""`live check --venue`: missing parts of a venue with remedies, the show's own packet, practice options."""

import json
import socket
from types import SimpleNamespace
from typing import Any

import pytest

from live.app.launch_options import LaunchOptions
from live.app.machine import venue_check
from live.app.machine.device_list import Section
from live.app.machine.venue_check import check_disk, check_osc, part_checks, venue_checks
from live.app.option_values import parse_measures
from live.app.practice import practice_events, practice_tempo
from live.app.session_audio import choose_audio
from live.base.errors import PersonError
from live.render.outputs import picture_layout
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.venue.venue import Venue, VenueAudio, VenueMidi
from live.show.venue.venue_output import VenueOutput
from tests.cli.command import run_live
from tests.show.made_show import made_show


def test_unknown_venue_is_refused_and_valid_show_is_checked(tmp_path):
    told = run_live("check", "score", "--venue", "nowhere-at-all")
    assert told.returncode == 2
    assert "there is no venue" in told.stderr
    ready = run_live("check", "score", "--json", "--osc", "0", cwd=tmp_path)
    facts = json.loads(ready.stdout)
    found = {check["name"]: check for check in facts["checks"]}
    assert found["steps"]["state"] == found["OSC"]["state"] == found["sections"]["state"] == "ok"
    missing = [check for check in facts["checks"] if check["needed"] and check["state"] != "ok"]
    assert facts["ready"] == (not missing)
    assert ready.returncode == (1 if missing else 0)


def test_venue_devices_are_found_by_part_of_name(monkeypatch):
    cards = Section("audio", ({"name": "Scarlett 2i2 USB"}, {"name": "HDMI"}))
    monkeypatch.setattr(venue_check, "audio_sections", lambda: (cards, cards))
    monkeypatch.setattr(venue_check, "midi_sections", lambda: (Section("in", (), "no MIDI here"), Section("out", ())))
    hall = Venue(audio=VenueAudio(device="scarlett", output="Behringer"), midi=VenueMidi(input="nanoKONTROL"))
    states = {check.name: check for check in venue_checks(hall)}
    assert states["audio.device"].state == "ok"
    assert states["audio.output"].state == states["midi.input"].state == "missing"
    assert "Scarlett 2i2 USB, HDMI" in states["audio.output"].remedy
    assert "no MIDI here" in states["midi.input"].remedy
    assert list(venue_checks(None)) == []


def test_busy_port_is_missing_and_free_port_is_ok():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        taken = check_osc("127.0.0.1", other.getsockname()[1])
    assert taken.state == "missing"
    assert check_osc("127.0.0.1", 0).state == "ok"


def test_disk_space_sets_state_of_check(tmp_path, monkeypatch):
    assert check_disk(tmp_path / "nowhere").state == "limited"
    for free, state in ((1e8, "missing"), (1e9, "limited"), (1e10, "ok")):
        monkeypatch.setattr(venue_check.shutil, "disk_usage", lambda folder, free=free: SimpleNamespace(free=free))
        assert check_disk(tmp_path).state == state


@pytest.mark.parametrize(("text", "measures"), [("17-24", (17, 24)), (" 3 – 5", (3, 5)), ("9", (9, 9)), (None, None)])
def test_measure_ranges_are_parsed(text, measures):
    assert parse_measures(text) == measures


@pytest.mark.parametrize("text", ["", "0-4", "8-4", "a-b", "1-", "-3", "1-2-3", "1.5-2"])
def test_invalid_measure_ranges_are_refused(text):
    with pytest.raises(PersonError, match="--measures"):
        parse_measures(text)


SCORE = '[[section]]\nname = "a"\nmeasures = 4\n[[section]]\nname = "b"\nmeasures = 4\n'


def test_practice_loops_measures_and_refuses_measures_beyond_score():
    show = made_show(SCORE)
    for event in practice_events(LaunchOptions(measures=(3, 5)), show):
        show.apply(event)
    places = []
    for tick in range(1, 64 * 18):
        if show.tick(tick / 64.0):
            places.append(show.playhead.written_measure(show.playhead.place(show.span.number)) + 1)
    assert places == [3, 4, 5, 3, 4, 5, 3, 4]
    assert practice_events(LaunchOptions(), show) == []
    with pytest.raises(PersonError, match="it has 8"):
        practice_events(LaunchOptions(measures=(7, 9)), show)


def fake_loaded_show(music: float | None) -> Any:
    clock = SimpleNamespace(bpm=120.0)
    return SimpleNamespace(patch=SimpleNamespace(clock=clock, music=SimpleNamespace(bpm=music)), music_path=None)


def test_practice_tempo_is_share_of_show_tempo():
    assert practice_tempo(LaunchOptions(tempo_share=0.8), fake_loaded_show(None)) == pytest.approx(96.0)
    assert practice_tempo(LaunchOptions(tempo_share=0.5), fake_loaded_show(100.0)) == pytest.approx(50.0)
    assert practice_tempo(LaunchOptions(tempo_share=0.5, bpm=90.0), fake_loaded_show(100.0)) == pytest.approx(45.0)
    assert practice_tempo(LaunchOptions(measures=(1, 2)), fake_loaded_show(None)) == pytest.approx(120.0)
    with pytest.raises(PersonError, match="12 bpm"):
        practice_tempo(LaunchOptions(tempo_share=0.1), fake_loaded_show(None))


def test_practice_plays_no_music_and_slowed_music_is_refused():
    assert choose_audio(LaunchOptions(measures=(1, 2)), fake_loaded_show(None)).music is None
    with pytest.raises(PersonError, match="--tempo-share"):
        choose_audio(LaunchOptions(tempo_share=0.8, audio="song.wav"), fake_loaded_show(None))


def test_venue_projectors_and_masks_are_checked(tmp_path, monkeypatch):
    from PIL import Image

    from live.app import output_config
    from live.render.window.monitors import Monitor, resolve_monitor

    there = [Monitor(1, "eDP-1", (0, 0), (1920, 1080), 60.0), Monitor(2, "HDMI-1", (1920, 0), (1280, 720), 60.0)]
    monkeypatch.setattr(output_config, "resolve_monitor", lambda text: resolve_monitor(text, there))
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path))
    (tmp_path / "venues").mkdir()
    Image.new("L", (64, 32)).save(tmp_path / "venues" / "m.png")
    outputs = [
        {"name": "a", "monitor": "right of primary", "mask": "m.png"}, {"name": "b", "monitor": "3", "mask": "n.png"},
    ]  # fmt: skip
    (tmp_path / "venues" / "hall.toml").write_text("")
    hall = Venue(operator="HDMI-7", output=outputs)
    told = {check.name: check for check in venue_checks(hall, "hall")}
    assert (told["output a"].state, told["output a"].detail) == ("ok", "2 HDMI-1 (1280x720 at 1920,0 60 Hz)")
    assert told["output a mask"].detail == "64x32 pixels"
    for name, words in (("operator", "HDMI-7"), ("output b", "eDP-1"), ("output b mask", "no such file")):
        assert told[name].state == "missing"
        assert told[name].needed
        assert words in told[name].detail
        assert "\n" not in told[name].detail


def test_check_tells_whether_machines_can_draw_their_part_alone(monkeypatch):
    loaded = load_show(DEFAULT_PATCH)
    halves = tuple(VenueOutput(name=node, node=node, crop=(at, 0.0, 0.5, 1.0)) for node, at in (("a", 0.0), ("b", 0.5)))
    assert list(part_checks(loaded, Venue(output=(VenueOutput(),)))) == []
    picture, size = part_checks(loaded, Venue(output=halves))
    assert picture.state == "ok"
    assert "a, b" in picture.detail
    assert (size.name, size.state) == ("picture_size", "limited")
    assert [one.state for one in part_checks(loaded, Venue(output=halves, picture_size=(3840, 1080)))] == ["ok"]
    monkeypatch.setattr(picture_layout, "whole_picture_reason", lambda scene, row: "the pass waves looks elsewhere")
    (limited,) = part_checks(loaded, Venue(output=halves))
    assert limited.state == "limited"
    assert "waves" in limited.detail
