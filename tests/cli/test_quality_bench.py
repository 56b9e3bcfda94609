"""The graph quality benchmark: path rows need no recordings, and rows without data have no values."""

import numpy as np
import pytest

from live.cli.bench import load_bench

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """With paths half as large in half the measures: the whole ones are tested in test_path_search."""
    run = load_bench("graph-quality")
    with pytest.MonkeyPatch.context() as shorter:
        shorter.setitem(run.__globals__, "MEASURES", 16)
        for line in ("SQUARE", "CIRCLE"):
            shorter.setitem(run.__globals__, line, 0.5 * np.array(run.__globals__[line]))
        return run(False, tmp_path_factory.mktemp("nothing"))


def test_paths_with_project_steps_meet_their_bars(rows):
    paths = [row for row in rows if "path error" in row.name]
    assert len(paths) == 4
    assert all(row.ok for row in paths)
    assert all(row.bar == 0.15 for row in paths)


def test_rows_without_recordings_have_no_values(rows):
    rest = [row for row in rows if "path error" not in row.name]
    assert {row.name.split(":")[0] for row in rest} >= {"salsa, leaders", "salsa, followers", "modern dance", "walks"}
    assert all(row.value is None and row.ok is None for row in rest)
