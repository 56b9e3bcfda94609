"""The linked timeline: exactly one segment for every dancer at every beat (T089, Fig 4.3)."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from live.agents.evolutions.timeline import AUXILIARY, Span, link_timeline

DANCERS, LENGTH = 5, 20
SPANS = st.lists(
    st.tuples(st.integers(0, 22), st.integers(1, 12), st.integers(0, 31)).map(
        lambda t: Span(float(t[0]), float(t[0] + t[1]), np.array([t[2] >> n & 1 for n in range(DANCERS)], bool))
    ),
    max_size=7,
)


def expected_source(spans, dancer, beat):
    """The span of a dancer by an independent rule: the latest to begin, unless it has ended."""
    own = [(s.begin, i) for i, s in enumerate(spans) if s.dancers[dancer] and s.begin <= beat]
    if not own:
        return AUXILIARY
    index = max(own)[1]
    return index if beat < spans[index].end else AUXILIARY


@given(SPANS)
def test_every_dancer_has_exactly_one_segment_per_beat(spans):
    links = link_timeline(spans, DANCERS, LENGTH)
    for dancer in range(DANCERS):
        for beat in np.arange(0.5, LENGTH):
            there = [link for link in links if link.dancers[dancer] and link.begin <= beat < link.end]
            assert [link.source for link in there] == [expected_source(spans, dancer, beat)]


@given(SPANS)
def test_links_form_one_continuous_sequence(spans):
    """The links of each dancer run from beat 0 to the end; groups change only at junctions."""
    links = link_timeline(spans, DANCERS, LENGTH)
    for index, link in enumerate(links):
        assert all(index in links[other].after for other in link.before)
        assert all(index in links[other].before for other in link.after)
        assert all(links[other].end == link.begin for other in link.before)
        if link.begin == link.end:
            assert link.source == AUXILIARY
            assert len(link.before) > 1 or len(link.after) > 1
            for side in (link.before, link.after):
                assert (np.sum([links[other].dancers for other in side], axis=0) == link.dancers).all()
        else:
            assert len(link.before) == (link.begin > 0)
            assert len(link.after) == (link.end < LENGTH)
            for other in (*link.before, *link.after):
                assert links[other].begin == links[other].end or (links[other].dancers == link.dancers).all()


def test_divided_groups_reunite_at_junctions():
    everybody = np.ones(4, bool)
    left = np.array([1, 1, 0, 0], bool)
    links = link_timeline([Span(0, 4, everybody), Span(4, 8, left), Span(6, 8, ~left), Span(8, 12, everybody)], 4, 12)
    assert [(x.begin, x.end, x.source, int(x.dancers.sum())) for x in links] == [
        (0, 4, 0, 4), (4, 4, AUXILIARY, 4), (4, 6, AUXILIARY, 2), (4, 8, 1, 2), (6, 8, 2, 2), (8, 8, AUXILIARY, 4),
        (8, 12, 3, 4),
    ]  # fmt: skip
