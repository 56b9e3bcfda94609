"""Library hash: by which steps are known again: a replay and a snapshot need the same."""

import hashlib

import numpy as np

from live.graph.motion_graph import MotionGraph
from live.graph.step_library import StepLibrary


def library_hash(library: StepLibrary) -> str:
    """A short hash over every bit of the library's motion and of what decides its edges: a replay needs the same."""
    digest = hashlib.blake2b(digest_size=8)
    for array in (
        library.clip_root, library.clip_rotation, library.clip_contact, library.node_first, library.node_last
    ):  # fmt: skip
        digest.update(np.ascontiguousarray(array).tobytes())
    for clip in library.clips:
        facts = (clip.step, clip.mirrored, clip.leading_foot, clip.begin_pose, clip.end_pose, clip.weight_transfer)
        digest.update(repr(facts).encode())
    return digest.hexdigest()


def steps_hash(graph: MotionGraph) -> str:
    """The same of a graph's library, that some of its clips are not begun any more included."""
    found = library_hash(graph.library)
    if not graph.leaving.any():
        return found
    return hashlib.blake2b(found.encode() + graph.leaving.tobytes(), digest_size=8).hexdigest()
