"""Service for cameras that see performers: plan and packets of the camera process, status, the lamp."""

import importlib.util
from collections import Counter
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from live.base.errors import PersonError
from live.base.event_queue import PriorityQueue
from live.base.picture_parameters import camera_from_row
from live.bridges.camera.stage_camera import ANY, MOST_CAMERAS, OFF, StageCamera
from live.clock.time_source import Clock
from live.control.camera.camera_plan import DRAWN_JOINTS, MODULE, CameraPlan, parse_camera
from live.control.camera.model_files import model_folder
from live.control.events.event_json import register_events
from live.control.events.events import ControlEvent, ExchangeSeen
from live.control.helper_process import HelperProcess
from live.motion.skeleton import SKELETON
from live.render.camera import world_to_clip
from live.show.patch.patch import Patch
from live.show.patch.section_io import DEFAULT_PERFORMER

if TYPE_CHECKING:
    from live.app.bridges import ServiceContext
    from live.control.camera.phone_landmarks import PhoneCameras
    from live.show.engine import Engine

OPTION: Final = "--camera"
_DRAWN_EVERY: Final = 4
"""Frames between reports of where dancers were drawn."""
_MOST_DRAWN: Final = 100
_MARGIN: Final = 1.5
"""How far from the stage [m] performers may be seen by a calibrated camera."""

register_events()  # both ends of the channel encode events


def make_camera_service(context: "ServiceContext[Any]", tables: tuple[StageCamera, ...]) -> "CameraService | None":
    """Return the service for the cameras that were asked for; None if there is none, and no phone may be one.

    PersonError, with the remedy, if a camera, the models or the extra `camera` are missing.
    """
    options = context.options
    plans = camera_plans(options.camera, tables, silhouette=options.camera_silhouette)
    if options.camera_model not in ("full", "lite"):
        raise PersonError(f"--camera-model {options.camera_model!r}: full or lite expected", "--camera-model lite")
    if options.camera_silhouette and not plans:
        raise PersonError(
            "--camera-silhouette: there is no camera whose silhouettes could be published", "--camera any"
        )
    if plans:
        check_installed()
    elif context.phones is None:
        return None
    service = CameraService(
        plans, options.camera_model, context.engine, context.add_queue(), context.clock, context.phones
    )
    context.notices.append(service.lamp)
    return service


def camera_plans(
    named: tuple[str, ...], tables: tuple[StageCamera, ...], *, silhouette: bool = False
) -> list[CameraPlan]:
    """Return the cameras of the command line, or those of the venue; PersonError if there is none like that.

    `silhouette`: whether all of them publish silhouettes, not only those that the venue says.
    """
    if OFF in named:
        return []
    wanted = [StageCamera(name=f"camera {number}", source=each) for number, each in enumerate(named, start=1)]
    if len(named) == 1 and len(tables) == 1:  # another source for the venue's only camera, with its marks
        wanted = [tables[0].model_copy(update={"source": named[0]})]
    chosen = wanted or list(tables)
    if len(chosen) > MOST_CAMERAS:
        raise PersonError(f"{OPTION}: {len(chosen)} cameras, {MOST_CAMERAS} at most")
    bare = [each.name for each in chosen if not each.marks]
    if len(chosen) > 1 and bare:
        raise PersonError(
            f"several cameras need marks on the floor, and {bare[0]} has none: without them nobody knows who is who",
            "name them as [[stage_camera]] in the venue, then: live calibrate camera",
        )
    plans = []
    for each in chosen:
        address = parse_camera("" if each.source == ANY else each.source, OPTION if wanted else "[[stage_camera]]")
        plans.append(
            CameraPlan(
                name=each.name, kind=address.kind, place=address.place, turn_deg=each.turn_deg,
                marks=each.marks, screen=each.screen, silhouette=silhouette or each.silhouette,
            )
        )  # fmt: skip
    return plans


def check_installed() -> None:
    """Raise PersonError if the extra `camera` or the models are missing."""
    if importlib.util.find_spec("ai_edge_litert") is None:
        where = "pip install 'choreographics-live[camera]', or in a checkout: uv sync --extra camera"
        raise PersonError(f"{OPTION} needs the extra `camera`, which is not installed", where)
    if model_folder() is None:
        raise PersonError(f"{OPTION} needs the pose models, which are not installed", "live camera models")


def performer_names(patch: Patch) -> tuple[str, ...]:
    """Return the names that seen people get, in order."""
    return tuple(each.name for each in patch.mocap) or (DEFAULT_PERFORMER,)


class CameraService:
    """Cameras of a show. Thread: the show's."""

    def __init__(
        self, cameras: list[CameraPlan], model: str, engine: "Engine", lane: PriorityQueue[ControlEvent], clock: Clock,
        phones: "PhoneCameras | None" = None,
    ) -> None:  # fmt: skip
        """`phones`: those of this show that are cameras; None if there is no page for them."""
        self._engine, self._lane, self._cameras, self._clock = engine, lane, cameras, clock
        names = performer_names(engine.show.patch)
        half_width, half_depth = engine.show.motion.stage_area.half
        plan = {
            "cameras": [each.as_packet() for each in cameras], "model": model, "performers": list(names),
            "most": len(names), "half": (float(half_width) + _MARGIN, float(half_depth) + _MARGIN),
        }  # fmt: skip
        self._helper = HelperProcess(MODULE, clock, plan, self._on_start, on_packet=self._take)
        self._names = names
        self._has_screen = any(each.screen for each in cameras)
        self._frames = 0
        self.received = 0
        """Poses received."""
        self._refusal, self._refused = "", 0
        if phones is not None:
            phones.handlers.append(self._pass_phone)

    @property
    def pid(self) -> int | None:
        """The camera process; None while there is none."""
        return self._helper.pid

    def start(self) -> None:
        """Start the camera process; PersonError if that fails."""
        try:
            self._helper.start()
        except OSError as error:
            raise PersonError(f"{OPTION}: the process for cameras cannot be started: {error}") from None

    def stop(self) -> None:
        """Close the cameras."""
        self._helper.stop()

    def before_frame(self) -> None:
        """Receive poses."""
        self._helper.frame()

    def frame(self) -> None:
        """Report where dancers were drawn, if a camera sees the screen."""
        self._frames += 1
        if self._has_screen and self._frames % _DRAWN_EVERY == 0:
            joints = drawn_joints(self._engine)
            self._helper.send(("drawn", self._clock.now(), joints.tobytes()))

    def update_patch(self, patch: Patch) -> None:
        """Use the performers of another patch."""
        self._names = performer_names(patch)
        self._on_start()

    def handle(self, event: ControlEvent) -> None:
        """Exchange two performers."""
        if isinstance(event, ExchangeSeen):
            unknown = [name for name in (event.performer, event.other) if name not in self._names]
            if unknown:
                self._refusal = f"no performer is called {unknown[0][:60]!r}; there are: {', '.join(self._names)}"
                self._refused += 1
            else:
                self._refusal = ""
                self._helper.send(("exchange", event.performer, event.other))

    def refusal(self) -> str:
        """Return why the last exchange was refused; empty if it was not."""
        return self._refusal

    def _on_start(self) -> None:
        self._helper.send(("names", self._names))

    def _take(self, events: Any) -> None:
        for event in events:
            self.received += 1
            self._lane.put(event, ("camera", event.performer))

    def _pass_phone(self, phone: str, performer: str, packet: bytes, arrival: float) -> None:
        self._helper.send(("phone", phone, performer, packet))

    def lamp(self) -> str:
        """Return the overlay's line while a camera is open."""
        if not self._cameras:
            return ""
        status = self._helper.status()
        facts = status.get("cameras")
        if not facts:
            return "● CAMERA: opens"
        told = []
        for each in facts:
            problem = each.get("problem") or each.get("light")
            told.append(f"{each['name']} sees {each.get('people', 0)}" + (f", {problem}" if problem else ""))
        shared = status.get("silhouette_problem") or ("silhouettes published" if status.get("silhouettes") else "")
        return "● CAMERA OPEN: " + "; ".join([*told, shared] if shared else told)

    def refused(self) -> Counter[str]:
        """Return the number of refused packets by reason."""
        count = self._helper.status().get("refused", 0) + self._refused
        return Counter({"camera": count} if count else {})

    def status(self) -> dict[str, Any]:
        """Return the values for the status line: the process, and the performers on the stage."""
        stage = self._engine.show.mocap.facts(self._engine.show.time)
        return {"open": bool(self._cameras), "received": self.received, **self._helper.status(), "stage": stage}


_DRAWN: Final = np.array([SKELETON.index(name) for name in DRAWN_JOINTS])


def drawn_joints(engine: "Engine") -> Any:
    """Return where the joints of the visible dancers were drawn last, (D, 12, 2) float32, in shares of the picture."""
    view, show = engine.view, engine.show
    if view.picture is None:
        return np.zeros((0, len(_DRAWN), 2), np.float32)
    aspect = show.patch.camera.aspect
    points = view.joint_position[view.present][:, _DRAWN].reshape(-1, 3).astype(np.float64)
    matrix = world_to_clip(camera_from_row(view.picture), (round(1000.0 * aspect), 1000))
    clip = np.column_stack((points, np.ones(len(points)))) @ matrix.T
    place = clip[:, :2] / np.maximum(clip[:, 3:], 1e-3) * (0.5, -0.5) + 0.5
    figures = place.reshape(-1, len(_DRAWN), 2)
    shown = (clip[:, 3].reshape(-1, len(_DRAWN)) > 0.05).all(axis=1) & (np.abs(figures - 0.5) < 1.0).all(axis=(1, 2))
    return figures[shown][:_MOST_DRAWN].astype(np.float32)
