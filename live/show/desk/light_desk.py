"""Light desk and stage manager of a show: parameters and fades, scenes, cues, panic, undo, and the picture's master.

The master sets the light level of the whole picture, freezes it, and lifts the flash limit.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from live.base.picture_parameters import BY_ADDRESS, GOBO_TURN, MAX_BACKGROUNDS
from live.base.scalar_kernels import damper
from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.dancers.variation import Variation
from live.show.desk.camera_director import CameraDirector
from live.show.desk.camera_framing import Framing
from live.show.desk.camera_rig import CameraRig, Spots, check_follow
from live.show.desk.camera_subjects import Subjects
from live.show.desk.cue_list import CueList
from live.show.desk.parameter_table import ParameterTable
from live.show.desk.parameters import Parameters
from live.show.desk.scenes import SCENE_EVENTS, Scenes, is_locked, start_row
from live.show.desk.score_light import ScoreLight
from live.show.desk.titles import TITLE_EVENTS, Titles
from live.show.desk.undo_history import EditablePart, UndoHistory
from live.show.patch.patch import Patch
from live.show.score.score_runner import ScoreRunner
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion

MASTER_EVENTS: Final = (
    events.FadePicture,
    events.FreezePicture,
    events.AllowFlashes,
    events.ShowCard,
    events.ShowJoinCard,
)
"""Events that `Master.act` handles."""
MIN_FADE_BEATS: Final = 0.125
"""Minimum length of a fade [beats]: quick, but no flash."""
ALL_OUTPUTS: Final = "*"
MAX_CARDS: Final = 64
"""Maximum number of outputs whose cards are kept; names come over the network."""


class Master:
    """Level, freeze and flash limit of the whole picture, after all scenes, cues and looks. Thread: the show's."""

    def __init__(self) -> None:
        self.level = 1.0
        """Present share of the light."""
        self.frozen = False
        """Whether the picture is frozen."""
        self.flashes = False
        """Whether the limit on flashes is lifted."""
        self.goal = 1.0
        """Share of the light at the end of the fade."""
        self.cards: dict[str, str] = {}
        """Requested test cards, by the output's case-folded name, in order; `*`: all outputs.

        Names and cards are checked where the windows are; they are kept here for a warm standby.
        """
        self._from = 1.0
        self._length, self._elapsed = 1.0, 1.0

    def handle(self, event: events.ControlEvent) -> None:
        """Handle an event of `MASTER_EVENTS`."""
        match event:
            case events.FadePicture():
                self._from, self.goal = self.level, event.level
                self._length, self._elapsed = max(event.beats, MIN_FADE_BEATS), 0.0
            case events.FreezePicture():
                self.frozen = event.on
            case events.AllowFlashes():
                self.flashes = event.on
            case events.ShowCard() | events.ShowJoinCard():
                self._show_card(event.output.strip().casefold(), event.card.strip().casefold())

    def _show_card(self, output: str, card: str) -> None:
        if output == ALL_OUTPUTS:
            self.cards.clear()
        self.cards.pop(output, None)
        if card != "off" or ALL_OUTPUTS in self.cards:
            self.cards[output] = card
        while len(self.cards) > MAX_CARDS:
            self.cards.pop(next(iter(self.cards)))

    def tick(self, beats: float) -> None:
        """Advance by `beats`."""
        if self._elapsed >= self._length:
            return
        self._elapsed += beats
        share = min(self._elapsed / self._length, 1.0)
        eased = share * share * (3.0 - 2.0 * share)
        self.level = self.goal if share >= 1.0 else self._from + (self.goal - self._from) * eased

    def status_lines(self) -> tuple[str, ...]:
        """Return the overlay's lines; none in the normal state."""
        lines = ["FROZEN: the picture stands still"] if self.frozen else []
        if self.level < 1.0:
            lines.append(f"faded to {self.level:.0%}")
        if self.flashes:
            lines.append("flashes are not limited")
        return tuple(lines)

    def facts(self) -> dict[str, float | bool]:
        """Return values for the status."""
        return {"level": round(self.level, 3), "frozen": self.frozen, "flashes": self.flashes}


DESK_EVENTS: Final = (
    *SCENE_EVENTS, *TITLE_EVENTS, events.Go, events.GiveCue, events.StandBy, events.StepBack, events.Panic,
    events.HoldShow, events.Undo, events.Redo, events.FollowSpot, *MASTER_EVENTS,
)  # fmt: skip
"""Events that `LightDesk.handle` handles."""
_BACKGROUND_ROWS: Final = np.array(
    [BY_ADDRESS[f"/dance/background/{number}"].first for number in range(1, MAX_BACKGROUNDS + 1)]
)
ENERGY_HALFLIFE: Final = 0.25
"""Half-life of the light's response to the energy of the music [s]."""
PANIC_FADE_BEATS: Final = 2.0
"""Fade time to the patch's own light after a panic [beats]."""


class LightDesk:
    """The desk of one show. Its effects on the show are returned as events. Thread: the show's."""

    EVENTS = (*DESK_EVENTS, events.TicksSkipped)

    def __init__(
        self,
        patch: Patch,
        score_runner: ScoreRunner,
        motion: "GroupMotion",
        variation: Variation,
        editable: Mapping[str, EditablePart],
        dancers: "Dancers",
        *,
        seed: int,
    ) -> None:
        """`editable`: other parts whose edits can be undone, by the names in `ControlEvent.edits`.

        Raises PersonError for a scene that names unknown parts.
        """
        table = ParameterTable([section.name for section in patch.group])
        beats = patch.clock.beats_per_measure
        self.parameters = Parameters(table, start_row(patch), variation, motion, beats=beats)
        self.camera_rig = CameraRig(self.parameters, motion, patch.camera.follow, beats=beats)
        """The moving camera."""
        check_follow(patch, motion)
        self.spots = Spots(self.parameters, motion)
        subjects = Subjects(motion, dancers, self.spots)
        self.score_light = ScoreLight(self.parameters, subjects, score_runner, variation.division)
        """The layer of light that follows the score."""
        self.director = CameraDirector(
            self.parameters, subjects, score_runner,
            Framing(patch.camera.aspect, 0.5 * np.array([patch.stage.width, patch.stage.depth])),
            locked=is_locked(patch), seed=seed, beats=beats,
        )  # fmt: skip
        """Who leads the camera while `/dance/camera/director` is on."""
        self.energy = 0.5
        """Smoothed energy of the music, 0 to 1."""
        self.background_age = np.zeros((MAX_BACKGROUNDS, 2))
        """Seconds and beats since each background was last dark, shape (8, 2)."""
        self._gobo_turns = 0.0
        self.scenes = Scenes(patch, self.parameters, self.camera_rig)
        self.titles = Titles(patch)
        self._score_runner = score_runner
        self.cues = CueList(patch.cue, score_runner.playhead, beats=patch.clock.beats_per_measure)
        self.undo_history = UndoHistory(
            {"parameters": self.parameters, "scenes": self.scenes, "standby": self.cues, **editable}
        )
        self.beats = patch.clock.beats_per_measure
        """Beats of a danced measure."""
        self.master = Master()
        """Master fade and freeze of the whole picture."""
        self.held = False
        """Whether cues and score stand still; `parameters.held` is the same for fades."""

    # -- events ------------------------------------------------------------------------------------------------

    def handle(self, event: ControlEvent, now: Now) -> list[ControlEvent]:
        """Handle an event of `EVENTS`; raises PersonError if it names unknown parts. Returns its effects elsewhere."""
        if type(event) in SCENE_EVENTS:  # frequent events first
            self.director.check(event)
            self.scenes.handle(event, beats_per_measure=float(now.timeline.beats_per_measure))
            return []
        if type(event) in TITLE_EVENTS:
            self.titles.handle(event, now)
            return []
        return self._handle(event, now)

    def _handle(self, event: ControlEvent, now: Now) -> list[ControlEvent]:
        match event:
            case events.Go():
                return [*self._release_hold(event, now), *self.cues.go(event, now.danced_beats)]
            case events.GiveCue():
                return [*self._release_hold(event, now), *self.cues.trigger(event.name, now.danced_beats)]
            case events.StandBy():
                self.cues.stand_by(event.name)
            case events.StepBack():
                return self.cues.step_back()
            case events.Panic():
                self.titles.clear(now.beat)
                return self._panic(event)
            case events.HoldShow():
                return self._hold(event) if event.on else self._release_hold(event, now)
            case events.FollowSpot():
                beats = max(event.measures, 0.0) * now.timeline.beats_per_measure
                self.spots.follow(event.spot, event.whom, event.level, beats=beats)
            case events.Undo():
                self.undo_history.undo()
            case events.Redo():
                self.undo_history.redo()
            case events.TicksSkipped():
                self.tick(now, event.count)
            case _:
                self.master.handle(event)
        return []

    def _panic(self, event: ControlEvent) -> list[ControlEvent]:
        self.cues.stop()
        self.parameters.held = False
        self.parameters.reset(beats=PANIC_FADE_BEATS)
        self.score_light.suspended = True
        self.camera_rig.follower.set_selection(self.camera_rig.start_selection)
        self.held = True
        self._score_runner.suppress(True)
        time, source = event.time, event.source
        return [events.Clear(time=time, source=source), events.HoldScore(time=time, source=source, on=True),
                events.MuteAudience(time=time, source=source, on=True)]  # fmt: skip

    def _hold(self, event: ControlEvent) -> list[ControlEvent]:
        self.held = self.parameters.held = True
        return [events.HoldScore(time=event.time, source=event.source, on=True)]

    def _release_hold(self, event: ControlEvent, now: Now) -> list[ControlEvent]:
        if not self.held:
            return []
        self.held = self.parameters.held = self.score_light.suspended = False
        self._score_runner.suppress(False)
        self.cues.resume(now.danced_beats)
        return [events.HoldScore(time=event.time, source=event.source, on=False)]

    # -- time --------------------------------------------------------------------------------------------------

    def tick(self, now: Now, ticks: int = 1) -> None:
        """Advance by `ticks`."""
        beats = ticks * TICK * now.timeline.tempo / 60.0
        self.parameters.tick(beats)
        self.master.tick(beats)
        self.camera_rig.tick(ticks * TICK, beats)
        self.spots.tick(ticks * TICK)
        self.director.tick(now, ticks)
        self.score_light.tick(now.timeline.tempo, ticks)
        self.background_age += ticks * TICK, beats
        self.background_age[self.parameters.picture[_BACKGROUND_ROWS] <= 0.0] = 0.0
        self.energy = damper(self.energy, self._score_runner.mood.value("energy"), ENERGY_HALFLIFE, ticks * TICK)
        self._gobo_turns = self.gobo_turns(beats / now.timeline.beats_per_measure)

    def gobo_turns(self, measures: float) -> float:
        """Return how far the pattern in the key light has turned `measures` after the last tick [turns], 0 to 1: it
        goes on from where it is when its speed changes."""
        return (self._gobo_turns + float(self.parameters.picture[GOBO_TURN]) * measures) % 1.0

    def fire(self, danced_beats: float, time: float) -> list[ControlEvent]:
        """Return the events of cues due by the danced beat, at `time` [s]."""
        return [] if self.held else self.cues.fire(danced_beats, time)

    def begin_measure(self, now: Now) -> list[ControlEvent]:
        """Begin a measure: return the jumps of cues."""
        self.director.begin_measure(now.span.number, now)
        self.score_light.begin_measure()
        self.camera_rig.follower.begin_measure()
        self.spots.begin_measure()
        return [] if self.held else self.cues.begin_measure(now.danced_beats)

    # -- reports -------------------------------------------------------------------------------------------------

    def hashed(self) -> tuple[npt.NDArray[np.float64], ...]:
        """Return the arrays that belong to the state hash; none until the desk is used."""
        used = self.parameters.touched or self.cues.state() != [0, -1] or self.held
        own = (self.parameters.value, np.array([self.held, *self.cues.state()], np.float64)) if used else ()
        return (
            *own,
            *self.camera_rig.follower.hashed(),
            *self.spots.hashed(),
            *self.director.hashed(),
            *self.score_light.hashed(),
        )

    def status_lines(self, danced_beats: float) -> tuple[str, ...]:
        """Return the overlay's lines on cues; none in a show without cues."""
        facts = self.cues.facts(danced_beats)
        still = "score, fades and cues" if self.parameters.held else "score and cues"
        lines = [f"HELD: {still} stand still"] if self.held else []
        counted = self.cues.count_in(danced_beats)
        if counted is not None:
            beats = f"{max(math.ceil(counted[0]), 0)} beats" if math.isfinite(counted[0]) else "the next section"
            lines.append(f"GO in {beats}: {counted[1]}")
        if facts["standby"] is not None:
            lines.append("stands by: " + "   ".join(word for word in (facts["standby"], facts["text"]) if word))
        if facts["next"] is not None:
            lines.append(f"then: {facts['next']}")
        return (*self.master.status_lines(), *lines, *self.director.status_lines())

    def facts(self, danced_beats: float) -> dict[str, Any]:
        """Return cues, fades, edits and hold for the status."""
        return {
            "cues": {**self.cues.facts(danced_beats), "held": self.held},
            "scenes": self.scenes.names,
            "fading": self.parameters.fading,
            "master": self.master.facts(),
            "titles": self.titles.facts(),
            **self.camera_rig.facts(),
            **self.director.facts(),
            **self.score_light.facts(),
            **self.spots.facts(),
            **self.undo_history.facts(),
        }
