"""Command `live check`: checks a patch, and with --venue the hall; errors name file, line, field and remedy."""

from pathlib import Path
from typing import Annotated

import typer


def check(
    patch: Annotated[str | None, typer.Argument(help="A patch. Default: the first show.")] = None,
    steps: Annotated[
        Path | None, typer.Option(help="Check with the recordings of this folder.", file_okay=False)
    ] = None,
    venue: Annotated[
        str | None, typer.Option(help="Also check the hall: devices, ports, monitors, disk space.", metavar="NAME")
    ] = None,
    osc: Annotated[str, typer.Option(help="The show's OSC address.", metavar="HOST:PORT")] = "127.0.0.1:9010",
    as_json: Annotated[bool, typer.Option("--json", help="Print all checks of --venue as one JSON object.")] = False,
) -> None:
    """Check a patch with its steps and music, without playing it; with --venue, also the hall's equipment.

    Exit 1 if something required is missing.
    """
    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels
    from live.base.errors import PersonError
    from live.show.patch.patch_search_path import find_patch

    find_patch(patch)  # reports an unknown name before seconds of loading
    warm_kernels(Console(stderr=True))  # before modules with kernels are imported
    from live.app.bridges import installed_bridges
    from live.app.launch_options import LaunchOptions
    from live.app.session_audio import choose_audio
    from live.rehearse.lint import lint_show
    from live.rehearse.open_ends import next_formation_hints
    from live.show.desk.scenes import is_locked

    options = LaunchOptions(patch=patch, steps=steps, venue=venue)
    hall = options.read_venue()
    loaded = options.load()
    show = loaded.start()
    if venue is not None or as_json:
        from live.app.machine.venue_check import all_venue_checks
        from live.app.option_values import parse_endpoint
        from live.cli.venue.doctor import print_checks

        checks = all_venue_checks(loaded, show, hall, parse_endpoint(osc), venue)
        print_checks(checks, "ready", ("Ready", "Not ready"), as_json=as_json)
    choose_audio(options, loaded)
    loaded.scene()
    library, graph = loaded.graph.library, loaded.graph
    console = Console(highlight=False)
    if graph.missing:
        raise PersonError("; ".join(graph.missing), "raise locomotion.threshold_m, or change those steps' ends")
    warnings = [words for doubts in lint_show(show) for words in doubts.warnings]
    locked = ["the camera is locked: it matches the hall, and its director never leads it"] * is_locked(loaded.patch)
    for note in (*loaded.notes, *locked, *installed_bridges().notes(loaded, hall), *warnings):
        console.print(f"note: {note}", style="yellow", soft_wrap=True, markup=False)
    for hint in next_formation_hints(loaded.start(begin=False)) if loaded.patch.element else ():
        console.print(f"hint: {hint}", style="cyan", soft_wrap=True, markup=False)
    console.print(
        f"ok {loaded.path}: {loaded.patch.name!r}, {loaded.patch.dancer_count} dancers in "
        f"{len(loaded.patch.group)} groups, {len(library.steps)} steps, {library.node_count} measures, "
        f"{graph.edge_count} transitions",
        style="green",
        soft_wrap=True,
        markup=False,
    )
