"""Links let in for a while, tokens for as long as the show knows its secret; nothing else does."""

import itertools
import random

from live.control.audience.refused import Bucket
from live.control.audience.tokens import ROTATES, VALID, hue_of, lets_in, link_key, number_of, token_of

SECRET, OTHER = b"a" * 32, b"b" * 32


def test_the_links_key_rotates_and_old_ones_are_valid_for_a_while():
    key = link_key(SECRET, 1000.0)
    assert len(key) == 12  # 72 bits
    assert lets_in(SECRET, key, 1000.0)
    assert link_key(SECRET, 1000.0 + ROTATES) != key
    assert lets_in(SECRET, key, 1000.0 + VALID * ROTATES - ROTATES)
    assert not lets_in(SECRET, key, 1000.0 + (VALID + 1) * ROTATES)
    assert not lets_in(SECRET, link_key(SECRET, 2000.0), 1000.0)
    assert not lets_in(OTHER, key, 1000.0)


def test_tokens_are_known_by_whoever_has_the_secret_and_forged_ones_by_nobody():
    chance = random.Random(7)
    for number in (1, 2, 999, 2**31 - 1):
        token = token_of(SECRET, number)
        assert number_of(SECRET, token) == number
        assert number_of(OTHER, token) == 0
        for _ in range(50):
            at = chance.randrange(len(token))
            forged = token[:at] + chance.choice("0123456789abcXYZ.-_é\0") + token[at + 1 :]
            assert forged == token or number_of(SECRET, forged) in (0, number)
            if number_of(SECRET, forged):  # the same number in other digits is not possible
                assert forged == token
    for rubbish in ("", ".", "1", "1.", ".x", "-1.x", "0." + token_of(SECRET, 1), "9" * 300, "１.x", "1.é"):
        assert number_of(SECRET, rubbish) == 0


def test_those_who_join_one_after_the_other_have_other_colours():
    hues = [hue_of(number) for number in range(1, 200)]
    for a, b in itertools.pairwise(hues):
        assert min((a - b) % 1000, (b - a) % 1000) > 200
    assert len(set(hues)) > 190


def test_a_bucket_lets_through_its_burst_and_then_its_rate():
    bucket = Bucket(10.0, 20.0)
    assert sum(bucket.take(5.0) for _ in range(100)) == 20
    assert sum(bucket.take(5.0 + step / 1000) for step in range(1, 2001)) == 20
    assert not bucket.take(6.0)  # a clock that goes back gives nothing
