"""Command `live pair`: pairs two machines, so that one can be the other's warm standby."""

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from live.supervisor.network.identity import Identity, Pairings

PHRASE_MINUTES = 5


def pair(
    host: Annotated[
        str | None,
        typer.Argument(
            help="The machine that shows a phrase. Default: this machine shows one.", metavar="[HOST[:PORT]]"
        ),
    ] = None,
    on: Annotated[
        str | None,
        typer.Option("--on", help="Address on which this machine waits for the other one.", metavar="[HOST:]PORT"),
    ] = None,
    names: Annotated[bool, typer.Option("--list", help="List the paired machines.")] = False,
    forget: Annotated[str | None, typer.Option(help="Remove the pairing with a machine.", metavar="NAME")] = None,
) -> None:
    """Pair two machines once: `live pair` on one shows a phrase, `live pair HOST` on the other asks for it.

    After that, either machine can lead a show with the other as standby (live play --lead, --standby).
    """
    import asyncio

    from live.base.errors import PersonError
    from live.supervisor.network.identity import Pairings

    if sum((host is not None, on is not None, names, forget is not None)) > 1:
        raise PersonError("one of HOST, --on, --list and --forget at a time", "live pair --help")
    pairings = Pairings()
    if names:
        _print_peers(pairings)
    elif forget is not None:
        if not pairings.forget(forget):
            raise PersonError(f"--forget {forget}: this machine is not paired with it", "live pair --list")
        print(f"removed the pairing with {forget}")
    elif host is None:
        asyncio.run(_show_phrase(pairings, on))
    else:
        _enter_phrase(pairings, host)


def _print_peers(pairings: "Pairings") -> None:
    print(f"this machine: {_identity().fingerprint[:16]}")
    peers = pairings.read()
    for peer in peers:
        print(f"{peer.name}: {peer.fingerprint[:16]}, valid until {peer.expires:%Y-%m-%d}")
    if not peers:
        print("no paired machines")


def _identity() -> "Identity":
    """Return this machine's identity; renew it if its certificate has expired."""
    import datetime

    from live.supervisor.network.identity import load_identity, renew_identity

    identity = load_identity()
    if identity.as_peer().expires > datetime.datetime.now(datetime.UTC):
        return identity
    print("this machine's certificate had expired and was renewed: pair it with every other machine again")
    return renew_identity()


async def _show_phrase(pairings: "Pairings", on: str | None) -> None:
    from live.app.option_values import parse_endpoint
    from live.supervisor.network.pairing import PORT, PairingServer, new_phrase

    host, port = (None, PORT) if on is None else parse_endpoint(on, "--on")
    phrase = new_phrase()

    def listening(port: int) -> None:
        there = "" if port == PORT else f":{port}"
        print(f"the phrase: {phrase}", flush=True)
        print(
            f"type it on the other machine within {PHRASE_MINUTES} minutes, after: live pair ADDRESS{there}", flush=True
        )

    shown = PairingServer(_identity(), pairings, phrase, on_listening=listening)
    peer = await shown.run(host, port, timeout=60.0 * PHRASE_MINUTES)
    print(f"paired with {peer.name} ({peer.fingerprint[:16]})")
    if shown.wrong_phrases:
        print(f"note: wrong phrases were entered before ({shown.wrong_phrases})")


def _enter_phrase(pairings: "Pairings", address: str) -> None:
    import asyncio

    from live.app.option_values import add_default_port, parse_endpoint
    from live.base.errors import PersonError
    from live.supervisor.network.pairing import PORT, pair_with

    host, port = parse_endpoint(add_default_port(address, PORT), "HOST")
    identity = _identity()
    phrase = typer.prompt("the phrase that the other machine shows")
    if not phrase.strip():
        raise PersonError("a phrase expected", "live pair on the other machine shows one")
    peer = asyncio.run(pair_with(identity, pairings, host, port, phrase))
    print(f"paired with {peer.name} ({peer.fingerprint[:16]})")
