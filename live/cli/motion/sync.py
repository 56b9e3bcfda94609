"""Command `live sync`: finds the beats of a recorded dance from claps, a click, a song, or the feet."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

if TYPE_CHECKING:
    from live.library.beat_alignment import SyncResult


def sync(
    file: Annotated[Path, typer.Argument(help="A recording: a motion file of any format (`live docs steps`).")],
    click: Annotated[
        float | None, typer.Option(help="Tempo of the click that the claps follow.", metavar="BPM")
    ] = None,
    count: Annotated[int | None, typer.Option(help="Number of clapped beats of the click.")] = None,
    song: Annotated[Path | None, typer.Option(help="The music that the claps follow.", metavar="AUDIO")] = None,
    anchor: Annotated[
        float | None, typer.Option(help="Known start of measure 1; overrides the estimate.", metavar="SECONDS")
    ] = None,
    bpm: Annotated[float | None, typer.Option(help="Known tempo; overrides the estimate.")] = None,
    beats_per_measure: Annotated[int, typer.Option(help="Beats per measure.")] = 4,
    fps: Annotated[float | None, typer.Option(help="True frame rate, if the header is wrong.")] = None,
    up: Annotated[Literal["Y", "Z"] | None, typer.Option(help="The axis that points up.")] = None,
    skeleton: Annotated[
        Path | None, typer.Option(help="The file with its skeleton, as for .amc. Default: the one next to it.")
    ] = None,
    drop_frames: Annotated[
        int | None, typer.Option(help="Leading frames to leave out. Default: an added T-pose and its run-in.")
    ] = None,
    json_out: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Find the first beat and the tempo of a recorded dance, and print the lines for its TOML file.

    Times count from the first kept frame. Clap on the beats before you dance; with --click or --song, claps are
    matched to its beats. Without claps, the beats are estimated from the feet; confirm that estimate.
    """
    from live.app.option_values import check_range
    from live.base.errors import PersonError
    from live.library.beat_alignment import SyncRequest, find_sync

    check_range(click, "--click", 20, 400)
    check_range(bpm, "--bpm", 20, 400)
    check_range(count, "--count", 1, 1000)
    check_range(anchor, "--anchor", 0, 36_000)
    check_range(beats_per_measure, "--beats-per-measure", 1, 16)
    check_range(fps, "--fps", 1, 10_000)
    check_range(drop_frames, "--drop-frames", 0, 10_000_000)
    if click is not None and song is not None:
        raise PersonError("--click and --song exclude each other", "--click for a click, --song for a music file")
    if count is not None and click is None:
        raise PersonError("--count counts the beats of a click", f"--click BPM --count {count}")
    found = find_sync(
        SyncRequest(
            file=file,
            skeleton=skeleton,
            fps=fps,
            up=up,
            drop_frames=drop_frames,
            click_bpm=click,
            count=count,
            song=song,
            anchor_s=anchor,
            bpm=bpm,
            beats_per_measure=beats_per_measure,
        )
    )
    if json_out:
        import json

        print(json.dumps(_as_json(found)))
    else:
        _print(found, _toml_lines(found, file, fps, beats_per_measure, by_hand=(bpm is not None, anchor is not None)))


def _as_json(found: "SyncResult") -> dict[str, Any]:
    reference = found.reference
    return {
        "first_beat_s": round(reference.first_beat_s, 4),
        "bpm": round(reference.bpm, 3),
        "confidence": round(reference.confidence, 3),
        "source": reference.source,
        "note": reference.note,
        "drop_frames": found.drop_frames,
        "fps": found.fps,
        "doubt": found.doubt,
        "claps": [
            {
                "time_s": round(one.clap.time_s, 4),
                "beat": one.beat,
                "residual_ms": None if one.residual_ms is None else round(one.residual_ms, 1),
                "distance_m": round(one.clap.distance_m, 3),
            }
            for one in found.claps
        ],
    }


def _toml_lines(
    found: "SyncResult", file: Path, fps: float | None, beats_per_measure: int, *, by_hand: tuple[bool, bool]
) -> list[str]:
    """Return lines for the recording's TOML file; `by_hand`: whether tempo and first beat were given by the user."""
    notes = ["" if one else f" # {found.comment}" for one in by_hand]
    lines = [f"file = {_quoted(file.name)}"]
    if fps is not None:
        lines.append(f"fps = {fps:g}")
    if found.drop_frames:
        lines.append(f"drop_frames = {found.drop_frames}")
    lines += [f"bpm = {found.reference.bpm:.3f}".rstrip("0").rstrip(".") + notes[0]]
    lines += [f"first_beat_s = {found.reference.first_beat_s:.4f}{notes[1]}"]
    return [*lines, f"beats_per_measure = {beats_per_measure}"] if beats_per_measure != 4 else lines


def _quoted(text: str) -> str:
    import json

    return json.dumps(text.encode("utf-8", "replace").decode("utf-8"), ensure_ascii=False)


def _print(found: "SyncResult", toml: list[str]) -> None:
    from rich.console import Console

    reference = found.reference
    console = Console(highlight=False, soft_wrap=True, markup=False)
    console.print(f"first beat {reference.first_beat_s:.3f} s, {reference.bpm:.2f} bpm")
    console.print(f"confidence {reference.confidence:.2f} ({reference.source}): {reference.note}")
    if found.doubt:
        console.print(f"doubtful: {found.doubt}", style="yellow")
    for one in found.claps:
        place = "no beat" if one.beat is None else f"beat {one.beat}, {one.residual_ms:+.0f} ms"
        console.print(f"  clap {one.clap.time_s:8.3f} s  {place}", style="dim" if one.beat is None else None)
    if found.drop_frames:
        dropped = found.drop_frames
        words = f"times count from frame {dropped}, after a T-pose; with --anchor, also give --drop-frames {dropped}"
        console.print(words, style="dim")
    console.print("\n".join(["", *toml]))
