"""Files of gestures: examples that a patch names, and NAME.gestures.toml, to which learned ones are written.

The patch gets the poses themselves, so that its journal has all that a replay needs.
"""

import math
from collections.abc import Generator, Iterable, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import tomlkit
from tomlkit.exceptions import TOMLKitError

from live.base.arrays import Float32, Float64
from live.base.errors import PersonError
from live.motion.capture.packed_pose import pack_pose, unpack_pose
from live.motion.clip import Clip
from live.motion.recognition.body_stream import BodyStream
from live.motion.recognition.gesture_examples import (
    EXAMPLE_RATE,
    MOMENTS_PER_EXAMPLE_MOMENT,
    at_once,
)
from live.motion.recognition.gesture_kernels import FEATURES
from live.motion.recognition.recognition_names import MAX_MOMENTS, MIN_MOMENTS
from live.show.patch.patch_search_path import PatchError, find_resource, gestures_path, is_file
from live.show.patch.toml_model import read_text

HEAD: Final = "# Gestures learned while the show ran (/dance/gesture/learn); a part of {patch}.\n"
GUARD_S: Final = 0.5
"""Motion [s] on both sides of an example that is not its background."""
POSES_PER_PIECE: Final = 6
"""Poses of which features are found in a piece of work: about 0.1 ms."""


def add_gesture_poses(data: dict[str, Any], path: Path) -> None:
    """Insert the poses of the files that `[[gesture]]` tables of a patch name; what is no text is reported later.

    PatchError, with the keys of its place, for a file that is missing, damaged or too long.
    """
    tables = data.get("gesture")
    for index, table in enumerate(tables if isinstance(tables, list) else ()):
        if not isinstance(table, dict) or not isinstance(table.get("example"), str) or "poses" in table:
            continue
        try:
            table["poses"], table["background"] = _read_example(table["example"], table.get("span_s"), path)
        except PersonError as error:
            raise PatchError(error.message, error.remedy, ("gesture", index, "example")) from None


def _read_example(name: str, span: object, path: Path) -> tuple[list[str], list[str]]:
    found = find_resource(name, path)
    if found is None or not is_file(found):
        raise PersonError(f"there is no file {name[:200]!r}", "put a motion file, such as BVH, in the patch's folder")
    from live.library.motion_file import read_motion  # few patches need it
    from live.motion.retarget.retarget import retarget

    try:
        clip = retarget(read_motion(found), name=name, sample_rate=EXAMPLE_RATE)
    except ValueError as error:
        raise PersonError(f"{found}: {error}") from None
    begin, end = 0, clip.sample_count
    if isinstance(span, list) and len(span) == 2 and all(isinstance(each, int | float) for each in span):
        begin, end = (round(min(max(float(each), 0.0), 36000.0) * EXAMPLE_RATE) for each in span)
        if end > clip.sample_count + 1:
            raise PersonError(f"{found}: span_s ends at {span[1]:g} s, the file at {clip.seconds:.2f} s")
    end = min(end, clip.sample_count)
    if not MIN_MOMENTS <= end - begin <= MAX_MOMENTS:
        shortest, longest = MIN_MOMENTS / EXAMPLE_RATE, MAX_MOMENTS / EXAMPLE_RATE
        seconds = (end - begin) / EXAMPLE_RATE
        words = f"{found}: {seconds:.2f} s; an example has {shortest:.2g} to {longest:g} s"
        raise PersonError(words, "span_s = [begin, end] of the gesture")
    guard = round(GUARD_S * EXAMPLE_RATE)
    before = range(max(0, begin - guard - MAX_MOMENTS // 2), max(0, begin - guard))
    room = MAX_MOMENTS - len(before)
    after = range(min(end + guard, clip.sample_count), min(end + guard + room, clip.sample_count))
    longest_part = before if len(before) > len(after) else after
    back = longest_part if len(longest_part) > end - begin else range(0)
    return _packed(clip, range(begin, end)), _packed(clip, back)


def _packed(clip: Clip, rows: range) -> list[str]:
    return [pack_pose(clip.root_position[row], clip.rotation[row]) for row in rows]


def pose_features(poses: Sequence[str]) -> Float64:
    """Return the features of packed poses, (M, FEATURES), M of them at `EXAMPLE_RATE`; ValueError for a damaged one."""
    return at_once(feature_work(poses))


def feature_work(poses: Sequence[str]) -> Generator[None, None, Float64]:
    """Find the features of packed poses as `pose_features` does, in pieces of `POSES_PER_PIECE`."""
    stream, rows = BodyStream(), list[Float64]()
    for number, pose in enumerate(poses):
        _add_features(rows, stream, unpack_pose(pose), number)
        if (number + 1) % POSES_PER_PIECE == 0:
            yield
    return np.array(rows).reshape(-1, FEATURES)


def features_of(poses: Iterable[tuple[Float32, Float32]]) -> Float64:
    """Return the features of poses, hips (3,) [m] and rotation (J, 4) each, at `EXAMPLE_RATE`, (M, FEATURES)."""
    stream, rows = BodyStream(), list[Float64]()
    for number, pose in enumerate(poses):
        _add_features(rows, stream, pose, number)
    return np.array(rows).reshape(-1, FEATURES)


def _add_features(rows: list[Float64], stream: BodyStream, pose: tuple[Float32, Float32], number: int) -> None:
    for _ in stream.feed(*pose, 1.0 + number / EXAMPLE_RATE):
        if stream.count % MOMENTS_PER_EXAMPLE_MOMENT == 0:
            rows.append(stream.feature.copy())
    if not number:
        rows.append(stream.feature.copy())


def updated_gestures_text(patch: Path, tables: Sequence[dict[str, Any]]) -> str:
    """Return the new text of the file of learned gestures next to `patch`, with these `[[gesture]]` tables added.

    Everything in the file is kept. PersonError if it is no TOML.
    """
    path = gestures_path(patch)
    before = read_text(path, "gestures") if is_file(path) else ""
    try:
        document = tomlkit.parse(before or HEAD.format(patch=patch.name))
        if "gesture" not in document:
            document["gesture"] = tomlkit.aot()
        rows: Any = document["gesture"]
        for table in tables:
            row = tomlkit.table()
            for key, value in table.items():
                row[key] = _array(value) if isinstance(value, list) else value
            rows.append(row)
    except (TOMLKitError, AttributeError) as error:
        raise PersonError(f"{path}: {error}", "repair it, and learn the gesture again") from None
    return tomlkit.dumps(document)


def _array(values: list[str]) -> Any:
    rows = tomlkit.array()
    rows.extend(values)
    return rows.multiline(True)


def beats_to_moments(beats: float, tempo: float) -> int:
    """Return how many moments of an example `beats` last at `tempo` [bpm], within its bounds."""
    return min(max(math.ceil(beats * 60.0 / tempo * EXAMPLE_RATE), MIN_MOMENTS), MAX_MOMENTS)
