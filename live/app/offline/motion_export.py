"""Motion for `live export`: a file on the engine's skeleton or a variation of a step, and its BVH or glTF file."""

import difflib
from pathlib import Path
from typing import Final

from rich.console import Console

from live.app.offline.step_listing import library_folders, named_steps
from live.base.errors import PersonError
from live.library.motion_file import read_motion
from live.library.motion_formats import encode_motion
from live.library.whole_file import write_atomically
from live.motion.clip import Clip, resample
from live.motion.formats.source_motion import UpAxis
from live.motion.retarget.retarget import retarget
from live.motion.step_clip import StepClip

KNOWN_STEPS_SHOWN: Final = 12


def load_file(
    path: Path,
    hertz: float | None,
    fps: float | None,
    unit: float | None,
    up: str | None,
    skeleton: Path | None,
    drop_frames: int | None,
) -> Clip:
    """Return the file's motion on the engine's skeleton; print warnings on stderr."""
    axis: UpAxis | None = None if up is None else "Y" if up.upper() == "Y" else "Z"
    try:
        motion = read_motion(path, skeleton=skeleton, up=axis)
        clip = retarget(
            motion,
            name=path.stem.encode("utf-8", "replace").decode("utf-8"),
            fps=fps,
            unit_m=unit,
            up=axis,
            drop_frames=drop_frames or 0,
            sample_rate=hertz or fps or motion.header_fps,
        )
    except ValueError as error:  # MotionFileError, or an argument out of range
        raise PersonError(" ".join(str(error).split())) from None
    console = Console(stderr=True, highlight=False)
    for warning in motion.warnings:
        console.print(f"warning: {path}: {warning.what}", soft_wrap=True, markup=False)
    return clip


def load_step(
    name: str, hertz: float | None, library: Path | None, variation: int | None, measures: int | None
) -> Clip:
    """Return the measures of one variation of a step, without the lead-in."""
    found = _variations(name, library)
    if variation is not None and not 1 <= variation <= len(found):
        raise PersonError(f"--variation {variation}: the step {name!r} has {len(found)}: {_describe_variations(found)}")
    step = found[(variation or 1) - 1]
    if measures is not None and not 1 <= measures <= step.measures:
        raise PersonError(f"--measures {measures}: the step {name!r} has {step.measures}")
    last = step.first + (measures or step.measures) * step.samples_per_measure
    return resample(step.clip, hertz or step.clip.sample_rate, first=step.first, last=last)


def _variations(name: str, library: Path | None) -> list[StepClip]:
    clips = [clip for step in named_steps(library) for clip in step.clips]
    found = [clip for clip in clips if clip.step.casefold() == name.strip().casefold()]
    if found:
        return found
    names = sorted({clip.step for clip in clips})
    where = " and ".join(map(str, library_folders(library)))
    near = difflib.get_close_matches(name, names, n=1)
    shown = ", ".join(names[:KNOWN_STEPS_SHOWN]) + (", ..." if len(names) > KNOWN_STEPS_SHOWN else "")
    raise PersonError(
        f"there is no file and no step {name[:100]!r} in {where}; steps there: {shown}",
        f"live export {near[0]!r}" if near else "give a motion file, a step, or --library DIR",
    )


def _describe_variations(clips: list[StepClip]) -> str:
    words = [f"{n} {clip.direction}{' (mirrored)' if clip.mirrored else ''}" for n, clip in enumerate(clips, 1)]
    return ", ".join(words)


def write_motion(clip: Clip, to: Path) -> int:
    """Write the file atomically; return its size in bytes."""
    return write_atomically(encode_motion(clip, to), to, "--to")
