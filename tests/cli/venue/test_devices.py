"""`live devices`: every section is a list or a reason for an empty one, with the hardware of this machine."""

import json
import os
from pathlib import Path

import pytest

from live.app.machine import device_list
from live.control.audio import devices as sound_devices
from live.control.audio.devices import SoundDevice
from live.control.midi import midi_ports
from live.control.midi.midi_streams import Direction, Port
from live.control.midi.midi_system import MidiUnavailable
from tests.cli.command import run_live, run_live_process
from tests.fixtures import two_monitor_x

SECTIONS = ["audio_inputs", "audio_outputs", "midi_inputs", "midi_outputs", "monitors"]


@pytest.mark.long
def test_json_has_five_sections_with_list_or_reason() -> None:
    done = run_live_process("devices", "--json")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""  # the C libraries' own complaints are kept off the screen
    report = json.loads(done.stdout)
    assert list(report) == SECTIONS
    for section in report.values():
        assert bool(section["items"]) == (section["why"] is None)


def test_table_names_every_section() -> None:
    done = run_live("devices")
    assert done.returncode == 0, done.stderr
    headings = [line for line in done.stdout.splitlines() if not line.startswith(" ")]
    assert headings == ["Audio in", "Audio out", "MIDI in", "MIDI out", "Monitors"]


def test_missing_screen_is_explained_by_display_variables() -> None:
    section = json.loads(run_live("devices", "--json", DISPLAY="", WAYLAND_DISPLAY="").stdout)["monitors"]
    assert section["items"] == []
    assert "DISPLAY" in section["why"]


def test_unresponsive_screen_is_explained() -> None:
    section = json.loads(run_live("devices", "--json", DISPLAY=":4711", WAYLAND_DISPLAY="").stdout)["monitors"]
    assert section["items"] == []
    assert ":4711" in section["why"]


class MidiSystemOf:
    """A MIDI system with these ports, or one that does not run."""

    name = "bus"

    def __init__(self, why: str = "", **ports: list[str]) -> None:
        self.why, self.ports = why, ports

    def port_names(self, direction: Direction) -> list[str]:
        if self.why:
            raise MidiUnavailable(self.why)
        return self.ports[direction]

    def open_port(self, direction: Direction, name: str) -> Port:
        raise OSError("it is taken")


def test_midi_without_sequencer_gives_every_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    systems = (MidiSystemOf("the kernel has no\nsequencer"), MidiSystemOf("no server runs"))
    monkeypatch.setattr(midi_ports, "SYSTEMS", systems)
    first, second = device_list.midi_sections()
    assert first.items == second.items == ()
    assert first.why == "no MIDI system runs here: the kernel has no sequencer, no server runs"


def test_midi_ports_are_listed_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    there = MidiSystemOf(input=["keys:0", "pads:1"], output=[])
    monkeypatch.setattr(midi_ports, "SYSTEMS", (MidiSystemOf("no server runs"), there))
    inputs, outputs = device_list.midi_sections()
    assert [item["name"] for item in inputs.items] == ["keys:0", "pads:1"]
    assert inputs.why is None
    assert outputs.why == "MIDI is available, but no device is connected"


def test_audio_devices_keep_numbers_and_are_sorted_by_direction(monkeypatch: pytest.MonkeyPatch) -> None:
    microphone = SoundDevice(1, "microphone", "ALSA", 1, 48000.0, default=True)
    speakers = SoundDevice(0, "speakers", "JACK", 2, 44100.0, default=False)
    monkeypatch.setattr(sound_devices, "list_input_devices", lambda: [microphone])
    monkeypatch.setattr(sound_devices, "list_output_devices", lambda: [speakers])
    inputs, outputs = device_list.audio_sections()
    keys = {"index": 1, "name": "microphone", "host": "ALSA", "channels": 1, "sample_rate": 48000.0, "default": True}
    assert inputs.items == (keys,)
    assert [item["name"] for item in outputs.items] == ["speakers"]
    assert inputs.why is outputs.why is None


def test_audio_without_portaudio_gives_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    def unavailable() -> list[SoundDevice]:
        raise sound_devices.SoundUnavailable("no sound devices: PortAudio library not found;\ninstall PortAudio")

    monkeypatch.setattr(sound_devices, "list_input_devices", unavailable)
    monkeypatch.setattr(sound_devices, "list_output_devices", list)
    inputs, outputs = device_list.audio_sections()
    assert (inputs.items, inputs.why) == ((), "no sound devices: PortAudio library not found; install PortAudio")
    assert outputs.why is not None
    assert "no output" in outputs.why


def test_stderr_is_restored_after_suppression(capfd: pytest.CaptureFixture[str]) -> None:
    with device_list.suppress_native_stderr():
        os.write(2, b"from a C library\n")
    os.write(2, b"ours\n")
    assert capfd.readouterr().err == "ours\n"


@pytest.mark.long
@pytest.mark.x11
def test_two_real_monitors_are_numbered_from_one(tmp_path: Path) -> None:
    try:
        screen, server = two_monitor_x.start(tmp_path)
    except two_monitor_x.NoX as reason:
        pytest.skip(str(reason))
    try:
        screen.plug_both()
        report = json.loads(run_live("devices", "--json", DISPLAY=screen.display).stdout)["monitors"]
        table = run_live("devices", DISPLAY=screen.display).stdout
    finally:
        two_monitor_x.stop(server)
    assert report["why"] is None
    seen = [(item["number"], item["name"], item["width"], item["position"]) for item in report["items"]]
    assert seen == [(1, "DUMMY0", 640, [0, 0]), (2, "DUMMY1", 800, [640, 0])]
    assert "  2  DUMMY1  800×600, 60 Hz, at (640, 0)" in table.splitlines()
