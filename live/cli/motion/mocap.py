"""`live mocap send`: a recording as if a real dancer were captured now: rehearsals without a suit."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(help="Live motion capture (docs/mocap.md).", no_args_is_help=True)


@app.command("send")
def send(
    file: Annotated[Path, typer.Argument(help="A .bvh, .amc, .glb, .gltf, .vrm, .vrma or AMASS .npz file.")],
    to: Annotated[
        str, typer.Option("--to", help="Where a show listens (`--vmc`).", metavar="[HOST:]PORT")
    ] = "127.0.0.1:39539",
    fps: Annotated[float | None, typer.Option(help="Its true frame rate, where the file lies.")] = None,
    rate: Annotated[float, typer.Option(help="Poses a second that are sent.")] = 60.0,
    begin: Annotated[float, typer.Option("--from", help="Begin so many seconds after its beginning.")] = 0.0,
    seconds: Annotated[float | None, typer.Option(help="End after so many seconds.")] = None,
    loop: Annotated[bool, typer.Option("--loop", help="Again and again, until Ctrl-C.")] = False,
) -> None:
    """Send a recording by the VMC protocol, in real time: to a show, or to any program that shows avatars."""
    from live.app.option_values import parse_endpoint, parse_number
    from live.base.errors import PersonError
    from live.control.capture.vmc_output import play_clip
    from live.library.motion_file import read_motion
    from live.motion.formats.file_error import MotionFileError
    from live.motion.retarget.retarget import retarget

    parse_number(fps, "--fps", 1, 10_000)
    parse_number(rate, "--rate", 1, 240)
    parse_number(seconds, "--seconds", 0.1, 7 * 86400)
    endpoint = parse_endpoint(to, "--to")
    try:
        clip = retarget(read_motion(file), name=file.stem, fps=fps, sample_rate=rate)
    except MotionFileError as error:
        raise PersonError(str(error)) from None
    parse_number(begin, "--from", 0.0, (clip.sample_count - 1) / rate)
    try:
        sent = play_clip(clip, endpoint, first=round(begin * rate), seconds=seconds, loop=loop)
    except OSError as error:
        raise PersonError(f"--to {to}: {error.strerror or error}", "name hosts by their numbers") from None
    typer.echo(f"{sent} poses sent to {endpoint[0]}:{endpoint[1]}")
