"""`live texture`, the work: reading, making, writing, and what is said of it."""

import json
import time
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from live.app.whole_file import write_whole
from live.base.errors import PersonError
from live.cli.steps.dance_report import check_targets, write_motion
from live.library.capture_material import read_material
from live.library.motion_file import MOTION_ENDINGS, read_motion
from live.library.sketch_folder import MAX_STEP_BYTES, sketched_steps
from live.motion.clip import Clip
from live.motion.resample import resample
from live.motion.retarget.retarget import retarget
from live.motion.texture.texture_corpus import material_of
from live.motion.texture.texture_report import figures_of
from live.motion.texture.texture_settings import Wish
from live.motion.texture.texture_synthesis import textured
from live.motion.texture.tracks import sample_clip


@dataclass(frozen=True, slots=True)
class Asked:
    """The options that are not the method's."""

    sketch: str
    places: tuple[Path, ...]
    out: Path
    fps: float | None
    drop_frames: int | None
    sketch_fps: float | None
    variation: int
    rate: float
    report: Path | None
    force: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Sketch:
    """The whole clip, and the samples of it that are the step."""

    clip: Clip
    first: float
    last: float


def make(asked: Asked, wish: Wish) -> None:
    """Texture the sketch and write a file for each path; PersonError for whatever cannot be."""
    targets = [asked.out] if wish.paths == 1 else [_numbered(asked.out, n) for n in range(1, wish.paths + 1)]
    for target in targets:
        check_targets(target, asked.report, force=asked.force)
    sketch = _read_sketch(asked)
    began = time.perf_counter()
    recorded = read_material(asked.places, fps=asked.fps, drop_frames=asked.drop_frames)
    read = time.perf_counter()
    material = material_of([one.clip for one in recorded.clips], [sample_clip(sketch.clip)])
    found = textured(sketch.clip, material, wish)
    made = time.perf_counter()
    console = Console(highlight=False, soft_wrap=True)
    for words in recorded.passed:
        console.print(f"passed over: {words}", style="yellow", markup=False)
    for target, one in zip(targets, found, strict=False):
        clip = resample(one.clip, asked.rate, first=sketch.first, last=sketch.last)
        write_motion(clip, target)
        joins = one.parts.count - 1
        console.print(
            f"{target}: {clip.seconds:.2f} s of {one.parts.count} pieces, {one.free} of {joins} joins were none in the "
            f"recordings either; matched to {one.distance:.3f} rad",
            markup=False,
        )
    if len(found) < wish.paths:
        console.print(f"only {len(found)} of {wish.paths} paths: more candidates (-K) give more", style="yellow")
    if asked.report is not None:
        values = figures_of(sketch.clip, material, wish, found)
        values |= {"sketch": asked.sketch, "out": [str(one) for one in targets[: len(found)]]}
        values |= {
            "passed_over": list(recorded.passed),
            "rates": {one.step: one.clip.sample_rate for one in recorded.clips},
        }
        values |= {"seconds": {"reading": round(read - began, 3), "texturing": round(made - read, 3)}}
        write_whole((json.dumps(values, ensure_ascii=False, indent=1) + "\n").encode(), asked.report, "--report")


def _numbered(out: Path, number: int) -> Path:
    return out.with_name(f"{out.stem}-{number}{out.suffix}")


def _read_sketch(asked: Asked) -> _Sketch:
    path = Path(asked.sketch)
    if path.suffix.lower() in MOTION_ENDINGS:
        try:
            motion = read_motion(path)
            clip = retarget(motion, name=path.stem, fps=asked.sketch_fps)
        except ValueError as error:
            raise PersonError(" ".join(str(error).split())) from None
        return _Sketch(clip, 0.0, clip.sample_count - 1.0)
    if path.suffix.lower() == ".toml":
        steps = sketched_steps({str(path): _text(path)})
    else:
        from live.cli.steps.steps_library import find_step, named_steps

        steps = list(find_step(named_steps(None), asked.sketch).clips)
    if not 1 <= asked.variation <= len(steps):
        raise PersonError(f"--variation {asked.variation}: {asked.sketch} has {len(steps)}", "--variation 1")
    step = steps[asked.variation - 1]
    return _Sketch(step.clip, step.first, step.first + step.measures * step.samples_per_measure)


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > MAX_STEP_BYTES:
            raise PersonError(f"{path}: a step has at most {MAX_STEP_BYTES} bytes")
        return path.read_bytes().decode("utf-8")
    except OSError as error:
        raise PersonError(
            f"cannot read {path}: {error.strerror}", "give a motion file, a step file or a name"
        ) from None
    except UnicodeDecodeError as error:
        raise PersonError(f"{path}: not a text in UTF-8 (byte {error.start})") from None
