"""What is new in a document makes the new one of the old one, and is as short as the format says."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hexwar_sb3.server.delta import changed, frozen, new_in, same_json

SCALARS = (
    st.none() | st.booleans() | st.integers(-3, 3) | st.floats(-1, 1) | st.sampled_from(["=", "+", "-", "a"])
)
DOCUMENTS: st.SearchStrategy[Any] = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from("ab=+-"), inner, max_size=4),
    max_leaves=12,
)


@settings(max_examples=300, deadline=None)
@given(old=DOCUMENTS, new=DOCUMENTS)
def test_the_change_makes_the_new_one_of_the_old_one(old: Any, new: Any) -> None:
    before = json.dumps(old)
    again = changed(old, json.loads(json.dumps(new_in(old, new))))

    assert same_json(again, frozen(new))
    assert json.dumps(old) == before


@settings(max_examples=100, deadline=None)
@given(old=st.lists(SCALARS, min_size=1), tail=st.lists(SCALARS))
def test_of_a_list_that_grows_only_the_end_is_told(old: list[Any], tail: list[Any]) -> None:
    assert new_in({"a": old}, {"a": old + tail}) == ({"a": ["+", len(old), tail]} if tail else {})


@pytest.mark.parametrize(
    ("old", "new", "change"),
    [
        ({"a": 1}, {"a": 1}, {}),
        ({"a": 1}, {"a": 2}, {"a": ["=", 2]}),
        ({"a": 1, "b": 2}, {"b": 2}, {"a": ["-"]}),
        ({"a": {"b": [1, 2]}}, {"a": {"b": [1, 3]}}, {"a": {"b": ["+", 1, [3]]}}),
        ({"a": [1, 2, 3]}, {"a": [1]}, {"a": ["+", 1, []]}),
        ({"a": [1]}, {"a": [2]}, {"a": ["=", [2]]}),
        ({"a": 1}, {"a": True}, {"a": ["=", True]}),  # equal in Python, not in JSON
    ],
)
def test_the_shape_of_a_change(old: Any, new: Any, change: Any) -> None:
    assert new_in(old, new) == change
