"""`live replay`: run a journal again and compare the state of every measure."""

from pathlib import Path
from typing import Annotated

import typer


def replay(
    journal: Annotated[Path, typer.Argument(help="A journal written by --journal.")],
    verify: Annotated[
        bool, typer.Option("--verify", help="Exit 1 unless every measure's state is the same, bit for bit.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Replay a journal as fast as the machine can, and compare the state hash of every measure."""
    import json
    import time

    from rich.console import Console

    from live.base.errors import PersonError
    from live.cli.warm import warm_kernels
    from live.clock.ticks import TICK
    from live.show.journal import JournalError, read_journal
    from live.show.replay import ReplayError, reload, replay

    warm_kernels(Console(stderr=True))
    try:
        recorded = read_journal(journal)
        show = reload(recorded)
    except (JournalError, ReplayError) as error:
        raise PersonError(str(error)) from None
    begin = time.perf_counter()
    try:
        result = replay(show, recorded)
    except ReplayError as error:
        raise PersonError(f"{journal}: {error}") from None
    seconds = time.perf_counter() - begin
    length = result.ticks * TICK
    if as_json:
        print(
            json.dumps(
                {
                    "journal": str(journal),
                    "complete": recorded.complete,
                    "seconds": length,
                    "measures": result.measures,
                    "different": [
                        {"measure": m, "tick": t, "then": then, "now": now} for m, t, then, now in result.differences
                    ],
                    "speed": length / seconds if seconds else None,
                }
            )
        )
    else:
        console = Console(highlight=False)
        end = "" if recorded.complete else " (the journal was cut off)"
        console.print(
            f"{length:.1f} s, {result.measures} measures compared, {len(result.differences)} differ{end}; "
            f"{length / max(seconds, 1e-9):.0f} times as fast as life"
        )
        for measure, tick, then, now in result.differences[:10]:
            console.print(f"  measure {measure}, tick {tick}: {then} then, {now} now")
    if verify and not result.measures:
        raise PersonError(f"{journal}: nothing to compare: no measure was finished in it")
    if verify and result.differences:
        raise typer.Exit(1)
