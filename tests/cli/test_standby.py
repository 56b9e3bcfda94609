"""A machine that stands by and lacks what the leader dances says so."""

import json
from pathlib import Path

import pytest

from live.alive.following import Following
from live.base.errors import PersonError
from live.cli.standby import follow
from live.show.load import LoadedShow
from live.show.patch_file import parse_patch
from tests.show.made_show import GRAPH, PATCH


def test_other_steps_than_the_leader_s_are_named_and_end_it_as_a_person_s_error():
    loaded = LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH)
    header = {"journal": 2, "origin": 0.0, **loaded.header(loaded.start(seed=1), tempo=None)}
    following = Following(loaded)
    following.take(json.dumps(header | {"steps_hash": "0" * 16}))
    following.take(json.dumps({"tick": 3}))
    with pytest.raises(PersonError, match="cannot be danced here") as raised:
        follow(following)
    assert "same steps" in str(raised.value.remedy)
