"""Command `live node`: a render node, which draws its part of a show that another machine plays."""

from pathlib import Path
from typing import Annotated

import typer

from live.app.launch_options import NETWORK, PICTURE


def node(
    leaders: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[HOST[:PORT]]...",
            help="The machine that plays the show (live play --nodes), and those that may take over. Left out: the one "
            "that answers in this network.",
        ),
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="The node, as in the venue's file. Default: this machine's name.")
    ] = None,
    patch: Annotated[
        str | None, typer.Option(help="The patch, the same as the leader's. Default: the first show.")
    ] = None,
    steps: Annotated[Path | None, typer.Option(help="As for live play.", file_okay=False)] = None,
    venue: Annotated[str | None, typer.Option(help="The hall: which outputs this node draws.", metavar="NAME")] = None,
    monitor: Annotated[
        str | None, typer.Option(help="The monitor of outputs that name none.", rich_help_panel=PICTURE)
    ] = None,
    fullscreen: Annotated[bool, typer.Option("--fullscreen", help="Full screen.", rich_help_panel=PICTURE)] = False,
    headless: Annotated[
        bool,
        typer.Option("--headless", help="No window: follow without a picture, or --share it.", rich_help_panel=PICTURE),
    ] = False,
    size: Annotated[str, typer.Option(help="Size of the window.", metavar="WxH", rich_help_panel=PICTURE)] = "1280x720",
    fps: Annotated[float | None, typer.Option(help="Default: the monitor's.", rich_help_panel=PICTURE)] = None,
    share: Annotated[
        list[str] | None,
        typer.Option(help="Share the picture with other programs, as live play does.", rich_help_panel=PICTURE),
    ] = None,
    web: Annotated[
        str | None,
        typer.Option(
            help="Show the operator's page and the studio of the machine that plays, at the same address whichever "
            "one leads. They ask for that machine's key.",
            rich_help_panel=NETWORK,
            metavar="[HOST:]PORT",
        ),
    ] = None,
    web_host: Annotated[
        list[str] | None,
        typer.Option(
            help="A name by which browsers reach this machine, for that page.",
            rich_help_panel=NETWORK,
            metavar="NAME[:PORT]",
        ),
    ] = None,
    status_json: Annotated[
        Path | None, typer.Option(help="Write one JSON line of figures a second.", rich_help_panel=NETWORK)
    ] = None,
) -> None:
    """Draw a part of a show that another machine plays, in lockstep with all other nodes.

    The patch, the steps and the version must be those of the leader. The node starts again by itself if it dies, and
    waits for the next show when one has ended.
    """
    import socket

    from live.app.launch_options import LaunchOptions
    from live.app.option_values import check_range, parse_endpoint, parse_shares, parse_size
    from live.app.processes.node_main import NodePlan, keep_node, parse_leaders
    from live.app.services.http_services import parse_web
    from live.base.errors import PersonError
    from live.nodes.bus import load_zenoh
    from live.nodes.leader import is_name
    from live.show.patch.patch_search_path import find_patch

    load_zenoh()
    find_patch(patch)
    check_range(fps, "--fps", 1.0, 480.0)
    called = name if name is not None else socket.gethostname().partition(".")[0]
    if not is_name(called):
        raise PersonError(f"--name {called[:80]!r}: letters, digits, - and _ expected", "--name left")
    options = LaunchOptions(
        patch=patch, steps=steps, venue=venue, monitor=monitor, fullscreen=fullscreen, headless=headless,
        size=parse_size(size), fps=fps, share=parse_shares(share or []), status_json=status_json, node=called,
    )  # fmt: skip
    options.read_venue()
    page = None if web is None else parse_endpoint(web, "--web")
    hosts = parse_web(None, key=None, new_key=False, hosts=web_host or []).hosts
    raise typer.Exit(keep_node(NodePlan(options, parse_leaders(leaders or []), page, hosts)))
