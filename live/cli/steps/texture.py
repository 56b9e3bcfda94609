"""`live texture`: a sketched motion gets the detail, and the joints it lacks, of motion capture."""

from pathlib import Path
from typing import Annotated

import typer


def texture(
    sketch: Annotated[
        str,
        typer.Argument(help="A motion file, a sketched step's TOML file, or a step's name.", metavar="SKETCH"),
    ],
    with_: Annotated[
        list[Path],
        typer.Option("--with", help="Motion capture: files, or folders of them; may be given often.", metavar="PLACE"),
    ],
    out: Annotated[Path, typer.Option(help="The file to write; several paths get numbers.", metavar="OUT.bvh|OUT.glb")],
    drive: Annotated[
        str,
        typer.Option(
            help='Joints whose angles are matched; others from a time on: "hips,knees @2.5 knees @4 hips".',
            metavar="JOINTS",
        ),
    ] = "hips,knees",
    synthesize: Annotated[
        str, typer.Option(help="Joints made of the motion capture alone.", metavar="JOINTS")
    ] = "upper",
    texture: Annotated[
        str, typer.Option(help="Joints that keep their motion and get detail.", metavar="JOINTS")
    ] = "lower",
    bands: Annotated[
        str, typer.Option(help="Bands of texture, 1 the highest; what is made anew has all from the first on.")
    ] = "2-3",
    match: Annotated[int, typer.Option(help="Band that is matched: 4 for walks, 6 for modern dance.")] = 4,
    cut: Annotated[str, typer.Option(help="Angle that cuts, like leftUpperLeg.x.", metavar="auto|JOINT.AXIS")] = "auto",
    keep: Annotated[float, typer.Option("--keep", "-K", help="Candidates: a share below 1, or a number.")] = 0.1,
    paths: Annotated[int, typer.Option(help="How many paths, each a file.")] = 1,
    apart: Annotated[
        bool, typer.Option("--apart", help="Paths that share nothing: dancers who differ, not the best few.")
    ] = False,
    weigh: Annotated[
        float, typer.Option(help="Cost of a join against matching less well; 0: the fewest joins, as published.")
    ] = 0.0,
    scale: Annotated[bool, typer.Option("--scale", help="Scale what is found as the driving angles ask.")] = False,
    join: Annotated[int, typer.Option(help="Samples (of 24 a second) beside a join that are smoothed.")] = 10,
    derivative: Annotated[float, typer.Option(help="Weight of derivatives in the matching.")] = 1.0,
    fps: Annotated[float | None, typer.Option(help="True rate of the motion capture where headers lie.")] = None,
    drop_frames: Annotated[int | None, typer.Option(help="Its leading frames to leave out. Default: T-poses.")] = None,
    sketch_fps: Annotated[float | None, typer.Option(help="SKETCH, a file: its true rate.")] = None,
    variation: Annotated[int, typer.Option(help="SKETCH, a step: which of its variations, from 1.")] = 1,
    rate: Annotated[float, typer.Option(help="Frames per second of what is written.")] = 60.0,
    report: Annotated[
        Path | None, typer.Option(help="Write what was taken from where, and figures.", metavar="FILE.json")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Write over files that are there.")] = False,
) -> None:
    """Texture a sketched motion, and complete it, from motion capture (after Pullen and Bregler 2002).

    The sketch is cut where one of its driving angles turns; for each piece the recordings are searched for the pieces
    that move most alike, and a path through these gives the joints to be made, and detail for the others. Feet stand
    where the sketch has them. JOINTS are words (upper, lower, hips, knees, ankles, pelvis, trunk, head, arms ...) or
    names of joints.
    """
    from live.app.offline.texture_run import Asked, make
    from live.app.option_values import parse_number
    from live.motion.texture.texture_settings import Wish, column_of, parse_bands, parse_drive, parse_joints

    parse_number(fps, "--fps", 1, 10_000)
    parse_number(sketch_fps, "--sketch-fps", 1, 10_000)
    parse_number(drop_frames, "--drop-frames", 0, 10_000_000)
    parse_number(rate, "--rate", 1, 1000)
    first, changes = parse_drive(drive, "--drive")
    driving = tuple(sorted({*first, *(joint for _, joints in changes for joint in joints)}))
    wish = Wish(
        drive=driving, changes=changes, first=first,
        synthesize=parse_joints(synthesize, "--synthesize"), texture=parse_joints(texture, "--texture"),
        bands=parse_bands(bands, "--bands"), match_band=match, cut=column_of(cut, "--cut", driving), keep=keep,
        paths=paths, apart=apart, weigh=weigh, scale=scale, reach=join, derivative=derivative,
    )  # fmt: skip
    make(
        Asked(
            sketch=sketch, places=tuple(with_), out=out, fps=fps, drop_frames=drop_frames, sketch_fps=sketch_fps,
            variation=variation, rate=rate, report=report, force=force,
        ),
        wish,
    )  # fmt: skip
