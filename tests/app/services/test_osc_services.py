"""What operators' OSC refused is counted."""

from collections import Counter
from types import SimpleNamespace
from typing import Any, cast

from live.app.services.osc_services import rejected_counts


def test_what_osc_refused_is_counted_with_what_was_lost() -> None:
    osc = SimpleNamespace(refused=lambda: {"range": 2}, lost=3)
    assert rejected_counts(cast(Any, osc)) == Counter({"range": 2, "lost before it was read": 3})
