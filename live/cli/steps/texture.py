"""Command `live texture`: adds detail and missing joints from motion capture to a sketched motion."""

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
        typer.Option("--with", help="Motion capture files or folders; may be repeated.", metavar="PLACE"),
    ],
    out: Annotated[
        Path, typer.Option(help="The file to write; numbered if there are several paths.", metavar="OUT.bvh|OUT.glb")
    ],
    drive: Annotated[
        str,
        typer.Option(
            help="Joints that drive: auto (chosen by cross-validation; hips and knees are matched), or joints with "
            'changes at times: "hips,knees @2.5 knees @4 hips".',
            metavar="auto|JOINTS",
        ),
    ] = "auto",
    synthesize: Annotated[
        str, typer.Option(help="Joints synthesised from motion capture only.", metavar="JOINTS")
    ] = "upper",
    texture: Annotated[
        str, typer.Option(help="Joints that keep their motion and get detail.", metavar="JOINTS")
    ] = "lower",
    bands: Annotated[
        str, typer.Option(help="Bands of texture, 1 the highest; synthesised joints use all from the first on.")
    ] = "2-3",
    match: Annotated[int, typer.Option(help="Band that is matched: 4 for walks, 6 for modern dance.")] = 4,
    cut: Annotated[
        str,
        typer.Option(help="Angle at whose turns the sketch is cut, such as leftUpperLeg.x.", metavar="auto|JOINT.AXIS"),
    ] = "auto",
    keep: Annotated[float, typer.Option("--keep", "-K", help="Candidates: a share below 1, or a number.")] = 0.1,
    paths: Annotated[int, typer.Option(help="Number of paths, each written to a file.")] = 1,
    apart: Annotated[
        bool,
        typer.Option("--apart", help="Paths without common pieces, for different dancers, instead of the best paths."),
    ] = False,
    weigh: Annotated[
        float, typer.Option(help="Cost of a join relative to the matching cost; 0: the fewest joins, as published.")
    ] = 0.0,
    published: Annotated[
        bool,
        typer.Option("--published", help="Synthesised joints from the recordings alone, as published; else learnt."),
    ] = False,
    spread: Annotated[
        float, typer.Option(help="Liveliness of learnt joints: 0 steady, 1 as far from real ones as a still pose.")
    ] = 0.25,
    scale: Annotated[bool, typer.Option("--scale", help="Scale the pieces to match the driving angles.")] = False,
    join: Annotated[int, typer.Option(help="Samples (24 per second) smoothed on each side of a join.")] = 10,
    derivative: Annotated[float, typer.Option(help="Weight of derivatives in the matching.")] = 1.0,
    fps: Annotated[
        float | None, typer.Option(help="True frame rate of the motion capture, if headers are wrong.")
    ] = None,
    drop_frames: Annotated[
        int | None, typer.Option(help="Leading motion capture frames to leave out. Default: T-poses.")
    ] = None,
    sketch_fps: Annotated[float | None, typer.Option(help="SKETCH, a file: its true frame rate.")] = None,
    variation: Annotated[int, typer.Option(help="SKETCH, a step: number of the variation, from 1.")] = 1,
    rate: Annotated[float, typer.Option(help="Frames per second of the output.")] = 60.0,
    report: Annotated[
        Path | None, typer.Option(help="Write the sources of the pieces, and figures.", metavar="FILE.json")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite existing files.")] = False,
) -> None:
    """Texture a sketched motion, and complete it, from motion capture (after Pullen and Bregler 2002).

    The sketch is cut where one of its driving angles turns. For each piece, the most similar pieces of the recordings
    are found. A path through these gives detail. Synthesised joints do what the sketch's legs and hips tell of them, as
    far as that holds at recordings left out, with variation from the path; what is not told stays in the mean pose. The
    program says what is told. With --published they come from the path alone. Feet stay where they are in the sketch.
    JOINTS are words (upper, lower, hips, knees, ankles, pelvis, trunk, head, arms ...) or joint names.
    """
    from live.base.system.blas_threads import use_one_blas_thread

    use_one_blas_thread()
    from live.app.offline.texture_run import TextureOptions, run_texture
    from live.app.option_values import check_range
    from live.motion.texture.texture_settings import (
        TextureSettings,
        parse_bands,
        parse_column,
        parse_drive,
        parse_joints,
    )

    check_range(fps, "--fps", 1, 10_000)
    check_range(sketch_fps, "--sketch-fps", 1, 10_000)
    check_range(drop_frames, "--drop-frames", 0, 10_000_000)
    check_range(rate, "--rate", 1, 1000)
    chosen = drive.strip().casefold() == "auto"
    first, changes = parse_drive("hips,knees" if chosen else drive, "--drive")
    driving = tuple(sorted({*first, *(joint for _, joints in changes for joint in joints)}))
    wish = TextureSettings(
        drive=driving, drive_changes=changes, initial_drive=first,
        synthesize=parse_joints(synthesize, "--synthesize"), texture=parse_joints(texture, "--texture"),
        bands=parse_bands(bands, "--bands"), match_band=match, cut=parse_column(cut, "--cut", driving), keep=keep,
        paths=paths, distinct_paths=apart, join_weight=weigh, scale=scale, reach=join, derivative=derivative,
        learnt=not published, learnt_drive=() if chosen else driving, spread=spread,
    )  # fmt: skip
    run_texture(
        TextureOptions(
            sketch=sketch, places=tuple(with_), out=out, fps=fps, drop_frames=drop_frames, sketch_fps=sketch_fps,
            variation=variation, rate=rate, report=report, force=force,
        ),
        wish,
    )  # fmt: skip
