"""Options of `live play` for programs, machines and people that play along over the network."""

from typing import Annotated

import typer

Osc = Annotated[str, typer.Option(help="Where OSC is received.", metavar="HOST:PORT")]
OscProcess = Annotated[
    bool | None,
    typer.Option(
        "--osc-process/--no-osc-process",
        help="Receive OSC in a process of its own, so that floods cost the picture little, or in the show's. Without "
        "either: of its own, but where the whole show is one process.",
    ),
]
OscMusicians = Annotated[
    str | None,
    typer.Option(
        help="A port of their own for musicians: what only an operator may is refused there.",
        metavar="HOST:PORT",
    ),
]
OscOut = Annotated[
    list[str] | None,
    typer.Option(
        help="Tell programs there over OSC what happens: beat, tempo, steps, feet, places. May come several times.",
        metavar="HOST:PORT",
    ),
]
Dmx = Annotated[
    list[str] | None,
    typer.Option(
        help="Let the hall's lamps follow the show: channels as [[dmx]] says. May come several times.",
        metavar="sacn:UNIVERSE[@HOST]|artnet:UNIVERSE@HOST",
    ),
]
Web = Annotated[
    str | None,
    typer.Option(
        help="Serve the operator's page for a browser: all controls, the values of now. Only the link that is "
        "printed lets in: it has the key.",
        metavar="[HOST:]PORT",
    ),
]
WebKey = Annotated[
    str | None,
    typer.Option(
        help="A key of your own for that page (16 characters or more), instead of the one that is kept. Others on this "
        "machine can read a command line: the variable is better.",
        metavar="KEY",
        envvar="LIVE_WEB_KEY",
    ),
]
NewWebKey = Annotated[
    bool,
    typer.Option("--new-web-key", help="Make another key for that page: who had the old one is let in no more."),
]
WebHost = Annotated[
    list[str] | None,
    typer.Option(
        help="A name by which this machine is reached beside its addresses, for that page and OSCQuery. May come "
        "several times.",
        metavar="NAME[:PORT]",
    ),
]
Psn = Annotated[
    str | None,
    typer.Option(
        help="Listen there for trackers by PosiStageNet, usually 236.10.10.10:56565; ADDRESS: of the network card.",
        metavar="[GROUP:]PORT[@ADDRESS]",
    ),
]
VmcOut = Annotated[
    list[str] | None,
    typer.Option(
        help="Send dancers to other programs as avatars by the VMC protocol: the first, or whom WHO means, each to "
        "the next port. May come several times.",
        metavar="HOST:PORT[=WHO][@RATE]",
    ),
]
Vmc = Annotated[
    list[str] | None,
    typer.Option(
        help="Listen there for a real dancer's body by the VMC protocol (usually 39539). May come several times.",
        metavar="[HOST:]PORT|HOST",
    ),
]
Oscquery = Annotated[
    str | None,
    typer.Option(
        help="Be found by ossia score, Chataigne, TouchOSC and others: OSCQuery over HTTP, and zeroconf.",
        metavar="HOST:PORT",
    ),
]
Audience = Annotated[
    str | None,
    typer.Option(
        help="Let the audience's phones play along, here: 127.0.0.1:8020 if nothing else is said; "
        "0.0.0.0:8020 lets in the whole network.",
        metavar="[[HOST:]PORT]",
    ),
]
AudienceLink = Annotated[
    str | None,
    typer.Option(help="The address that phones are given, if it is another one.", metavar="http://HOST[:PORT]"),
]
AudienceTls = Annotated[
    str | None,
    typer.Option(
        help="Meet phones over https, with this certificate and its key (PEM files, as Let's Encrypt makes them).",
        metavar="CERT,KEY",
    ),
]
