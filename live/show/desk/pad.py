"""Pads: what can be launched for some dancers, found by kind and name, and the event that launches it."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from live.base.errors import PersonError, error_context
from live.control.events import events
from live.control.events.event import ControlEvent
from live.show.patch.patch import Patch
from live.show.score.step_names import UnknownStep, find_step, step_measures

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.evolutions import Evolutions

KINDS: Final = ("own", "step", "phrase", "formation", "element", "look")
"""The pages of pads, in order; scenes and cues share one."""
LANES: Final = {
    "step": "steps", "phrase": "steps", "formation": "motion", "element": "elements", "scene": "looks", "cue": "looks",
}  # fmt: skip
"""Dancers have one running pad in each of these."""
SHAPES: Final = ("line", "circle", "grid", "triangle", "star", "spiral")
"""Formations by notation, besides those of the show."""
MAX_PADS: Final = 256
"""Maximum number of pads of a page."""
DEFAULT_MEASURES: Final = 4.0
FOLLOWS: Final = ("stop", "again", "next", "first", "other")
_Points = tuple[tuple[float, float], ...]
_ELEMENTS: Final[dict[str, tuple[str, _Points, str]]] = {
    "attract": ("gather in the middle", ((0.0, 0.0),), ""),
    "repel": ("away from the middle", ((0.0, 0.0),), ""),
    "spread": ("spread out", ((0.0, 0.0),), ""),
    "cross": ("change sides", ((0.0, -2.0), (0.0, 2.0)), ""),
    "vortex": ("around the middle", ((0.0, 0.0),), "vortex"),
    "wander": ("wander", ((0.0, 0.0),), ""),
    "flock": ("as a flock", ((0.0, 0.0),), ""),
    "pause": ("stay", (), ""),
}
"""Elements by name: in words, their points [m], and their kind of flow; a pause has no points."""


@dataclass(frozen=True, slots=True)
class Pad:
    """Something that can be launched."""

    kind: str
    """A key of `LANES`."""
    name: str
    words: str = ""
    """What it does, in a few words."""
    own: str = ""
    """The name of its `[[pad]]`; empty if it has none."""
    measures: float = DEFAULT_MEASURES
    follow: str = "stop"

    @property
    def text(self) -> str:
        """Kind and name, as `/dance/launch` takes them."""
        return f"own {self.own}" if self.own else f"{self.kind} {self.name}"

    @property
    def lane(self) -> str:
        """Of what dancers have one at a time."""
        return "motion" if (self.kind, self.name) == ("element", "pause") else LANES[self.kind]


class Pads:
    """All pads of a show, in the order in which pages and controllers show them. Thread: the show's."""

    def __init__(self, patch: Patch, dancers: "Dancers", evolutions: "Evolutions") -> None:
        """Raises PersonError for a `[[pad]]` that does nothing there is."""
        self._patch, self._dancers, self._evolutions = patch, dancers, evolutions
        for index, pad in enumerate(patch.pad):
            with error_context(f"pad {pad.name!r}", ("pad", index, "does")):
                self._find_shared(pad.does)

    def apply_patch(self, fresh: "Pads") -> None:
        """Offer what another patch has."""
        self._patch = fresh._patch

    # -- lists -------------------------------------------------------------------------------------------------------

    def page(self, kind: str) -> tuple[Pad, ...]:
        """Return the pads of a page of `KINDS`, at most `MAX_PADS`."""
        pages = {
            "own": self._own_pads, "step": self._step_pads, "phrase": self._phrase_pads,
            "formation": self._formation_pads, "element": self._element_pads, "look": self._look_pads,
        }  # fmt: skip
        return tuple(itertools.islice(pages[kind](), MAX_PADS))

    def _own_pads(self) -> Iterator[Pad]:
        for each in self._patch.pad:
            kind, _, name = each.does.strip().partition(" ")
            yield Pad(kind.casefold(), name.strip(), each.does, each.name, float(each.measures), each.follow)

    def _step_pads(self) -> Iterator[Pad]:
        graph = self._dancers.graph
        for index, name in enumerate(graph.library.steps):
            if len(graph.entries(index)):
                measures = step_measures(graph, index)
                yield Pad("step", name, "1 measure" if measures == 1 else f"{measures} measures")

    def _phrase_pads(self) -> Iterator[Pad]:
        for number, section in enumerate(self._patch.sequence, start=1):
            if section.choose == "sequence":
                yield Pad("phrase", section.name or str(number), ", ".join(section.steps)[:100])

    def _formation_pads(self) -> Iterator[Pad]:
        own = self._evolutions.formations
        yield from (Pad("formation", formation.name, "of this show") for formation in own.values())
        yield from (Pad("formation", name) for name in SHAPES if name not in own)

    def _element_pads(self) -> Iterator[Pad]:
        yield from (Pad("element", name, words) for name, (words, _, _) in _ELEMENTS.items())

    def _look_pads(self) -> Iterator[Pad]:
        yield from (Pad("scene", scene.name, "scene") for scene in self._patch.scene)
        yield from (Pad("cue", cue.name, "cue") for cue in self._patch.cue)

    # -- one pad -----------------------------------------------------------------------------------------------------

    def find(self, text: str) -> Pad:
        """Return the pad of a text as `step couru`. Raises PersonError for something that is not there."""
        kind, _, name = text.strip().partition(" ")
        if kind.casefold() != "own":
            return self._find_shared(text)
        folded = name.casefold().strip()
        own = next((pad for pad in self._own_pads() if pad.own.casefold().strip() == folded), None)
        if own is None:
            names = ", ".join(pad.name for pad in self._patch.pad)
            raise PersonError(f"no pad is called {name!r}", f"there are: {names}" if names else "the patch has none")
        return own

    def _find_shared(self, text: str) -> Pad:
        """Return a pad that is no `[[pad]]`."""
        kind, _, name = text.strip().partition(" ")
        kind, name = kind.casefold(), name.strip()
        if kind not in LANES or not name:
            raise PersonError(f"{text[:60]!r} is no pad", f"write a kind and a name; kinds are {', '.join(LANES)}, own")
        match kind:
            case "step":
                try:
                    name = self._dancers.graph.library.steps[find_step(self._dancers.graph, name)]
                except UnknownStep as error:
                    raise PersonError(str(error)) from None
            case "formation":
                name = self._evolutions.formation_name(name)
            case _:
                return self._find_listed(kind, name)
        return Pad(kind, name)

    def _find_listed(self, kind: str, name: str) -> Pad:
        folded = name.casefold()
        page = "look" if kind == "cue" else kind
        if kind == "scene":  # it may be stored live: the desk refuses one that does not exist
            return Pad("scene", name)
        found = [pad for pad in getattr(self, f"_{page}_pads")() if pad.kind == kind]
        for pad in found:
            if pad.name.casefold().strip() == folded:
                return Pad(kind, pad.name, pad.words)
        names = ", ".join(pad.name for pad in found)
        raise PersonError(f"no {kind} is called {name!r}", f"there are: {names}" if names else "the patch has none")

    def following(self, pad: Pad) -> tuple[Pad, ...]:
        """Return the pads among which the one after this pad is found: all of its kind, itself included."""
        if pad.own:
            return self.page("own")
        page = "look" if pad.kind in ("scene", "cue") else pad.kind
        return tuple(one for one in self.page(page) if one.kind == pad.kind)

    # -- events ------------------------------------------------------------------------------------------------------

    def event(
        self, pad: Pad, group: str, *, measures: float, after: int, ahead: bool, time: float, source: str
    ) -> ControlEvent:
        """Return the event that begins a pad for `group`, for `measures`, at `time` [s].

        `ahead`: it begins with the next measure, else now, and lasts for `after` whole measures after this one. Raises
        PersonError for a pad that is gone.
        """
        match pad.kind:
            case "step" if ahead:
                return events.CallStep(time=time, source=source, name=pad.name, measures=measures, group=group)
            case "step":
                return events.StepNow(time=time, source=source, name=pad.name, measures=after, group=group)
            case "phrase":
                return events.SetSequence(time=time, source=source, steps=self._phrase(pad.name), group=group)
            case "formation":
                return events.Evolve(
                    time=time, source=source, formation=pad.name, measures=measures, group=group, next=ahead
                )
            case "element" if pad.name == "pause":
                return events.Pause(time=time, source=source, measures=measures, group=group, next=ahead)
            case "element":
                _, points, flow = _ELEMENTS[pad.name]
                return events.PlaceElement(
                    time=time, source=source, kind="flow" if flow else pad.name, points=points, flow=flow,
                    measures=measures, group=group, next=ahead,
                )  # fmt: skip
            case "scene":
                return events.RecallScene(time=time, source=source, name=pad.name)
        return events.GiveCue(time=time, source=source, name=pad.name)

    def _phrase(self, name: str) -> str:
        """Return the steps of a phrase as `/dance/sequence` takes them."""
        for number, section in enumerate(self._patch.sequence, start=1):
            if section.choose == "sequence" and (section.name or str(number)) == name:
                return ", ".join(section.steps)
        raise PersonError(f"no phrase is called {name!r}")
