"""`live partner`: a follower for a leader's recorded motion, by example (Hsu, Gentry, Popovic)."""

from pathlib import Path
from typing import Annotated

import typer


def partner(
    leader: Annotated[Path | None, typer.Argument(help="The leader's motion: BVH, AMC, glTF, GLB, VRM, npz.")] = None,
    examples: Annotated[
        Path | None, typer.Option(help="Pairs of recordings to learn from.", metavar="PAIRS.toml")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write the follower here.", metavar="FOLLOWER.bvh")] = None,
    path: Annotated[
        Path | None, typer.Option(help="In place of a leader: a drawn path for a walker.", metavar="PATH.csv")
    ] = None,
    smooth: Annotated[
        float | None, typer.Option(help="Smooth the drawn path over so long. Default: 0.15.", metavar="SECONDS")
    ] = None,
    online: Annotated[bool, typer.Option("--online", help="Answer as it would be live, frame by frame.")] = False,
    stretch: Annotated[
        float | None, typer.Option(help="How much longer or shorter a unit may be. Default: 0.15, walks 0.2.")
    ] = None,
    k: Annotated[float | None, typer.Option("--k", help="What continuity counts. Default: 1, walks 4.")] = None,
    beam: Annotated[
        float | None, typer.Option(help="Give up what is worse than the best by this. Default: nothing.", metavar="W")
    ] = None,
    rate: Annotated[
        float | None, typer.Option(help="Frames a second of the search. Default: 7.5, walks 10.", metavar="HZ")
    ] = None,
    cluster: Annotated[
        float | None, typer.Option(help="Keep one of all units that are nearer to each other than this, in m (rms).")
    ] = None,
    fps: Annotated[
        float | None, typer.Option(help="The leader's true frame rate. Default: as the file or its like in PAIRS.toml.")
    ] = None,
    drop_frames: Annotated[
        int | None, typer.Option(help="Leading frames to leave out. Default: an added T-pose and its run-in.")
    ] = None,
    bpm: Annotated[float | None, typer.Option(help="The leader's tempo: units then begin on beats.")] = None,
    first_beat: Annotated[
        float | None, typer.Option(help="When a beat falls, from the first frame kept.", metavar="SECONDS")
    ] = None,
    smoothing: Annotated[str, typer.Option(help="How units are joined: eased, linear (as published), none.")] = "eased",
    hold_feet: Annotated[bool, typer.Option(help="Hold feet where the examples say they stand.")] = True,
    truth: Annotated[Path | None, typer.Option(help="What the real follower did, to compare.", metavar="FILE")] = None,
    report: Annotated[Path | None, typer.Option(help="Write figures here.", metavar="REPORT.json")] = None,
    transcript: Annotated[Path | None, typer.Option(help="Write the units as a score.", metavar="SCORE.txt")] = None,
    seed: Annotated[int, typer.Option(help="For which unit of a cluster is kept.")] = 0,
) -> None:
    """Answer a leader's motion with a follower's, read off recorded pairs.

    The leader is read as a row of recorded units, two beats each, stretched, turned and moved; their followers are
    joined to one motion that stands in the leader's own place on the floor, frame by frame beside the leader's file.
    """
    from live.app.option_values import parse_choice, parse_number, writable_file
    from live.base.errors import PersonError

    parse_number(stretch, "--stretch", 0, 2)
    parse_number(k, "--k", 0, 1e6)
    parse_number(beam, "--beam", 0, 1e9)
    parse_number(rate, "--rate", 1, 60)
    parse_number(cluster, "--cluster", 0, 10)
    parse_number(fps, "--fps", 1, 10_000)
    parse_number(drop_frames, "--drop-frames", 0, 10_000_000)
    parse_number(smooth, "--smooth", 0, 5)
    parse_number(bpm, "--bpm", 20, 400)
    parse_number(first_beat, "--first-beat", 0, 36_000)
    parse_choice(smoothing, "--smoothing", "eased", "linear", "none")
    if (leader is None) == (path is None):
        raise PersonError(
            "one leader expected: a motion file, or --path", "live partner LEADER.bvh --examples PAIRS.toml"
        )
    if examples is None or out is None:
        missing = "--examples PAIRS.toml" if examples is None else "--out FOLLOWER.bvh"
        raise PersonError(f"{missing} is missing", "live partner LEADER.bvh --examples PAIRS.toml --out FOLLOWER.bvh")
    if (bpm is None) != (first_beat is None):
        raise PersonError("--bpm and --first-beat: both or neither", "--bpm 163 --first-beat 0.61")
    for option, file in (("--out", out), ("--report", report), ("--transcript", transcript)):
        writable_file(file, option)
        if file is not None and any(
            one is not None and one.exists() and file.exists() and file.samefile(one)
            for one in (leader, examples, path, truth)
        ):
            raise PersonError(f"{option} {file}: that is a file to be read", "give the new file another name")

    from live.app.offline.partner_request import Wish
    from live.app.offline.partner_search import run

    run(Wish(
        leader=leader, examples=examples, out=out, path=path, online=online, stretch=stretch, k=k, beam=beam,
        rate=rate, cluster=cluster, fps=fps, drop_frames=drop_frames, bpm=bpm, first_beat=first_beat,
        smoothing=smoothing, hold_feet=hold_feet, truth=truth, report=report, transcript=transcript, seed=seed,
            smooth=smooth,
    ))  # fmt: skip
