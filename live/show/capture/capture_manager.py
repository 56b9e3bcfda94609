"""Live motion capture: dancers of the show that wear the poses of captured performers.

Each performer drives one dancer and the position of its agent, so that others avoid the agent and the group's elements
include it; steering does not move it. The dancer's own steps continue unseen at the same position. When the capture
falls silent, the last pose is held for a quarter of a second; then the own steps fade in within a measure, and the
capture fades in likewise when it returns.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.base.arrays import Bool, Float64, Int64
from live.base.errors import PersonError, error_context
from live.clock.ticks import TICK
from live.control.events import capture as events
from live.control.events.event import ControlEvent
from live.control.events.groups import Performer
from live.control.registry.control import ArgumentValue
from live.motion.capture.capture_blend_kernels import move_agents
from live.show.capture.performer import CapturedPerformer
from live.show.capture.performer_forces import PerformerForces
from live.show.capture.stage_presence import MAX_SPEED
from live.show.patch.patch import Patch
from live.show.patch.section_io import DEFAULT_PERFORMER, MocapSection
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion
    from live.show.selection.scheduler import Scheduler


MOCAP_EVENTS: Final = (
    events.MocapFrame, events.TrackerMoved, events.CastMocap, events.ShowMocap, events.MirrorMocap, events.PlaceMocap,
    events.CanonMocap, events.BlockMocap, events.DrawMocap,
)  # fmt: skip
"""Events that `handle` handles."""
SETTINGS: Final[dict[str, tuple[Callable[..., ControlEvent], tuple[str, ...]]]] = {
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
SPEED_SMOOTHING: Final = 0.15
"""Smoothing of agent speed: share of a new value taken per tick, because capture is noisy."""


class CaptureManager:
    """All captured performers of one show. Thread: the show's."""

    EVENTS = MOCAP_EVENTS

    def __init__(self, patch: Patch, motion: "GroupMotion", dancers: "Dancers", scheduler: "Scheduler") -> None:
        self._patch, self._motion, self._dancers, self._scheduler = patch, motion, dancers, scheduler
        self.performers = {section.name: CapturedPerformer(section, motion.stage_area.half) for section in patch.mocap}
        dancers.captured = self.performers
        dancers.beats = patch.clock.beats_per_measure
        count = len(motion.casting.group)
        self._driven: Bool = np.zeros(count, np.bool_)
        self._place, self._speed = np.zeros((count, 2)), np.zeros((count, 2))
        self._forces = PerformerForces(motion)
        self._time = 0.0
        for index, section in enumerate(patch.mocap):  # report invalid words at the start
            for key, words in (("dancer", section.dancer), ("canon", section.canon), ("attracts", section.attracts)):
                if words is not None and words.strip() != NOBODY:
                    with error_context(f"mocap {section.name!r}", ("mocap", index, key)):
                        motion.casting.select(words, motion.state.position)

    def apply_patch(self, fresh: "CaptureManager") -> None:
        """Adopt the sections of an edited patch that changed; live settings stay for the others."""
        old = {section.name: section for section in self._patch.mocap}
        for section in fresh._patch.mocap:
            if section != old.pop(section.name, None):
                known, captured = (
                    self.performers.get(section.name),
                    CapturedPerformer(section, self._motion.stage_area.half),
                )
                if known is not None:
                    captured.take_over(known)
                self.performers[section.name] = captured
        for name in old:
            self.performers[name].shown = False

    # -- events --------------------------------------------------------------------------------------------------------

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event of `MOCAP_EVENTS`; raises PersonError for unknown names."""
        match event:
            case events.MocapFrame():
                try:
                    self._performer(event.performer).add_pose(event.pose, event.time, now.danced_beats_at(event.time))
                except ValueError as error:
                    raise PersonError(f"{event.performer}: {error}") from None
            case events.TrackerMoved():
                self._track(event)
            case _:
                assert isinstance(event, MOCAP_EVENTS)
                assert not isinstance(event, events.TrackerMoved)
                self._apply_setting(event, self._performer(event.performer))

    def _apply_setting(self, event: ControlEvent, captured: CapturedPerformer) -> None:
        """Change a setting of a performer."""
        match event:
            case events.CastMocap():
                if event.dancer.strip() != NOBODY:
                    self._motion.casting.select(event.dancer, self._motion.state.position)
                captured.assign_dancer(event.dancer)
            case events.ShowMocap():
                captured.shown = event.shown
            case events.MirrorMocap():
                captured.set_mirrored(event.mirrored, event.time)
            case events.PlaceMocap():
                captured.place_floor(event.x, event.z, event.turn, event.scale)
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

    def restore_setting(self, name: str, what: str, values: Iterable[ArgumentValue] | None) -> None:
        """Restore the setting `what` of a performer to `values` (see `CapturedPerformer.said`); None: the default.

        Does nothing if the performer is gone.
        """
        captured = self.performers.get(name)
        if captured is not None:
            kind, fields = SETTINGS[what]
            if values is None:
                values = CapturedPerformer(MocapSection(name=name), self._motion.stage_area.half).current_settings[what]
            said = dict(zip(fields, values, strict=True))
            self._apply_setting(kind(time=self._time, source="mocap", performer=name, **said), captured)

    def edited_values(self, event: ControlEvent) -> dict[tuple[str, str], tuple[ArgumentValue, ...]]:
        """Return the settings by performer and control name, see `EditablePart`."""
        performers = self.performers.items()
        return {(name, what): now for name, captured in performers for what, now in captured.current_settings.items()}

    def restore_values(self, values: Mapping[tuple[str, str], Iterable[ArgumentValue] | None]) -> None:
        """See `EditablePart`."""
        for (name, what), said in values.items():
            self.restore_setting(name, what, said)

    def _track(self, event: events.TrackerMoved) -> None:
        """Handle the position of a tracker: of a performer, or of a real dancer as an obstacle."""
        place = self._patch.psn.to_floor((event.x, event.y, event.z))
        captured = self._by_tracker(event.tracker)
        if captured is not None:
            captured.track(place, event.time)
        elif self._patch.psn.others:
            x, z = place
            tracked = Performer(time=event.time, source=event.source, name=event.tracker, x=x, z=z)
            if not self._motion.performers.track(tracked):
                raise PersonError("there is no place for more obstacles", "name those who matter in [[mocap]]")

    def _by_tracker(self, tracker: str) -> CapturedPerformer | None:
        """Return the performer with this tracker: by its setting, or by the performer's name if none is set."""
        for name, captured in self.performers.items():
            if tracker == (captured.section.tracker or name):
                return captured
        return None

    def _performer(self, name: str) -> CapturedPerformer:
        captured = self.performers.get(name)
        if captured is not None:
            return captured
        if self._patch.mocap or name != DEFAULT_PERFORMER:
            named = ", ".join(self.performers) or DEFAULT_PERFORMER
            raise PersonError(f"no performer is called {name[:60]!r}", f"there are: {named}")
        captured = self.performers[name] = CapturedPerformer(MocapSection(name=name), self._motion.stage_area.half)
        return captured

    # -- time ----------------------------------------------------------------------------------------------------------

    def tick(self, now: Now) -> None:
        """Advance by one tick; call after the dancers' tick."""
        self._time = time = now.time
        if not self.performers:
            return
        danced_beats, timeline = now.danced_beats, now.timeline
        self._forces.tick()
        rate = TICK * timeline.tempo / (60.0 * timeline.beats_per_measure)
        taken: set[int] = set()
        led: set[int] = set()
        for captured in self.performers.values():
            captured.update_tracker(time)
            wanted = self._assign_dancers(captured, taken, time, danced_beats)
            if len(captured.rows):
                asked = captured.keep_on_stage(time, danced_beats)
                live = captured.is_live(asked, time, timeline.tempo) & wanted
                captured.update_fade(live, rate, asked)
                self._drive_agents(captured, live, asked)
                led |= set(captured.rows[live].tolist())
                captured.keep(wanted | (captured.fade > 0.0))
            self._drive_tracked(captured, taken, led, time)
            self._forces.update(captured, now)
        self._set_yielding(led)

    def _assign_dancers(self, captured: CapturedPerformer, taken: set[int], time: float, danced_beats: float) -> Bool:
        """Choose the dancers to wear the performer's poses and add new ones to `rows`; return which rows are wanted,
        (n,)."""
        wanted: dict[int, float] = {}
        if captured.shown and captured.poses.count:
            own = self._own_dancer(captured, taken)
            if own is not None:
                wanted[own] = 0.0
            if captured.canon.strip() != NOBODY:
                others = (row for row in self._select_present(captured.canon) if row != own and row not in taken)
                wanted |= {row: captured.canon_beats * number for number, row in enumerate(others, start=1)}
        captured.poses.resize(captured.canon.strip() != NOBODY)
        taken |= set(wanted) | set(captured.rows.tolist())
        known = dict(zip(captured.rows.tolist(), captured.delay.tolist(), strict=True))
        new = {row: beats for row, beats in wanted.items() if row not in known}
        if new:
            captured.add(new, self._dancers.drawn_hips, time, danced_beats)
        return np.array([wanted.get(row) == beats for row, beats in
                         zip(captured.rows.tolist(), captured.delay.tolist(), strict=True)], np.bool_)  # fmt: skip

    def _own_dancer(self, captured: CapturedPerformer, taken: set[int]) -> int | None:
        """Return the row of the performer's own dancer; None if there is none."""
        if captured.dancer is not None and captured.dancer.strip() == NOBODY:
            return None
        for row, beats in zip(captured.rows.tolist(), captured.delay.tolist(), strict=True):
            if beats == 0.0 and self._motion.present[row]:
                return int(row)  # an assigned dancer stays assigned, even if the words select another one now
        others = {row for other in self.performers.values() if other is not captured for row in other.rows.tolist()}
        there = self._select_present("*" if captured.dancer is None else captured.dancer)
        return next((row for row in there if row not in taken and row not in others), None)

    def _select_present(self, words: str) -> list[int]:
        """Return the rows of present dancers that the words select; empty if they select none."""
        try:
            who = self._motion.casting.select(words, self._motion.state.position)
        except PersonError:
            return []
        found: list[int] = np.flatnonzero(who & self._motion.present).tolist()
        return found

    def _drive_agents(self, captured: CapturedPerformer, live: Bool, requests: Float64) -> None:
        """Move agents to where the dancers are seen, and move the hidden steps of fully driven dancers along."""
        rows, dancers = captured.rows, self._dancers
        there, way = captured.find_positions(requests, live, dancers.drawn_hips, dancers.leg_rotation)
        self._move_agents(rows, there, live)
        gone = way.any(axis=1)
        if gone.any():
            self._scheduler.root_correction.displace(rows[gone], way[gone])

    def _move_agents(self, rows: Int64, positions: Float64, live: Bool) -> None:
        """Move the agents of `rows` (n,) that are `live` (n,) to `positions` (n, 2) [m]."""
        flat = self._motion.state.flat
        move_agents(
            rows, live, positions, self._place, self._speed, self._driven, flat, TICK, MAX_SPEED, SPEED_SMOOTHING
        )

    def _drive_tracked(self, captured: CapturedPerformer, taken: set[int], driven: set[int], time: float) -> None:
        """For a performer with a tracker but no pose: move the dancer's agent to the tracker; the dancer's steps
        follow."""
        words = captured.dancer
        if words is None or words.strip() == NOBODY or captured.is_danced or not captured.is_tracked(time):
            captured.follower = -1
            return
        row = captured.follower
        if row < 0 or not self._motion.present[row]:
            others = {each.follower for each in self.performers.values()}
            row = next((row for row in self._select_present(words) if row not in taken and row not in others), -1)
            captured.follower = row
        if row < 0 or not captured.shown:
            return
        taken.add(row)
        driven.add(row)
        self._move_agents(np.array([row]), np.array([captured.position(time)], np.float64), np.ones(1, np.bool_))

    def _set_yielding(self, driven: set[int]) -> None:
        """Let all agents avoid the driven ones, which avoid no others."""
        now = np.zeros(len(self._driven), np.bool_)
        now[list(driven)] = True
        changed = np.flatnonzero(now != self._driven)
        if len(changed):
            self._speed[changed] = 0.0
            self._motion.set_yielding(changed, now[changed])
            self._driven = now

    # -- reports -------------------------------------------------------------------------------------------------------

    def facts(self, time: float) -> dict[str, Any]:
        """Return for the status, by performer: dancers, visible weight, and seconds since the last data."""
        told: dict[str, Any] = {}
        for name, captured in self.performers.items():
            ago = time - captured.last_time
            told[name] = {
                "dancers": (captured.rows + 1).tolist() or [captured.follower + 1] * (captured.follower >= 0),
                "seen": np.round(captured.fade, 3).tolist(),
                "poses": captured.poses.count,
                "last_s_ago": round(ago, 2) if np.isfinite(ago) else None,
                **captured.tracker_facts(time),
            }
        return told
