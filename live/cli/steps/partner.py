"""Command `live partner`: synthesises a follower for a leader's motion from examples (Hsu, Gentry, Popovic)."""

from pathlib import Path
from typing import Annotated

import typer


def partner(
    leader: Annotated[Path | None, typer.Argument(help="The leader's motion: a file of any format.")] = None,
    examples: Annotated[
        Path | None, typer.Option(help="Pairs of recordings to learn from.", metavar="PAIRS.toml")
    ] = None,
    style: Annotated[
        str | None, typer.Option(help="Dance only pairs of this style, and those without one.", metavar="NAME")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write the follower here.", metavar="FOLLOWER.bvh")] = None,
    path: Annotated[
        Path | None, typer.Option(help="A drawn path for a walker, instead of a leader.", metavar="PATH.csv")
    ] = None,
    smooth: Annotated[
        float | None, typer.Option(help="Smoothing time of the drawn path. Default: 0.15.", metavar="SECONDS")
    ] = None,
    online: Annotated[bool, typer.Option("--online", help="Decode causally, frame by frame, as in a show.")] = False,
    stretch: Annotated[
        float | None, typer.Option(help="Maximum change of a unit's length, as a share. Default: 0.15, walks 0.2.")
    ] = None,
    k: Annotated[float | None, typer.Option("--k", help="Weight of continuity. Default: 1, walks 4.")] = None,
    beam: Annotated[
        float | None,
        typer.Option(help="Prune hypotheses worse than the best by this cost. Default: no pruning.", metavar="W"),
    ] = None,
    rate: Annotated[
        float | None, typer.Option(help="Frames per second of the search. Default: 7.5, walks 10.", metavar="HZ")
    ] = None,
    cluster: Annotated[
        float | None, typer.Option(help="Keep one unit of each cluster within this distance, in m (rms).")
    ] = None,
    fps: Annotated[
        float | None,
        typer.Option(help="The leader's true frame rate. Default: as in the file or similar files in PAIRS.toml."),
    ] = None,
    drop_frames: Annotated[
        int | None, typer.Option(help="Leading frames to leave out. Default: an added T-pose and its run-in.")
    ] = None,
    bpm: Annotated[float | None, typer.Option(help="The leader's tempo; units then begin on beats.")] = None,
    first_beat: Annotated[
        float | None, typer.Option(help="Time of a beat, from the first kept frame.", metavar="SECONDS")
    ] = None,
    smoothing: Annotated[str, typer.Option(help="Blend between units: eased, linear (as published), none.")] = "eased",
    hold_feet: Annotated[bool, typer.Option(help="Lock feet that are planted in the examples.")] = True,
    truth: Annotated[
        Path | None, typer.Option(help="The real follower's motion, for comparison.", metavar="FILE")
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write figures here.", metavar="REPORT.json")] = None,
    transcript: Annotated[Path | None, typer.Option(help="Write the units as a score.", metavar="SCORE.txt")] = None,
    seed: Annotated[int, typer.Option(help="Random seed of the clustering.")] = 0,
) -> None:
    """Synthesise a follower's motion for a leader's, from recorded pairs.

    The leader's motion is matched by a sequence of recorded units of two beats, stretched, turned and moved. Their
    followers are joined to one motion in the leader's coordinates, with the frames of the leader's file.
    """
    from live.app.option_values import check_choice, check_range, check_writable
    from live.base.errors import PersonError

    check_range(stretch, "--stretch", 0, 2)
    check_range(k, "--k", 0, 1e6)
    check_range(beam, "--beam", 0, 1e9)
    check_range(rate, "--rate", 1, 60)
    check_range(cluster, "--cluster", 0, 10)
    check_range(fps, "--fps", 1, 10_000)
    check_range(drop_frames, "--drop-frames", 0, 10_000_000)
    check_range(smooth, "--smooth", 0, 5)
    check_range(bpm, "--bpm", 20, 400)
    check_range(first_beat, "--first-beat", 0, 36_000)
    check_choice(smoothing, "--smoothing", "eased", "linear", "none")
    if (leader is None) == (path is None):
        raise PersonError(
            "one leader expected: either a motion file or --path", "live partner LEADER.bvh --examples PAIRS.toml"
        )
    if examples is None or out is None:
        missing = "--examples PAIRS.toml" if examples is None else "--out FOLLOWER.bvh"
        raise PersonError(f"{missing} is missing", "live partner LEADER.bvh --examples PAIRS.toml --out FOLLOWER.bvh")
    if (bpm is None) != (first_beat is None):
        raise PersonError("--bpm and --first-beat: both or neither", "--bpm 163 --first-beat 0.61")
    for option, file in (("--out", out), ("--report", report), ("--transcript", transcript)):
        check_writable(file, option)
        if file is not None and any(
            one is not None and one.exists() and file.exists() and file.samefile(one)
            for one in (leader, examples, path, truth)
        ):
            raise PersonError(f"{option} {file}: that is an input file", "give the new file another name")

    from live.app.offline.partner_request import PartnerOptions
    from live.app.offline.partner_search import run_partner

    run_partner(PartnerOptions(
        leader=leader, examples=examples, out=out, path=path, online=online, stretch=stretch, k=k, beam=beam,
        rate=rate, cluster=cluster, fps=fps, drop_frames=drop_frames, bpm=bpm, first_beat=first_beat,
        smoothing=smoothing, hold_feet=hold_feet, truth=truth, report=report, transcript=transcript, seed=seed,
            smooth=smooth, style=style,
    ))  # fmt: skip
