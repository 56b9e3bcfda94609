"""Command `live mocap send`: plays a recording as live motion capture, for rehearsals without a suit."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(help="Live motion capture (`live docs mocap`).", no_args_is_help=True)


@app.command("send")
def send(
    file: Annotated[Path, typer.Argument(help="A motion file of any format (`live docs steps`).")],
    to: Annotated[
        str, typer.Option("--to", help="The show's VMC address (`--vmc`).", metavar="[HOST:]PORT")
    ] = "127.0.0.1:39539",
    fps: Annotated[float | None, typer.Option(help="The true frame rate, if the header is wrong.")] = None,
    rate: Annotated[float, typer.Option(help="Poses per second to send.")] = 60.0,
    begin: Annotated[float, typer.Option("--from", help="Seconds to skip at the start.")] = 0.0,
    seconds: Annotated[float | None, typer.Option(help="Duration in seconds.")] = None,
    loop: Annotated[bool, typer.Option("--loop", help="Repeat until Ctrl-C.")] = False,
) -> None:
    """Send a recording in real time with the VMC protocol, to a show or any other VMC receiver."""
    from live.app.option_values import check_range, parse_endpoint
    from live.base.errors import PersonError
    from live.bridges.vmc.vmc_output import play_clip
    from live.library.motion_file import read_motion
    from live.motion.formats.file_error import MotionFileError
    from live.motion.retarget.retarget import retarget

    check_range(fps, "--fps", 1, 10_000)
    check_range(rate, "--rate", 1, 240)
    check_range(seconds, "--seconds", 0.1, 7 * 86400)
    endpoint = parse_endpoint(to, "--to")
    try:
        clip = retarget(read_motion(file), name=file.stem, fps=fps, sample_rate=rate)
    except MotionFileError as error:
        raise PersonError(str(error)) from None
    check_range(begin, "--from", 0.0, (clip.sample_count - 1) / rate)
    try:
        sent = play_clip(clip, endpoint, first=round(begin * rate), seconds=seconds, loop=loop)
    except OSError as error:
        raise PersonError(f"--to {to}: {error.strerror or error}", "give the host's IP address") from None
    typer.echo(f"{sent} poses sent to {endpoint[0]}:{endpoint[1]}")
