"""Command `live gateway`: serves a part of the audience's phones for a show on another machine."""

from pathlib import Path
from typing import Annotated

import typer


def gateway(
    host: Annotated[
        str, typer.Argument(help="The machine that plays, with --gateways-listen.", metavar="HOST[:PORT]")
    ],
    listen: Annotated[
        str, typer.Option(help="Where phones, or the proxy in front of them, connect.", metavar="[HOST:]PORT")
    ] = "0.0.0.0:8020",
    tls: Annotated[
        str | None, typer.Option(help="Serve phones over https, with this certificate and its key (PEM files).",
                                 metavar="CERT,KEY"),
    ] = None,
    phones: Annotated[int, typer.Option(help="Most phones at a time.", min=1, max=100_000)] = 10_000,
    name: Annotated[str, typer.Option(help="Name in the show's status. Default: this machine's.")] = "",
) -> None:  # fmt: skip
    """Serve a part of the audience's phones for a show on another machine.

    The two machines are paired once (live pair). Several gateways share the phones behind a proxy: live docs stadium.
    """
    from live.app.option_values import GATEWAYS_PORT, add_default_port, parse_endpoint
    from live.app.processes.remote_gateway import run_gateway
    from live.app.services.audience_tls import parse_tls

    where = parse_endpoint(add_default_port(host, GATEWAYS_PORT), "HOST")
    files: tuple[Path, Path] | None = None if tls is None else parse_tls(tls, "--tls")
    run_gateway(where, parse_endpoint(listen, "--listen"), files, phones, name)
