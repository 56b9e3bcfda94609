"""Latency calibration of `live calibrate`: round trip of the sound, claps for the display, the venue's file."""

import time
from typing import Any

from live.app.offline.clap_calibration import WindowScreen, clap_test
from live.base.errors import PersonError, error_context
from live.clock.time_source import SystemClock
from live.control.audio.channel_mixer import Channels
from live.control.audio.devices import SoundDevice, SoundUnavailable, find_device
from live.control.audio.latency_sweep import Microphone, measure, play_and_record, sweep_train
from live.library.whole_file import write_with_folder
from live.show.venue.venue import Venue, updated_venue_text, venue_path


def find_input(audio: str | None, audio_channel: str | None, venue: Venue) -> tuple[SoundDevice, Channels]:
    """Return audio input and channels, by option or venue; raise PersonError if there is no such device."""
    with error_context("--audio-channel" if audio_channel is not None else "audio.channels of the venue"):
        channels = Channels.parse(audio_channel if audio_channel is not None else venue.audio.channels or (1, 2))
    try:
        return find_device(audio or venue.audio.device), channels
    except (SoundUnavailable, ValueError) as error:
        raise PersonError(f"--audio: {error}") from None


def measure_round_trip(
    device: SoundDevice, channels: Channels, output: str | None, repeats: int
) -> tuple[dict[str, Any], dict[str, float]]:
    """Measure the sound's round trip with sweeps; return the report and the venue's values [ms]."""
    try:
        speaker = find_device(output, "output")
    except (SoundUnavailable, ValueError) as error:
        raise PersonError(f"--output: {error}") from None
    clock = SystemClock()
    train = sweep_train(speaker.sample_rate, repeats)
    microphone = Microphone(device, channels, len(train.sound) / train.sample_rate + 10.0, clock)
    try:
        recording, reported = play_and_record(train, speaker, microphone, clock)
    finally:
        microphone.close()
    trip = measure(train, recording)
    known = reported is not None and microphone.latency is not None
    share = reported / (reported + microphone.latency) if known else 0.5  # type: ignore[operator]
    values = {
        "input_ms": round(1000.0 * trip.seconds * (1.0 - share), 1),
        "output_ms": round(1000.0 * trip.seconds * share, 1),
        "round_trip_ms": round(1000.0 * trip.seconds, 1),
        "round_trip_spread_ms": round(1000.0 * trip.spread, 2),
    }
    report = {
        "output": speaker.name,
        "input": device.name,
        **values,
        "divided": "as reported by the devices" if known else "in halves",
        "heard": trip.detected,
        "of": trip.total,
    }
    return report, values


def measure_claps(
    device: SoundDevice, channels: Channels, venue: Venue, flashes: int, monitor: str | None
) -> tuple[dict[str, Any], dict[str, float]]:
    """Measure the display's latency with claps; return the report and the venue's values [ms]."""
    with WindowScreen(monitor) as screen:
        offset = clap_test(screen, device, channels, max(flashes, 16))
    seconds = max(offset.seconds - venue.latency.input_ms / 1000.0, 0.0)
    display = min(venue.latency.display_ms, 1000.0 * seconds)
    values = {
        "display_ms": round(display, 1),
        "projector_ms": round(1000.0 * seconds - display, 1),
        "claps_spread_ms": round(1000.0 * offset.spread, 1),
    }
    report = {"input": device.name, "input_ms": venue.latency.input_ms, **values, "claps": offset.claps}
    return report, values


def write_latencies(name: str, values: dict[str, dict[str, Any]]) -> str:
    """Write values into a venue's file and return its path; other keys and comments stay."""
    path = venue_path(name)
    text = updated_venue_text(path, name, values, f"measured {time.strftime('%Y-%m-%d')}")
    write_with_folder(text.encode(), path, "--venue")
    return str(path)
