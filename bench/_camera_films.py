"""Made films of cameras, with the truth: dancers whose joints, camera and light are known, drawn by our own renderer.

Nobody real is seen: plain faces and rooms flatter a pose model, which the faults of a cheap sensor make up for in part.
"""

import contextlib
import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from bench._camera_dances import LEAD, RATE, Dance, Source, heel_and_ball_contacts, read_dance
from bench._camera_sensor import WEBCAM, CompressedFilm, Sensor, SensorPicture, moment_times
from live.base.arrays import Bool, Float64
from live.base.body.appearance import APPEARANCE_SIZE, BY_CHANCE, COSTUMES, HAIRS, SHOES
from live.base.picture_parameters import picture_row
from live.base.set_geometry import SetItem
from live.base.stage_snapshot import Background, Camera, Colour, Scene, StageView
from live.motion.clip import Clip, read_clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import BODY_HEIGHT, JOINT_COUNT, SKELETON
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import world_to_clip
from live.render.headless import OffscreenTarget, create_headless_context, release_headless_context
from live.render.renderer import Renderer
from live.show.desk.worlds import is_drawing_style, world_values

FPS: Final = 30.0
STAGE: Final = (10.0, 8.0)
"""Width and depth of the stage that is drawn [m]."""


@dataclass(frozen=True, slots=True)
class Person:
    """What one dancer looks like."""

    body: str = "woman"
    """A name of `live.base.body.catalogue.BODIES`."""
    costume: str = "trousers"
    colour: Colour = (0.55, 0.08, 0.10)
    second: Colour = (0.05, 0.06, 0.12)
    """Of trousers, tights and trims."""
    skin: int = 170
    """Tone of the skin, from 0 (darkest) to 255 (palest)."""
    hair: str = "bob"
    hair_colour: int = 60
    shoes: str = "sneakers"


@dataclass(frozen=True, slots=True)
class Light:
    """How the room is lit: values of picture parameters over those of a world."""

    world: str = "studio"
    values: tuple[tuple[str, float | Colour], ...] = ()
    wall: float = 0.8
    """How bright the cluttered back wall is."""


GOOD: Final = Light("haze", (
    ("/dance/light/key", 0.7), ("/dance/light/key/colour", (1.0, 0.97, 0.92)), ("/dance/light/rim", 0.15),
    ("/dance/light/side", 0.0), ("/dance/light/back", 0.0), ("/dance/light/beams", 0.0), ("/dance/light/haze", 0.0),
    ("/dance/light/fill", 0.6), ("/dance/light/background", (0.30, 0.29, 0.28)),
    ("/dance/light/floor", (0.26, 0.19, 0.13)), ("/dance/pass/mirror", 0.15), ("/dance/pass/vignette", 0.2),
))  # fmt: skip
"""A rehearsal room by day: wooden floor, soft light."""
WHITE: Final = Light("studio", (("/dance/light/key", 0.5), ("/dance/light/fill", 0.5)))
"""A white studio."""
DARK: Final = Light("haze", (
    ("/dance/light/key", 0.35), ("/dance/light/rim", 0.25), ("/dance/light/beams", 0.0), ("/dance/light/fill", 0.06),
    ("/dance/light/haze", 0.0), ("/dance/light/floor", (0.03, 0.03, 0.035)), ("/dance/light/back", 0.0),
), wall=0.05)  # fmt: skip
"""A stage with little light from one side."""
BACK: Final = Light("studio", (
    ("/dance/light/key", 0.05), ("/dance/light/fill", 0.10), ("/dance/light/rim", 1.2), ("/dance/light/back", 0.8),
    ("/dance/light/floor", (0.20, 0.20, 0.20)), ("/dance/pass/mirror", 0.1), ("/dance/pass/vignette", 0.0),
), wall=1.1)  # fmt: skip
"""Light from behind, a bright wall: dancers are dark against it."""


@dataclass(frozen=True, slots=True)
class FilmCase:
    """One film to make: who dances what, before which camera, in which light."""

    name: str
    """Of its files; letters, digits, `-` and `_`."""
    source: Source
    seconds: float
    people: tuple[Person, ...]
    """One for each dancer of the source."""
    eye: tuple[float, float, float] = (0.0, 1.4, 5.5)
    """Position of the camera [m]."""
    target: tuple[float, float, float] = (0.0, 0.9, 0.0)
    """The point that it looks at [m]."""
    field_of_view_deg: float = 42.0
    """The camera's vertical field of view."""
    size: tuple[int, int] = (640, 480)
    light: Light = GOOD
    sensor: Sensor = WEBCAM
    height: float = BODY_HEIGHT
    """Height of all its people [m]: the whole world is scaled, so proportions stay those of the skeleton."""
    items: tuple[SetItem, ...] = ()
    """Scenery that hides people [m]."""
    cluttered: bool = True
    """Whether pictures, shelves and doors are on the back wall."""
    wall: float = -3.6
    """Where the back wall stands, z [m]."""
    seed: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class FilmTruth:
    """What is known of a film: F frames, D dancers, J joints (22)."""

    film: Path
    name: str
    size: tuple[int, int]
    fps: float
    time: Float64
    """Time of each frame from the first [s], (F,): the middle of the exposure of its middle row."""
    joints: Float64
    """World positions [m], (F, D, J, 3)."""
    rotation: Float64
    """Local rotations as in a clip, (F, D, J, 4)."""
    contact: Bool
    """Whether the left and right foot are on the floor (`live.motion.foot_contact`), (F, D, 2)."""
    heel_ball: Bool
    """The same for heel and ball of each foot, (F, D, 2, 2)."""
    camera: Float64
    """Matrix from the world to pixels, (3, 4): `x, y, w = camera @ (X, Y, Z, 1)`, pixel = (x / w, y / w), y down."""
    eye: Float64
    """Position of the camera [m], (3,)."""
    scale: float
    """Height of the people over the skeleton's."""
    in_picture: Bool
    """Whether each joint is within the picture, hidden or not, (F, D, J)."""
    bpm: float | None
    """Tempo of the show that is danced; None for recorded takes."""
    lines: Float64
    """Times of measure lines [s]."""
    steps: tuple[tuple[str, ...], ...]
    """For each dancer the step of the measure that begins at each line."""

    @property
    def hips(self) -> Float64:
        """World positions of the hips [m], (F, D, 3)."""
        return self.joints[:, :, 0]

    def pixels(self) -> Float64:
        """Return the joints in the picture [pixels], (F, D, J, 2), y down."""
        return to_pixels(self.camera, self.joints)


def to_pixels(camera: Float64, points: Float64) -> Float64:
    """Return the pixels (..., 2) of world points (..., 3) [m] by a matrix (3, 4)."""
    seen = points @ camera[:, :3].T + camera[:, 3]
    return np.asarray(seen[..., :2] / seen[..., 2:])


def make_film(case: FilmCase, folder: Path, shared: Path | None = None) -> FilmTruth | None:
    """Make the film of a case and its truth: NAME.mp4 and NAME.npz in `folder`. None if its recordings are missing.

    The .npz is there when the film is complete. `shared` holds the folder `mocap`. The same case gives the same film on
    one machine. Raises ValueError for a case whose people or times do not fit its source; NoOpenGL without a driver.
    """
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        dance = read_dance(case.source, case.seconds, shared, scratch)
        if dance is None:
            return None
        if len(dance.clips) != len(case.people):
            raise ValueError(f"{case.name}: {len(case.people)} people for {len(dance.clips)} dancers")
        truth = _truth(case, dance, folder)
        _truth_file(truth).unlink(missing_ok=True)
        _draw(case, dance, truth, scratch)
    _save(truth)
    return truth


def _truth(case: FilmCase, dance: Dance, folder: Path) -> FilmTruth:
    frames = round(case.seconds * FPS)
    time = np.arange(frames) / FPS
    joints, rotation, contact, ends = [], [], [], []
    scale = case.height / BODY_HEIGHT
    for clip in dance.clips:
        samples = _samples(time)
        root, local, on_floor = read_clip(clip, samples)
        joints.append(scale * forward_kinematics(root, local)[0])
        rotation.append(local)
        contact.append(on_floor)
        nearest = np.clip(np.rint(samples).astype(np.int64), 0, clip.sample_count - 1)
        ends.append(heel_and_ball_contacts(clip)[nearest])
    camera = camera_matrix(case)
    places = np.stack(joints, axis=1)
    pixels = to_pixels(camera, places)
    inside = np.asarray(((pixels >= 0.0) & (pixels < np.array(case.size))).all(axis=-1))
    return FilmTruth(
        film=folder / f"{case.name}.mp4", name=case.name, size=case.size, fps=FPS, time=time, joints=places,
        rotation=np.stack(rotation, axis=1), contact=np.stack(contact, axis=1), heel_ball=np.stack(ends, axis=1),
        camera=camera, eye=np.array(case.eye), scale=scale, in_picture=inside, bpm=dance.bpm,
        lines=dance.lines[dance.lines < case.seconds], steps=dance.steps,
    )  # fmt: skip


def _samples(time: Float64) -> Float64:
    """Return the samples of a dance's clips at times of the film [s]."""
    return (time + LEAD) * RATE


def camera_matrix(case: FilmCase) -> Float64:
    """Return the matrix (3, 4) from the world [m] to pixels, y down, with w = depth along the axis [m]."""
    clip = world_to_clip(Camera(case.eye, case.target, case.field_of_view_deg), case.size)
    width, height = case.size
    to_picture = np.array([[0.5 * width, 0.0, 0.5 * width], [0.0, -0.5 * height, 0.5 * height], [0.0, 0.0, 1.0]])
    return np.asarray(to_picture @ clip[[0, 1, 3]])


def _scene(case: FilmCase, scratch: Path) -> Scene:
    """Return the scene in the skeleton's own size: people of another height are seen from another distance."""
    back = BODY_HEIGHT / case.height
    world = {key: value for key, value in world_values(case.light.world).items() if not is_drawing_style(key)}
    values = world | {"/dance/light/pulse": 0.0} | dict(case.light.values)
    groups = tuple(
        (
            ("/dance/draw/variety", (0.0,)), ("/dance/draw/accent", tuple(map(float, person.second))),
            ("/dance/draw/accent/amount", (1.0,)),
        )
        for person in case.people
    )  # fmt: skip
    items = tuple(
        replace(
            item, at=(back * item.at[0], back * item.at[1]), lift=back * item.lift,
            size=(back * item.size[0], back * item.size[1], back * item.size[2]),
        )
        for item in case.items
    )  # fmt: skip
    walls: tuple[Background, ...] = ()
    if case.cluttered:
        picture = scratch / "wall.png"
        _clutter(picture, case.seed)
        walls = (Background(str(picture), width=back * 11.0, at=(0.0, back * case.wall), brightness=case.light.wall),)
        values |= {"/dance/background/1": 1.0}
    return Scene(
        STAGE, _camera(case), len(case.people), JOINT_COUNT,
        group_colours=tuple(person.colour for person in case.people), group_styles=groups, backgrounds=walls,
        items=items, bodies=tuple(person.body for person in case.people), start_values=tuple(values.items()),
    )  # fmt: skip


def _camera(case: FilmCase) -> Camera:
    back = BODY_HEIGHT / case.height
    (ex, ey, ez), (tx, ty, tz) = case.eye, case.target
    return Camera((back * ex, back * ey, back * ez), (back * tx, back * ty, back * tz), case.field_of_view_deg)


def _clutter(path: Path, seed: int) -> None:
    """Write the picture of a wall with a door, shelves, windows and posters, by chance."""
    from PIL import Image, ImageDraw, ImageFilter

    chance = np.random.default_rng((seed, 7))
    base = chance.integers(120, 215, 3)
    image = Image.new("RGB", (1100, 340), tuple(int(value) for value in base))
    draw = ImageDraw.Draw(image)
    for _ in range(int(chance.integers(14, 26))):
        x, y = chance.uniform(0, 1100), chance.uniform(0, 330)
        w, h = chance.uniform(15, 130), chance.uniform(15, 160)
        shade = base + chance.normal(0, 45) + chance.normal(0, 18, 3)
        fill = tuple(int(value) for value in np.clip(shade, 0, 255))
        draw.rectangle((x, y, x + w, min(y + h, 338)), fill=fill, outline=(40, 36, 34))
        for line in range(int(chance.integers(0, 5))):
            level = y + h * (line + 1) / 6
            draw.line((x, level, x + w, level), fill=(60, 55, 50), width=2)
    image.filter(ImageFilter.GaussianBlur(1.2)).save(path)


def _appearance(people: tuple[Person, ...]) -> np.ndarray[tuple[int, int], np.dtype[np.int32]]:
    rows = [
        (BY_CHANCE, person.skin, HAIRS.index(person.hair), person.hair_colour, COSTUMES.index(person.costume),
         SHOES.index(person.shoes))
        for person in people
    ]  # fmt: skip
    return np.array(rows, np.int32).reshape(len(people), APPEARANCE_SIZE)


@contextlib.contextmanager
def _drawing(case: FilmCase, scratch: Path) -> Iterator[tuple[Scene, Renderer, OffscreenTarget]]:
    with contextlib.ExitStack() as stack:
        ctx = create_headless_context()
        stack.callback(release_headless_context, ctx)
        scene = _scene(case, scratch)
        target = OffscreenTarget(ctx, case.size)
        stack.callback(target.release)
        # bodies as on a graphics card, everything else as without one
        quality = replace(SOFTWARE, near_level=HARDWARE.near_level, far_level=HARDWARE.near_level)
        renderer = Renderer(ctx, scene, size=case.size, quality=quality, blocking_video=True, warm_up=False)
        stack.callback(renderer.release)
        yield scene, renderer, target


def _draw(case: FilmCase, dance: Dance, truth: FilmTruth, scratch: Path) -> None:
    moments = moment_times(case.sensor)
    times = truth.time[:, None] + moments
    poses = [_poses(clip, times.ravel()) for clip in dance.clips]
    with _drawing(case, scratch) as (scene, renderer, target):
        view = StageView.allocate(len(case.people), JOINT_COUNT)
        view.group[:] = np.arange(len(case.people))
        view.appearance[:] = _appearance(case.people)
        view.picture = picture_row(scene)
        developed = SensorPicture(case.sensor, case.size, case.seed)
        film = CompressedFilm(truth.film, case.size, truth.fps, case.sensor.kilobits)
        for number, time in enumerate(times.ravel().tolist()):
            for dancer, (positions, rotations) in enumerate(poses):
                view.joint_position[dancer], view.joint_rotation[dancer] = positions[number], rotations[number]
            view.time, view.beat = time, 2.0 * time
            renderer.draw(view, target.framebuffer)
            developed.add(target.read())
            if (number + 1) % len(moments) == 0:
                film.write(developed.develop())
        film.close()


def _poses(clip: Clip, times: Float64) -> tuple[Float64, Float64]:
    root, local, _ = read_clip(clip, _samples(times))
    positions, world = forward_kinematics(root, local)
    return np.asarray(positions, np.float64), np.asarray(world, np.float64)


def _truth_file(truth: FilmTruth) -> Path:
    return truth.film.with_suffix(".npz")


def _save(truth: FilmTruth) -> None:
    arrays = {
        name: getattr(truth, name)
        for name in ("time", "joints", "rotation", "contact", "heel_ball", "camera", "eye", "in_picture", "lines")
    }
    told = {
        "name": truth.name, "film": truth.film.name, "size": truth.size, "fps": truth.fps, "scale": truth.scale,
        "bpm": truth.bpm, "steps": truth.steps, "joints": SKELETON.names,
    }  # fmt: skip
    np.savez_compressed(_truth_file(truth), told=np.array(json.dumps(told)), hips=truth.hips, **arrays)


def load_truth(path: Path) -> FilmTruth:
    """Return the truth of a film from its .npz; the film lies beside it. OSError or KeyError if it is no such file."""
    with np.load(path) as data:
        told = json.loads(str(data["told"]))
        return FilmTruth(
            film=path.parent / told["film"], name=told["name"], size=(told["size"][0], told["size"][1]),
            fps=told["fps"], time=data["time"], joints=data["joints"], rotation=data["rotation"],
            contact=data["contact"], heel_ball=data["heel_ball"], camera=data["camera"], eye=data["eye"],
            scale=told["scale"], in_picture=data["in_picture"], bpm=told["bpm"], lines=data["lines"],
            steps=tuple(tuple(own) for own in told["steps"]),
        )  # fmt: skip
