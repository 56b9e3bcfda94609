"""Audience of a show: elements, lights and votes from phones, limited by the operator (T002, T150).

The gateway (`live/control/audience`) sends one aggregated event per tick at most. All behaviour follows from events and
measure lines alone, so that a replay has the same audience.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Int64
from live.base.errors import PersonError
from live.base.stage_snapshot import LIGHT_CAPACITY, StageView
from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.audience import VoiceLight
from live.control.events.elements import PlaceElement
from live.control.events.events import ControlEvent
from live.control.registry.element_controls import VOICE_MEASURES
from live.show.audience.voting import NO_BAR, Turn, Vote, VoteNames, resolve_choices, winner_events
from live.show.audience.words import WORD_EVENTS, Words
from live.show.group.elements import SCORE, Elements
from live.show.patch.section_io import AudienceSection
from live.show.stages.now import Now

AUDIENCE_EVENTS: Final = (
    events.AudienceHeard, events.OpenAudience, events.SetAudienceGain, events.MuteAudience, events.WeighRegion,
    events.GiveTurn, events.BanPhone, events.AskVote, events.DropVote, events.ShowTally, events.RenewInvitation,
    events.AllowShaking, *WORD_EVENTS,
)  # fmt: skip
"""Events that `handle` handles."""
_SWITCHES: Final[Mapping[type, str]] = {
    events.MuteAudience: "muted", events.AllowShaking: "shaking", events.ShowTally: "tally",
}  # fmt: skip
SOURCE: Final = "audience"
FULL_VOICES: Final = 4.0
"""Votes that pull with full strength: see `QUORUM` of the fair kernels."""
MAX_PLACES: Final = 4
LED_GAIN: Final = 0.25
"""Audience gain while an element of an operator or musician is active."""
SHARPNESS: Final = 4.0
"""Sharpness of repulsion: a place with half the weight of the heaviest repels 2 to the power of this less."""
SHAKE_BEGIN: Final = 0.5
SHAKE_END: Final = 0.3
"""A spread starts above the first share of shaking players, and again only after the share fell below the second."""
MAX_BANNED: Final = 4096
LIGHT_MOVE_HALFLIFE: Final = 0.06
"""Half-life [s] of a light's approach to its phone's position."""
LIGHT_FADE_HALFLIFE: Final = 0.12
"""Half-life [s] of a light's fade in and out."""
CAPTION_FADE_BEATS: Final = 2.0
"""The winner's name fades out within this many beats."""
REPEL_MODE: Final = 2
"""Mode of a touch that repels dancers."""


@dataclass(frozen=True, slots=True)
class TouchCluster:
    """Cluster of touches: position (x, z) [m], weight relative to the heaviest place, and whether it repels."""

    x: float
    z: float
    weight: float
    repels: bool


class Audience:
    """The audience of one show. Thread: the show's."""

    EVENTS = AUDIENCE_EVENTS

    def __init__(
        self, section: AudienceSection, elements: Elements, names: VoteNames, words: Words, *, seed: int
    ) -> None:
        """The audience moves the `elements`, votes on the `names`, and says `words`."""
        self.words = words
        self._elements, self._names = elements, names
        self._seed = seed
        self.regions: tuple[str, ...] = section.regions
        self._vote_measures, self._winner_measures = section.vote_measures, section.winner_measures
        self.open, self.gain, self.muted, self.shaking = section.open, section.gain, False, section.shake
        self.weights: list[float] = [1.0] * len(section.regions)
        """Weight of each region's votes and touches."""
        self.turn: Turn | None = None
        self.vote: Vote | None = None
        self.result: tuple[int, str] = (0, "")
        """Number of the last vote and its winner; empty: none."""
        self._result_measure = 0
        """The measure (from 0) that began when the last vote closed."""
        self.tally = section.tally
        """Whether projectors show the state of a vote, and its winner."""
        self.invitation = 1
        """Number of the present invitation for the operator's team; a new one makes the one before void."""
        self.banned: dict[int, None] = {}
        """Numbers of banned phones, oldest first."""
        self.command_count = 0
        """Number of operator commands the gateway has to follow; aggregates made before the last one are ignored."""
        self.phones = 0
        self._votes = 0
        self._share = 0.0
        self._places: tuple[TouchCluster, ...] = ()
        self._shaken = False
        self._number: Int64 = np.zeros(LIGHT_CAPACITY, np.int64)
        """Phone number of each light; 0: unused."""
        self._light_on: npt.NDArray[np.bool_] = np.zeros(LIGHT_CAPACITY, np.bool_)
        self._goal: Float32 = np.zeros((LIGHT_CAPACITY, 2), np.float32)
        self._light: Float32 = np.zeros((LIGHT_CAPACITY, 5), np.float32)

    def apply_patch(self, fresh: "Audience") -> None:
        """Adopt the regions of an edited patch; weights are kept by name."""
        if fresh.regions != self.regions:
            known = dict(zip(self.regions, self.weights, strict=True))
            self.regions, self.weights = fresh.regions, [known.get(name, 1.0) for name in fresh.regions]
            self.turn = None
            self.command_count += 1
        self._vote_measures, self._winner_measures = fresh._vote_measures, fresh._winner_measures

    # -- events ------------------------------------------------------------------------------------------------

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event of `AUDIENCE_EVENTS`; raises PersonError if it names unknown parts."""
        if type(event) in WORD_EVENTS:
            self.words.handle(event, now)
            return
        if isinstance(event, events.AudienceHeard):
            self._handle_input(event)
        else:
            self._handle_command(event, now.span.number)
        self._apply_places(event.time, now)

    def _handle_command(self, event: ControlEvent, measure: int) -> None:
        """Handle an operator command within `measure`."""
        match event:
            case events.OpenAudience():
                self.open = event.on
                if not event.on:
                    self._places, self._share = (), 0.0
                    self._number[:] = 0
                    self._light_on[:] = False
            case events.SetAudienceGain():
                self.gain = event.gain
            case events.MuteAudience() | events.AllowShaking() | events.ShowTally():
                setattr(self, _SWITCHES[type(event)], event.on)
            case events.WeighRegion():
                for index in self._region_indices(event.name):
                    self.weights[index] = event.weight
            case events.GiveTurn():
                named = self._region_indices(event.name)
                begins = measure + 1
                one = len(named) == 1 and event.name.strip() != "*"
                self.turn = Turn(named[0], begins, begins + max(round(event.measures), 1)) if one else None
            case events.BanPhone():
                self._ban(event.number, event.on)
            case events.AskVote():
                self._votes += 1
                closes = measure + 1 + self._vote_measures
                self.vote = Vote(self._votes, event.what, resolve_choices(event, self._names.known()), closes)
            case events.DropVote():
                self.vote = None
            case events.RenewInvitation():
                self.invitation += 1
        self.command_count += 1

    def _region_indices(self, name: str) -> list[int]:
        if name.strip() in ("", "*"):
            return list(range(len(self.regions)))
        folded = [each.casefold().strip() for each in self.regions]
        if name.casefold().strip() not in folded:
            there = f"there are: {', '.join(self.regions)}" if self.regions else "the patch's [audience] has none"
            raise PersonError(f"no region of the audience is called {name!r}", there)
        return [folded.index(name.casefold().strip())]

    def _ban(self, number: int, on: bool) -> None:
        if on and number > 0:
            self.banned[number] = None
            if len(self.banned) > MAX_BANNED:
                del self.banned[next(iter(self.banned))]
            self._light_on[self._number == number] = False
            self._light[self._number == number, 3] = 0.0
        elif not on:
            self.banned = {} if number <= 0 else {each: None for each in self.banned if each != number}

    # -- input from phones ---------------------------------------------------------------------------------------

    def _handle_input(self, event: events.AudienceHeard) -> None:
        self.phones = max(event.phones, 0)
        if event.order != self.command_count or not self.open:
            return
        if event.places is not None:
            self._share = min(max(event.share, 0), 1000) / 1000.0
            self._places = tuple(
                TouchCluster(x / 100, z / 100, w / 1000, mode == REPEL_MODE)
                for x, z, w, mode in event.places[:MAX_PLACES]
            )
        if event.lights is not None:
            self._update_lights(event.lights[:LIGHT_CAPACITY])
        if event.votes and self.vote is not None:
            self.vote = self.vote.with_counts(event.votes)
        share = event.shaken / 1000.0
        self._shaken = share > (SHAKE_END if self._shaken else SHAKE_BEGIN)

    def _update_lights(self, rows: tuple[VoiceLight, ...]) -> None:
        """Update the lights; those not listed fade out."""
        self._light_on[:] = False
        for number, x, z, hue, mode in rows:
            if number <= 0 or number in self.banned:
                continue
            own = np.flatnonzero(self._number == number)
            row = int(own[0]) if len(own) else int(np.argmin(np.where(self._light_on, 2.0, self._light[:, 3])))
            self._goal[row] = x / 100, z / 100
            if not len(own):
                self._light[row, :2], self._light[row, 3] = self._goal[row], 0.0
            self._number[row], self._light_on[row] = number, True
            self._light[row, 2], self._light[row, 4] = (hue % 1000) / 1000, float(mode == REPEL_MODE)

    def _apply_places(self, time: float, now: Now) -> None:
        """Apply the places as elements: attracting ones are fair to all voices."""
        elements = self._elements
        heard = self.open and not self.muted
        pull = self.gain * self._share if heard else 0.0
        if pull > 0.0 and _operator_active(elements, now.beat):
            pull *= LED_GAIN
        attracting = [place for place in self._places if not place.repels and pull > 0.0]
        total = sum(place.weight for place in attracting) or 1.0
        touches: dict[str, PlaceElement | None] = {}
        for index in range(MAX_PLACES):
            source = f"{SOURCE} {index + 1}"
            place = self._places[index] if index < len(self._places) and pull > 0.0 else None
            if place is None or place.weight <= 0.0:
                touches[source] = None
                continue
            share = place.weight**SHARPNESS if place.repels else FULL_VOICES * place.weight / total
            touches[source] = PlaceElement(
                time=time, source=source, kind="repel" if place.repels else "attract", points=((place.x, place.z),),
                strength=pull * share, measures=VOICE_MEASURES, fair=not place.repels, drag=True,
            )  # fmt: skip
        elements.handle_touches(touches, now, at_once=not heard)
        if self._shaken and self.shaking and heard and not elements.has_source(f"{SOURCE} shakes"):
            spread = PlaceElement(time=time, source=f"{SOURCE} shakes", kind="spread", measures=VOICE_MEASURES)
            elements.handle(spread, now)

    # -- time ----------------------------------------------------------------------------------------------------

    def begin_measure(self, measure: int, time: float) -> list[ControlEvent]:
        """Begin a measure (from 0): update turns, and return the events of a vote that closes."""
        turn = self.turn
        if turn is not None and measure in (turn.begins, turn.ends):
            self.command_count += 1
            self.turn = None if measure >= turn.ends else turn
        vote = self.vote
        if vote is None or measure < vote.closes:
            return []
        winner = vote.winner(self._seed)
        self.vote, self.result, self._result_measure = None, (vote.number, winner), measure
        self.command_count += 1
        return winner_events(vote.kind, winner, time) if winner else []

    def region_weights(self, measure: int) -> list[float]:
        """Return the weight of each region in a measure; during a turn all others have 0."""
        turn = self.turn
        if turn is None or not turn.begins <= measure < turn.ends:
            return list(self.weights)
        return [weight if index == turn.region else 0.0 for index, weight in enumerate(self.weights)]

    def tick(self) -> None:
        """Update light positions and fades; costs nothing without lights."""
        if not self._number.any():
            return
        light = self._light
        light[:, :2] += (self._goal - light[:, :2]) * np.float32(1.0 - 0.5 ** (TICK / LIGHT_MOVE_HALFLIFE))
        light[:, 3] += (self._light_on - light[:, 3]) * np.float32(1.0 - 0.5 ** (TICK / LIGHT_FADE_HALFLIFE))
        self._number[~self._light_on & (light[:, 3] < 0.01)] = 0

    # -- drawing -------------------------------------------------------------------------------------------------

    def show(self, view: StageView) -> None:
        """Copy the lights and the caption into the drawing snapshot, whose moment is known."""
        view.caption, view.caption_level = self._caption(view) if self.open and self.tally else ((), 1.0)
        rows = np.flatnonzero(self._number)
        view.light_count = len(rows)
        if len(rows):
            view.light[: len(rows)] = self._light[rows]

    def _caption(self, view: StageView) -> tuple[tuple[tuple[str, float], ...], float]:
        """Return the lines of the open vote, else of the last winner, and their opacity."""
        if self.vote is not None:
            return self.vote.shares, 1.0
        left = self._result_measure + self._winner_measures - view.measure
        if left <= 0 or not self.result[1]:
            return (), 1.0
        beats = left * view.beats_per_measure - view.phase
        return ((self.result[1], NO_BAR),), min(max(beats / CAPTION_FADE_BEATS, 0.0), 1.0)

    def facts(self) -> dict[str, Any]:
        """Return values for the status."""
        vote = self.vote
        return {
            "open": self.open, "muted": self.muted, "gain": round(self.gain, 3), "heard": round(self._share, 3),
            "regions": dict(zip(self.regions, self.weights, strict=True)),
            "turn": None if self.turn is None else self.regions[self.turn.region],
            "places": len(self._places), "banned": list(self.banned)[-16:],
            "lights": [[int(self._number[row]), *(round(float(v), 1) for v in self._light[row, :2])]
                       for row in np.flatnonzero(self._number)],
            "vote": None if vote is None else {"what": vote.kind, "closes": vote.closes + 1} | vote.tally,
            "won": self.result[1], "words": self.words.facts(),
        }  # fmt: skip


def _operator_active(elements: Elements, beat: float) -> bool:
    """Whether an element of an operator or musician is active; these have priority over the audience."""
    return any(
        element.source != SCORE and not element.source.startswith(SOURCE) and not element.fair
        and element.level(beat) > 0.0
        for element in elements.in_force
    )  # fmt: skip
