"""Command `live export`: writes recordings and steps as BVH or glTF for Blender, or as .vrma for VRM avatars."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Mapping


def export(
    source: Annotated[str, typer.Argument(help="A motion file, or the name of a step.", metavar="FILE|STEP")],
    to: Annotated[Path, typer.Option(help="The file to write.", metavar="OUT.bvh|OUT.glb|OUT.vrma")],
    rate: Annotated[
        str, typer.Option(help="Frames per second; 'source' keeps the frames of the file.", metavar="HZ|source")
    ] = "60",
    force: Annotated[bool, typer.Option("--force", help="Overwrite OUT if it exists.")] = False,
    fps: Annotated[float | None, typer.Option(help="FILE: its true frame rate, if its header is wrong.")] = None,
    unit: Annotated[float | None, typer.Option(help="FILE: metres per unit, to check its size.")] = None,
    up: Annotated[str | None, typer.Option(help="FILE: the axis that points up.", metavar="Y|Z")] = None,
    skeleton: Annotated[
        Path | None, typer.Option(help="The file with its skeleton, as for .amc. Default: the one next to it.")
    ] = None,
    drop_frames: Annotated[int | None, typer.Option(help="FILE: leading frames to leave out.")] = None,
    library: Annotated[
        Path | None,
        typer.Option(help="STEP: its folder. Default: yours and the built-in one.", metavar="DIR"),
    ] = None,
    variation: Annotated[int | None, typer.Option(help="STEP: number of the variation, from 1.")] = None,
    measures: Annotated[int | None, typer.Option(help="STEP: number of measures from the start. Default: all.")] = None,
) -> None:
    """Write a recording or a step as a BVH, GLB or VRMA file with the engine's skeleton.

    A recording is retargeted to the engine's skeleton first. A step is written at its own tempo, from its first beat
    to the end of its last measure. BVH: centimetres, Y up, ZXY. GLB: metres, Y up, opens in Blender and VRM tools.
    """
    from rich.console import Console

    from live.app.offline.motion_export import load_file, load_step, write_motion
    from live.app.option_values import check_range
    from live.base.errors import PersonError

    hertz = _parse_rate(rate)
    check_range(fps, "--fps", 1, 10_000)
    check_range(unit, "--unit", 1e-6, 1000)
    if up is not None and up.upper() not in ("Y", "Z"):
        raise PersonError(f"--up {up!r}: Y or Z expected")
    _check_target(to, source, force=force)
    for_files = {"--fps": fps, "--unit": unit, "--up": up, "--skeleton": skeleton, "--drop-frames": drop_frames}
    for_steps = {"--library": library, "--variation": variation, "--measures": measures}
    if _is_file(source):
        _refuse_options(for_steps, source, "a file; that option is for steps")
        clip = load_file(Path(source), hertz, fps, unit, up, skeleton, drop_frames)
    else:
        _refuse_options(for_files, source, "a step; that option is for files")
        clip = load_step(source, hertz, library, variation, measures)
    size = write_motion(clip, to)
    Console(highlight=False).print(
        f"{to}: {clip.sample_count} frames, {clip.sample_rate:g} per second, {clip.seconds:.2f} s, {size} bytes",
        soft_wrap=True,
        markup=False,
    )


def _parse_rate(text: str) -> float | None:
    """Parse frames per second; None: keep the source's."""
    from live.base.errors import PersonError

    if text.strip().lower() == "source":
        return None
    try:
        hertz = float(text)
    except ValueError:
        hertz = 0.0
    if not 1.0 <= hertz <= 1000.0:
        raise PersonError(f"--rate {text!r}: 1 to 1000 frames per second expected, or source", "--rate 60")
    return hertz


def _check_target(to: Path, source: str, *, force: bool) -> None:
    from live.app.option_values import check_writable
    from live.base.errors import PersonError
    from live.library.motion_formats import check_written_name

    check_written_name(to, "--to", ".glb")
    check_writable(to, "--to")
    if not to.exists():
        return
    if _is_file(source) and Path(source).exists() and to.samefile(source):
        raise PersonError(f"--to {to}: that is the input file", "give the new file another name")
    if not force:
        raise PersonError(f"--to {to}: the file exists already", "give another name, or --force to overwrite it")


def _is_file(source: str) -> bool:
    """Whether the source names a file, existing or not, instead of a step."""
    from live.library.motion_formats import format_by_suffix
    from live.show.patch.patch_search_path import is_file

    path = Path(source)
    return is_file(path) or format_by_suffix(path) is not None or "/" in source


def _refuse_options(options: "Mapping[str, object]", source: str, words: str) -> None:
    from live.base.errors import PersonError

    given = [name for name, value in options.items() if value is not None]
    if given:
        raise PersonError(f"{given[0]}: {source!r} is {words}", f"leave {' and '.join(given)} out")
