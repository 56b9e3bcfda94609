"""Launcher: what was launched for which dancers, from the request to its end and what follows it.

Beats are danced beats: (measure + phase) times the beats of a measure. Everything happens in ticks and is in snapshots,
so replays and standbys launch the same.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.base.arrays import Int32
from live.base.errors import PersonError
from live.control.events import events
from live.control.events.event import ControlEvent
from live.graph.structure_rules import UNREACHABLE
from live.show.dancers.rng import Purpose, generator_for
from live.show.desk.pad import FOLLOWS, Pad, Pads
from live.show.desk.refusals import Refusals
from live.show.group.casting import EVERYONE, Casting
from live.show.group.division import dancer_words
from live.show.patch.patch import Patch
from live.show.score.playhead import Place, Playhead
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.selection.scheduler import Scheduler

WHENS: Final = ("now", "beat", "measure", "section")
AHEAD_BEATS: Final = 2.0
"""What begins on a measure line is called so many beats before it: a little before the measure is planned."""
CHOICE_BEATS: Final = 2.75
"""So many beats before the end of a pad the next one is chosen, and waits."""
LATE_BEATS: Final = 1.0
"""A request that waited longer than this past its beat (the show was held) waits for the next one of its kind."""
PHRASE_MEASURES: Final = 8
"""A phrase of music without a map, and of a score without sections [measures]."""
MAX_LAUNCHES: Final = 128
"""Maximum number of pads that wait, and of those that run."""
EPSILON: Final = 1e-9
Issue = Callable[[Iterable[ControlEvent]], None]


@dataclass(frozen=True, slots=True)
class Launched:
    """A pad launched for some dancers."""

    pad: Pad
    group: str
    """The dancers, `*` for everybody."""
    when: str
    due: float
    """Beat at which it begins; inf: nobody knows yet."""
    measures: float
    follow: str
    number: int
    """Number of the launch in this show."""
    called: bool = False
    """Whether its event was issued ahead of its measure line."""
    ends: float = math.inf
    """Beat at which it ends; -inf, or just after its beginning: it was stopped."""
    ended: bool = False
    """Whether its end was issued."""

    @property
    def key(self) -> str:
        """What it replaces another launch of: its lane, and its dancers."""
        return f"{self.pad.lane} {self.group.casefold()}"

    @property
    def source(self) -> str:
        """Source of its events."""
        return f"launch {self.number}"


def _end_event(one: Launched) -> events.LaunchEnded:
    what = one.pad.kind if one.pad.lane == "steps" else one.pad.lane
    return events.LaunchEnded(time=0.0, source=one.source, what=what, group=one.group)


class Launcher:
    """The launches of one show. Thread: the show's."""

    EVENTS = (events.Launch, events.StopLaunches, events.Clear)

    def __init__(
        self,
        patch: Patch,
        pads: Pads,
        refusals: Refusals,
        *,
        seed: int,
        casting: Casting,
        playhead: Playhead,
        dancers: "Dancers",
        scheduler: "Scheduler",
    ) -> None:
        self.pads = pads
        """What can be launched."""
        self.waiting: dict[str, Launched] = {}
        """Launches that have not begun, by `Launched.key`."""
        self.running: dict[str, Launched] = {}
        """Launches that have begun and not ended."""
        self.refused: dict[str, tuple[str, str, str]] = {}
        """Pad, dancers and reason of the last launch that was refused when it was due, by key."""
        self._patch, self._refusals, self._seed = patch, refusals, seed
        self._casting, self._playhead, self._dancers, self._scheduler = casting, playhead, dancers, scheduler
        self._count = 0
        self._course: tuple[object, ...] = ()

    def apply_patch(self, fresh: "Launcher") -> None:
        """Use another patch. What runs goes on; what waits for something that is gone is refused when it is due."""
        self._patch = fresh._patch
        self.pads.apply_patch(fresh.pads)

    # -- requests ----------------------------------------------------------------------------------------------------

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event of `EVENTS`. Raises PersonError for something that is not there."""
        match event:
            case events.Launch():
                self._launch(event, now)
            case events.StopLaunches():
                self._stop(event.group)
            case _:  # the other parts end everything
                self.waiting.clear()
                self.running.clear()
                self.refused.clear()

    def _launch(self, event: events.Launch, now: Now) -> None:
        pad = self.pads.find(event.pad)
        for word, known, what in ((event.when, WHENS, "when"), (event.follow or "stop", FOLLOWS, "follow")):
            if word not in known:
                raise PersonError(f"{what} {word!r} is unknown", f"there are: {', '.join(known)}")
        group = event.group.strip()
        everybody = group in EVERYONE or pad.lane == "looks"
        who = self._casting.select(group, now.position)
        if not who.any():
            raise PersonError(f"{group!r}: nobody is there now")
        if self._casting.depends_on_places(group):  # a place counts once, now: the same dancers end it
            group = dancer_words((np.flatnonzero(who) + 1).tolist())
        self._count += 1
        made = Launched(
            pad, "*" if everybody else group, event.when, 0.0, event.measures or pad.measures,
            event.follow or pad.follow, self._count,
        )  # fmt: skip
        if made.key not in self.waiting and len(self.waiting) >= MAX_LAUNCHES:
            raise PersonError(f"{MAX_LAUNCHES} pads wait already", "/dance/launch/stop stops them")
        self.refused.pop(made.key, None)
        self.waiting[made.key] = replace(made, due=self._due(made, now))

    def _stop(self, group: str) -> None:
        """Stop what was launched for these dancers, everything for everybody."""
        folded = group.casefold().strip()
        for key, one in [*self.waiting.items()]:
            if folded in EVERYONE or one.group.casefold() == folded:
                del self.waiting[key]
                if one.called:  # it is planned: it ends as soon as it has begun
                    self.running[key] = replace(one, ends=one.due + EPSILON, follow="stop")
        for key, one in [*self.running.items()]:
            if (folded in EVERYONE or one.group.casefold() == folded) and one.ends > one.due + EPSILON:
                self.running[key] = replace(one, ends=-math.inf, follow="stop", ended=False)

    # -- undo --------------------------------------------------------------------------------------------------------

    def edited_values(self, event: ControlEvent) -> dict[str, Launched]:
        """Return what waits, see `EditablePart`."""
        return dict(self.waiting)

    def restore_values(self, values: Mapping[str, Launched | None]) -> None:
        """Let these launches wait again; for None what waits is withdrawn, or what runs already is stopped."""
        for key, one in values.items():
            before = self.waiting.get(key)
            if one is not None:
                self.waiting[key] = replace(one, due=-math.inf, called=False)
            elif before is not None:
                self._stop_one(self.waiting, key)
            else:
                self._stop_one(self.running, key)

    def _stop_one(self, launches: dict[str, Launched], key: str) -> None:
        one = launches.pop(key, None)
        if one is None or (launches is self.waiting and not one.called):
            return
        ends = one.due + EPSILON if launches is self.waiting else -math.inf
        self.running[key] = replace(one, ends=ends, follow="stop", ended=False)

    # -- time --------------------------------------------------------------------------------------------------------

    def fire(self, now: Now, danced: float, issue: Issue) -> None:
        """Begin and end what is due by the danced beat `danced`. `issue` passes events to their parts."""
        if not self.waiting and not self.running:
            return
        self._update_course(now, danced)
        for key, one in [*self.running.items()]:
            self._continue(key, one, now, danced, issue)
        for one in sorted(self.waiting.values(), key=lambda one: (one.due, one.number)):
            if one.due <= danced:
                self._begin(one, now, issue)
            elif not one.called and self._is_ahead(one) and danced >= one.due - AHEAD_BEATS:
                self._call_ahead(one, now, issue)

    def _is_ahead(self, one: Launched) -> bool:
        """Whether it is called before its measure line, so that the measure is planned with it."""
        return one.pad.lane != "looks" and (one.when in ("measure", "section") or one.pad.kind == "phrase")

    def _update_course(self, now: Now, danced: float) -> None:
        """Find the beats of launches that wait for a section, and of those that were held."""
        course = self._playhead.course
        moved, self._course = course != self._course, course
        for key, one in self.waiting.items():
            late = one.due < danced - LATE_BEATS
            if not one.called and (late or (moved and one.when == "section")):
                self.waiting[key] = replace(one, due=self._due(one, now))

    def _due(self, one: Launched, now: Now) -> float:
        """Return the next beat at which a launch may begin."""
        beats, line = now.measure_beats, now.span.number + 1
        danced = now.danced_beats
        if one.when == "section":
            begin = self._playhead.next_begin(max(line, 0), self._begins)
            return math.inf if begin is None else float(begin * beats)
        if one.when == "measure" or one.pad.kind == "phrase":
            return float(line * beats)
        return danced if one.when == "now" else float(math.ceil(danced - EPSILON))

    def _begins(self, place: Place) -> bool:
        """Whether a section of the score begins at this place; without sections, whether a phrase does."""
        if self._patch.section or place.measure == 0:
            return place.measure == 0
        phrases = self._patch.music.phrase
        written = self._playhead.written_measure(place)
        return any(one.measure == written + 1 for one in phrases) if phrases else written % PHRASE_MEASURES == 0

    def _call_ahead(self, one: Launched, now: Now, issue: Issue) -> None:
        """Call what begins with the next measure, if that can still be planned."""
        if one.pad.lane == "steps":
            if not self._scheduler.replan(now.span, now.timeline, now.time):
                if one.pad.kind == "phrase":  # a step is cut to on the line; a phrase begins with the next measure
                    self.waiting[one.key] = replace(one, due=one.due + now.measure_beats)
                return
            self._end_replaced(one, issue)
        if self._issue(one, now, issue, ahead=True):
            self.waiting[one.key] = replace(one, called=True)

    def _begin(self, one: Launched, now: Now, issue: Issue) -> None:
        """Begin what is due; what was not called ahead is called now."""
        del self.waiting[one.key]
        self._end_replaced(one, issue)
        if not one.called and not self._issue(one, now, issue, ahead=one.pad.kind != "step" and self._is_ahead(one)):
            return
        for key in self._replaced(one):
            del self.running[key]
        if len(self.running) >= MAX_LAUNCHES:
            issue([_end_event(self.running.pop(next(iter(self.running))))])
        self.running[one.key] = replace(one, ends=self._end(one, now))

    def _end(self, one: Launched, now: Now) -> float:
        """Return the measure line at which it ends, at least its measures after its beginning."""
        beats = now.measure_beats
        return math.ceil((one.due / beats + math.ceil(one.measures - EPSILON)) - EPSILON) * beats

    def _issue(self, one: Launched, now: Now, issue: Issue, *, ahead: bool) -> bool:
        """Issue the event of a launch; False if it was refused."""
        beats = now.measure_beats
        ends = self._end(one, now)
        line = (math.floor(one.due / beats + EPSILON) + 1) * beats
        lasts = one.measures if one.pad.lane == "motion" else (ends - one.due) / beats
        before, reason = self._refusals.count, ""
        try:
            called = self.pads.event(
                one.pad, one.group, measures=lasts, after=max(round((ends - line) / beats), 0), ahead=ahead,
                time=now.time, source=one.source,
            )  # fmt: skip
        except PersonError as error:
            reason = str(error)
        else:
            issue([called])
            if self._refusals.count == before:
                return True
            reason = self._refusals.last_reason
        self.waiting.pop(one.key, None)
        self.refused.pop(one.key, None)
        self.refused[one.key] = (one.pad.text, one.group, reason[:300])
        if len(self.refused) > MAX_LAUNCHES:
            del self.refused[next(iter(self.refused))]
        return False

    def _replaced(self, one: Launched) -> list[str]:
        """Return the keys of what runs and a launch replaces; one for everybody replaces those for groups."""
        return [
            key
            for key, other in self.running.items()
            if key == one.key or (one.group == "*" and other.pad.lane == one.pad.lane)
        ]

    def _end_replaced(self, one: Launched, issue: Issue) -> None:
        """End what a launch replaces and would go on by itself; nothing follows it."""
        for key in self._replaced(one):
            other = self.running[key]
            if not other.ended and (other.pad.kind == "phrase" or other.pad.lane == "elements"):
                issue([_end_event(other)])
            self.running[key] = replace(other, ended=True, follow="stop")

    def _continue(self, key: str, one: Launched, now: Now, danced: float, issue: Issue) -> None:
        """Let a running launch go on: it begins later, something follows it, it ends."""
        if one.ends == -math.inf or one.due < one.ends < one.due + 2.0 * EPSILON < danced:  # stopped
            del self.running[key]
            if one.pad.lane != "looks":
                issue([_end_event(one)])
            return
        if danced >= one.due and self._waits_for_dancers(one):
            self.running[key] = replace(one, due=one.due + now.measure_beats, ends=one.ends + now.measure_beats)
            return
        if one.follow != "stop" and danced >= one.ends - CHOICE_BEATS:
            self._choose_next(one)
            one = self.running[key] = replace(one, follow="stop")
        if one.pad.kind == "phrase" and not one.ended and danced >= one.ends - AHEAD_BEATS:
            self.running[key] = replace(one, ended=True)
            issue([_end_event(one)])
        if one.ends <= danced:
            del self.running[key]

    def _choose_next(self, one: Launched) -> None:
        """Let the pad wait that follows this one, unless another one waits already."""
        pad = self._next(one)
        self._count += 1
        measures, follow = (pad.measures, pad.follow) if pad.own else (one.measures, one.follow)
        made = Launched(pad, one.group, "measure", one.ends, measures, follow, self._count)
        if one.key not in self.waiting:
            self.waiting.setdefault(made.key, made)

    # -- what can follow -----------------------------------------------------------------------------------------

    def _waits_for_dancers(self, one: Launched) -> bool:
        """Whether a step was called ahead, and its dancers are still within another one of several measures."""
        if one.pad.kind != "step" or not one.called:
            return False
        groups = self._casting.groups_of(one.group)
        step = self._dancers.graph.library.step_index(one.pad.name)
        return groups is not None and all(self._scheduler.programmes[index].waits_for(step) for index in groups)

    def measures_away(self, group: str) -> "Int32":
        """Return for each step how many measures these dancers need before the last of them can dance it, (steps,).

        0: it can follow at once; UNREACHABLE: never. None of them on the stage: 0.
        """
        graph = self._dancers.graph
        groups = self._casting.groups_of(group)
        nodes = self._dancers.coming.node if self._dancers.decided else self._dancers.present.node
        if groups is not None and len(groups) < len(self._casting.names):
            nodes = nodes[np.isin(self._casting.group, groups)]
        nodes = np.unique(nodes)
        if not len(nodes):
            return np.zeros(len(graph.library.steps), np.int32)
        hops = graph.hops[:, nodes].max(axis=1)
        return np.asarray(np.where(hops >= UNREACHABLE, UNREACHABLE, np.maximum(hops - 1, 0)), np.int32)

    def _next(self, one: Launched) -> Pad:
        """Return the pad that follows: steps that cannot follow at once are left out."""
        if one.follow == "again":
            return one.pad
        pads = self.pads.following(one.pad)
        steps, away = self._dancers.graph.library, self.measures_away(one.group)

        def fits(pad: Pad) -> bool:
            index = steps.step_index(pad.name) if pad.kind == "step" else None
            return index is None or away[index] == 0

        place = next((index for index, pad in enumerate(pads) if pad.text == one.pad.text), -1)
        others = [*pads[place + 1 :], *pads[: max(place, 0)]]
        if one.follow == "first":
            others = list(pads)
        fitting = [pad for pad in others if fits(pad)]
        if not fitting:
            return one.pad
        if one.follow != "other":
            return fitting[0]
        chance = generator_for(self._seed, Purpose.FOLLOW, one.number)
        return fitting[int(chance.integers(len(fitting)))]

    # -- reports -----------------------------------------------------------------------------------------------------

    def facts(self) -> dict[str, Any]:
        """Return what waits and runs, for the status."""
        return {
            "waiting": {key: one.pad.text for key, one in self.waiting.items()},
            "running": {key: one.pad.text for key, one in self.running.items()},
            "launched": self._count,
        }
