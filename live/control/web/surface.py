"""Control surface: the widgets and pages of the registry's controls, independent of the program that shows them.

Controls that cannot be set in one touch are omitted: names not known beforehand, drawn lines, and three numbers that
are no colour.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

from live.control.registry.control import ROLE_RANKS, Control, Role
from live.control.registry.registry import QUERIES

WidgetKind = Literal["fader", "toggle", "button", "pad", "colour"]
MAX_PAGE_WIDGETS: Final = 24
"""Maximum widgets on a page that is still easy to use."""
MOST_BUTTONS: Final = 48
"""Maximum names of one kind that get a button each."""
PAD_REACH: Final = (6.0, 4.5)
"""Half the width and depth of the stage on a pad [m], where no patch gives its size."""


@dataclass(frozen=True, slots=True)
class Widget:
    """One fader, button or pad. `minimum`, `maximum`: one number each, two for a pad; `values`: arguments
    of a button."""

    kind: WidgetKind
    address: str
    label: str
    minimum: tuple[float, ...] = ()
    maximum: tuple[float, ...] = ()
    start: tuple[float, ...] = ()
    values: tuple[str, ...] = ()
    once: bool = False
    """Whether a pad sends once, when the finger leaves it; otherwise it sends all movements."""


@dataclass(frozen=True, slots=True)
class Page:
    """Widgets that belong together."""

    title: str
    widgets: tuple[Widget, ...]


@dataclass(frozen=True, slots=True)
class Surface:
    """All pages, and the addresses without a widget."""

    pages: tuple[Page, ...]
    omitted: tuple[str, ...]


def make_surface(
    controls: Iterable[Control],
    *,
    role: Role,
    names: Mapping[str, Sequence[str]],
    reach: tuple[float, float] = PAD_REACH,
) -> Surface:
    """Return the surface for `role`.

    `names`: values of an address's first argument (steps, cues …); `reach` [m]: half the stage's width and depth.
    """
    pages: dict[str, list[Widget]] = {}
    left_out = []
    for control in controls:
        if ROLE_RANKS[control.role] > ROLE_RANKS[role] or control.address in QUERIES:
            continue
        widgets = list(_widgets(control, names.get(control.address, ())[:MOST_BUTTONS], reach))
        if not widgets:
            left_out.append(control.address)
        for widget in widgets:
            title = _title(control, widget)
            pages.setdefault(title, []).append(replace(widget, label=widget.label.removeprefix(f"{title} ")))
    return Surface(tuple(_split_pages(pages)), tuple(left_out))


def _title(control: Control, widget: Widget) -> str:
    parts = control.address.split("/")[2:]
    if widget.kind == "pad":
        return "stage"
    return parts[0] if len(parts) > 1 or widget.values else "show"


def _split_pages(pages: Mapping[str, Sequence[Widget]]) -> Iterator[Page]:
    for title in sorted(pages, key=lambda title: (title not in ("show", "stage"), title == "show", title)):
        widgets = pages[title]
        count = -(-len(widgets) // MAX_PAGE_WIDGETS)
        size = -(-len(widgets) // count)
        for number in range(count):
            part = tuple(widgets[number * size : (number + 1) * size])
            yield Page(title if count == 1 else f"{title} {number + 1}", part)


def _widgets(control: Control, names: Sequence[str], reach: tuple[float, float]) -> Iterator[Widget]:
    arguments, address = control.arguments, control.address
    label = " ".join(address.split("/")[2:])
    required = [argument for argument in arguments if argument.default is None]
    first = arguments[0] if arguments else None
    if [argument.name for argument in required] == ["x", "z"] == [argument.name for argument in arguments[:2]]:
        if control.value > len(required):
            return  # a pad would overwrite the other values
        low, high = (-reach[0], -reach[1]), reach
        yield Widget("pad", address, label, low, high, (0.0, 0.0), once=control.kind == "event")
    elif control.named:
        for name in names:
            if (own := control.address_of(name)) is not None:
                yield from _widgets(replace(control, address=own, arguments=arguments[1:], named=False), (), reach)
        return
    elif control.value == 3 and _is_colour(control):
        top = max(argument.maximum for argument in arguments[:3])
        start = tuple(float(value) for value in control.start[:3])
        yield Widget("colour", address, label, (0.0,), (top,), start)
    elif control.value >= 1 and first is not None and first.type == "float" and _rest_stays(control):
        start = tuple(float(value) for value in control.start[:1])
        yield Widget("fader", address, label, (first.minimum,), (first.maximum,), start)
    elif control.value == 1 and first is not None and first.type == "bool":
        yield Widget("toggle", address, label, (0.0,), (1.0,), tuple(float(value) for value in control.start[:1]))
    elif control.kind == "event" and not required and not control.value:
        yield Widget("button", address, label)
    if first is not None and first.type in ("name", "text") and len(required) <= 1:
        for name in names:
            yield Widget("button", address, name, values=(name,))


def _rest_stays(control: Control) -> bool:
    """Whether further values stay unchanged when they are omitted."""
    return all(argument.default == "" for argument in control.arguments[1 : control.value])


def _is_colour(control: Control) -> bool:
    return all(argument.minimum == 0.0 for argument in control.arguments[:3])
