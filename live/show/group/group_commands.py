"""Handler for live control events of group motion: segments, groups, entrances, stage and obstacles."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from live.base.arrays import Bool
from live.base.errors import PersonError
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.capture.stage_presence import OBSTACLE_PREFIX
from live.show.dancers.timing_offsets import parse_ripple
from live.show.dancers.variation import Variation
from live.show.patch.patch import Patch
from live.show.score.score import Score
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion


SEGMENT_EVENTS = (events.Evolve, events.Travel, events.Pause)
GROUP_EVENTS = (
    *SEGMENT_EVENTS, events.DefineFormation, events.Release, events.Regroup, events.SetRipple,
    events.Enter, events.Leave, events.SetStage, events.PlaceObstacle, events.PlaceWall, events.RemoveObstacle,
    events.Performer,
)  # fmt: skip
"""Events for the groups' motion."""


class GroupCommands:
    """Applies events to the group motion of a show."""

    EVENTS = (*GROUP_EVENTS, events.Clear, events.LaunchEnded)

    def __init__(
        self, patch: Patch, motion: "GroupMotion", dancers: "Dancers", variation: Variation, score: Score | None = None
    ) -> None:
        self._patch = patch
        self._motion = motion
        self._dancers = dancers
        self._variation = variation
        self._score = score or Score(patch)
        self._joining: dict[int, int] = {}

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Apply an event of `EVENTS`. Raises PersonError if it names something unknown or impossible."""
        motion, measure = self._motion, now.span.number
        match event:
            case events.Evolve() | events.Travel() | events.Pause():
                heading = self._dancers.present.end_heading()
                motion.evolutions.handle(
                    event, measure=measure, beat=now.danced_beats, position=now.position, heading=heading
                )
            case events.DefineFormation():
                motion.evolutions.define(event, measure=measure)
            case events.Release() | events.LaunchEnded(what="motion"):
                motion.evolutions.release(self._select(event.group))
            case events.Regroup():
                self._regroup(self._select(event.dancers), self._group(event.group))
            case events.SetRipple():
                ripple = parse_ripple(event.begins, event.beats)
                groups, who = motion.casting.groups_of(event.group), self._select(event.group)
                if groups is None and not who.any():
                    raise PersonError(f"{event.group!r}: nobody is there now")
                self._variation.set_ripple(groups, who, ripple)
            case events.Enter():
                self._enter(event)
            case events.Leave():
                self._leave(event)
            case events.SetStage():
                beats_per_measure = now.timeline.beats_per_measure
                motion.resize(
                    event.width, event.depth, measure=measure, beat=now.beat, beats_per_measure=beats_per_measure
                )
            case events.Clear():
                motion.elements.clear(now.beat)
                motion.evolutions.clear(np.ones(len(motion.casting.group), np.bool_))
            case _:
                self._handle_set_event(event)

    def _handle_set_event(self, event: ControlEvent) -> None:
        """Apply an event of the set or of a performer."""
        surroundings = self._motion.surroundings
        match event:
            case events.PlaceObstacle():
                self._require_free_slot(surroundings.set_obstacle(event.name, event.x, event.z, event.radius))
            case events.PlaceWall():
                self._require_free_slot(surroundings.set_wall(event.name, event.x, event.z, event.x2, event.z2))
            case events.RemoveObstacle():
                if not surroundings.remove(event.name):
                    raise PersonError(f"nothing on the stage is called {event.name!r}")
            case events.Performer():
                self._require_free_slot(self._motion.performers.track(event))

    def edited_values(self, event: ControlEvent) -> dict[tuple[str, str], tuple[float, ...]]:
        """Return walls and obstacles by kind and name, without real dancers, see `EditablePart`."""
        return self._set_items()

    def _set_items(self) -> dict[tuple[str, str], tuple[float, ...]]:
        around = self._motion.surroundings
        walls = {("wall", name): tuple(around.walls[row].tolist()) for row, name in enumerate(around.wall_names)}
        obstacles = {
            ("obstacle", name): tuple(around.obstacles[row].tolist()) for row, name in enumerate(around.obstacle_names)
        }
        return {key: row for key, row in {**walls, **obstacles}.items() if not key[1].startswith(OBSTACLE_PREFIX)}

    def restore_values(self, values: Mapping[tuple[str, str], tuple[float, ...] | None]) -> None:
        """See `EditablePart`."""
        around = self._motion.surroundings
        now = {**self._set_items(), **values}
        for name in {name for _, name in values}:  # a wall and an obstacle may share a name, and `remove` removes both
            around.remove(name)
            wall, obstacle = now.get(("wall", name)), now.get(("obstacle", name))
            if wall is not None:
                around.set_wall(name, *wall)
            if obstacle is not None:
                around.set_obstacle(name, *obstacle)

    def cross_measure_line(self, measure: int) -> None:
        """Apply the score's regroupings of `measure` (from 0), and move dancers who enter to their groups."""
        for section in self._score.regroups(measure):
            self._regroup(self._select(section.dancers), self._group(section.group))
        for group in sorted(set(self._joining.values())):
            rows = [row for row, index in self._joining.items() if index == group]
            who = np.zeros(len(self._motion.casting.group), np.bool_)
            who[rows] = True
            self._regroup(who, group)
        self._joining.clear()

    def _select(self, words: str) -> Bool:
        return self._motion.casting.select(words, self._motion.state.position)

    def _group(self, name: str) -> int:
        index = self._motion.casting.index_of(name)
        if index is None:
            names = ", ".join(section.name for section in self._patch.group)
            raise PersonError(f"no group is called {name!r}", f"there are: {names}")
        return index

    def _gate(self, name: str) -> int | None:
        if name.strip() in ("", "*"):
            return None
        index = self._motion.entrances.gate_index(name.strip())
        if index is None:
            names = ", ".join(gate.name for gate in self._motion.gates)
            raise PersonError(f"no gate is called {name!r}", f"there are: {names}")
        return index

    def _regroup(self, who: Bool, index: int) -> None:
        motion = self._motion
        motion.casting.regroup(who, index)
        motion.elements.update_groups(motion.state.position)
        motion.evolutions.update_groups()
        self._variation.update_groups()

    def _enter(self, event: events.Enter) -> None:
        own = event.group.strip() in ("", "*")
        group, gate = 0 if own else self._group(event.group), self._gate(event.gate)
        rows = self._motion.entrances.call_in(int(event.count), gate)
        for row in rows.tolist():
            self._joining[row] = int(self._motion.casting.group[row]) if own else group
        if len(rows) < int(event.count):
            waiting = "nobody waits" if not len(rows) else f"only {len(rows)} waited"
            raise PersonError(f"{waiting} in the wings", "raise the reserve in the patch")

    def _leave(self, event: events.Leave) -> None:
        motion = self._motion
        gate = self._gate(event.gate)
        who = self._select(event.dancers)
        gone = motion.entrances.send_off(who, gate, motion.state.position)
        motion.evolutions.clear(who)
        if not gone:
            raise PersonError(f"nobody on the stage is {event.dancers!r}")

    @staticmethod
    def _require_free_slot(placed: bool) -> None:
        if not placed:
            raise PersonError("there is no place for more obstacles", "remove some of them first")
