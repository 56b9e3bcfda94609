"""What is measured of a library's steps is measured once in a process of tests: half of what a show takes to load.

Only `build_graph` remembers, and only for the same library to the bit; whoever gets an answer gets a copy of it.
"""

import contextlib
import copy
import hashlib
import pickle
from collections.abc import Iterator
from unittest import mock

from live.graph import motion_graph
from live.graph.node_features import NodeFacts, node_facts
from live.graph.step_library import StepLibrary

_known: dict[bytes, NodeFacts] = {}


def remembered(library: StepLibrary, window: float) -> NodeFacts:
    """As `node_facts`, but not twice for the same."""
    key = hashlib.sha256(pickle.dumps((library, window))).digest()
    if key not in _known:
        _known[key] = node_facts(library, window)
    return copy.deepcopy(_known[key])


@contextlib.contextmanager
def facts_remembered() -> Iterator[None]:
    """While this lasts."""
    with mock.patch.object(motion_graph, "node_facts", remembered):
        yield
