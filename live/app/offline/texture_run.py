"""Execution of `live texture` and `live steps enrich`: texturing of sketched motion with motion capture."""

import json
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from live.app.offline.dance_report import check_targets, write_motion
from live.app.offline.step_listing import library_folders
from live.base.errors import PersonError
from live.graph.step_library import plain_name
from live.library.capture_material import read_material
from live.library.motion_file import read_motion
from live.library.motion_formats import is_readable_name
from live.library.recording_file import read_step_files
from live.library.step_folder import MAX_STEP_BYTES, sketched_steps
from live.library.textured_steps import (
    EnrichedStep,
    UpperBodyMode,
    build_material,
    enrich,
    textured_path,
    textured_text,
)
from live.library.whole_file import write_atomically
from live.motion.clip import Clip, resample
from live.motion.retarget.retarget import retarget
from live.motion.step_clip import StepClip
from live.motion.texture.frequency_bands import sample_clip
from live.motion.texture.texture_corpus import TextureCorpus, make_corpus
from live.motion.texture.texture_report import make_report
from live.motion.texture.texture_settings import TextureSettings
from live.motion.texture.texture_synthesis import texture_sketch


@dataclass(frozen=True, slots=True)
class TextureOptions:
    """Options of the command besides the texture settings."""

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
    """Sketched clip, and the range of samples that is the step."""

    clip: Clip
    first: float
    last: float


def run_texture(options: TextureOptions, settings: TextureSettings) -> None:
    """Texture the sketch and write a file for each path; raise PersonError if that fails."""
    targets = (
        [options.out] if settings.paths == 1 else [_numbered(options.out, n) for n in range(1, settings.paths + 1)]
    )
    for target in targets:
        check_targets(target, options.report, force=options.force)
    sketch = _read_sketch(options)
    began = time.perf_counter()
    recorded = read_material(options.places, fps=options.fps, drop_frames=options.drop_frames)
    read = time.perf_counter()
    material = make_corpus([one.clip for one in recorded.clips], [sample_clip(sketch.clip)])
    found = texture_sketch(sketch.clip, material, settings)
    made = time.perf_counter()
    console = Console(highlight=False, soft_wrap=True)
    for words in recorded.skipped:
        console.print(f"passed over: {words}", style="yellow", markup=False)
    if settings.learnt and settings.synthesize:
        _say_what_is_told(console, material, settings)
    for target, one in zip(targets, found, strict=False):
        clip = resample(one.clip, options.rate, first=sketch.first, last=sketch.last)
        write_motion(clip, target)
        joins = one.fragments.count - 1
        console.print(
            f"{target}: {clip.seconds:.2f} s of {one.fragments.count} pieces, {one.consecutive_joins} of {joins} joins "
            f"were none in the recordings either; matched to {one.distance:.3f} rad",
            markup=False,
        )
    if len(found) < settings.paths:
        console.print(f"only {len(found)} of {settings.paths} paths: more candidates (-K) give more", style="yellow")
    if options.report is not None:
        values = make_report(sketch.clip, material, settings, found)
        values |= {"sketch": options.sketch, "out": [str(one) for one in targets[: len(found)]]}
        values |= {
            "passed_over": list(recorded.skipped),
            "rates": {one.step: one.clip.sample_rate for one in recorded.clips},
        }
        values |= {"seconds": {"reading": round(read - began, 3), "texturing": round(made - read, 3)}}
        write_atomically((json.dumps(values, ensure_ascii=False, indent=1) + "\n").encode(), options.report, "--report")


def _say_what_is_told(console: Console, material: TextureCorpus, settings: TextureSettings) -> None:
    """Say which recordings are copies, and how well each group of joints is told at recordings left out."""
    regression = material.regression(settings)
    for dance in range(regression.dances.count):
        names = [material.clips[n].name for n in np.flatnonzero(regression.dances.number == dance)]
        if len(names) > 1:
            console.print(f"one choreography, left out together: {', '.join(names)}", style="dim", markup=False)
    if regression.dances.count == 1:
        console.print(
            "there is only one choreography: its parts were left out, so other dances are told worse", style="yellow"
        )
    for name, share in regression.told_shares().items():
        drivers = sorted({part.choices[0].drivers.name for part in regression.groups if part.name == name})
        words = f"{share:.0%} of the movement is told, best by {' or '.join(drivers)}"
        if share <= 0.0:
            words = "legs and hips do not tell it, so it keeps the mean pose"
        console.print(f"{name}: {words}", markup=False)


def _numbered(out: Path, number: int) -> Path:
    return out.with_name(f"{out.stem}-{number}{out.suffix}")


def _read_sketch(asked: TextureOptions) -> _Sketch:
    path = Path(asked.sketch)
    if is_readable_name(path):
        try:
            motion = read_motion(path)
            clip = retarget(motion, name=path.stem, fps=asked.sketch_fps)
        except ValueError as error:
            raise PersonError(" ".join(str(error).split())) from None
        return _Sketch(clip, 0.0, clip.sample_count - 1.0)
    if path.suffix.lower() == ".toml":
        steps = sketched_steps({str(path): _text(path)})
    else:
        from live.app.offline.step_listing import find_step, named_steps

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


def enrich_library(
    library: Path | None,
    places: list[Path],
    steps: list[str],
    settings: TextureSettings,
    upper: UpperBodyMode,
    *,
    fps: float | None,
    remove: bool,
) -> None:
    """Write textured versions of every sketched step, or of `steps`, next to it; or remove them."""
    console = Console(highlight=False, soft_wrap=True)
    sketches = _sketches(library, steps)
    if remove:
        _remove(console, sketches)
        return
    if not places:
        raise PersonError("there is no motion capture to take texture from", "--with DIR_OR_FILES")
    recorded = read_material(places, fps=fps)
    for words in recorded.skipped:
        console.print(f"passed over: {words}", style="yellow", markup=False)
    own = {file: sketched_steps({file: text}) for file, text in sketches.items()}
    everything = [step for clips in own.values() for step in clips if not step.mirrored]
    material = build_material([one.clip for one in recorded.clips], everything)
    seconds = sum(clip.seconds for clip in material.clips)
    console.print(f"{len(material.clips)} recordings, {seconds:.0f} s", markup=False)
    if settings.learnt and upper != "texture":
        _say_what_is_told(console, material, settings)
    facts = {"with": [str(place) for place in places], "bands": list(settings.bands), "match_band": settings.match_band}
    for file, clips in own.items():
        try:
            made = enrich(clips, material, settings, upper)
        except PersonError as error:
            raise PersonError(f"{file}: {error.message}", error.remedy) from None
        mirror = any(step.mirrored for step in clips)
        text = textured_text(made.clips, sketches[file], facts | {"mirror": mirror})
        size = write_atomically(text.encode(), textured_path(Path(file)), "--library")
        _say(console, clips, made, size)
    console.print("see one: live steps show STEP; remove them: live steps enrich --remove", style="dim")


def _sketches(library: Path | None, wanted: list[str]) -> dict[str, str]:
    """Return sketch texts by file name, of all folders or of the named steps."""
    found: dict[str, str] = {}
    for folder in library_folders(library):
        found |= read_step_files(folder).sketches
    if not found:
        raise PersonError("there is no sketched step to texture", "sketches are TOML files: `live docs steps`")
    if not wanted:
        return found
    names = {plain_name(sketched_steps({file: text})[0].step): file for file, text in found.items()}
    unknown = [one for one in wanted if plain_name(one) not in names]
    if unknown:
        raise PersonError(f"--step {unknown[0][:60]!r}: there is no sketch of that name", ", ".join(sorted(names)[:20]))
    return {names[plain_name(one)]: found[names[plain_name(one)]] for one in wanted}


def _remove(console: Console, sketches: dict[str, str]) -> None:
    gone = 0
    for file in sketches:
        path = textured_path(Path(file))
        if path.is_file():
            try:
                path.unlink()
            except OSError as error:
                raise PersonError(f"{path}: cannot be removed: {error.strerror}", "remove it by hand") from None
            gone += 1
    console.print(f"{gone} files of textured steps removed", markup=False)


def _say(console: Console, clips: list[StepClip], made: EnrichedStep, size: int) -> None:
    how = "made" if made.replaced_upper else "textured"
    console.print(
        f"{clips[0].step}: {len(made.clips)} versions, upper body {how}, matched to {made.distance:.3f} rad, "
        f"{made.continuous_share:.0%} of joins as recorded, {made.kept_share:.0%} of it left at "
        f"measure lines, {size // 1000} kB",
        markup=False,
    )
