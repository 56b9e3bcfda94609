"""Live motion capture: dancers of the show that wear the poses of captured performers.

Each performer drives one dancer and the position of its agent, so that others avoid the agent and the group's elements
include it; steering does not move it. The dancer's own steps continue unseen at the same position. When the capture
falls silent, the last pose is held for a quarter of a second; then the own steps fade in within a measure, and the
capture fades in likewise when it returns.
"""

from collections.abc import Callable, Iterable
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError, named
from live.clock.ticks import TICK
from live.clock.timeline import Timeline
from live.control.capture.vmc_input import ALONE
from live.control.events import capture as events
from live.control.events.event import ControlEvent
from live.control.events.groups import Performer
from live.control.registry.control import Plain
from live.motion.capture.capture_blend_kernels import put_agents
from live.show.capture.performer import Captured, Float64, Int64
from live.show.capture.performer_forces import Presence
from live.show.capture.stage_presence import FASTEST
from live.show.dancers.dancers import Dancers
from live.show.group.group_motion import GroupMotion
from live.show.patch.patch import Patch
from live.show.patch.section_io import MocapSection
from live.show.selection.scheduler import Scheduler

Bool = npt.NDArray[np.bool_]

MOCAP_EVENTS: Final = (
    events.MocapFrame, events.TrackerMoved, events.CastMocap, events.ShowMocap, events.MirrorMocap, events.PlaceMocap,
    events.CanonMocap, events.BlockMocap, events.DrawMocap,
)  # fmt: skip
"""Events that `act` handles."""
SAID: Final[dict[str, tuple[Callable[..., ControlEvent], tuple[str, ...]]]] = {
    "dancer": (events.CastMocap, ("dancer",)),
    "shown": (events.ShowMocap, ("shown",)),
    "mirrored": (events.MirrorMocap, ("mirrored",)),
    "place": (events.PlaceMocap, ("x", "z", "turn", "scale")),
    "canon": (events.CanonMocap, ("group", "beats")),
    "obstacle": (events.BlockMocap, ("obstacle",)),
    "attract": (events.DrawMocap, ("strength", "group")),
}
"""Settings of a performer, as in `/dance/mocap/NAME/...`: the event and its fields."""
NOBODY: Final = "none"
SPEED_SHARE: Final = 0.15
"""Smoothing of agent speed: share of a new value taken per tick, because capture is noisy."""


class Mocap:
    """All captured performers of one show. Thread: the show's."""

    def __init__(self, patch: Patch, motion: GroupMotion, dancers: Dancers, scheduler: Scheduler) -> None:
        self._patch, self._motion, self._dancers, self._scheduler = patch, motion, dancers, scheduler
        self.performers = {section.name: Captured(section, motion.floor.half) for section in patch.mocap}
        dancers.captured = self.performers
        dancers.beats = patch.clock.beats_per_measure
        count = len(motion.casting.group)
        self._led: Bool = np.zeros(count, np.bool_)
        self._place, self._speed = np.zeros((count, 2)), np.zeros((count, 2))
        self._presence = Presence(motion)
        self._time = 0.0
        for index, section in enumerate(patch.mocap):  # report invalid words at the start
            for key, words in (("dancer", section.dancer), ("canon", section.canon), ("attracts", section.attracts)):
                if words is not None and words.strip() != NOBODY:
                    with named(f"mocap {section.name!r}", ("mocap", index, key)):
                        motion.casting.select(words, motion.state.position)

    def take_patch(self, fresh: "Mocap") -> None:
        """Adopt the sections of an edited patch that changed; live settings stay for the others."""
        old = {section.name: section for section in self._patch.mocap}
        for section in fresh._patch.mocap:
            if section != old.pop(section.name, None):
                known, captured = self.performers.get(section.name), Captured(section, self._motion.floor.half)
                if known is not None:
                    captured.take(known)
                self.performers[section.name] = captured
        for name in old:
            self.performers[name].shown = False

    # -- events --------------------------------------------------------------------------------------------------------

    def act(self, event: ControlEvent, *, beat: float) -> None:
        """Handle an event at the danced `beat`; raises PersonError for unknown names."""
        match event:
            case events.MocapFrame():
                try:
                    self._whom(event.performer).hear(event.pose, event.time, beat)
                except ValueError as error:
                    raise PersonError(f"{event.performer}: {error}") from None
            case events.TrackerMoved():
                self._track(event)
            case _:
                assert isinstance(event, MOCAP_EVENTS)
                assert not isinstance(event, events.TrackerMoved)
                self._direct(event, self._whom(event.performer))

    def _direct(self, event: ControlEvent, captured: Captured) -> None:
        """Change a setting of a performer."""
        match event:
            case events.CastMocap():
                if event.dancer.strip() != NOBODY:
                    self._motion.casting.select(event.dancer, self._motion.state.position)
                captured.recast(event.dancer)
            case events.ShowMocap():
                captured.shown = event.shown
            case events.MirrorMocap():
                captured.mirror(event.mirrored, event.time)
            case events.PlaceMocap():
                captured.lay(event.x, event.z, event.turn, event.scale)
            case events.CanonMocap():
                if event.group.strip() != NOBODY:
                    self._motion.casting.select(event.group, self._motion.state.position)
                captured.canon, captured.canon_beats = event.group, event.beats
            case events.BlockMocap():
                captured.obstacle = event.obstacle
            case events.DrawMocap():
                group = event.group or captured.attracts
                self._motion.casting.select(group, self._motion.state.position)
                captured.attract, captured.attracts = event.strength, group

    def say(self, name: str, what: str, values: Iterable[Plain] | None) -> None:
        """Restore the setting `what` of a performer to `values` (see `Captured.said`); None: the default.

        Does nothing if the performer is gone.
        """
        captured = self.performers.get(name)
        if captured is not None:
            kind, fields = SAID[what]
            if values is None:
                values = Captured(MocapSection(name=name), self._motion.floor.half).said[what]
            said = dict(zip(fields, values, strict=True))
            self._direct(kind(time=self._time, source="mocap", performer=name, **said), captured)

    def _track(self, event: events.TrackerMoved) -> None:
        """Handle the position of a tracker: of a performer, or of a real dancer as an obstacle."""
        place = self._patch.psn.on_floor((event.x, event.y, event.z))
        captured = self._at(event.tracker)
        if captured is not None:
            captured.track(place, event.time)
        elif self._patch.psn.others:
            x, z = place
            tracked = Performer(time=event.time, source=event.source, name=event.tracker, x=x, z=z)
            if not self._motion.performers.track(tracked):
                raise PersonError("there is no place for more obstacles", "name those who matter in [[mocap]]")

    def _at(self, tracker: str) -> Captured | None:
        """Return the performer with this tracker: by its setting, or by the performer's name if none is set."""
        for name, captured in self.performers.items():
            if tracker == (captured.section.tracker or name):
                return captured
        return None

    def _whom(self, name: str) -> Captured:
        captured = self.performers.get(name)
        if captured is not None:
            return captured
        if self._patch.mocap or name != ALONE:
            named = ", ".join(self.performers) or ALONE
            raise PersonError(f"no performer is called {name[:60]!r}", f"there are: {named}")
        captured = self.performers[name] = Captured(MocapSection(name=name), self._motion.floor.half)
        return captured

    # -- time ----------------------------------------------------------------------------------------------------------

    def tick(self, time: float, danced: float, timeline: Timeline, next_line: float) -> None:
        """Advance by one tick at `time` [s], the `danced` beat; call after the dancers' tick. `next_line`: the
        danced beat of the next measure line."""
        self._time = time
        if not self.performers:
            return
        self._presence.tick()
        rate = TICK * timeline.tempo / (60.0 * timeline.beats_per_measure)
        taken: set[int] = set()
        led: set[int] = set()
        for captured in self.performers.values():
            captured.settle(time)
            wanted = self._cast(captured, taken, time, danced)
            if len(captured.rows):
                asked = captured.stay(time, danced)
                live = captured.is_live(asked, time, timeline.tempo) & wanted
                captured.go(live, rate, asked)
                self._lead(captured, live, asked)
                led |= set(captured.rows[live].tolist())
                captured.keep(wanted | (captured.share > 0.0))
            self._lead_tracked(captured, taken, led, time)
            self._presence.touch(captured, time, timeline, next_line)
        self._give_way(led)

    def _cast(self, captured: Captured, taken: set[int], time: float, danced: float) -> Bool:
        """Choose the dancers to wear the performer's poses and add new ones to `rows`; return which rows are wanted,
        (n,)."""
        wanted: dict[int, float] = {}
        if captured.shown and captured.poses.count:
            own = self._own(captured, taken)
            if own is not None:
                wanted[own] = 0.0
            if captured.canon.strip() != NOBODY:
                others = (row for row in self._there(captured.canon) if row != own and row not in taken)
                wanted |= {row: captured.canon_beats * number for number, row in enumerate(others, start=1)}
        captured.poses.remember(captured.canon.strip() != NOBODY)
        taken |= set(wanted) | set(captured.rows.tolist())
        known = dict(zip(captured.rows.tolist(), captured.delay.tolist(), strict=True))
        new = {row: beats for row, beats in wanted.items() if row not in known}
        if new:
            captured.add(new, self._dancers.shown, time, danced)
        return np.array([wanted.get(row) == beats for row, beats in
                         zip(captured.rows.tolist(), captured.delay.tolist(), strict=True)], np.bool_)  # fmt: skip

    def _own(self, captured: Captured, taken: set[int]) -> int | None:
        """Return the row of the performer's own dancer; None if there is none."""
        if captured.dancer is not None and captured.dancer.strip() == NOBODY:
            return None
        for row, beats in zip(captured.rows.tolist(), captured.delay.tolist(), strict=True):
            if beats == 0.0 and self._motion.present[row]:
                return int(row)  # an assigned dancer stays assigned, even if the words select another one now
        others = {row for other in self.performers.values() if other is not captured for row in other.rows.tolist()}
        there = self._there("*" if captured.dancer is None else captured.dancer)
        return next((row for row in there if row not in taken and row not in others), None)

    def _there(self, words: str) -> list[int]:
        """Return the rows of present dancers that the words select; empty if they select none."""
        try:
            who = self._motion.casting.select(words, self._motion.state.position)
        except PersonError:
            return []
        found: list[int] = np.flatnonzero(who & self._motion.present).tolist()
        return found

    def _lead(self, captured: Captured, live: Bool, asked: Float64) -> None:
        """Move agents to where the dancers are seen, and move the hidden steps of fully driven dancers along."""
        rows, dancers = captured.rows, self._dancers
        there, way = captured.find(asked, live, dancers.shown, dancers.leg_rotation)
        self._put(rows, there, live)
        gone = way.any(axis=1)
        if gone.any():
            self._scheduler.carrying.take_along(rows[gone], way[gone])

    def _put(self, rows: Int64, there: Float64, live: Bool) -> None:
        """Move the agents of `rows` (n,) that are `live` (n,) to `there` (n, 2) [m]."""
        flat = self._motion.state.flat
        put_agents(rows, live, there, self._place, self._speed, self._led, flat, TICK, FASTEST, SPEED_SHARE)

    def _lead_tracked(self, captured: Captured, taken: set[int], led: set[int], time: float) -> None:
        """For a performer with a tracker but no pose: move the dancer's agent to the tracker; the dancer's steps
        follow."""
        words = captured.dancer
        if words is None or words.strip() == NOBODY or captured.is_danced or not captured.is_tracked(time):
            captured.follower = -1
            return
        row = captured.follower
        if row < 0 or not self._motion.present[row]:
            others = {each.follower for each in self.performers.values()}
            row = next((row for row in self._there(words) if row not in taken and row not in others), -1)
            captured.follower = row
        if row < 0 or not captured.shown:
            return
        taken.add(row)
        led.add(row)
        self._put(np.array([row]), np.array([captured.stands(time)], np.float64), np.ones(1, np.bool_))

    def _give_way(self, led: set[int]) -> None:
        """Let all agents avoid the driven ones, which avoid no others."""
        now = np.zeros(len(self._led), np.bool_)
        now[list(led)] = True
        changed = np.flatnonzero(now != self._led)
        if len(changed):
            self._speed[changed] = 0.0
            self._motion.yield_to(changed, now[changed])
            self._led = now

    # -- reports -------------------------------------------------------------------------------------------------------

    def facts(self, time: float) -> dict[str, Any]:
        """Return for the status, by performer: dancers, visible weight, and seconds since the last data."""
        told: dict[str, Any] = {}
        for name, captured in self.performers.items():
            ago = time - captured.last
            told[name] = {
                "dancers": (captured.rows + 1).tolist() or [captured.follower + 1] * (captured.follower >= 0),
                "seen": np.round(captured.share, 3).tolist(),
                "poses": captured.poses.count,
                "last_s_ago": round(ago, 2) if np.isfinite(ago) else None,
                **captured.tracker_facts(time),
            }
        return told
