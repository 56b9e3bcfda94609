"""Commands `live steps …`: add recordings to the step library, and list, show, check and play steps."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from live.cli.steps.cut import cut
from live.cli.steps.recording_options import (
    PANEL_FILE,
    PANEL_MUSIC,
    Anchor,
    BeatsPerMeasure,
    Bpm,
    Click,
    Count,
    DropFrames,
    FrameRate,
    Repair,
    Song,
    Unit,
    UpAxis,
)

app = typer.Typer(
    help="The step library: recordings and sketches, with their annotations and previews.",
    no_args_is_help=True,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)

PANEL_STEP = "Annotations of the step"

Library = Annotated[
    Path | None,
    typer.Option(
        "--library", help="A folder of steps. Default: yours and the built-in one.", metavar="DIR", file_okay=False
    ),
]
JsonOut = Annotated[bool, typer.Option("--json", help="Print JSON.")]


@app.command("add")
def add(
    file: Annotated[Path, typer.Argument(help="A recording: a motion file of any format (`live docs steps`).")],
    name: Annotated[str, typer.Option(help="The step's name; steps with the same name are variations.")],
    bpm: Bpm = None,
    anchor: Anchor = None,
    click: Click = None,
    count: Count = None,
    song: Song = None,
    beats_per_measure: BeatsPerMeasure = None,
    start: Annotated[
        int | None,
        typer.Option(help="Measure in which the step begins. Default: 1.", rich_help_panel=PANEL_MUSIC),
    ] = None,
    measures: Annotated[
        int | None, typer.Option(help="Length in measures. Default: 1.", rich_help_panel=PANEL_MUSIC)
    ] = None,
    fps: FrameRate = None,
    unit: Unit = None,
    up: UpAxis = None,
    skeleton: Annotated[
        Path | None,
        typer.Option(
            help="The file with its skeleton, as for .amc. Default: the one next to it.", rich_help_panel=PANEL_FILE
        ),
    ] = None,
    drop_frames: DropFrames = None,
    repair: Repair = False,
    leading_foot: Annotated[
        Literal["left", "right"] | None,
        typer.Option(help="The foot that begins.", rich_help_panel=PANEL_STEP),
    ] = None,
    begin_pose: Annotated[
        str | None, typer.Option(help="Name of the pose in which it begins.", rich_help_panel=PANEL_STEP)
    ] = None,
    end_pose: Annotated[
        str | None, typer.Option(help="Name of the pose in which it ends.", rich_help_panel=PANEL_STEP)
    ] = None,
    weight_transfer: Annotated[
        bool,
        typer.Option(
            "--weight-transfer",
            help="It ends on the other foot, so repeats alternate sides.",
            rich_help_panel=PANEL_STEP,
        ),
    ] = False,
    direction: Annotated[
        str | None, typer.Option(help='Such as "long left". Default: measured.', rich_help_panel=PANEL_STEP)
    ] = None,
    distance: Annotated[
        float | None, typer.Option(help="Distance in metres. Default: measured.", rich_help_panel=PANEL_STEP)
    ] = None,
    author: Annotated[str | None, typer.Option(help="Name of the dancer.", rich_help_panel=PANEL_STEP)] = None,
    style: Annotated[str | None, typer.Option(help="Dance style.", rich_help_panel=PANEL_STEP)] = None,
    tag: Annotated[list[str] | None, typer.Option(help="A tag; may be repeated.", rich_help_panel=PANEL_STEP)] = None,
    mirror: Annotated[
        bool, typer.Option("--mirror", help="Also add the mirror image as a variation.", rich_help_panel=PANEL_STEP)
    ] = False,
    library: Library = None,
) -> None:
    """Cut a step out of a recording and add it to the library.

    The recording is copied to the library, and a table "step" is added to the TOML file of its name. Nothing is
    written unless the step can be cut, and no existing file is overwritten.
    """
    from live.app.offline.step_adding import ClapReference, add_to_library

    given = {
        "name": name, "skeleton": None if skeleton is None else str(skeleton), "fps": fps, "unit_m": unit, "up": up,
        "drop_frames": drop_frames, "repair": repair or None, "bpm": bpm, "first_beat_s": anchor,
        "beats_per_measure": beats_per_measure, "start_measure": start, "measures": measures,
        "leading_foot": leading_foot, "begin_pose": begin_pose, "end_pose": end_pose,
        "weight_transfer": weight_transfer or None, "direction": direction, "distance_m": distance, "author": author,
        "style": style, "tags": tag or None, "mirror": mirror or None,
    }  # fmt: skip
    fields = {key: value for key, value in given.items() if value is not None}
    add_to_library(file, fields, library, ClapReference(click=click, count=count, song=song))


app.command("cut")(cut)


@app.command("list")
def list_(library: Library = None, json_out: JsonOut = False) -> None:
    """List the steps: name, variations, length, tempo, directions, feet, poses, tags."""
    from live.app.offline.step_report import print_list

    print_list(library, json_out)


@app.command("show")
def show(
    step: Annotated[str, typer.Argument(help="The step's name.")],
    library: Library = None,
    json_out: JsonOut = False,
    reach: Annotated[
        Path | None,
        typer.Option(help="Draw the region reachable in one measure, from above.", metavar="OUT.svg|OUT.png"),
    ] = None,
) -> None:
    """Show a step: its annotations, variations, foot contacts on the beats, and possible next steps."""
    from live.app.offline.step_report import print_step

    if reach is not None:
        from live.app.offline.step_report import write_reach

        write_reach(step, library, reach)
    print_step(step, library, json_out)


@app.command("graph")
def graph(
    library: Annotated[
        Path | None,
        typer.Argument(help="A folder of steps. Default: yours and the built-in one.", metavar="[LIBRARY]"),
    ] = None,
    json_out: JsonOut = False,
    dot: Annotated[bool, typer.Option("--dot", help="Print the structural variations as Graphviz text.")] = False,
    svg: Annotated[Path | None, typer.Option(help="Draw the steps and their transitions.", metavar="OUT.svg")] = None,
    threshold: Annotated[float | None, typer.Option(help="Maximum distance of joined poses in metres.")] = None,
    window: Annotated[
        float | None, typer.Option(help="Length of a transition as a share of the measure. Default: 0.75 beats.")
    ] = None,
    bridges: Annotated[
        bool, typer.Option("--bridges", help="Search the recordings for motion that would join unconnected steps.")
    ] = False,
) -> None:
    """Show the motion graph: transitions between steps, their distances, dead ends, and missing transitions."""
    from live.app.offline.graph_report import print_graph
    from live.app.option_values import check_range, check_writable
    from live.base.errors import PersonError

    check_range(threshold, "--threshold", 0.001, 10)
    check_range(window, "--window", 0.01, 0.9)
    if svg is not None and svg.suffix.lower() != ".svg":
        raise PersonError(f"--svg {svg}: a name that ends in .svg expected", f"--svg {svg.with_suffix('.svg')}")
    if json_out and dot:
        raise PersonError("--json and --dot exclude each other", "leave one of them out")
    check_writable(svg, "--svg")
    print_graph(library, as_json=json_out, as_dot=dot, svg=svg, threshold=threshold, window=window, bridges=bridges)


@app.command("check")
def check(library: Library = None, json_out: JsonOut = False) -> None:
    """Report errors and warnings of a library. Exit 1 if a step in it cannot be danced."""
    from live.app.offline.step_report import print_findings

    if print_findings(library, json_out):
        raise typer.Exit(1)


@app.command("enrich")
def enrich(
    with_: Annotated[
        list[Path] | None,
        typer.Option("--with", help="Motion capture files or folders; may be repeated.", metavar="PLACE"),
    ] = None,
    library: Library = None,
    step: Annotated[list[str] | None, typer.Option(help="Only this step; may be repeated.")] = None,
    paths: Annotated[int, typer.Option(min=1, max=16, help="Textured versions of each variation.")] = 2,
    bands: Annotated[str, typer.Option(help="Bands of texture, 1 the highest.")] = "2-3",
    match: Annotated[int, typer.Option(help="Band that is matched: 4 for walks, 6 for modern dance.")] = 4,
    drive: Annotated[str, typer.Option(help="Joints whose angles are matched.", metavar="JOINTS")] = "hips,knees",
    upper: Annotated[
        Literal["auto", "make", "texture"],
        typer.Option(help="Upper bodies: synthesised or textured; auto: synthesised unless the sketch animates them."),
    ] = "auto",
    weigh: Annotated[float, typer.Option(help="Cost of a join; 0: the fewest joins, as published.")] = 2.0,
    published: Annotated[
        bool,
        typer.Option("--published", help="New upper bodies from the recordings alone, as published; else learnt."),
    ] = False,
    fps: Annotated[
        float | None, typer.Option(help="True frame rate of the motion capture, if headers are wrong.")
    ] = None,
    remove: Annotated[bool, typer.Option("--remove", help="Remove the textured versions.")] = False,
) -> None:
    """Write textured versions of every sketched step, with upper bodies and detail of real dancers.

    They are stored next to the sketch (walk.textured next to walk.toml), are used as other takes of the same step, and
    begin and end at the same place as the sketch. They contain the motion capture data they need.
    """
    from live.base.system.blas_threads import use_one_blas_thread

    use_one_blas_thread()
    from live.app.offline.texture_run import enrich_library
    from live.app.option_values import check_range
    from live.motion.texture.texture_settings import TextureSettings, parse_bands, parse_joints

    check_range(fps, "--fps", 1, 10_000)
    wish = TextureSettings(
        drive=parse_joints(drive, "--drive"), bands=parse_bands(bands, "--bands"), match_band=match, paths=paths,
        distinct_paths=True, join_weight=weigh, learnt=not published,
    )  # fmt: skip
    enrich_library(library, with_ or [], step or [], wish, upper, fps=fps, remove=remove)


@app.command("play")
def play(
    step: Annotated[str, typer.Argument(help="The step's name.")],
    library: Library = None,
    variation: Annotated[int | None, typer.Option(min=1, help="Only this variation (see `live steps show`).")] = None,
    tempo: Annotated[float | None, typer.Option(help="Beats per minute. Default: the step's own.")] = None,
    seconds: Annotated[float | None, typer.Option(help="Duration in seconds.")] = None,
    travel: Annotated[bool, typer.Option("--travel", help="Let dancers travel. Default: they dance in place.")] = False,
    headless: Annotated[
        bool, typer.Option("--headless", help="No window: run in real time without a picture.")
    ] = False,
    film: Annotated[Path | None, typer.Option(help="Render a film instead.", metavar="OUT.mp4")] = None,
    monitor: Annotated[str | None, typer.Option(help="Monitor by number or name.", metavar="N|NAME")] = None,
    fullscreen: Annotated[bool, typer.Option("--fullscreen", help="Full screen.")] = False,
    size: Annotated[str, typer.Option(help="Size of the window or film.", metavar="WxH")] = "1280x720",
    fps: Annotated[float | None, typer.Option(help="Frames per second.")] = None,
) -> None:
    """Loop a step on the stage, with a dancer for each variation."""
    from live.app.offline.step_preview import Preview, play_step
    from live.app.option_values import check_film_path, check_range, check_writable, parse_size

    check_range(tempo, "--tempo", 20, 400)
    check_range(seconds, "--seconds", 0.1, 7 * 86400)
    check_range(fps, "--fps", 1, 480)
    check_writable(film, "--film")
    check_film_path(film, "--film", inputs=[])
    play_step(
        Preview(
            step=step, library=library, variation=variation, tempo=tempo, seconds=seconds, travel=travel,
            headless=headless, film=film, monitor=monitor, fullscreen=fullscreen, size=parse_size(size), fps=fps,
        )
    )  # fmt: skip
