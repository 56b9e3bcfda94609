"""Scenes: named parameter values, from the patch or stored live, recalled with a cross-fade; also views, looks, worlds.

A stored scene contains all values; a scene of the patch only those it lists. `start` is the state at the start of the
patch. Views are cameras by name: those of the patch and a few built-in ones.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from live.base import picture_parameters
from live.base.arrays import Float64
from live.base.custom_pass import PASS_ADDRESS, PASSES, custom_pass_numbers
from live.base.errors import PersonError
from live.base.parameter import WORLD_NAMES
from live.base.stage_snapshot import Camera
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.desk.camera_rig import NO_FOLLOW_WORDS, CameraRig
from live.show.desk.look_settings import group_settings, look_settings, world_settings
from live.show.desk.parameter_table import LOOK, NAMED, VIEW, WORLD, ParameterTable, Slot, parse_value, split_key
from live.show.desk.parameters import Parameters
from live.show.desk.worlds import FADE_MEASURES, WORLD_PARAMETERS
from live.show.patch.patch import Patch
from live.show.patch.section_base import Setting, parameter_rows, parameter_values
from live.show.patch.section_stage import PROJECTOR, AnyCamera, ViewSection
from live.show.view.render_scene import camera_of_section, make_scene, projector_camera

_ANGLE: Final = 34.0
_ANGLE_FROM_ABOVE: Final = 20.0
_MIN_ASPECT: Final = 1.7
"""Minimum aspect ratio of pictures, for which these views contain the whole stage."""
_ORBIT_MEASURES: Final = 16.0
"""Measures of one orbit of the view `around`."""


def camera_settings(camera: Camera, moves: AnyCamera | None = None) -> dict[str, Setting]:
    """Return a camera and its motion as values by address: all that `/dance/camera/...` can set."""
    moves = moves or AnyCamera()
    return {
        **parameter_values("camera", moves),
        **picture_parameters.camera_values(camera),
        "/dance/camera/orbit": 0.0 if moves.orbit_measures == 0.0 else 1.0 / moves.orbit_measures,
        "/dance/camera/following": float(moves.follow is not None),
        "/dance/camera/director": float(moves.asks_for_director),
    }


def start_row(patch: Patch) -> Float64:
    """Return the picture's row at the start of a patch, shape (picture.SIZE,)."""
    row = picture_parameters.picture_row(make_scene(patch))
    said = camera_settings(picture_parameters.camera_from_row(row), patch.camera)
    said["/dance/camera/director"] = float(is_directed(patch))
    said |= {f"/dance/background/{number}": one.seen for number, one in enumerate(patch.background, start=1)}
    said |= {f"/dance/scenery/{number}": one.seen for number, one in enumerate(patch.scenery, start=1)}
    for address, value in said.items():
        row[picture_parameters.BY_ADDRESS[address].row_slice] = value
    return row


def is_locked(patch: Patch) -> bool:
    """Whether the director never leads this show's camera: it is locked, or the projector's view."""
    return patch.camera.lock or (patch.projector is not None and "camera" not in patch.model_fields_set)


def is_directed(patch: Patch) -> bool:
    """Whether the director leads the camera from the start: the patch says so, or has no camera of its own."""
    if is_locked(patch):
        return False
    return patch.camera.asks_for_director or "camera" not in patch.model_fields_set


def view_settings(patch: Patch) -> dict[str, tuple[dict[str, Setting], str | None]]:
    """Return all views except `start` by name: values, and followed dancers."""
    width, depth = patch.stage.width, patch.stage.depth
    views: dict[str, tuple[dict[str, Setting], str | None]] = {}
    front = Camera(*_from_the_front(width, depth), _ANGLE)
    turned = (front.eye[2], front.eye[1], 0.0)
    views["front"] = camera_settings(front), None
    views["side"] = camera_settings(Camera(turned, front.target, _ANGLE)), None
    views["around"] = camera_settings(front, AnyCamera(orbit_measures=_ORBIT_MEASURES)), None
    views["top"] = camera_settings(_from_above(width, depth), AnyCamera(plan=1.0)), None
    projector = projector_camera(patch)
    if projector is not None:
        views[PROJECTOR] = camera_settings(projector), None
    own = {view.name.casefold().strip() for view in patch.view}
    views = {name: view for name, view in views.items() if name not in own}
    return views | {view.name: _view_of_section(view) for view in patch.view}


def _view_of_section(view: ViewSection) -> tuple[dict[str, Setting], str | None]:
    return camera_settings(camera_of_section(view), view), view.follow


def _from_the_front(width: float, depth: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    away = 0.54 * width / (math.tan(math.radians(0.5 * _ANGLE)) * _MIN_ASPECT)
    return (0.0, 0.9 + 0.2 * away, 0.5 * depth + away), (0.0, 0.9, 0.0)


def _from_above(width: float, depth: float) -> Camera:
    half = math.tan(math.radians(0.5 * _ANGLE_FROM_ABOVE))
    height = max(0.56 * depth / half, 0.56 * width / (half * _MIN_ASPECT))
    return Camera((0.0, height, 0.0), (0.0, 0.0, 0.0), _ANGLE_FROM_ABOVE)


MAX_STORED: Final = 1000
"""Maximum number of stored scenes."""
START: Final = "start"


Selected = tuple[str, str, tuple[float, ...]]
"""Selection, address and numbers."""


@dataclass(frozen=True, slots=True)
class Scene:
    """Target values of a scene, by place in the parameter row, without those of parts of groups."""

    name: str
    goals: Mapping[int, float]
    measures: float
    """Length of the cross-fade [measures]."""
    follow: str | None = None
    """Dancers that its camera follows."""
    selected: tuple[Selected, ...] = ()
    """Values of selected dancers."""


class Scenes:
    """The scenes, views and looks of one show. Thread: the show's."""

    def __init__(self, patch: Patch, parameters: Parameters, rig: CameraRig) -> None:
        """Raises PersonError for a scene that names unknown parts."""
        self._parameters, self._rig = parameters, rig
        self._custom_passes = custom_pass_numbers(patch.picture.own_passes)
        self.stored: dict[str, Scene] = {}
        """Scenes stored live, by case-folded name."""
        table, start = parameters.table, parameters.start
        addresses = dict.fromkeys((*(row.address for row in parameter_rows("look").values()), *WORLD_PARAMETERS))
        light = [place for address in addresses for slot in table.find(address) for place in slot.numbers]
        camera = range(picture_parameters.CAMERA.start, picture_parameters.CAMERA.stop)
        self._views = {START: Scene(START, {place: float(start[place]) for place in camera}, 0.0)}
        self._looks = {START: Scene(START, {place: float(start[place]) for place in light}, 1.0)}
        self._backgrounds = [section.name for section in patch.background]
        self._background_places = [section.place for section in patch.background]
        self._views[START] = replace(self._views[START], follow=patch.camera.follow)
        for name, (settings, whom) in view_settings(patch).items():
            self._views[_folded(name)] = self._scene(table, name, settings, 0.0, whom)
        self._worlds = {
            name: self._scene(table, name, world_settings(patch, name), FADE_MEASURES) for name in WORLD_NAMES
        }
        for look in patch.looks:
            self._looks[_folded(look.name)] = self._scene(table, look.name, look_settings(patch, look), look.measures)
        drawn: dict[str, Setting] = {}
        for group in patch.group:
            drawn |= group_settings(group.name, group.draw)[1]
        self._scenes = {START: self._scene(table, START, drawn, 2.0)}
        self._set_start()
        self._scenes[START] = replace(self._scenes[START], goals=self._whole(start))
        for scene in patch.scene:
            whom = self._follow_of(scene.set)
            self._scenes[_folded(scene.name)] = self._scene(table, scene.name, scene.set, scene.measures, whom)

    def _set_start(self) -> None:
        """Give selected dancers the values with which the patch lets them begin."""
        scene = self._scenes[START]
        if scene.selected:
            self._selected_slots(scene)  # divides groups; only then every part is known
        for some, (_, _, numbers) in zip(self._selected_slots(scene), scene.selected, strict=True):
            for slot in some:
                self._parameters.begin_with(slot, numbers)

    def _whole(self, row: Float64) -> dict[int, float]:
        """Return the numbers of a row by place, without those of parts of groups."""
        table = self._parameters.table
        whole = np.flatnonzero(table.part_of < len(table.group_names))
        return dict(zip(whole.tolist(), row[whole].tolist(), strict=True))

    def _follow_of(self, settings: Mapping[str, Setting]) -> str | None:
        view = settings.get(VIEW)
        return None if view is None else _find_scene(self._views, str(view), "view").follow

    def apply_patch(self, fresh: "Scenes") -> None:
        """Adopt views, looks and scenes of an edited patch; scenes stored live stay."""
        redressed = fresh._scenes[START].selected != self._scenes[START].selected
        self._views, self._looks, self._scenes = fresh._views, fresh._looks, fresh._scenes
        self._worlds = fresh._worlds
        if redressed:
            self._set_start()
        self._custom_passes = fresh._custom_passes

    def _scene(
        self,
        table: ParameterTable,
        name: str,
        settings: Mapping[str, Setting],
        measures: float,
        follow: str | None = None,
    ) -> Scene:
        goals: dict[int, float] = {}
        selected: list[Selected] = []
        for key, value in settings.items():
            address, group = split_key(key)
            if address in NAMED:
                kept = {VIEW: self._views, LOOK: self._looks, WORLD: self._worlds}[address]
                found = _find_scene(kept, str(value), NAMED[address])
                goals |= found.goals
                selected += found.selected
                continue
            numbers = parse_value(address, value)
            if group.strip() not in ("", "*") and not table.has_group(group):
                self._parameters.check_words(group)
                selected.append((group, address, numbers))
                continue
            for one in table.find(address, group):
                goals |= dict(zip(one.numbers, numbers, strict=True))
        return Scene(name, goals, measures, follow, tuple(selected))

    @property
    def names(self) -> list[str]:
        """Names of all scenes."""
        return [scene.name for scene in (self._scenes | self.stored).values()]

    def written(self, name: str | None = None) -> dict[str, Setting]:
        """Return the values of a scene stored live, or for None the present ones, as a `[[scene]]` sets them.

        Those that the show starts with are left out. Raises PersonError for an unknown scene.
        """
        scene = self._present(START) if name is None else _find_scene(self.stored, name, "scene stored live")
        start, settings = self._parameters.start, dict[str, Setting]()
        table = self._parameters.table
        for address, slots in table.slots():
            for slot in slots:
                numbers = tuple(scene.goals.get(place, float(start[place])) for place in slot.numbers)
                if slot.parameter.size in (1, 3) and numbers != tuple(float(start[place]) for place in slot.numbers):
                    group = "" if slot.part < 0 else f" {table.group_names[slot.part]}"
                    settings[address + group] = _setting(slot, numbers)
        for words, address, numbers in scene.selected:
            settings[f"{address} {words}"] = _setting(table.slot(address, 0), numbers)
        return settings

    def _present(self, name: str) -> Scene:
        """Return the present values as a scene."""
        goals, table = np.asarray(self._parameters.goals()), self._parameters.table
        selected: list[Selected] = []
        for part, group, words in self._parameters.parts():
            for address in (address for address, slots in table.slots() if slots[0].part >= 0):
                numbers, usual = (
                    tuple(goals[list(table.slot(address, one).numbers)].tolist()) for one in (part, group)
                )
                if numbers != usual:
                    selected.append((words, address, numbers))
        return Scene(name, self._whole(goals), 2.0, self._rig.follower.selection, tuple(selected))

    def edited_values(self, event: ControlEvent) -> dict[str, Scene]:
        """Return the scenes stored live, by name, see `EditablePart`."""
        return dict(self.stored)

    def restore_values(self, values: Mapping[str, Scene | None]) -> None:
        """See `EditablePart`."""
        for name, scene in values.items():
            if scene is None:
                self.stored.pop(name, None)
            else:
                self.stored[name] = scene

    def handle(self, event: ControlEvent, *, beats_per_measure: float) -> None:
        """Handle an event of `SCENE_EVENTS`; raises PersonError if it names unknown parts."""
        _HANDLERS[type(event)](self, event, beats_per_measure)

    def recall(self, name: str, *, measures: float, beats_per_measure: float) -> None:
        """Fade to a scene in `measures`; below 0: in the scene's own time. Raises PersonError for an unknown scene."""
        scene = _find_scene(self._scenes | self.stored, name, "scene")
        self._light(scene, measures, beats_per_measure)

    def _fade_to(self, scene: Scene, measures: float, size: float) -> None:
        lasts = scene.measures if measures < 0.0 else measures
        if scene.follow is not None:
            self._rig.follower.follow(scene.follow, cut=lasts <= 0.0)
        slots = self._selected_slots(scene)  # divides groups; only then every part is known
        goals = self._parameters.with_parts(scene.goals)
        for some, (_, _, numbers) in zip(self._selected_slots(scene) if slots else (), scene.selected, strict=False):
            goals |= {place: number for one in some for place, number in zip(one.numbers, numbers, strict=True)}
        self._parameters.fade(goals, beats=lasts * size)

    def _selected_slots(self, scene: Scene) -> list[list[Slot]]:
        """Return the slots of the selected dancers; empty where nobody is, or where there are too many parts."""
        found: list[list[Slot]] = []
        for words, address, _ in scene.selected:
            try:
                found.append(self._parameters.slots(address, words))
            except PersonError:  # the rest of the scene counts
                found.append([])
        return found

    def _set_parameter(self, event: events.SetParameter, size: float) -> None:
        numbers = parse_value(event.address, event.value)
        for slot in self._parameters.slots(event.address, event.group):
            self._parameters.set(slot, numbers, beats=event.measures * size)

    def _set_pass(self, event: events.SetPass, size: float) -> None:
        address = "/".join(filter(None, (PASS_ADDRESS, _folded(event.name), event.parameter.strip())))
        own = self._custom_passes.get(address)
        if own is not None:
            amount = min(max(event.amount, own.low), own.high)
            self._parameters.fade(
                {picture_parameters.CUSTOM_PASS_SLICE.start + own.index: amount}, beats=event.measures * size
            )
            return
        known = picture_parameters.BY_ADDRESS.get(address)
        if known is None or known.size != 1:
            names = [one.removeprefix(f"{PASS_ADDRESS}/") for one in self._custom_passes]
            what = f"parameter {event.parameter!r}" if event.parameter else "pass"
            raise PersonError(
                f"no {what} is called {event.name!r}" if not event.parameter else f"{event.name!r} has no {what}",
                f"there are: {', '.join((*PASSES, *names))}",
            )
        amount = min(max(event.amount, known.low), known.high)
        for slot in self._parameters.table.find(known.address):
            self._parameters.set(slot, (amount,), beats=event.measures * size)

    def _view(self, event: events.RecallView, size: float) -> None:
        self._fade_to(_find_scene(self._views, event.name, "view"), max(event.measures, 0.0), size)

    def _follow(self, event: events.Accompany, size: float) -> None:
        nobody = event.whom.strip().casefold() in NO_FOLLOW_WORDS
        if not nobody:
            self._rig.follower.follow(event.whom, cut=event.measures <= 0.0)
        goals = {picture_parameters.FOLLOWING: 0.0 if nobody else 1.0}
        if event.along >= 0.0:
            goals[picture_parameters.ALONG] = event.along
        self._parameters.fade(goals, beats=max(event.measures, 0.0) * size)

    def _background(self, event: events.ShowBackground, size: float) -> None:
        chosen = event.name.strip().casefold()
        names = [name.strip().casefold() for name in self._backgrounds]
        if chosen != "none" and chosen not in names:
            known = ", ".join([*self._backgrounds, "none"])
            raise PersonError(f"no background is called {event.name!r}", f"there are: {known}")
        places = [
            picture_parameters.BY_ADDRESS[f"/dance/background/{number}"].first for number in range(1, len(names) + 1)
        ]
        where = {self._background_places[number] for number, name in enumerate(names) if name == chosen}
        goals = {
            row: float(name == chosen)
            for row, name, place in zip(places, names, self._background_places, strict=True)
            if chosen == "none" or place in where
        }
        self._parameters.fade(goals, beats=max(event.measures, 0.0) * size)

    def _look(self, event: events.RecallLook, size: float) -> None:
        self._light(_find_scene(self._looks, event.name, "look"), event.measures, size)

    def _light(self, scene: Scene, measures: float, size: float) -> None:
        """Fade to a scene or look, which claims its values, and no others; the patch's own claims none."""
        self._parameters.release()
        self._fade_to(scene, measures, size)
        if scene.name == START:
            self._parameters.release()

    def _world(self, event: events.RecallWorld, size: float) -> None:
        self._fade_to(_find_scene(self._worlds, event.name, "world"), event.measures, size)

    def _recall(self, event: events.RecallScene, size: float) -> None:
        self.recall(event.name, measures=event.measures, beats_per_measure=size)

    def _store(self, event: events.StoreScene, size: float) -> None:
        folded = _folded(event.name)
        if folded == START:
            raise PersonError(f"{START!r} is the patch's own scene", "give yours another name")
        if folded not in self.stored and len(self.stored) >= MAX_STORED:
            raise PersonError(f"{MAX_STORED} scenes are stored already", "replace one of them")
        old = (self._scenes | self.stored).get(folded)
        measures = 2.0 if old is None else old.measures
        self.stored[folded] = replace(self._present(event.name), measures=measures)


def _setting(slot: Slot, numbers: tuple[float, ...]) -> Setting:
    if slot.parameter.kind == "names":
        return slot.parameter.names_of_number(numbers[0])
    one = bool(numbers[0]) if slot.parameter.kind == "switch" else numbers[0]
    return one if len(numbers) == 1 else (numbers[0], numbers[1], numbers[2])


def _folded(name: str) -> str:
    return name.casefold().strip()


def _find_scene(kept: Mapping[str, Scene], name: str, what: str) -> Scene:
    found = kept.get(_folded(name))
    if found is None:
        raise PersonError(
            f"no {what} is called {name!r}", f"there are: {', '.join(scene.name for scene in kept.values())}"
        )
    return found


_HANDLERS: Final[dict[type, Callable[..., None]]] = {
    events.SetPass: Scenes._set_pass,
    events.SetParameter: Scenes._set_parameter,
    events.RecallView: Scenes._view,
    events.Accompany: Scenes._follow,
    events.ShowBackground: Scenes._background,
    events.RecallLook: Scenes._look,
    events.RecallWorld: Scenes._world,
    events.RecallScene: Scenes._recall,
    events.StoreScene: Scenes._store,
}
SCENE_EVENTS: Final = tuple(_HANDLERS)
"""Events that `handle` handles."""
