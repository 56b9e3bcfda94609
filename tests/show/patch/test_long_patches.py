"""Long patches are validated, written and freed in batches, with the same results as in one piece."""

import json
import tomllib
import weakref

import pytest
from pydantic import ValidationError

from live.show.patch.patch import Patch
from live.show.patch.table_batches import BATCH_SIZE, free_patches, patch_json, validate_model
from live.show.patch.toml_model import TomlSources, parse_text
from tests.show.made_show import PATCH

ENTRY = '[[element]]\nkind = "wander"\nmeasure = {}\nmeasures = 1\n'
LONG = PATCH + "".join(ENTRY.format(n) for n in range(1, 3 * BATCH_SIZE)) + "[motion]\nhead = 0.5\n"


def test_batched_validation_returns_the_same_patch_and_json():
    data = tomllib.loads(LONG)
    patch = validate_model(Patch, data)
    assert patch == Patch.model_validate(data)
    text = patch_json(patch)
    assert json.loads(text) == patch.to_json_values()
    again = validate_model(Patch, json.loads(text))
    assert again == patch
    assert patch_json(again) == text
    assert again.motion.model_fields_set == {"head"}


def test_batched_validation_reports_the_same_errors():
    data = tomllib.loads(LONG + ENTRY.format(0) + "[stage]\nwidth = 0\n")
    found = []
    for read in (lambda: validate_model(Patch, data), lambda: Patch.model_validate(data)):
        with pytest.raises(ValidationError) as error:
            read()
        found.append(error.value.errors(include_url=False))
    assert found[0] == found[1]
    assert {problem["loc"] for problem in found[0]} == {("element", 299, "measure"), ("stage", "width")}


def test_patch_is_freed_in_batches():
    patch = validate_model(Patch, TomlSources([parse_text(LONG, "x", "patch")]).data)
    first, last = weakref.ref(patch), patch.element[-1].measure
    spent = [patch]
    del patch
    free_patches(spent)
    assert spent == []
    assert first() is None
    assert last == 3 * BATCH_SIZE - 1
