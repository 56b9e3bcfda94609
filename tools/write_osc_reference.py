"""Write docs/osc.md from the registry of controls (`--check`: only say whether it is up to date)."""

import sys
from pathlib import Path

from live.base.processing_budget import BURST, FLOOD_RATE, FLOODED_PER_SECOND, PER_SECOND
from live.control.osc import osc_codec
from live.control.osc import osc_scheduler as later
from live.control.osc.osc_handler import MAX_LANES, MAX_LANES_PER_HOST, PATTERNS_PER_SECOND
from live.control.osc.osc_output import MESSAGES, PREFIX
from live.control.osc.osc_pattern import MAX_CHARACTERS, MAX_CHOICES
from live.control.osc.osc_subscriptions import ECHO_DELAY, UPDATE_INTERVAL
from live.control.osc.osc_subscriptions import MAX_SUBSCRIBERS as MOST_SUBSCRIBERS
from live.control.registry.control import NAME_LENGTH, TEXT_LENGTH, Argument, Control
from live.control.registry.registry import READINGS, REGISTRY

HORIZON, MOST_WAITING, RATE = later.MAX_DELAY, later.MAX_ITEMS, 1 / UPDATE_INTERVAL

PATH = Path(__file__).resolve().parent.parent / "docs" / "osc.md"
TYPES = {"float": "number (f i d h)", "bool": "switch (T F, or 0 1 as i f d h)", "name": "text (s)", "text": "text (s)"}
KINDS = {"continuous": "value", "event": "event"}
WHO = {"operator": "operator", "musician": "operator, musician", "audience": "everybody"}

HEAD = """# OSC reference

*Written by `tools/write_osc_reference.py` from the registry in `live/control/registry/`; change that, not this page.*

The engine listens for Open Sound Control 1.0 over UDP on 127.0.0.1:9010; `--osc HOST:PORT` chooses another address.
Positions are metres on the stage: origin at the centre, x to the right as the audience sees it, z towards the
audience. Measures are those of the music. Values in brackets may be left out.

```
oscsend localhost 9010 /dance/attract ff 1.5 -0.5
oscsend localhost 9010 /dance/spread
```
"""

RULES = f"""
## Rules

- Everybody who reaches the port may do everything: the default address is reachable from this machine only. At the
  port of `--osc-musicians HOST:PORT` only what musicians may is taken; both ports have lanes of their own, so that who
  floods one does not keep the other waiting. Every sender has such a lane (there are {MAX_LANES}, {MAX_LANES_PER_HOST} \
of them for the ports
  of one host; others share one), and who has said little lately is served first; who sends rubbish alone is not read
  for a quarter of a second.
- In a show with a supervisor ([alive.md](alive.md)) a process of its own receives (`--no-osc-process`: the show's), so
  that floods cost the picture little; it goes on while engines change, and what is sent meanwhile waits. It hands
  over {PER_SECOND:.0f} messages a second (after a pause {BURST:.0f} at once), {FLOODED_PER_SECOND:.0f} while more \
than {FLOOD_RATE:.0f} a second come: values
  that wait give way to later ones (`replaced`), events keep their order.
- A *value* says what something is from now on: of several that arrive within a tick the last one counts. An *event*
  happens each time. Of the same value an operator's setting counts before a musician's, and a musician's before the
  audience's: for 0.3 s after each setting lower ones are left out, and counted as `outranked`.
- Patterns (`* ? [ab] [!a-c] {{one,other}}`) stand for values only, never for events: a panic wants its own name. At
  most {MAX_CHARACTERS} characters, {MAX_CHOICES} choices in the braces of a part, and {PATTERNS_PER_SECOND} new \
patterns a second; they are matched in
  linear time. Where some of the values take what is sent, the others are not meant.
- A whole number serves where a number is expected, and 0 and 1 for a switch. N (nil) and I (impulse) mean "no value":
  the default is taken where there is one. A value too many, a value of another type or outside its range, NaN and
  infinities are refused; nothing is clamped.
- Push buttons may send 1 when pressed and 0 when let go: a control without values acts on the 1 and ignores the 0.
- A bundle's messages act in their order, each for itself. Time tags up to {HORIZON:g} s ahead are waited for \
({MOST_WAITING} messages at
  most); what lies further ahead acts at once and is counted.
- A packet is refused as a whole if anything in it is malformed. Limits: {osc_codec.MAX_PACKET_BYTES} bytes a packet,
  {osc_codec.MAX_MESSAGES} messages, {osc_codec.MAX_BUNDLE_DEPTH} bundles inside each other, \
{osc_codec.MAX_ARGUMENTS} values a message, {osc_codec.MAX_STRING_BYTES} bytes an address or text,
  {osc_codec.MAX_BLOB_BYTES} bytes a blob, {NAME_LENGTH} printable characters a name. Type tags: \
i f s b h d T F N I t m; a message without a type
  tag string is refused.
- What is refused is counted by reason in the status, and never answered. Answers go to the sender alone; outside this
  machine and private networks with no more bytes than were received.

## Present values

A message without values asks what something is: `/dance/light/key` is answered with `/dance/light/key 0.8`, as one
would set it. Where groups differ there is one message for each, with its name; captured performers answer each at her
own address (`/dance/mocap/mirrored` with `/dance/mocap/anna/mirrored 1`). Where a message without values already
means something (`/dance/clock/hold`), and for patterns, `/dance/get ADDRESS` asks; what has no present value is
answered with `/dance/no_value ADDRESS`.

`/dance/subscribe` sends all values under an address, then each that changes: never twice the same, at most
{RATE:.0f} datagrams a second, and not to whoever has set it, unless after {ECHO_DELAY:g} s it is not what was set. Say it
again within `seconds`; there is room for {MOST_SUBSCRIBERS} subscribers in all, of this machine and private networks.

```
oscdump 9011 &
oscsend localhost 9010 /dance/subscribe sfi /dance/status 60 9011
```

| figure | type | unit | meaning |
|---|---|---|---|
{{READINGS}}

## What the show sends

`live play --osc-out HOST:PORT` (as often as there are programs to be told), `[osc] out` of the venue or of the patch
([patch.md](patch.md), which also says how often places are told, and whether feet are) makes the show tell what happens
in it. A process of its own sends, beats when they are due and not with the next frame; dancers count from 1. It never
waits: what a program does not take is lost to it alone. To an instrument in SuperCollider:

```
live play --osc-out 127.0.0.1:57120
OSCdef(\\taps, {{ |m| Synth(\\tap, [\\amp, m[5], \\pan, m[3] / 6]) }}, '/dance/out/foot');
```

| message | types | when |
|---|---|---|
{{SENT}}

## Layouts for tablets

```
live layout touchosc --patch samba --out samba.tosc
live layout open-stage-control --patch samba --role musician --osc 192.168.1.20:9012 --out samba.json
```

writes a layout for TouchOSC (1.2 or later) or Open Stage Control (1.26 or later) from the same table as this page:
faders with their ranges, switches, colours, pads that show the stage with the audience below, and buttons for the
patch's steps, cues, scenes, looks, cameras, sections and formations. What a hand cannot say in one touch is left out,
and named when the file is written. In TouchOSC set the show's address (Connections, OSC, UDP; the same port to send and
to receive) and press "hear the show": faders then follow what is set elsewhere, for an hour. Open Stage Control asks
by itself.

## OSCQuery

With `live play --oscquery HOST:PORT` ossia score, Chataigne, TouchOSC and others find the show by themselves (zeroconf
`_oscjson._tcp` and `_osc._udp`, on the network of that host) and read everything above as a tree: types, units, ranges,
present values; a WebSocket at the same port streams the values that they LISTEN to. A process of its own answers. It
only tells: what is set is set over OSC, at the port that it names. Of an event the tree has the values that must be
given; where groups differ it has the first one's value, LISTEN all of them.

It asks for no key, for those programs know none: whoever reaches it reads the names in the patch, what is danced and
every present value, and where OSC is heard. Nothing can be set through it. At `127.0.0.1:9011` that is this machine
alone, and zeroconf then neither listens nor announces anywhere else; at an address it does in the network of that
address alone, at `0.0.0.0` in all. Pages of other sites are refused: Host has to be the address that was asked,
localhost where that is loopback, this machine's own name in the network where it is not, or a name given as `--web-host
NAME` or in the venue (`[web] hosts`). Connections that say nothing, or read nothing, are closed within seconds; 32
programs may LISTEN, 16 of one address.
"""


def _usage(control: Control) -> str:
    words = [argument.name if argument.default is None else f"[{argument.name}]" for argument in control.arguments]
    return " ".join([control.address, *words])


def _row(argument: Argument) -> str:
    allowed = {"name": "any name", "text": f"at most {TEXT_LENGTH} characters"}.get(argument.type, "0 or 1")
    if argument.type == "float":
        allowed = f"{argument.minimum:g} to {argument.maximum:g}"
    default = "must be given" if argument.default is None else str(argument.default).removesuffix(".0")
    cells = (argument.name, TYPES[argument.type], argument.unit or "–", allowed, default, argument.description)
    return "| " + " | ".join(cells) + " |"


def _shown(value: object) -> str:
    return (
        {True: "1", False: "0"}[value]
        if isinstance(value, bool)
        else f"{value:.4g}"
        if isinstance(value, float | int)
        else f'"{value}"'
    )


def reference() -> str:
    """The whole page."""
    parts = [HEAD, "## Controls\n", "| control | | what it does | who may |", "|---|---|---|---|"]
    parts += [
        f"| `{_usage(control)}` | {KINDS[control.kind]} | {control.description} | {WHO[control.role]} |"
        for control in REGISTRY
    ]
    for control in REGISTRY:
        if control.arguments:
            parts += [f"\n### {control.address}\n", "| value | type | unit | allowed | default | meaning |"]
            parts += ["|---|---|---|---|---|---|", *map(_row, control.arguments)]
        if control.start:
            parts.append(f"\nWhere nobody says anything it is {' '.join(map(_shown, control.start))}.")
    figures = "\n".join(f"| `{r.address}` | {r.type} | {r.unit or '–'} | {r.description} |" for r in READINGS)
    sent = "\n".join(f"| `{PREFIX}{name} {values}` | {tags} | {words} |" for name, tags, values, words in MESSAGES)
    return "\n".join(parts) + "\n" + RULES.replace("{READINGS}", figures).replace("{SENT}", sent)


def main() -> int:
    """Write the page, or compare it (exit 1: out of date)."""
    if "--check" in sys.argv[1:]:
        if PATH.is_file() and PATH.read_text(encoding="utf-8") == reference():
            return 0
        print(f"{PATH.name} is out of date: run python tools/write_osc_reference.py", file=sys.stderr)
        return 1
    PATH.parent.mkdir(exist_ok=True)
    PATH.write_text(reference(), encoding="utf-8")
    print(f"wrote docs/{PATH.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
