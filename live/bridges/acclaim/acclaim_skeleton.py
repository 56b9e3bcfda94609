"""Reader for Acclaim skeleton files (.asf): :units, :root, :bonedata and :hierarchy, as the CMU library writes them."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int32
from live.motion.formats.file_error import MotionFileError, count_line_ends, quoted, read_number
from live.motion.quaternion import euler_to_quaternion

METRES_PER_INCH: Final = 0.0254


@dataclass(frozen=True, slots=True, eq=False)
class AcclaimSkeleton:
    """The bones of an ASF file as J joints: the root and the start of each bone, parents first. Lengths in file units.

    In the rest pose the joint axes are the world axes, so `offsets` are those of a BVH file. A bone's motion is written
    in its own axes, rotated by `axes` C: its rotation relative to its parent is C M C⁻¹ (CMU: L = C⁻¹ M C B in rows).
    """

    names: tuple[str, ...]
    parents: Int32
    """Parent of each joint, -1 for the root, shape (J,)."""
    offsets: Float64
    """Offset of each joint from its parent (the parent's bone); of the root its `position`, shape (J, 3)."""
    end_parents: Int32
    """Joints whose bones have no children, shape (E,)."""
    end_offsets: Float64
    """Vectors of those bones, shape (E, 3)."""
    axes: Float64
    """C of each joint, unit quaternions, shape (J, 4)."""
    channels: tuple[str, ...]
    """Per joint one letter for each number of its AMC line: x y z = translation, X Y Z = rotation about that axis."""
    length: float
    """`length` of :units; CMU's 0.45 is 0.45 units per inch."""

    @property
    def unit_m(self) -> float:
        """Metres per unit, with `length` as the CMU uses it: units per inch."""
        return METRES_PER_INCH / self.length


LINE_LIMIT: Final = 100_000
"""Maximum characters per line."""
_BLANK_OR_COMMENT: Final = re.compile(rb"(?>\s++|#[^\r\n]*+)*+")
"""Whitespace and comments; possessive quantifiers avoid backtracking."""
_END: Final = re.compile(rb"[\r\n]")


def iterate_lines(data: bytes, file: str) -> Iterator[tuple[int, list[str]]]:
    """Yield number (from 1) and words of each non-empty line; text after a # is ignored.

    Raises MotionFileError for lines of over 100,000 characters.
    """
    place, number = 0, 1
    while True:
        nothing = _BLANK_OR_COMMENT.match(data, place)
        start = nothing.end() if nothing else place
        number += count_line_ends(data, place, start)
        place = start
        if place == len(data):
            return
        following = _END.search(data, place)
        end = following.start() if following else len(data)
        if end - place > LINE_LIMIT:
            raise MotionFileError(file, number, f"a line of {end - place} letters", "an ASF or AMC file expected")
        words = data[place:end].decode("utf-8", errors="replace").split("#", 1)[0].split()
        if words:
            yield number, words
        place = end


Vector = tuple[float, float, float]

MAX_BYTES: Final = 4_000_000
BONE_LIMIT: Final = 1000
_CHANNELS: Final = {**{f"t{a}": a for a in "xyz"}, **{f"r{a}": a.upper() for a in "xyz"}}


@dataclass(slots=True)
class _Bone:
    """A bone between its `begin` and `end`; the root has length 0."""

    name: str
    line: int
    direction: Vector = (0.0, 0.0, 0.0)
    length: float = 0.0
    axis: Vector = (0.0, 0.0, 0.0)
    axis_order: str = "xyz"
    channels: str = ""


def parse_asf(data: bytes, file: str) -> AcclaimSkeleton:
    """Parse an ASF file; `file` is its name for messages.

    Raises MotionFileError with the line and the expected content. Sections and bone entries without effect on the
    motion (:documentation, :skin, limits, masses) are ignored.
    """
    if len(data) > MAX_BYTES:
        raise MotionFileError(file, None, f"more than {MAX_BYTES} bytes", "the skeleton of one performer expected")
    return _AsfReader(file).read(data)


class _AsfReader:
    def __init__(self, file: str) -> None:
        self._file, self._line = file, 1
        self._length, self._radians_per_unit = 1.0, math.pi / 180.0
        self._root = _Bone("root", 1)
        self._position: Vector = (0.0, 0.0, 0.0)
        self._bone: _Bone | None = None
        self._bones: dict[str, _Bone] = {}
        self._children: dict[str, list[str]] = {}
        self._attached: set[str] = set()

    def read(self, data: bytes) -> AcclaimSkeleton:
        readers = {
            ":units": self._read_units,
            ":root": self._read_root,
            ":bonedata": self._read_bone,
            ":hierarchy": self._read_hierarchy,
        }
        read, found = None, set()
        for line, words in iterate_lines(data, self._file):
            self._line = line
            if words[0].startswith(":"):
                section = words[0].lower()
                if section in found:
                    raise self._error(f"a second {section}", "each section once expected")
                if self._bone is not None:
                    raise self._error(f"{section} was read within bone {quoted(self._bone.name)}", "'end' expected")
                found.add(section)
                read = readers.get(section)
            elif not found:
                raise self._error(f"{quoted(words[0])} was read", "an ASF file begins with :version")
            elif read is not None:
                read(words)
        for section in (":root", ":bonedata", ":hierarchy"):
            if section not in found:
                raise self._error(f"no {section} up to the end", "a whole Acclaim skeleton expected")
        if self._bone is not None:
            raise self._error(f"the file ends within bone {quoted(self._bone.name)}", "'end' expected")
        return self._build()

    def _read_units(self, words: list[str]) -> None:
        if words[0].lower() == "length":
            (self._length,) = self._numbers(words, 1)
            if not 1e-6 <= self._length <= 1e6:
                raise self._error(f"length {quoted(words[1])}", "a scale over zero expected")
        elif words[0].lower() == "angle":
            if words[1:] not in (["deg"], ["rad"]):
                raise self._error(f"angle {quoted(' '.join(words[1:]))}", "deg or rad expected")
            self._radians_per_unit = math.pi / 180.0 if words[1] == "deg" else 1.0

    def _read_root(self, words: list[str]) -> None:
        key = words[0].lower()
        if key == "order":
            self._root.channels = self._channels(words)
        elif key == "axis":
            self._root.axis_order = self._axis_order(words[1] if len(words) == 2 else "")
        elif key == "position":
            self._position = self._vector(words)
        elif key == "orientation":
            self._root.axis = self._vector(words)

    def _read_bone(self, words: list[str]) -> None:
        key = words[0].lower()
        if self._bone is None:
            if key != "begin":
                raise self._error(f"{quoted(words[0])} was read", "'begin' of a bone expected")
            if len(self._bones) >= BONE_LIMIT:
                raise self._error(f"more than {BONE_LIMIT} bones", f"at most {BONE_LIMIT} expected")
            self._bone = _Bone("", self._line)
            return
        bone = self._bone
        if key == "name":
            bone.name = self._new_name(words)
        elif key == "direction":
            bone.direction = self._vector(words)
        elif key == "length":
            (bone.length,) = self._numbers(words, 1)
        elif key == "axis":
            bone.axis, bone.axis_order = self._vector(words[:4]), self._axis_order(words[4] if len(words) == 5 else "")
        elif key == "dof":
            bone.channels = self._channels(words)
        elif key == "end":
            self._end_bone(bone)
        elif key == "begin":
            raise self._error("'begin' was read within a bone", "'end' expected")

    def _new_name(self, words: list[str]) -> str:
        if len(words) != 2 or len(words[1]) > 200 or words[1] in self._bones or words[1].lower() == "root":
            raise self._error(f"name {quoted(' '.join(words[1:]))}", "one word that names no other bone expected")
        return words[1]

    def _end_bone(self, bone: _Bone) -> None:
        if not bone.name:
            raise self._error(f"the bone begun in line {bone.line} has no name", "'name' expected")
        self._bones[bone.name] = bone
        self._bone = None

    def _read_hierarchy(self, words: list[str]) -> None:
        if len(words) == 1:
            if words[0].lower() not in ("begin", "end"):
                raise self._error(f"{quoted(words[0])} stands alone", "a bone and its children expected")
            return
        parent = self._resolve_bone(words[0])
        for name in words[1:]:
            child = self._resolve_bone(name)
            if child == "root" or child in self._attached:
                raise self._error(f"{quoted(name)} has two parents", "one parent for each bone expected")
            self._attached.add(child)
            self._children.setdefault(parent, []).append(child)

    def _build(self) -> AcclaimSkeleton:
        """Build the joints from the root down; a bone that is not connected to the root is an error."""
        bones: list[_Bone] = []
        parents: list[int] = []
        ends: list[int] = []
        stack = [("root", -1)]
        while stack:
            name, parent = stack.pop()
            children = self._children.get(name, [])
            stack += [(child, len(bones)) for child in reversed(children)]
            if not children:
                ends.append(len(bones))
            bones.append(self._bones.get(name, self._root))
            parents.append(parent)
        if len(bones) <= len(self._bones):
            reached = {bone.name for bone in bones}
            loose = next(name for name in self._bones if name not in reached)
            raise self._error(f"{quoted(loose)} is not connected to the root", "one tree of all bones expected")
        vectors = np.array([np.multiply(bone.direction, bone.length) for bone in bones])
        parent_indices = np.array(parents, np.int32)
        offsets = vectors[np.maximum(parent_indices, 0)]
        offsets[0] = self._position
        return AcclaimSkeleton(
            names=tuple(bone.name for bone in bones),
            parents=parent_indices,
            offsets=offsets,
            end_parents=np.array(ends, np.int32),
            end_offsets=vectors[ends],
            axes=np.array([self._axes(bone) for bone in bones]),
            channels=tuple(bone.channels for bone in bones),
            length=self._length,
        )

    def _axes(self, bone: _Bone) -> list[float]:
        """Return C of a bone: rotations about the world axes in the order of its `axis` entry, first to last."""
        by_letter = dict(zip("xyz", bone.axis, strict=True))
        order = bone.axis_order[::-1]
        angles = np.array([by_letter[letter] * self._radians_per_unit for letter in order])
        turned: list[float] = euler_to_quaternion(angles, order.upper()).tolist()
        return turned

    def _resolve_bone(self, name: str) -> str:
        if name.lower() == "root":
            return "root"
        if name not in self._bones:
            raise self._error(f"{quoted(name)} is no bone", "names from :bonedata expected")
        return name

    def _channels(self, words: list[str]) -> str:
        letters = "".join(_CHANNELS.get(word.lower(), "?") for word in words[1:])
        if "?" in letters or len(set(letters)) < len(letters):
            allowed = "tx ty tz rx ry rz, each once at most,"
            raise self._error(f"{words[0]} {quoted(' '.join(words[1:]))}", f"{allowed} expected")
        return letters

    def _axis_order(self, word: str) -> str:
        if sorted(word.lower()) != ["x", "y", "z"]:
            raise self._error(f"axis order {quoted(word)}", "X, Y and Z in some order expected, as in XYZ")
        return word.lower()

    def _vector(self, words: list[str]) -> Vector:
        x, y, z = self._numbers(words, 3)
        return x, y, z

    def _numbers(self, words: list[str], count: int) -> list[float]:
        if len(words) != count + 1:
            raise self._error(f"{len(words) - 1} numbers after {quoted(words[0])}", f"{count} expected")
        return [read_number(word, self._file, self._line, words[0]) for word in words[1:]]

    def _error(self, problem: str, expected: str) -> MotionFileError:
        return MotionFileError(self._file, self._line, problem, expected)
