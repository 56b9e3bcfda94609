"""Pages of the OSC reference, made from the registry of controls: rules on the first one, then one for each family."""

from collections.abc import Iterable
from typing import Final

from live.base.processing_budget import BURST, FLOOD_RATE, FLOODED_PER_SECOND, PER_SECOND
from live.control.osc import osc_codec
from live.control.osc import osc_scheduler as later
from live.control.osc.osc_handler import MAX_LANES, MAX_LANES_PER_HOST, PATTERNS_PER_SECOND
from live.control.osc.osc_output import MESSAGES, PREFIX
from live.control.osc.osc_pattern import MAX_CHARACTERS, MAX_CHOICES
from live.control.osc.osc_prefilter import FLOOD_WINDOW, MAX_INVALID_SURPLUS
from live.control.osc.osc_subscriptions import ECHO_DELAY, UPDATE_INTERVAL
from live.control.osc.osc_subscriptions import MAX_SUBSCRIBERS as MOST_SUBSCRIBERS
from live.control.registry.control import NAME_LENGTH, TEXT_LENGTH, Argument, Control
from live.control.registry.registry import READINGS, REGISTRY

HORIZON, MOST_WAITING, RATE = later.MAX_DELAY, later.MAX_ITEMS, 1 / UPDATE_INTERVAL

TYPES = {"float": "number (f i d h)", "bool": "switch (T F, or 0 1 as i f d h)", "name": "text (s)", "text": "text (s)"}
KINDS = {"continuous": "value", "event": "event"}
WHO = {"operator": "operator", "musician": "operator, musician", "audience": "everybody"}

HEAD = """# OSC reference

Every OSC message that the engine receives and sends, and the rules for them.

The engine listens for Open Sound Control 1.0 over UDP on 127.0.0.1:9010. `--osc HOST:PORT` sets another address.
Positions are in metres on the stage: the origin is the centre, x points to the right as the audience sees it, z towards
the audience. Measures are measures of the music. Arguments in square brackets are optional.

```
oscsend localhost 9010 /dance/attract ff 1.5 -0.5
oscsend localhost 9010 /dance/spread
```
"""

RULES = f"""
## Rules

**Access.** OSC has no passwords: every program that reaches the port may use every control. The default address is
reachable from this machine only. The port of `--osc-musicians HOST:PORT` accepts only the controls that musicians may
use.

**Lanes.** Each port has its own {MAX_LANES} lanes (queues), so a flood at one port does not delay the other. Each
sender has its own lane, at most {MAX_LANES_PER_HOST} for the source ports of one host. Further senders share one
lane. A sender that has sent little recently is served first. A sender is ignored when its refused datagrams exceed
its valid ones by {MAX_INVALID_SURPLUS} within {FLOOD_WINDOW:g} s, for the rest of that time.

**Process.** In a show with a supervisor ([Processes](../../explanation/processes.md)) a separate process receives OSC,
so floods cost the frame loop little (`--no-osc-process`: the show's process receives). It keeps running while
engines change. Messages sent meanwhile wait. It passes on {PER_SECOND:.0f} messages a second, {BURST:.0f} at once after
a pause, and {FLOODED_PER_SECOND:.0f} a second while more than {FLOOD_RATE:.0f} a second arrive. Waiting values are
replaced by later ones (counted as `replaced`). Events keep their order.

**Values and events.** A *value* sets a state. If several messages for one value arrive within a tick, the last one
counts. An *event* acts each time it arrives. An operator's value has priority over a musician's, and a musician's over
the audience's: for 0.3 s after a value is set, settings of lower rank are ignored and counted as `outranked`.

**Patterns** (`* ? [ab] [!a-c] {{one,other}}`) match values only, never events: an event such as panic needs its full
name. A pattern may have {MAX_CHARACTERS} characters, and {MAX_CHOICES} choices in the braces of one part.
{PATTERNS_PER_SECOND} new patterns a second are accepted. Matching takes linear time. If only some of the matching
values accept the arguments, only those are set.

**Types.** A whole number is accepted as a number, and 0 and 1 as a switch. N (nil) and I (impulse) mean "no value": the
default is used if there is one. Extra arguments, arguments of another type or outside their range, NaN and infinities
are refused. Nothing is clamped.

**Push buttons** may send 1 when pressed and 0 when released: a control without arguments acts on the 1 and ignores
the 0.

**Bundles.** The messages of a bundle act in order, each independently. Messages with a time tag up to {HORIZON:g} s
ahead wait for it, at most {MOST_WAITING} of them. Messages further ahead, or beyond that number, act at once and are
counted.

**Refusals.** A packet is refused as a whole if any part of it is malformed or has no type tag string. Allowed type
tags: i f s b h d T F N I t m. Refusals are counted by reason in the status and not answered.

| limit | value |
|---|---|
| bytes of a packet | {osc_codec.MAX_PACKET_BYTES} |
| messages in a packet | {osc_codec.MAX_MESSAGES} |
| nested bundles | {osc_codec.MAX_BUNDLE_DEPTH} |
| arguments of a message | {osc_codec.MAX_ARGUMENTS} |
| bytes of an address or text | {osc_codec.MAX_STRING_BYTES} |
| bytes of a blob | {osc_codec.MAX_BLOB_BYTES} |
| printable characters of a name | {NAME_LENGTH} |

**Answers** go to the sender only. Outside this machine and private networks, an answer is never longer than the message
that was received.

## Present values

A message without arguments asks for the present value. `/dance/light/key` is answered with `/dance/light/key 0.8`, in
the form that sets it. If groups have different values, there is one message for each group, with its name. Captured
performers are answered with one address each: `/dance/mocap/mirrored` with `/dance/mocap/anna/mirrored 1`.

`/dance/get ADDRESS` asks where a message without arguments has another meaning (`/dance/clock/hold`), and for patterns.
An address without a present value is answered with `/dance/no_value ADDRESS`.

`/dance/subscribe` sends all values under an address, then every change, at most {RATE:.0f} updates a second. A value
is not sent twice. The sender that set a value gets it back only if the value is different after {ECHO_DELAY:g} s. Renew
a subscription within `seconds`. {MOST_SUBSCRIBERS} subscribers are possible, from this machine and private networks.

```
oscdump 9011 &
oscsend localhost 9010 /dance/subscribe sfi /dance/status 60 9011
```

| figure | type | unit | meaning |
|---|---|---|---|
{{READINGS}}

## Messages sent by the show

`live play --osc-out HOST:PORT` sends the events of the show to other programs. Repeat the option for several programs,
or set `[osc] out` in the venue or the patch. [`[osc]`](../patch/osc.md) also has the keys for the rate of positions
and for feet. A separate process sends, and sends beats when they are due, not with the next frame. Dancers count from
1. The sender never waits: a program that does not read loses messages, and no other program is affected.

Example for an instrument in SuperCollider:

```
live play --osc-out 127.0.0.1:57120
OSCdef(\\taps, {{ |m| Synth(\\tap, [\\amp, m[5], \\pan, m[3] / 6]) }}, '/dance/out/foot');
```

| message | types | when |
|---|---|---|
{{SENT}}

## Layouts and discovery

[Layouts for tablets](../bridges/layouts.md) are written from the same table as this page, and programs that
know [OSCQuery](../bridges/oscquery.md) find the show and this table by themselves.
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


FAMILIES: Final = {
    "elements": ("Elements", "attract repel spread cross flow path wander flock follow pursue evade voice"),
    "groups": (
        "Groups and formations",
        "formation travel pause release ripple enter leave obstacle wall stage performer regroup clear",
    ),
    "steps": ("Steps and motion", "step now sequence facing why launch motion mood"),
    "partners": ("Partners and captured performers", "partner mocap"),
    "light": ("Light, looks and scenes", "light spot look scene"),
    "picture": ("Camera and picture", "camera background pass group draw output picture"),
    "cues": ("Cues and score", "go cue standby back panic hold undo redo section advance practice improvise signal"),
    "clock": ("Clock and sound", "clock blackout audio click latency"),
    "audience": ("The audience", "audience"),
    "editing": ("Editing the show", "document midi"),
    "machines": ("Machines and questions", "takeover breaker ping get subscribe unsubscribe"),
}
"""Pages by name: title, and first words of the addresses. Other addresses stand where those before them stand."""


def families(controls: Iterable[Control] = REGISTRY) -> dict[str, list[Control]]:
    """Return the controls of each page."""
    pages = {word: page for page, (_, words) in FAMILIES.items() for word in words.split()}
    found: dict[str, list[Control]] = {page: [] for page in FAMILIES}
    page = next(iter(FAMILIES))
    for control in controls:
        page = pages.get(control.address.split("/")[2], page)
        found[page].append(control)
    return found


def _describe(control: Control) -> list[str]:
    """Return the lines of one control."""
    lines = [
        f"## {control.address}\n",
        f"{control.description[:1].upper()}{control.description[1:].rstrip('.')}.\n",
        f"`{_usage(control)}`\n",
        f"{KINDS[control.kind].capitalize()}, for: {WHO[control.role]}."
        + (f" Value if nothing sets it: {' '.join(map(_shown, control.start))}." if control.start else "")
        + "\n",
    ]
    if control.arguments:
        lines += ["| value | type | unit | allowed | default | meaning |", "|---|---|---|---|---|---|"]
        lines += [*map(_row, control.arguments), ""]
    return lines


def _overview(page: str, controls: list[Control]) -> list[str]:
    """Return a family's lines of the first page."""
    rows = [
        f"| [`{control.address}`]({page}.md#{control.address.strip('/').replace('/', '-').replace('_', '-')}) "
        f"| {control.description} |"
        for control in controls
    ]
    return [f"### {FAMILIES[page][0]}\n", "| address | effect |", "|---|---|", *rows, ""]


def osc_pages() -> dict[str, str]:
    """Return the pages by file name."""
    found = families()
    figures = "\n".join(f"| `{r.address}` | {r.type} | {r.unit or '–'} | {r.description} |" for r in READINGS)
    sent = "\n".join(f"| `{PREFIX}{name} {values}` | {tags} | {words} |" for name, tags, values, words in MESSAGES)
    index = [HEAD, "```{toctree}\n:maxdepth: 1\n", *found, "```\n", "## Controls\n"]
    for page, controls in found.items():
        index += _overview(page, controls)
    pages = {"index.md": "\n".join(index) + RULES.replace("{READINGS}", figures).replace("{SENT}", sent)}
    for page, controls in found.items():
        lines = [f"# OSC: {FAMILIES[page][0][:1].lower()}{FAMILIES[page][0][1:]}\n"]
        for control in controls:
            lines += _describe(control)
        pages[f"{page}.md"] = "\n".join(lines)
    return pages
