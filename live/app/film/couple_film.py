"""Film of an answer over the real couple: leader, answer and, in outline, the real follower, with what each dances."""

import contextlib
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from rich.console import Console

from live.app.film.live_recording import film_writer
from live.app.film.show_film import progress_bar
from live.base.arrays import Float, Float64
from live.base.body.appearance import COSTUMES
from live.base.errors import PersonError
from live.base.picture_parameters import EYE, TARGET, picture_row
from live.base.stage_snapshot import Camera, Colour, Scene, StageView, Title
from live.motion.clip import Clip, read_clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.partner.couple_comparison import ComparedDance
from live.motion.partner.couple_states import CoupleStates, Stance
from live.motion.skeleton import JOINT_COUNT
from live.render.film.film_writer import FilmError
from live.render.headless import NoOpenGL, OffscreenTarget, create_headless_context, release_headless_context
from live.render.renderer import Renderer

LEADER_COLOUR: Final[Colour] = (0.16, 0.2, 0.3)
ANSWER_COLOUR: Final[Colour] = (0.86, 0.2, 0.1)
REAL_COLOUR: Final[Colour] = (0.55, 0.8, 1.0)
AGREE_COLOUR: Final[Colour] = (0.35, 0.8, 0.45)
PALE: Final[Colour] = (0.8, 0.8, 0.82)
FIELD_OF_VIEW: Final = 30.0
HEIGHT: Final = 2.5
"""Height of what the picture shows where the nearest dancer is, at least [m]: a dancer, raised hands and captions."""
TARGET_HEIGHT: Final = 0.85
"""Height to which the camera looks [m]."""
MARGIN: Final = 0.8
"""Space beside the outermost hips [m]."""
FOLLOWING_S: Final = 1.0
"""Standard deviation of the smoothing of the camera's way [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class CoupleFilm:
    """What a film shows; all clips have one rate and one world frame."""

    name: str
    leader: Clip
    real: ComparedDance
    answer: ComparedDance
    beats: Float64
    """Samples of the counts (n,), ascending; empty: no counts are shown."""
    first: int
    """Index of a beat that is a one."""
    counts: int
    """Counts of a pattern."""
    patterns: Sequence[tuple[float, float, str, str]]
    """Begin and end [s] of each pattern, its label of a person, and that of the answer; empty without labels."""


def film_couple(film: CoupleFilm, path: Path, *, size: tuple[int, int], fps: float, console: Console) -> None:
    """Draw the film; PersonError if it cannot be drawn or written."""
    clips = (film.leader, film.answer.follower, film.real.follower)
    rate = film.leader.sample_rate
    count = min(clip.sample_count for clip in clips)
    frames = max(int((count - 1) / rate * fps), 1)
    scene = Scene(
        (8.0, 8.0), Camera(field_of_view_deg=FIELD_OF_VIEW), 3, JOINT_COUNT,
        group_colours=(LEADER_COLOUR, ANSWER_COLOUR, REAL_COLOUR),
        group_styles=(
            (("/dance/draw/costume", (float(COSTUMES.index("trousers")),)),),
            (("/dance/draw/costume", (float(COSTUMES.index("unitard")),)),),
            (("/dance/draw/solid", (0.0,)), ("/dance/draw/xray", (1.0,))),
        ),
        bodies=("man", "woman", "woman"),
    )  # fmt: skip
    view = StageView.allocate(3, JOINT_COUNT)
    view.group[:] = (0, 1, 2)
    view.picture = row = picture_row(scene)
    middle, away = _camera(clips, size, frames, fps)
    with contextlib.ExitStack() as stack:
        target, renderer = _renderer(stack, scene, size)
        try:
            writer = stack.enter_context(film_writer(path, size=size, fps=fps, sound=None))
            progress = stack.enter_context(progress_bar(console))
            task = progress.add_task("", total=frames)
            for frame in range(frames):
                sample = frame / fps * rate
                for dancer, clip in enumerate(clips):
                    view.joint_position[dancer], view.joint_rotation[dancer] = _pose(clip, sample)
                (x, z), far = middle[frame].tolist(), float(away[frame])
                row[EYE], row[TARGET] = (x, 1.15 + 0.08 * far, z + far), (x, TARGET_HEIGHT, z)
                view.time = frame / fps
                view.beat = _beat(film, sample)
                view.phase = view.beat % 4.0
                view.titles = _titles(film, sample)
                renderer.draw(view, target.framebuffer)
                if (picture := target.push()) is not None:
                    writer.write(picture)
                progress.advance(task)
            if (picture := target.flush()) is not None:
                writer.write(picture)
        except FilmError as error:
            raise PersonError(str(error)) from None


def _renderer(stack: contextlib.ExitStack, scene: Scene, size: tuple[int, int]) -> tuple[OffscreenTarget, Renderer]:
    try:
        ctx = create_headless_context()
    except NoOpenGL as error:
        raise PersonError(str(error)) from None
    stack.callback(release_headless_context, ctx)
    try:
        target = OffscreenTarget(ctx, size)
        stack.callback(target.release)
        renderer = Renderer(ctx, scene, size=size, blocking_video=True, warm_up=False)
    except ValueError as error:
        raise PersonError(str(error)) from None
    stack.callback(renderer.release)
    return target, renderer


def _pose(clip: Clip, sample: float) -> tuple[Float, Float]:
    """Return world positions (J, 3) and rotations (J, 4) at a sample."""
    root, rotation, _ = read_clip(clip, np.array([sample]))
    positions, world = forward_kinematics(np.asarray(root, np.float64), np.asarray(rotation, np.float64))
    return positions[0], world[0]


def _camera(clips: tuple[Clip, ...], size: tuple[int, int], frames: int, fps: float) -> tuple[Float64, Float64]:
    """Return where a camera in the hall looks in each frame, x and z (frames, 2), and how far it is away (frames,) [m].

    It follows the middle of the dancers slowly, and goes back in time for all of them to be seen whole.
    """
    from scipy.ndimage import gaussian_filter1d, maximum_filter1d

    rate = clips[0].sample_rate
    samples = np.minimum(np.arange(frames) / fps * rate, min(clip.sample_count for clip in clips) - 1.0).astype(
        np.int64
    )
    ways = np.stack([clip.root_position[samples][:, (0, 2)] for clip in clips], axis=1).astype(np.float64)
    middle = 0.5 * (ways.min(axis=1) + ways.max(axis=1))
    middle = np.asarray(gaussian_filter1d(middle, FOLLOWING_S * fps, axis=0, mode="nearest"), np.float64)
    away = ways - middle[:, None]
    half = np.tan(np.radians(0.5 * FIELD_OF_VIEW))
    across = (np.abs(away[..., 0]) + MARGIN) * size[1] / size[0]
    far = (np.maximum(across, 0.5 * HEIGHT) / half + away[..., 1]).max(axis=1)
    far = maximum_filter1d(far, 2 * round(2.0 * FOLLOWING_S * fps) + 1, mode="nearest")
    return middle, np.asarray(gaussian_filter1d(far, FOLLOWING_S * fps, mode="nearest"), np.float64)


def _beat(film: CoupleFilm, sample: float) -> float:
    """Return the beat at a sample, 0 at the first one; without beats two in a second."""
    if len(film.beats) < 2:
        return sample / film.leader.sample_rate * 2.0
    return float(np.interp(sample, film.beats, np.arange(len(film.beats))))


def _titles(film: CoupleFilm, sample: float) -> tuple[Title, ...]:
    """Return the captions at a sample: name and count above, what both dance below."""
    words = [
        ("real follower: ", film.real.states, REAL_COLOUR, 0.25), ("answer: ", film.answer.states, ANSWER_COLOUR, 0.75),
    ]  # fmt: skip
    danced = [_state_words(states, sample) for _, states, _, _ in words]
    titles = [
        Title(f"{name}{does}", at=(across, 0.93, 0.0), size=0.026, colour=colour)
        for (name, _, colour, across), does in zip(words, danced, strict=True)
    ]
    if danced[0] == danced[1]:
        titles.append(Title("same", at=(0.5, 0.93, 0.0), size=0.026, colour=AGREE_COLOUR))
    titles.append(Title(film.name, at=(0.1, 0.06, 0.0), size=0.026, colour=PALE))
    if len(film.beats):
        index = bisect_right(film.beats.tolist(), sample) - 1
        if index >= 0:
            count = (index - film.first) % film.counts + 1
            titles.append(Title(str(count), at=(0.5, 0.08, 0.0), size=0.06, colour=PALE))
    time = sample / film.leader.sample_rate
    for begin, end, real, answer in film.patterns:
        if begin <= time < end:
            colours = (AGREE_COLOUR, AGREE_COLOUR) if real == answer else (REAL_COLOUR, ANSWER_COLOUR)
            titles += [
                Title(text, at=(across, 0.87, 0.0), size=0.032, colour=colour)
                for text, across, colour in zip((real, answer), (0.25, 0.75), colours, strict=True)
            ]
    return tuple(titles)


def _state_words(states: CoupleStates, sample: float) -> str:
    index = min(round(sample), len(states.stance) - 1)
    stance = Stance(int(states.stance[index])).words
    turn = states.turn_at(sample)
    return stance if turn is None else f"{stance}, {turn.words}"
