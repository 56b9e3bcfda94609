"""Write docs/osc.md from the registry of controls (`--check`: only say whether it is up to date)."""

import sys
from pathlib import Path

from live.control import osc_decode as limits
from live.control.control import NAME_LENGTH, TEXT_LENGTH, Argument, Control
from live.control.registry import REGISTRY

PATH = Path(__file__).resolve().parent.parent / "docs" / "osc.md"
TYPES = {"float": "number (f i d h)", "bool": "switch (T F, or 0 1 as i f d h)", "name": "text (s)", "text": "text (s)"}
WHO = {"operator": "operator", "musician": "operator, musician", "audience": "everybody"}

HEAD = """# OSC reference

*Written by `tools/write_osc_reference.py` from the registry in `live/control/registry.py`; change that, not this page.*

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

- Over OSC everybody who reaches the port may do everything: the default address is reachable from this machine only.
  "Who may" holds where people have roles, as on web pages.
- An address must be exactly one of those above; patterns (`* ? [ ] {{ }}`) are refused.
- A whole number serves where a number is expected, and 0 and 1 for a switch. N (nil) and I (impulse) mean "no value":
  the default is taken where there is one. A value too many, a value of another type or outside its range, NaN and
  infinities are refused; nothing is clamped.
- Push buttons may send 1 when pressed and 0 when let go: a control without values acts on the 1 and ignores the 0.
- A bundle's messages act in their order, each for itself, at the moment of arrival. Time tags are accepted but not
  waited for; those in the future are counted.
- A packet is refused as a whole if anything in it is malformed. Limits: {limits.MAX_PACKET_BYTES} bytes a packet,
  {limits.MAX_MESSAGES} messages, {limits.MAX_BUNDLE_DEPTH} bundles inside each other, {limits.MAX_ARGUMENTS} values a \
message, {limits.MAX_STRING_BYTES} bytes an address or text,
  {limits.MAX_BLOB_BYTES} bytes a blob, {NAME_LENGTH} printable characters a name. Type tags: i f s b h d T F N I t m; \
a message without a type
  tag string is refused.
- What is refused is counted by reason in the status, and never answered. Only `/dance/ping` is answered, to its
  sender alone, once per datagram and with no more bytes than were received.
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


def reference() -> str:
    """The whole page."""
    parts = [HEAD, "## Controls\n", "| control | what it does | who may |", "|---|---|---|"]
    parts += [f"| `{_usage(control)}` | {control.description} | {WHO[control.who]} |" for control in REGISTRY]
    for control in REGISTRY:
        if control.arguments:
            parts += [f"\n### {control.address}\n", "| value | type | unit | allowed | default | meaning |"]
            parts += ["|---|---|---|---|---|---|", *map(_row, control.arguments)]
    return "\n".join(parts) + "\n" + RULES


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
