"""`live check`: is this patch good? Names file, line, field and remedy if it is not."""

from pathlib import Path
from typing import Annotated

import typer


def check(
    patch: Annotated[str | None, typer.Argument(help="A patch. Default: the first show.")] = None,
    steps: Annotated[
        Path | None, typer.Option(help="Check it with the recordings of this folder.", file_okay=False)
    ] = None,
) -> None:
    """Check a patch with its steps and music, without playing it."""
    from rich.console import Console

    from live.base.errors import PersonError
    from live.cli.session_sound import choose_sound
    from live.cli.wish import Wish
    from live.show.rehearsing import rehearsal_notes

    wish = Wish(patch=patch, steps=steps)
    loaded = wish.load()
    show = loaded.start()
    choose_sound(wish, loaded)
    library, graph = loaded.graph.library, loaded.graph
    console = Console(highlight=False)
    if graph.missing:
        raise PersonError("; ".join(graph.missing), "raise locomotion.threshold_m, or change those steps' ends")
    for note in rehearsal_notes(show):
        console.print(f"note: {note}", style="yellow", soft_wrap=True, markup=False)
    console.print(
        f"ok {loaded.path}: {loaded.patch.name!r}, {loaded.patch.dancer_count} dancers in "
        f"{len(loaded.patch.group)} groups, {len(library.steps)} steps, {library.node_count} measures, "
        f"{graph.edge_count} transitions",
        style="green",
        soft_wrap=True,
        markup=False,
    )
