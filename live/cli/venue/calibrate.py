"""Command `live calibrate`: measures audio and display latency in a hall and writes them to the venue's file."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from live.control.audio.channel_mixer import Channels
    from live.control.audio.devices import SoundDevice
    from live.show.venue.venue import Venue


def calibrate(
    venue: Annotated[
        str | None, typer.Option(help="The venue to write to. Default: nothing is written.", metavar="NAME")
    ] = None,
    claps: Annotated[
        bool, typer.Option("--claps", help="Measure display latency: the screen flashes, people clap with it.")
    ] = False,
    audio: Annotated[str | None, typer.Option(help="Name of the audio input.", metavar="DEVICE")] = None,
    audio_channel: Annotated[
        str | None, typer.Option(help="Channels of the input: 3, or 5,6, or all.", metavar="N[,N]|all")
    ] = None,
    output: Annotated[str | None, typer.Option(help="Name of the audio output.", metavar="DEVICE")] = None,
    repeats: Annotated[int, typer.Option(help="Number of sweeps or flashes.")] = 16,
    monitor: Annotated[str | None, typer.Option(help="The monitor that flashes.", metavar="N|NAME")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Measure latency: of audio with sweeps that are played and recorded, of the display with claps.

    First without --claps: the loudspeakers play sweeps, and the show's microphone records them. Then with --claps: the
    projector flashes, and people at the audience's place clap with the flashes.
    """
    from live.app.option_values import check_range
    from live.base.errors import PersonError
    from live.show.venue.venue import Venue, read_venue, user_venue_folder, venue_path

    check_range(repeats, "--repeats", 8, 200)
    there = read_venue(venue) if venue is not None and venue_path(venue).is_file() else Venue()
    microphone, channels = _find_input(audio, audio_channel, there)
    if claps:
        found, values = _measure_claps(microphone, channels, there, repeats, monitor)
    else:
        found, values = _measure_round_trip(microphone, channels, output or there.audio.output, repeats)
    chosen: dict[str, Any] = {"device": microphone.name} if audio is not None else {}
    if audio_channel is not None and channels.numbers:
        chosen["channels"] = [number + 1 for number in channels.numbers]
    if output is not None:
        chosen["output"] = found["output"]
    if venue is not None:
        found["file"] = _write(venue, {"audio": chosen, "latency": values} if chosen else {"latency": values})
        if not str(found["file"]).startswith(str(user_venue_folder())):
            found["note"] = "this venue is a built-in one"
    if not found:
        raise PersonError("nothing was measured")
    _print(found, as_json)


def _find_input(audio: str | None, audio_channel: str | None, venue: "Venue") -> "tuple[SoundDevice, Channels]":
    from live.base.errors import PersonError, error_context
    from live.control.audio.channel_mixer import Channels
    from live.control.audio.devices import SoundUnavailable, find_device

    with error_context("--audio-channel" if audio_channel is not None else "audio.channels of the venue"):
        channels = Channels.parse(audio_channel if audio_channel is not None else venue.audio.channels or (1, 2))
    try:
        return find_device(audio or venue.audio.device), channels
    except (SoundUnavailable, ValueError) as error:
        raise PersonError(f"--audio: {error}") from None


def _measure_round_trip(
    device: "SoundDevice", channels: "Channels", output: str | None, repeats: int
) -> tuple[dict[str, Any], dict[str, float]]:
    from live.base.errors import PersonError
    from live.clock.time_source import SystemClock
    from live.control.audio.devices import SoundUnavailable, find_device
    from live.control.audio.latency_sweep import Microphone, measure, play_and_record, sweep_train

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
    told = {
        "output": speaker.name,
        "input": device.name,
        **values,
        "divided": "as reported by the devices" if known else "in halves",
        "heard": trip.detected,
        "of": trip.total,
    }
    return told, values


def _measure_claps(
    device: "SoundDevice", channels: "Channels", venue: "Venue", flashes: int, monitor: str | None
) -> tuple[dict[str, Any], dict[str, float]]:
    from live.app.offline.clap_calibration import WindowScreen, clap_test

    with WindowScreen(monitor) as screen:
        offset = clap_test(screen, device, channels, max(flashes, 16))
    seconds = max(offset.seconds - venue.latency.input_ms / 1000.0, 0.0)
    display = min(venue.latency.display_ms, 1000.0 * seconds)
    values = {
        "display_ms": round(display, 1),
        "projector_ms": round(1000.0 * seconds - display, 1),
        "claps_spread_ms": round(1000.0 * offset.spread, 1),
    }
    told = {"input": device.name, "input_ms": venue.latency.input_ms, **values, "claps": offset.claps}
    return told, values


def _write(name: str, values: dict[str, dict[str, Any]]) -> str:
    import time

    from live.app.whole_file import write_atomically
    from live.base.errors import PersonError
    from live.show.venue.venue import updated_venue_text, venue_path

    path = venue_path(name)
    text = updated_venue_text(path, name, values, f"measured {time.strftime('%Y-%m-%d')}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PersonError(f"cannot make the folder {path.parent}: {error.strerror}") from None
    write_atomically(text.encode(), path, "--venue")
    return str(path)


def _print(found: dict[str, Any], as_json: bool) -> None:
    if as_json:
        import json

        print(json.dumps(found))
        return
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    for key, value in found.items():
        unit = " ms" if key.endswith("_ms") else ""
        console.print(f"{key.removesuffix('_ms').replace('_', ' ')}: {value}{unit}")
