"""Command `live replay`: replays a journal, compares the state of every measure, and can render it to a film."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from live.show.journal.journal_reader import Journal
    from live.show.journal.replay import ReplayResult


def replay(
    journal: Annotated[Path, typer.Argument(help="A journal written by --journal.")],
    verify: Annotated[
        bool, typer.Option("--verify", help="Exit 1 unless the state of every measure is bit-identical.")
    ] = False,
    first: Annotated[
        int, typer.Option("--from", min=1, help="Begin with this measure, from the snapshot before it.", metavar="N")
    ] = 1,
    last: Annotated[int | None, typer.Option("--to", min=1, help="End with this measure.", metavar="N")] = None,
    frames: Annotated[
        str | None,
        typer.Option(
            help="Film these frames: the first one and the one after the last, from 0, of the whole show.",
            metavar="A:B",
        ),
    ] = None,
    render: Annotated[
        Path | None,
        typer.Option(
            help="Render a film with sound (.mp4, .mov, .mkv, or a folder), or write the dancers' motion "
            "(.glb, .usdc, .bvh, .csv, .json).",
            metavar="FILE",
        ),
    ] = None,
    size: Annotated[str, typer.Option(help="Size of the film.", metavar="WxH")] = "1920x1080",
    fps: Annotated[str, typer.Option(help="Frames per second of the film: 25, 59.94, 24000/1001.", metavar="N")] = "60",
    fine: Annotated[bool, typer.Option("--fine", help="Render at GPU quality even without a GPU.")] = False,
    alpha: Annotated[
        bool,
        typer.Option(
            "--alpha", help="Film the dancers without the stage, on a transparent background (.mov, .mkv, PNG)."
        ),
    ] = False,
    workers: Annotated[
        int | None,
        typer.Option(min=1, max=256, help="Draw parts of the film in so many processes of this machine.", metavar="N"),
    ] = None,
    cluster: Annotated[
        str | None,
        typer.Option(help="Draw parts of the film on your own Dask cluster.", metavar="tcp://HOST:PORT"),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Replay a journal as fast as possible, and compare the state hash of every measure."""
    import json
    import time

    from rich.console import Console

    from live.app.film.film_names import parse_film_path, parse_frames, parse_rate
    from live.app.machine.kernel_warmup import warm_kernels
    from live.app.option_values import parse_size
    from live.base.errors import PersonError

    rate = parse_rate(fps) or 60.0
    picture = parse_size(size)
    if render is not None:
        render = parse_film_path(render, "--render", alpha=alpha, inputs=[str(journal)])
    if last is not None and last < first:
        raise PersonError(f"--from {first} --to {last}: the first measure is after the last")
    wanted = parse_frames(frames)
    _check_film_options(render, first, last, frames=frames, workers=workers, cluster=cluster)
    warm_kernels(Console(stderr=True))  # before modules with kernels are imported
    from live.base.jit import KERNEL_SET
    from live.clock.ticks import TICK
    from live.show.journal.journal_reader import JournalError, read_journal
    from live.show.journal.replay import ReplayError, load_journal, run_from, start_before

    problems: list[str] = []
    try:
        recorded = read_journal(journal)
        loaded = load_journal(recorded)
        start = start_before(recorded, loaded, first, problems) if render is None else None
    except (JournalError, ReplayError) as error:
        raise PersonError(str(error)) from None
    begin = time.perf_counter()
    if render is not None:
        from live.app.film.parted_film import film_journal
        from live.app.film.replay_film import FilmLook
        from live.clock.ticks import FrameGrid

        look = FilmLook(picture, FrameGrid(rate), fine=fine, alpha=alpha)
        result = film_journal(
            recorded, loaded, render, look, measures=(first, last), frames=wanted, workers=workers, cluster=cluster,
            problems=problems, console=Console(stderr=True, highlight=False),
        )  # fmt: skip
    if start is not None:
        result = run_from(start, recorded, loaded=loaded, to=last)
    made_with = recorded.header.get("kernels", KERNEL_SET)
    if result.different and made_with != KERNEL_SET:
        problems.append(f"recorded with other kernels: {made_with}; here: {KERNEL_SET}")
    result.problems[:0] = problems
    seconds = time.perf_counter() - begin
    if as_json:
        print(json.dumps(_facts(recorded, result, seconds)))
    else:
        _print_result(recorded, result, (result.ticks - result.first_tick) * TICK / max(seconds, 1e-9))
    if verify and not result.measures:
        raise PersonError(f"{journal}: nothing to compare: it has no complete measure")
    if verify and (result.different or result.problems):
        raise typer.Exit(1)


def _check_film_options(
    render: Path | None, first: int, last: int | None, *, frames: str | None, workers: int | None, cluster: str | None
) -> None:
    """Raise PersonError for options that do not fit together."""
    from live.base.errors import PersonError
    from live.library.motion_formats import stage_format

    given = {"--frames": frames, "--workers": workers, "--cluster": cluster}
    for option in (name for name, value in given.items() if value is not None):
        if render is None:
            raise PersonError(f"{option} is for films", f"{option} … --render film.mp4")
        if option != "--frames" and stage_format(render.suffix) is not None:
            raise PersonError(f"{option}: {render} has the dancers' motion, which is not drawn", f"leave {option} out")
    if frames is not None and (first > 1 or last is not None):
        raise PersonError("--frames and --from, --to both say which part it is", "give only one of them")


def _facts(journal: "Journal", result: "ReplayResult", seconds: float) -> dict[str, Any]:
    from live.clock.ticks import TICK

    length = (result.ticks - result.first_tick) * TICK
    return {
        "journal": str(journal.path),
        "complete": journal.complete,
        "seconds": length,
        "from_tick": result.first_tick,
        "measures": result.measures,
        "different": [{"measure": m, "tick": t, "then": then, "now": now} for m, t, then, now in result.differences],
        "measures_different": result.different,
        "measures_lacking": result.not_compared,
        "failed_events": result.failed,
        "problems": result.problems,
        "speed": length / seconds if seconds else None,
    }


def _print_result(journal: "Journal", result: "ReplayResult", speed: float) -> None:
    from rich.console import Console

    from live.clock.ticks import TICK

    console = Console(highlight=False)
    end = "" if journal.complete else " (the journal was cut off)"
    console.print(
        f"{(result.ticks - result.first_tick) * TICK:.1f} s, {result.measures} measures compared, {result.different} "
        f"differ{end}; {speed:.{0 if speed >= 10 else 2}f} times real time"
    )
    for measure, tick, then, now in result.differences[:10]:
        console.print(f"  measure {measure}, tick {tick}: {then} recorded, {now} replayed")
    for before, after in result.not_compared[:10]:
        console.print(f"  measures {before} to {after} are missing and were not compared", style="yellow")
    if result.failed:
        console.print(f"  {result.failed} events were rejected with an error, as in the show", style="yellow")
    for problem in result.problems[:10]:
        console.print(f"  {problem}", style="yellow", soft_wrap=True, markup=False)
    if len(result.problems) > 10:
        console.print(f"  and {len(result.problems) - 10} more that could not be used", style="yellow")
