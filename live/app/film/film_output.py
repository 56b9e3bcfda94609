"""Where the frames of a show go offline: as pictures into a film, or as motion into files for other programs."""

import contextlib
import hashlib
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from live.base.arrays import Bool, Float32
from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.base.errors import PersonError
from live.base.stage_snapshot import StageView
from live.library.motion_formats import stage_format
from live.library.whole_file import write_atomically
from live.motion.clip import Clip
from live.motion.formats.stage_motion import DancerMotion, FigureMesh, StageFormation, StageMotion
from live.motion.forward_kinematics import local_rotations
from live.motion.skeleton import JOINT_COUNT
from live.render.body.body_lookup import build_figure
from live.render.body.body_mesh import skeleton_weights
from live.render.film.film_writer import FilmError, Picture, PictureWriter
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.show import Show
from live.show.view.render_scene import draw_patch

if TYPE_CHECKING:
    from live.render.headless import OffscreenTarget
    from live.render.renderer import Renderer

FINEST_LEVEL: Final = 2
"""Level of detail of bodies in files."""
MAX_MOTION_BYTES: Final = 4 * 10**9
"""The poses of a show are held in memory until all are there."""


class FilmOutput(Protocol):
    """Takes the frames of a show in order: `draw` each, then `advance`; at the end `close`."""

    def draw(self, view: StageView) -> None:
        """Take a frame."""

    def follow(self, view: StageView) -> None:
        """Take in a frame before the film's first one, for what later ones remember of it."""

    def warm_up(self, view: StageView) -> None:
        """Take a frame before the film's first one that has to be drawn."""

    def advance(self) -> None:
        """Go on to the next frame. PersonError if the file cannot be written."""

    def change_patch(self, patch: Patch) -> None:
        """The show goes on with another patch."""

    def close(self) -> str:
        """Complete the files; return where they are. PersonError if they cannot be written."""


class PictureOutput:
    """Pictures, drawn off the screen and written by a thread."""

    def __init__(self, renderer: "Renderer", target: "OffscreenTarget", writer: PictureWriter, path: Path) -> None:
        self._renderer, self._target, self._writer, self._path = renderer, target, writer, path
        self.before = ""
        """Hash of the picture before the first one, of a film that does not begin with the show."""
        self.last = ""
        """Hash of the last picture, once the film is closed."""

    def begin_anew(self, titles: Sequence[tuple[str, str]]) -> None:
        """Forget what the renderer has drawn; `titles` were shown before (`Renderer.begin_anew`)."""
        self._renderer.begin_anew(titles)

    def draw(self, view: StageView) -> None:
        """See `FilmOutput`."""
        self._renderer.draw(view, self._target.framebuffer)

    def follow(self, view: StageView) -> None:
        """See `FilmOutput`."""
        self._renderer.follow(view)

    def warm_up(self, view: StageView) -> None:
        """See `FilmOutput`; the picture is kept in `before`."""
        self.draw(view)
        self.before = _picture_hash(self._target.read())

    def advance(self) -> None:
        """See `FilmOutput`."""
        self._write(self._target.push())

    def change_patch(self, patch: Patch) -> None:
        """See `FilmOutput`."""
        with contextlib.suppress(PersonError):  # as live: the last good pass stays
            draw_patch(self._renderer, patch)

    def close(self) -> str:
        """See `FilmOutput`."""
        picture = self._target.flush()
        self.last = "" if picture is None else _picture_hash(picture)
        self._write(picture)
        try:
            self._writer.close()
        except FilmError as error:
            raise PersonError(str(error)) from None
        return f"the film is here: {self._path.resolve()}"

    def _write(self, picture: Picture | None) -> None:
        if picture is None:
            return
        try:
            self._writer.write(picture)
        except FilmError as error:
            raise PersonError(str(error)) from None


def _picture_hash(picture: Picture) -> str:
    return hashlib.blake2b(np.ascontiguousarray(picture).data, digest_size=16).hexdigest()


def _formations(show: Show) -> Iterator[StageFormation]:
    """Yield the formations that the show knows by name, with places for its largest group."""
    count = max(group.dancers for group in show.patch.group)
    for formation in show.motion.evolutions.formations.values():
        places = formation.places_for(count)
        slots = np.asarray(places.slots, np.float64).reshape(-1, 2)
        yield StageFormation(formation.name, slots, np.broadcast_to(places.heading, len(slots)).astype(np.float64))


@cache
def _figure(name: str) -> FigureMesh:
    """Return a built-in body at its finest level, for other programs."""
    body = build_figure(FINEST_LEVEL, name)
    joints, weights = skeleton_weights(body)
    return FigureMesh(
        positions=np.ascontiguousarray(body.position, np.float32),
        normals=np.ascontiguousarray(body.normal, np.float32),
        joints=joints.astype(np.uint8),
        weights=weights,
        indices=body.triangle.ravel().astype(np.uint16),
    )


class MotionOutput:
    """The poses of all dancers who are ever on the stage."""

    def __init__(self, loaded: LoadedShow, show: Show, path: Path, *, frames: int, fps: float, begin: float) -> None:
        """`frames`: how many there will be, 0 if it is not known; `begin` [s]: time of the first one in the show.

        PersonError if so many poses cannot be held.
        """
        self._path, self._rate, self._begin = path, fps, begin
        self._name = loaded.path.stem
        self._groups = [group.name for group in show.patch.group]
        scene = loaded.scene()
        self._colours, self._bodies = scene.group_colours, scene.bodies
        self._group = np.array(show.group)
        self._formations = tuple(_formations(show))
        self._root: list[Float32] = []
        self._rotation: list[Float32] = []
        self._present: list[Bool] = []
        self._beat: list[tuple[float, int]] = []
        self._check_size(frames)

    def _check_size(self, frames: int) -> None:
        count = len(self._group)
        needed = frames * count * (16 * JOINT_COUNT + 12)
        if needed > MAX_MOTION_BYTES:
            raise PersonError(
                f"{count} dancers in {frames} frames need {needed / 1e9:.1f} GB of memory",
                "give fewer frames per second (--fps 30) or a part of the show",
            )

    def draw(self, view: StageView) -> None:
        """See `FilmOutput`; PersonError if there are too many frames."""
        self._check_size(len(self._root) + 1)
        self._root.append(view.joint_position[:, 0].copy())
        self._rotation.append(view.joint_rotation.copy())
        self._present.append(view.present.copy())
        self._beat.append((view.beat, view.measure + 1))

    def follow(self, view: StageView) -> None:
        """See `FilmOutput`: poses remember nothing."""

    warm_up = follow

    def advance(self) -> None:
        """See `FilmOutput`."""

    def change_patch(self, patch: Patch) -> None:
        """See `FilmOutput`."""

    def motion(self) -> StageMotion:
        """Return the motion so far; PersonError if nobody was on the stage."""
        present = np.array(self._present)
        root = np.array(self._root)
        beat = np.array(self._beat, np.float64).reshape(-1, 2)
        seen = np.flatnonzero(present.any(axis=0)).tolist() if len(present) else []
        if not seen:
            raise PersonError("nobody is on the stage: there is no motion to write")
        dancers = []
        for number in seen:
            world = np.array([rotation[number] for rotation in self._rotation])
            clip = Clip(
                name=f"dancer {number + 1}",
                root_position=np.ascontiguousarray(root[:, number]),
                rotation=np.ascontiguousarray(local_rotations(world), np.float32),
                sample_rate=self._rate,
                contact=np.zeros((len(root), 2), np.bool_),
            )
            group = int(self._group[number])
            name = self._groups[group] if group < len(self._groups) else ""
            colour = self._colours[group % len(self._colours)]
            figure = self._body(number)
            dancers.append(DancerMotion(clip.name, name, clip, present[:, number], colour, figure))
        return StageMotion(
            self._name, tuple(dancers), self._rate, self._begin, beat[:, 0], beat[:, 1], self._formations
        )

    def _body(self, dancer: int) -> FigureMesh:
        """Return the body of a dancer; the usual one stands for a character, which stays in its own file."""
        name = self._bodies[dancer] if dancer < len(self._bodies) else DEFAULT_BODY
        return _figure(name if name in BODIES else DEFAULT_BODY)

    def close(self) -> str:
        """See `FilmOutput`."""
        motion, suffix = self.motion(), self._path.suffix.lower()
        made = stage_format(suffix)
        assert made is not None
        assert made.write_stage is not None
        files = made.write_stage(motion, suffix)
        paths = [self._path.with_name(f"{self._path.stem}{part}{self._path.suffix}") for part in files]
        for path, data in zip(paths, files.values(), strict=True):
            write_atomically(data, path, "the motion")
        where = f"{paths[0].resolve()}" if len(paths) == 1 else f"{paths[0].resolve()} to {paths[-1].name}"
        return f"the motion of {len(motion.dancers)} dancers in {motion.sample_count} frames is here: {where}"
