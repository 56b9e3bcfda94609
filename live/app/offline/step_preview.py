"""Preview of a step for `live steps play`: loops the step with a dancer for each variation."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.app.offline.step_listing import find_step, named_steps
from live.app.session_audio import AudioChoice
from live.base.errors import PersonError
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.motion.clip import Clip
from live.motion.step_clip import StepClip, travel
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.patch.section_motion import GroupSection, LocomotionSection
from live.show.patch.section_music import ClockSection
from live.show.patch.section_stage import CameraSection, StageSection

MAX_VARIATIONS = 16
"""Maximum number of variations shown at once."""
PER_ROW = 8
DANCER_SPACING = 1.7
"""Distance between dancers [m]."""
ANY_POSE_THRESHOLD = 2.0
"""Join threshold [m], so large that the step can loop whatever its ends are."""
LOOPS = 8
"""Number of loops in a film without --seconds."""
TRAVEL_LOOPS = 4
"""Number of loops for which the stage has room with --travel."""


@dataclass(frozen=True, slots=True)
class Preview:
    """Options of the command line."""

    step: str
    library: Path | None = None
    variation: int | None = None
    tempo: float | None = None
    seconds: float | None = None
    travel: bool = False
    headless: bool = False
    film: Path | None = None
    monitor: str | None = None
    fullscreen: bool = False
    size: tuple[int, int] = (1280, 720)
    fps: float | None = None


@dataclass(frozen=True, slots=True)
class PreviewOptions(LaunchOptions):
    """Launch options with a show that is made here instead of loaded."""

    show: LoadedShow | None = None

    def load(self, *, whole: bool = True) -> LoadedShow:
        """Return the show that was made here."""
        assert self.show is not None
        return self.show


def play_step(preview: Preview) -> None:
    """Show the step in a window, as a film or headless; raise PersonError if that fails."""
    step = find_step(named_steps(preview.library), preview.step)
    chosen = _select_clips(list(step.clips), preview.variation)
    console = Console(stderr=True, highlight=False)
    if len(chosen) > MAX_VARIATIONS:
        console.print(
            f"{len(chosen)} variations, the first {MAX_VARIATIONS} are shown; select others with --variation N"
        )
        chosen = chosen[:MAX_VARIATIONS]
    for number, clip in chosen:
        mirrored = ", mirrored" if clip.mirrored else ""
        words = f"{number}: {clip.direction}{mirrored}, {clip.measures} measures at {clip.bpm:g} bpm"
        console.print(words, style="dim", soft_wrap=True, markup=False)
    loaded = preview_show(step.name, [clip for _, clip in chosen], travelling=preview.travel)
    bpm = preview.tempo or chosen[0][1].bpm
    loop = max(clip.beats for _, clip in chosen) * 60.0 / bpm
    options = PreviewOptions(
        bpm=bpm, osc=("127.0.0.1", 0), seconds=preview.seconds, record=preview.film, size=preview.size,
        fps=preview.fps, monitor=preview.monitor, fullscreen=preview.fullscreen, headless=preview.headless, show=loaded,
    )  # fmt: skip
    from live.app.headless_loop import play_show
    from live.render.window.monitors import list_monitors

    if preview.film is not None and not preview.headless:
        from live.app.film.show_film import film_show
        from live.app.machine.kernel_warmup import warm_kernels

        warm_kernels(console)
        seconds = preview.seconds or LOOPS * loop
        film_show(options, loaded, AudioChoice(), path=preview.film, seconds=seconds, console=console)
        console.print(f"the film is here: {preview.film.resolve()}", soft_wrap=True, markup=False)
        return
    if not preview.headless and not list_monitors():  # play_show then makes a film: name it after the step
        name = "".join(letter if letter.isalnum() else "-" for letter in step.name)
        options = replace(options, record=Path(f"{name}.mp4"), seconds=preview.seconds or LOOPS * loop)
    play_show(options)


def _select_clips(clips: list[StepClip], variation: int | None) -> list[tuple[int, StepClip]]:
    numbered = list(enumerate(clips, start=1))
    if variation is None:
        return numbered
    if variation > len(clips):
        raise PersonError(f"--variation {variation}: the step has {len(clips)}", "live steps show STEP lists them")
    return [numbered[variation - 1]]


def preview_show(name: str, clips: list[StepClip], *, travelling: bool) -> LoadedShow:
    """Return a show in which each dancer loops one of the variations `clips`, in rows side by side.

    Unless `travelling`, travel is removed from the clips evenly, as on a treadmill, and a small correction keeps the
    dancers in place.
    """
    names = [f"{name} {number}" for number in range(1, len(clips) + 1)]
    shown = [
        replace(clip if travelling else on_the_spot(clip), step=own, begin_pose="", end_pose="", weight_transfer=False)
        for own, clip in zip(names, clips, strict=True)
    ]
    rows = math.ceil(len(clips) / PER_ROW)
    columns = math.ceil(len(clips) / rows)
    room = TRAVEL_LOOPS * max(float(np.hypot(*travel(clip))) for clip in clips) if travelling else 0.0
    width, depth = columns * DANCER_SPACING + 2.0 + 2 * room, rows * DANCER_SPACING + 2.0 + 2 * room
    groups = []
    for number, own in enumerate(names):
        row, column = divmod(number, columns)
        in_row = min(columns, len(names) - row * columns)
        centre = ((column - (in_row - 1) / 2) * DANCER_SPACING, ((rows - 1) / 2 - row) * DANCER_SPACING)
        groups.append(GroupSection(name=own[:60] + str(number), dancers=1, steps=(f"{own} x1",), centre=centre))
    patch = Patch(
        name=f"Step {name}"[:64],
        reserve=0,
        clock=ClockSection(bpm=clips[0].bpm, beats_per_measure=clips[0].beats_per_measure),
        stage=StageSection(width=min(width, 200.0), depth=min(depth, 200.0)),
        camera=_camera(columns * DANCER_SPACING + 2 * room, rows * DANCER_SPACING + 2 * room),
        locomotion=LocomotionSection(
            threshold_m=ANY_POSE_THRESHOLD,
            correction_m=0.0 if travelling else 0.1,
            turn_deg=0.0 if travelling else 10.0,
        ),
        group=tuple(groups),
    )
    window = min(1.0, patch.locomotion.transition_beats / patch.clock.beats_per_measure)
    try:
        graph = build_graph(build_library(shown), window=window, threshold=ANY_POSE_THRESHOLD)
    except ValueError as error:
        raise PersonError(f"step {name!r}: {error}") from None
    return LoadedShow(Path(patch.name), patch, graph)


def on_the_spot(step: StepClip) -> StepClip:
    """Return the step without travel: the hips' displacement is removed evenly over its measures."""
    samples = np.arange(step.clip.sample_count)
    done = (samples - step.first) / (step.measures * step.samples_per_measure)
    x, z = travel(step)
    root = step.clip.root_position - np.outer(done, (x, 0.0, z)).astype(np.float32)
    clip = Clip(step.clip.name, root, step.clip.rotation, step.clip.sample_rate, step.clip.contact)
    return replace(step, clip=clip, distance_m=0.0)


def _camera(width: float, depth: float) -> CameraSection:
    """Return a camera for dancers within `width` and `depth` [m] at 16:9 with a 36 degree field of view."""
    far = max(4.2, 0.5 * width / 0.55) + 0.5 * depth
    return CameraSection(eye=(0.0, 1.3 + 0.12 * far, far), target=(0.0, 0.85, 0.0), field_of_view_deg=36)
