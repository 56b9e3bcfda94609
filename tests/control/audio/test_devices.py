"""Tests of sound device lookup: by name, index or default; unknown devices are answered with a list."""

import builtins
import sys
from typing import Any

import pytest

from live.control.audio import devices
from live.control.audio.devices import SoundDevice, SoundUnavailable, UnknownDevice, find_again, find_device

DEVICES = [
    SoundDevice(0, "HDA Intel: ALC295 (hw:0,0)", "ALSA", 2, 44_100.0, False),
    SoundDevice(3, "pulse", "ALSA", 32, 48_000.0, True),
    SoundDevice(7, "USB Pulse Interface", "ALSA", 8, 96_000.0, False),
]


@pytest.fixture
def three_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(devices, "_list", lambda kind: DEVICES)


@pytest.mark.usefixtures("three_devices")
@pytest.mark.parametrize(
    ("text", "index"), [(None, 3), (7, 7), ("7", 7), ("pulse", 3), ("PULSE", 3), ("usb", 7), ("alc295", 0)]
)
def test_device_is_found_by_name_index_or_default(text: str | int | None, index: int) -> None:
    assert find_device(text).index == index


def test_reconnected_device_is_matched_by_exact_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = SoundDevice(3, "USB Pulse", "ALSA", 2, 48_000.0, True)
    there = [DEVICES[2], SoundDevice(1, "usb pulse", "JACK", 2, 48_000.0, False)]
    monkeypatch.setattr(devices, "_list", lambda kind: there[:1])
    with pytest.raises(UnknownDevice, match="USB Pulse is not there"):
        find_again(own)
    monkeypatch.setattr(devices, "_list", lambda kind: there)
    assert find_again(own).index == 1
    there.append(SoundDevice(5, "USB Pulse", "ALSA", 2, 48_000.0, False))
    assert find_again(own).index == 5  # in its own sound system


@pytest.mark.usefixtures("three_devices")
@pytest.mark.parametrize("text", ["theremin", "", "  ", 5, "5", "-1"])
def test_unknown_device_error_lists_all_devices(text: str | int) -> None:
    with pytest.raises(UnknownDevice) as caught:
        find_device(text)
    assert all(device.name in str(caught.value) for device in DEVICES)


def test_missing_devices_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(devices, "_list", lambda kind: [])
    with pytest.raises(UnknownDevice, match="no sound output at all"):
        find_device(None, "output")


def test_missing_portaudio_error_names_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def refuse(name: str, *arguments: Any, **keywords: Any) -> Any:
        if name == "sounddevice":
            raise OSError("PortAudio library not found")
        return real(name, *arguments, **keywords)

    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(SoundUnavailable, match="libportaudio2"):
        devices.list_input_devices()
