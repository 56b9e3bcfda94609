"""Handler for live requests to groups of dancers: steps, sequences, variation, partners and facing."""

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from live.base.arrays import Bool
from live.base.errors import PersonError
from live.control.events import events
from live.control.events.events import ControlEvent
from live.graph.search.live_sequence import HORIZON, LiveSequence
from live.graph.search.sequence import parse_sequence
from live.show.dancers.variation import Variation
from live.show.score.canon import Canon, StepSource
from live.show.score.step_names import UnknownStep, find_step
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion
    from live.show.partner.partner_response import PartnerResponse
    from live.show.selection.interrupts import Interrupts
    from live.show.selection.scheduler import Scheduler


class StepRequests:
    """Applies each request to its groups. Requests that are impossible are refused and change nothing."""

    def __init__(
        self,
        motion: "GroupMotion",
        dancers: "Dancers",
        variation: Variation,
        scheduler: "Scheduler",
        interrupts: "Interrupts",
    ) -> None:
        self._motion, self._casting = motion, motion.casting
        self._dancers, self._variation = dancers, variation
        self._scheduler, self._interrupts = scheduler, interrupts
        self.explained_dancer: int | None = None
        """The dancer (index) whose step choice is explained to an operator, None for none."""

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Apply an event of `EVENTS`. Raises PersonError for what is unknown or impossible."""
        try:
            self._HANDLERS[type(event)](self, event)
        except UnknownStep as error:
            raise PersonError(str(error)) from None

    def _clear(self, event: events.Clear) -> None:
        """Drop all requests."""
        self._interrupts.clear()
        self._scheduler.subgroups.clear()
        for programme in self._scheduler.programmes:
            programme.release()

    def _end_launch(self, event: events.LaunchEnded) -> None:
        """End a step or a sequence that was launched: back to the score."""
        if event.what not in ("step", "phrase"):
            return
        members = self._casting.groups_of(event.group)
        programs = self._subgroup_programs(event.group) if members is None else []
        for index in members or ():
            programs.append(self._scheduler.programmes[index])
            self._scheduler.subgroups.end_call(index)
        for program in programs:
            if event.what == "step":
                program.end_call()
            else:
                program.release()

    def _call_step(self, event: events.CallStep) -> None:
        step = find_step(self._dancers.graph, event.name)
        members = self._casting.groups_of(event.group)
        if members is None:
            for program in self._subgroup_programs(event.group):
                program.call(step, measures=event.measures)
            return
        for index in members:
            self._scheduler.programmes[index].call(step, measures=event.measures)
            self._scheduler.subgroups.call(index, step, measures=event.measures)

    def _step_now(self, event: events.StepNow) -> None:
        self._interrupts.cue(event)

    def _set_sequence(self, event: events.SetSequence) -> None:
        """Change a sequence if its dancers can reach it within two measures; else nothing changes."""
        members, graph = self._casting.groups_of(event.group), self._dancers.graph
        wanted = parse_sequence(event.steps, graph.library)
        danced = self._dancers.coming if self._dancers.decided else self._dancers.present
        nodes = danced.node[self._select(event.group) if members is None else np.isin(self._casting.group, members)]
        if LiveSequence(graph, []).feasible_delay(wanted[: HORIZON + 1], nodes) is None:
            raise PersonError(f"{event.steps!r} cannot be joined from here", "`live dance` reports what is missing")
        if members is None:
            for program in self._subgroup_programs(event.group):
                program.set_sequence(wanted)
            return
        for index in members:
            programme = self._scheduler.programmes[index]
            self._scheduler.subgroups.drop_requested(index)
            if len(members) == 1 or not isinstance(programme, Canon):  # for all groups, echoes stay echoes
                programme.set_sequence(wanted)

    def _set_partner(self, event: events.SetPartner) -> None:
        answering = self._partner_response()
        if event.parameter not in ("on", "amount", "window", "hands"):
            raise PersonError(f"a partner has no parameter {event.parameter!r}", "one of on, amount, window, hands")
        value = event.value >= 0.5 if event.parameter == "on" else event.value
        answering.set_value(event.partner, event.parameter, value)

    def _style_partner(self, event: events.StylePartner) -> None:
        self._partner_response().set_style(event.partner, event.style)

    def _pair_partner(self, event: events.PairPartner) -> None:
        answering = self._partner_response()
        if event.role not in ("leader", "follower"):
            raise PersonError(f"a partner has no role {event.role!r}", "leader or follower")
        for index in answering.find(event.partner):
            path = event.role == "leader" and event.who.strip().casefold() == "path"
            if event.role == "leader" and path != answering.settings[index].by_path:
                raise PersonError(
                    f"partner {answering.settings[index].name!r} is led by "
                    f"{'a path' if not path else 'dancers'}: its examples fit only that",
                    "add another [[partner]] to the patch",
                )
        answering.set_value(event.partner, event.role, event.who)

    def _walk_on(self, event: events.WalkOn) -> None:
        self._partner_response().extend_path(event.partner, (event.x, event.z), restart=event.anew)

    def _partner_response(self) -> "PartnerResponse":
        if self._dancers.partner_response is None:
            raise PersonError("the show has no partners", "add [[partner]] to the patch")
        return self._dancers.partner_response

    def _set_facing(self, event: events.SetFacing) -> None:
        headings = self._scheduler.targets.headings
        headings.set(self._casting.groups_of(event.group), self._select(event.group), headings.parse(event.facing))

    def _improvise(self, event: events.Improvise) -> None:
        members = self._casting.groups_of(event.group)
        if members is None:
            for program in self._subgroup_programs(event.group):
                program.improvise(event.on)
            return
        for index in members:
            self._scheduler.subgroups.drop_requested(index)
            self._scheduler.programmes[index].improvise(event.on)

    def _ask_why(self, event: events.AskWhy) -> None:
        self.explained_dancer = event.dancer - 1 if 1 <= event.dancer <= len(self._casting.group) else None

    def _select(self, words: str) -> Bool:
        """Return the dancers that words select, (A,). PersonError if there are none."""
        who = self._casting.select(words, self._motion.state.position)
        if not who.any() and self._casting.groups_of(words) is None:
            raise PersonError(f"{words!r}: nobody is there now", "groups are " + ", ".join(self._casting.names))
        return who

    def _subgroup_programs(self, words: str) -> list[StepSource]:
        return [*self._scheduler.subgroups.request(words.strip(), self._select(words))]

    _HANDLERS: ClassVar[dict[type[ControlEvent], Callable[..., None]]] = {
        events.CallStep: _call_step,
        events.StepNow: _step_now,
        events.SetSequence: _set_sequence,
        events.SetPartner: _set_partner,
        events.StylePartner: _style_partner,
        events.WalkOn: _walk_on,
        events.PairPartner: _pair_partner,
        events.SetFacing: _set_facing,
        events.Improvise: _improvise,
        events.AskWhy: _ask_why,
        events.Clear: _clear,
        events.LaunchEnded: _end_launch,
    }
    EVENTS = tuple(_HANDLERS)
