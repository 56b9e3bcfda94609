"""Address patterns against an independent oracle (Python's `re`), and their worst-case cost."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.control.osc.osc_pattern import WILDCARDS, BadPattern, Matcher
from live.control.registry.registry import REGISTRY

ADDRESSES = [control.address for control in REGISTRY]


def pattern_regex(pattern):
    """The regular expression of a well-formed pattern by the rules of OSC 1.0."""
    out, inside = "", False
    position = 0
    while position < len(pattern):
        c = pattern[position]
        if c == "*":
            out += "[^/]*"
        elif c == "?":
            out += "[^/]"
        elif c == "[":
            stop = pattern.index("]", position)
            body = pattern[position + 1 : stop]
            out += "[^/" + body[1:] + "]" if body[0] == "!" else "[" + body + "]"
            position = stop
        elif c == "{":
            out, inside = out + "(?:", True
        elif c == "}":
            out, inside = out + ")", False
        elif c == "," and inside:
            out += "|"
        else:
            out += re.escape(c)
        position += 1
    return re.compile(out)


piece = st.sampled_from(["*", "?", "a", "b", "ab", "[ab]", "[!a]", "[a-c]", "{a,bc}", "{,b}", "{ab,b,c}", "c"])
part = (
    st.lists(piece, min_size=1, max_size=5)
    .map("".join)
    .filter(lambda text: text.count("{") <= 2 and text.count(",") <= 3)
)
word = st.text("abc", min_size=1, max_size=5)


@given(st.lists(part, min_size=1, max_size=3), st.lists(st.lists(word, min_size=1, max_size=3), max_size=8))
def test_matches_equal_those_of_regex_oracle(parts, words):
    addresses = list(dict.fromkeys("/" + "/".join(each) for each in words))
    pattern = "/" + "/".join(parts)
    oracle = pattern_regex(pattern)
    assert set(Matcher(addresses).find(pattern)) == {each for each in addresses if oracle.fullmatch(each)}


def test_patterns_match_control_addresses():
    matcher = Matcher(ADDRESSES)
    assert set(matcher.find("/dance/light/{key,rim}/colour")) == {"/dance/light/key/colour", "/dance/light/rim/colour"}
    assert set(matcher.find("/dance/light/*")) == {a for a in ADDRESSES if re.fullmatch("/dance/light/[^/]+", a)}
    assert matcher.find("/dance/spot/[1-2]") == ("/dance/spot/1", "/dance/spot/2")
    assert matcher.find("/dance/*/{key,rim}/c*r") == matcher.find("/dance/light/{key,rim}/colour")
    assert matcher.find("/nobody/*") == ()
    assert all(map(WILDCARDS.isdisjoint, ADDRESSES))


@pytest.mark.parametrize("pattern", ["/a[b", "/a]b", "/a{b", "/a}b", "/a[]b", "/{a,{b}}", "/" + "{a,b}" * 4, "/*" * 60])
def test_malformed_or_oversized_pattern_is_refused(pattern):
    with pytest.raises(BadPattern):
        Matcher(ADDRESSES).find(pattern)


def test_many_stars_take_few_more_steps():
    """Twenty stars cost python-osc 1.45 s on as many addresses; here every character of an address is one step."""
    import sys

    def steps(pattern):
        matcher, count = Matcher(ADDRESSES), 0

        def counting(frame, event, _):
            nonlocal count
            count += event == "line"
            return counting

        sys.settrace(counting)
        try:
            matcher.find(pattern)
        finally:
            sys.settrace(None)
        return count

    few, many = steps("/*/*e*/*e*"), steps("/*/" + "*e" * 18 + "*/" + "*e" * 18 + "*x")
    assert many < 3 * few + 2000
    assert Matcher(["/" + "a" * 40]).find("/" + "*a" * 20 + "*b") == ()
