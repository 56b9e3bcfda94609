"""Commands `live couple`: recorded couples seen by a choreographer: compared with answers, labelled, notated."""

from pathlib import Path
from typing import Annotated

import typer

from live.cli.play import STUDIO_PORT, open_browser_later, studio_link

app = typer.Typer(
    no_args_is_help=True,
    help="Recorded couples: compare the answers to their leaders, label their patterns, write down what they dance.",
)

Pairs = Annotated[Path, typer.Argument(help="Pairs of recordings.", metavar="PAIRS.toml")]
Take = Annotated[str | None, typer.Option(help="One take, by its name or number. Default: all.", metavar="NAME")]
First = Annotated[int, typer.Option(help="The beat that is a one, from 1.", metavar="BEAT")]


@app.command()
def compare(
    pairs: Pairs,
    take: Take = None,
    online: Annotated[bool, typer.Option("--online", help="Answer frame by frame, as in a show.")] = False,
    style: Annotated[
        str | None, typer.Option(help="Only pairs of this style, and those without one.", metavar="NAME")
    ] = None,
    first: First = 1,
    labels: Annotated[
        Path | None,
        typer.Option(help="Patterns, labelled by a person. Default: PAIRS.labels.toml.", metavar="LABELS.toml"),
    ] = None,
    film: Annotated[Path | None, typer.Option(help="Film the answer over the real couple.", metavar="FILM.mp4")] = None,
    size: Annotated[str, typer.Option(help="Size of the film.", metavar="WIDTHxHEIGHT")] = "1280x720",
    fps: Annotated[float, typer.Option(help="Pictures per second of the film.")] = 30.0,
    notation: Annotated[
        Path | None, typer.Option(help="Write what the answer dances, count by count.", metavar="FILE.txt")
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write the figures here.", metavar="REPORT.json")] = None,
) -> None:
    """Answer the leader of each take from the other takes, and compare with the real follower.

    The table has the joints, the facing, stances and turns, and each pattern of eight beats. Patterns have the labels
    that a person gave them (`live couple label`); without any they are recognised. `=` marks a pattern that is wholly
    the same, `~` one that is so for most of the time, `?` one that is answered with units without a label.
    """
    from rich.console import Console

    from live.app.offline.couple_compare import CompareOptions, run_compare
    from live.app.option_values import check_film_path, check_range, check_writable, parse_size

    check_range(first, "--first", 1, 10_000)
    check_range(fps, "--fps", 1, 240)
    for option, file in (("--notation", notation), ("--report", report)):
        check_writable(file, option)
    check_film_path(film, "--film", inputs=[str(pairs)])
    run_compare(
        CompareOptions(
            pairs=pairs, take=take, online=online, style=style, first=first, labels=labels, film=film, report=report,
            notation=notation, size=parse_size(size), fps=fps,
        ),
        Console(stderr=True, highlight=False),
    )  # fmt: skip


@app.command()
def notation(
    pairs: Pairs,
    take: Take = None,
    first: First = 1,
    out: Annotated[
        Path | None, typer.Option(help="Write the text here. Default: print it.", metavar="FILE.txt")
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write it as JSON, too.", metavar="FILE.json")] = None,
) -> None:
    """Write down what recorded couples dance, count by count, in words of Labanotation.

    Of each dancer: the foot that takes the weight, the direction, the level, and the turn in eighths; of the couple:
    held hands (the leader's first), stance and turn.
    """
    from live.app.offline.couple_compare import run_notation
    from live.app.option_values import check_range, check_writable

    check_range(first, "--first", 1, 10_000)
    for option, file in (("--out", out), ("--report", report)):
        check_writable(file, option)
    run_notation(pairs, take, first=first, out=out, report=report)


@app.command()
def label(
    pairs: Pairs,
    labels: Annotated[
        Path | None, typer.Option(help="Where the labels are. Default: PAIRS.labels.toml.", metavar="LABELS.toml")
    ] = None,
    web: Annotated[str, typer.Option(help="Where the page is served.", metavar="[HOST:]PORT")] = str(STUDIO_PORT),
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
) -> None:
    """Label the patterns of recorded couples, by keys, while they dance on a page of the studio.

    A pattern is eight beats. Each change is written at once to a file beside the pairs; `live couple compare` reads it.
    Ctrl-C ends it.
    """
    import sys

    from live.app.option_values import check_writable, parse_endpoint
    from live.app.services.http_services import stored_key
    from live.app.services.label_page import open_desk, serve_labels

    check_writable(labels, "--labels")
    desk = open_desk(pairs, labels)
    key, where = stored_key(), parse_endpoint(web, "--web")
    print(f"labels: {studio_link(where, key)}", file=sys.stderr)
    if browser:
        open_browser_later(where, key)
    serve_labels(desk, where, key)
