"""The parts of a show that can be edited, as values by key: see `live.show.desk.edits`."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from live.agents.crowd.obstacles import Surroundings
from live.base import picture
from live.control.events.event import ControlEvent
from live.control.events.events import SetPicture
from live.show.capture.capture_manager import Mocap
from live.show.capture.performers import PERFORMER
from live.show.dancers.variation import Variation
from live.show.desk.cue_list import Cues
from live.show.desk.edits import Kept, Now, Part
from live.show.desk.parameters import Parameters
from live.show.desk.scenes import Scenes
from live.show.group.group_motion import GroupMotion
from live.show.selection.headings import Headings
from live.show.selection.scheduler import Scheduler


class EditedParameters(Part):
    """Where each parameter is, or is going, by its place in the row."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    def take(self) -> Now:
        """See `Part`."""
        return self._parameters.goals()

    def concerned(self, event: ControlEvent) -> Now:
        """See `Part`. A value of the picture is set by the thousand: only its own numbers are looked at."""
        if type(event) is SetPicture:
            places = self._parameters.table.places(event.parameter, event.group)
            if places and max(places) < picture.SIZE:
                return self._parameters.goals_at(places)
        return self._parameters.goals()

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        self._parameters.fade(values, beats=0.0)


class EditedScenes(Part):
    """Scenes stored live, by name."""

    def __init__(self, scenes: Scenes) -> None:
        self._scenes = scenes

    def take(self) -> Kept:
        """See `Part`."""
        return dict(self._scenes.stored)

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for name, scene in values.items():
            if scene is None:
                self._scenes.stored.pop(name, None)
            else:
                self._scenes.stored[name] = scene


class EditedFormations(Part):
    """Formations by name."""

    def __init__(self, motion: GroupMotion) -> None:
        self._motion = motion

    def take(self) -> Kept:
        """See `Part`."""
        return self._motion.evolutions.formations

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        self._motion.evolutions.restore(values)


class EditedSequences(Part):
    """Sequences set live, by group."""

    def __init__(self, scheduler: Scheduler) -> None:
        self._scheduler = scheduler

    def take(self) -> Kept:
        """See `Part`."""
        return {index: programme.live or None for index, programme in enumerate(self._scheduler.programmes)}

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for index, wanted in values.items():
            if wanted is None:
                self._scheduler.programmes[index].release()
            else:
                self._scheduler.programmes[index].dance(list(wanted))


class EditedFacings(Part):
    """Where groups look."""

    def __init__(self, headings: Headings) -> None:
        self._headings = headings

    def take(self) -> Kept:
        """See `Part`."""
        return dict(enumerate(self._headings.facings))

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for group, facing in values.items():
            self._headings.set(group, facing)


class EditedRipples(Part):
    """What runs over groups."""

    def __init__(self, variation: Variation) -> None:
        self._variation = variation

    def take(self) -> Kept:
        """See `Part`."""
        return dict(enumerate(self._variation.ripples))

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for group, ripple in values.items():
            self._variation.ripples[group] = ripple


class EditedSet(Part):
    """Walls and obstacles by kind and name; real dancers are none."""

    def __init__(self, surroundings: Surroundings) -> None:
        self._surroundings = surroundings

    def take(self) -> Kept:
        """See `Part`."""
        around = self._surroundings
        walls = {("wall", name): _row(around.walls[row]) for row, name in enumerate(around.wall_names)}
        obstacles = {("obstacle", name): _row(around.obstacles[row]) for row, name in enumerate(around.obstacle_names)}
        return {key: row for key, row in {**walls, **obstacles}.items() if not key[1].startswith(PERFORMER)}

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        now = {**self.take(), **values}
        for name in {name for _, name in values}:  # a wall and an obstacle of one name go together
            self._surroundings.remove(name)
            wall, obstacle = now.get(("wall", name)), now.get(("obstacle", name))
            if wall is not None:
                self._surroundings.put_wall(name, *wall)
            if obstacle is not None:
                self._surroundings.put_obstacle(name, *obstacle)


class EditedMocap(Part):
    """What is said of captured performers, by their names and that of the control."""

    def __init__(self, mocap: Mocap) -> None:
        self._mocap = mocap

    def take(self) -> Kept:
        """See `Part`."""
        performers = self._mocap.performers.items()
        return {(name, what): now for name, captured in performers for what, now in captured.said.items()}

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        for (name, what), said in values.items():
            self._mocap.say(name, what, said)


class EditedStandBy(Part):
    """The cue that stands by."""

    def __init__(self, cues: Cues) -> None:
        self._cues = cues

    def take(self) -> Kept:
        """See `Part`."""
        return {"standby": self._cues.standby}

    def give(self, values: Mapping[Any, Any]) -> None:
        """See `Part`."""
        self._cues.standby = values["standby"]


def _row(row: np.ndarray[Any, Any]) -> tuple[float, ...]:
    return tuple(row.tolist())


def parts_of(
    parameters: Parameters, scenes: Scenes, cues: Cues, motion: GroupMotion, scheduler: Scheduler,
    variation: Variation, mocap: Mocap,
) -> dict[str, Part]:  # fmt: skip
    """All parts of a show that can be edited, by the names in `EDITED`."""
    return {
        "parameters": EditedParameters(parameters),
        "scenes": EditedScenes(scenes),
        "formations": EditedFormations(motion),
        "sequences": EditedSequences(scheduler),
        "facings": EditedFacings(scheduler.aims.headings),
        "ripples": EditedRipples(variation),
        "set": EditedSet(motion.surroundings),
        "mocap": EditedMocap(mocap),
        "standby": EditedStandBy(cues),
    }
