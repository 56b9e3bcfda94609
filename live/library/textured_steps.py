"""Textured versions of sketched steps, made from motion capture (P022).

They are stored next to their sketches, `walk.textured` next to `walk.toml`, as lossless clips, because the motion
capture may not be available later, with a digest of the sketch. After a change of the sketch they are ignored until
they are made again.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from live.base.errors import PersonError
from live.library.clip_text import clips_from_text, clips_to_text
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_step
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip
from live.motion.texture.foot_constraints import blend_to_sketch
from live.motion.texture.frequency_bands import sample_clip
from live.motion.texture.texture_corpus import TextureCorpus, make_corpus
from live.motion.texture.texture_settings import UPPER, TextureSettings
from live.motion.texture.texture_synthesis import texture_sketch

UpperBodyMode = Literal["auto", "make", "texture"]
"""Treatment of upper bodies: `make` from the recordings alone, `texture`, or `auto` by the sketch."""
HAND_RAISE_M: Final = 0.45
"""The arms of a sketch matter if a hand rises this far above the hips (to the shoulders) ..."""
TRUNK_LEAN: Final = np.radians(15.0)
"""... and its trunk if the ribs lean this far to and fro: recordings then add only the finest detail."""
TEXTURED_STYLE: Final = "textured"
"""The style of textured versions, followed by their number."""

_HANDS: Final = (SKELETON.index("leftHand"), SKELETON.index("rightHand"))


@dataclass(frozen=True, slots=True, eq=False)
class EnrichedStep:
    """The textured versions of one step."""

    clips: tuple[StepClip, ...]
    distance: float
    """Mean over all versions of the root mean square error of matches [rad]."""
    continuous_share: float
    """Mean share of joins that are continuous in the data."""
    replaced_upper: bool
    """Whether upper bodies were made from the recordings alone; else textured."""
    kept_share: float
    """Mean share of the texture that is left at measure lines."""


def build_material(recordings: Sequence[Clip], steps: Sequence[StepClip]) -> TextureCorpus:
    """Return the recordings, divided so that all of these steps can be textured."""
    return make_corpus(recordings, [sample_clip(step.clip) for step in steps])


def upper_body_matters(step: StepClip) -> bool:
    """Whether the sketch's upper body is essential to the step, so that it must not be replaced."""
    part = slice(int(step.first), int(np.ceil(step.first + step.measures * step.samples_per_measure)))
    rotation = step.clip.rotation[part].astype(np.float64)
    rotation[:, 0] = (1.0, 0.0, 0.0, 0.0)
    position, world = forward_kinematics(np.zeros((len(rotation), 3)), rotation)
    up = quaternion.rotate(world[:, SKELETON.index("upperChest")], np.array((0.0, 1.0, 0.0)))
    bent = np.arccos(np.clip(up @ quaternion.unit(up.mean(axis=0)), -1.0, 1.0))
    return bool(position[:, _HANDS, 1].max() > HAND_RAISE_M or bent.max() > TRUNK_LEAN)


def enrich(
    steps: Sequence[StepClip], material: TextureCorpus, settings: TextureSettings, upper: UpperBodyMode = "auto"
) -> EnrichedStep:
    """Return textured versions of the variations `steps` of one step, path by path; mirrored ones are skipped.

    Textured versions have the attributes of their variation: they are takes of the same step. PersonError if nothing
    in the recordings fits.
    """
    clips: list[StepClip] = []
    distances: list[float] = []
    free: list[float] = []
    kept: list[float] = []
    made = upper == "make" or (upper == "auto" and not upper_body_matters(steps[0]))
    if not made:
        # essential arm motion is faster than that of legs: only the first band preserves it
        settings = replace(
            settings, synthesize=(), texture=tuple(sorted({*settings.texture, *UPPER})), bands=(settings.bands[0],) * 2
        )
    for step in steps:
        if step.mirrored:
            continue
        for number, one in enumerate(texture_sketch(step.clip, material, settings), start=1):
            clip, left = blend_to_sketch(step, one.clip)
            name = f"{step.clip.name}, {TEXTURED_STYLE} {number}"
            style = " ".join(word for word in (step.style, TEXTURED_STYLE, str(number)) if word)
            clips.append(replace(step, clip=replace(clip, name=name), style=style))
            distances.append(one.distance)
            free.append(one.consecutive_joins / max(1, one.fragments.count - 1))
            kept += left
    if not clips:
        raise PersonError("no variation of the step can be textured", "give other recordings")
    return EnrichedStep(tuple(clips), _mean(distances), _mean(free), made, _mean(kept))


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


TEXTURED_SUFFIX: Final = ".textured"
MAX_BYTES: Final = 100_000_000


def textured_path(sketch: Path) -> Path:
    """Return the file of the textured versions of the sketch in this file."""
    return sketch.with_suffix(TEXTURED_SUFFIX)


def textured_text(clips: Sequence[StepClip], sketch: str, facts: Mapping[str, Any]) -> str:
    """Return the text of such a file: a line of JSON with `facts` for people, and a line with the clips.

    `clips` are the versions without mirror images; reading adds those for mirrored steps.
    """
    header = {"sketch": _digest(sketch), "clips": [clip.clip.name for clip in clips], **facts}
    return json.dumps(header, ensure_ascii=False) + "\n" + clips_to_text(clips) + "\n"


def read_textured(sketches: Mapping[str, str]) -> list[StepClip]:
    """Read the textured versions of `sketches`, texts by file name, without those of changed sketches.

    PersonError names a file that cannot be read, and the remedy.
    """
    found: list[StepClip] = []
    for name, text in sketches.items():
        path = textured_path(Path(name))
        if path.is_file():
            header, clips = _read(path)
            if header.get("sketch") == _digest(text):
                found += clips
                if header.get("mirror") is True:
                    found += [mirror_step(clip) for clip in clips]
    return found


def stale_textures(sketches: Mapping[str, str]) -> list[Path]:
    """Return the files of textured versions with a sketch that was changed since."""
    paths = [(textured_path(Path(name)), text) for name, text in sketches.items()]
    return [path for path, text in paths if path.is_file() and _read(path)[0].get("sketch") != _digest(text)]


def _read(path: Path) -> tuple[dict[str, Any], list[StepClip]]:
    remedy = "make it again: live steps enrich --with DIR; or remove it"
    try:
        if path.stat().st_size > MAX_BYTES:
            raise PersonError(f"{path}: more than {MAX_BYTES} bytes", remedy)
        first, _, rest = path.read_bytes().decode("ascii", "surrogateescape").partition("\n")
        header = json.loads(first.encode("ascii", "surrogateescape"))
        if not isinstance(header, dict):
            raise ValueError("no header")
        return header, clips_from_text(rest.strip())
    except OSError as error:
        raise PersonError(f"{path}: cannot be read: {error.strerror}", remedy) from None
    except (ValueError, RecursionError):
        raise PersonError(f"{path}: it holds no textured steps", remedy) from None


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
