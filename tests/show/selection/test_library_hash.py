"""Library hash: equal for equal steps, different for any changed bit and for clips that are leaving."""

from dataclasses import replace

import numpy as np

from live.show.selection.graph_update import library_hash, steps_hash
from tests.show.made_show import GRAPH


def test_every_motion_bit_changes_the_library_hash():
    library = GRAPH.library
    assert library_hash(library) == library_hash(replace(library))
    for name in ("clip_root", "clip_rotation", "clip_contact"):
        changed = getattr(library, name).copy()
        changed.view(np.uint8).reshape(-1)[7] ^= 1
        assert library_hash(replace(library, **{name: changed})) != library_hash(library)


def test_leaving_nodes_change_the_steps_hash():
    assert steps_hash(GRAPH) == library_hash(GRAPH.library)
    leaving = np.zeros_like(GRAPH.leaving)
    leaving[0] = True
    left = replace(GRAPH, leaving=leaving)
    assert steps_hash(left) not in (steps_hash(GRAPH), library_hash(left.library))
