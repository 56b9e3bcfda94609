"""What calls of a patch name is there: scenes, views, looks, signals, gates, facings, and places of the score."""

from collections.abc import Callable, Sequence
from typing import Final

from live.base.errors import PersonError
from live.control.events import events
from live.control.registry.registry import REGISTRY
from live.show.dancers.ripple import parse_ripple
from live.show.patch.cue_check import START, Recalled, standing_views
from live.show.patch.facing import parse_facing
from live.show.patch.score_checks import calls_of, signals_of, written_length
from live.show.patch.section_base import Amiss

NAMING: Final = (
    "/dance/scene", "/dance/camera", "/dance/look", "/dance/signal", "/dance/section", "/dance/advance",
    "/dance/practice", "/dance/enter", "/dance/leave", "/dance/facing", "/dance/ripple",
)  # fmt: skip
"""Controls whose names only the patch knows."""
GATES: Final = ("left", "right", "back")
"""The gates of a stage that names none."""
WHENS: Final = ("measure", "section")


def check_named(patch: Recalled) -> None:
    """Amiss for a call of the score or of a cue that names what is not there."""
    named: _Named | None = None
    seen: set[tuple[object, ...]] = set()
    for call, values, place in calls_of(patch):
        if call not in NAMING or (call, *values) in seen:
            continue
        seen.add((call, *values))
        named = named or _Named(patch)
        try:
            named.check(REGISTRY.call(call, values, 0.0, "patch"))
        except PersonError as error:
            raise Amiss(f"call {call}: {error}", *place) from None


class _Named:
    """What is there, by kind."""

    def __init__(self, patch: Recalled) -> None:
        self._patch = patch
        stored = [str(values[0]) for call, values, _ in calls_of(patch) if call == "/dance/scene/store"]
        stored += [str(one.values.get("name")) for one in patch.midi.map if one.control == "/dance/scene/store"]
        self._scenes = [START, *(scene.name for scene in patch.scene), *stored]
        self._views = [*standing_views(patch), *(view.name for view in patch.view)]
        self._looks = [START, *(look.name for look in patch.looks)]
        self._gates = [gate.name for gate in patch.gate] or list(GATES)

    def check(self, event: object) -> None:
        """PersonError if the event names what is not there."""
        act = _CHECKS.get(type(event))
        if act is not None:
            act(self, event)

    def _scene(self, event: events.RecallScene) -> None:
        _there("scene", event.name, self._scenes)

    def _view(self, event: events.RecallView) -> None:
        _there("view", event.name, self._views)

    def _look(self, event: events.RecallLook) -> None:
        _there("look", event.name, self._looks)

    def _signal(self, event: events.Signal) -> None:
        _there("signal", event.name, sorted(signals_of(self._patch)))

    def _jump(self, event: events.JumpTo) -> None:
        _there("section", event.section, [section.name for section in self._patch.section])
        _there("when", event.when, WHENS)
        size = next(one.measures for one in self._patch.section if _folded(one.name) == _folded(event.section))
        if event.measure > size:
            raise PersonError(f"section {event.section!r} has no measure {event.measure}", f"it has {size}")

    def _advance(self, event: events.Advance) -> None:
        _there("when", event.when, WHENS)

    def _practice(self, event: events.Practice) -> None:
        length = written_length(self._patch)
        if event.first > event.last:
            raise PersonError(f"measures {event.first} to {event.last}: the first one comes last")
        if length is not None and event.last > length:
            raise PersonError(f"the score has no measure {event.last}", f"it has {length}")

    def _gate(self, event: events.Enter | events.Leave) -> None:
        if event.gate.strip() not in ("", "*"):
            _there("gate", event.gate, self._gates)

    def _facing(self, event: events.SetFacing) -> None:
        names = tuple(_folded(group.name) for group in self._patch.group)
        dancers = sum(group.dancers for group in self._patch.group) + self._patch.reserve
        parse_facing(event.facing, dancers=dancers, groups=names)

    def _ripple(self, event: events.SetRipple) -> None:
        parse_ripple(event.begins, event.beats)


def _there(what: str, name: str, known: Sequence[str]) -> None:
    """PersonError if nothing of the kind `what` is called so."""
    if _folded(name) not in map(_folded, known):
        raise PersonError(f"no {what} is called {name!r}", f"there are: {', '.join(known) or 'none'}")


def _folded(name: str) -> str:
    return name.casefold().strip()


_CHECKS: Final[dict[type, Callable[..., None]]] = {
    events.RecallScene: _Named._scene,
    events.RecallView: _Named._view,
    events.RecallLook: _Named._look,
    events.Signal: _Named._signal,
    events.JumpTo: _Named._jump,
    events.Advance: _Named._advance,
    events.Practice: _Named._practice,
    events.Enter: _Named._gate,
    events.Leave: _Named._gate,
    events.SetFacing: _Named._facing,
    events.SetRipple: _Named._ripple,
}
