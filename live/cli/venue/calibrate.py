"""Command `live calibrate`: measures audio and display latency in a hall and writes them to the venue's file.

Below it are commands of bridges, which measure what belongs to them.
"""

from typing import Annotated, Any

import typer

app = typer.Typer(invoke_without_command=True)


@app.callback()
def calibrate(
    context: typer.Context,
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
    """Measure latency (of audio with sweeps that are played and recorded, of the display with claps), or a camera.

    First without --claps: the loudspeakers play sweeps, and the show's microphone records them. Then with --claps: the
    projector flashes, and people at the audience's place clap with the flashes.
    """
    from live.app.machine.latency_calibration import find_input, measure_claps, measure_round_trip, write_latencies
    from live.app.option_values import check_range
    from live.base.errors import PersonError
    from live.show.venue.venue import Venue, read_venue, user_venue_folder, venue_path

    if context.invoked_subcommand is not None:
        _check_no_options(context)
        return
    check_range(repeats, "--repeats", 8, 200)
    there = read_venue(venue) if venue is not None and venue_path(venue).is_file() else Venue()
    microphone, channels = find_input(audio, audio_channel, there)
    if claps:
        found, values = measure_claps(microphone, channels, there, repeats, monitor)
    else:
        found, values = measure_round_trip(microphone, channels, output or there.audio.output, repeats)
    chosen: dict[str, Any] = {"device": microphone.name} if audio is not None else {}
    if audio_channel is not None and channels.numbers:
        chosen["channels"] = [number + 1 for number in channels.numbers]
    if output is not None:
        chosen["output"] = found["output"]
    if venue is not None:
        found["file"] = write_latencies(venue, {"audio": chosen, "latency": values} if chosen else {"latency": values})
        if not str(found["file"]).startswith(str(user_venue_folder())):
            found["note"] = "this venue is a built-in one"
    if not found:
        raise PersonError("nothing was measured")
    _print(found, as_json)


def _check_no_options(context: typer.Context) -> None:
    """Raise PersonError for options before the command below, which would not be used."""
    from live.base.errors import PersonError

    for each in context.command.params:
        source = None if each.name is None else context.get_parameter_source(each.name)
        if source is not None and source.name == "COMMANDLINE":
            below = f"live calibrate {context.invoked_subcommand}"
            raise PersonError(f"{each.opts[0]} stands before {context.invoked_subcommand}", f"{below} {each.opts[0]} …")


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
