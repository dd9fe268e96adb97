"""The verdict is the worst of its items."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.assess.verdict import ORDER, Item, at_least, at_most, holds, verdict, within


@given(st.lists(st.sampled_from(ORDER), min_size=1))
def test_the_worst_item_decides(statuses):
    found = verdict(Item("x", 1.0, 2.0, status) for status in statuses)
    assert found["status"] == max(statuses, key=ORDER.index)
    assert len(found["items"]) == len(statuses)


def test_nothing_checked_is_no_pass():
    assert verdict([]) == {"status": "warn", "items": []}


@pytest.mark.parametrize(
    ("item", "status"),
    [
        (at_most("a", 1.0, 1.0), "pass"),
        (at_most("a", 1.1, 1.0), "fail"),
        (at_most("a", 1.1, 1.0, otherwise="warn"), "warn"),
        (at_most("a", None, 1.0, otherwise="warn"), "fail"),
        (at_most("a", float("nan"), 1.0), "fail"),
        (at_least("a", 30.0, 30.0), "pass"),
        (at_least("a", 29.0, 30.0, otherwise="warn"), "warn"),
        (at_least("a", None, 30.0, otherwise="warn"), "fail"),
        (within("a", 2.0, 1.8, 2.2), "pass"),
        (within("a", 2.3, 1.8, 2.2, otherwise="warn"), "warn"),
        (within("a", float("inf"), 1.8, 2.2), "fail"),
        (holds("a", True), "pass"),
        (holds("a", False, otherwise="warn"), "warn"),
    ],
)
def test_checks(item, status):
    assert item.status == status
    json.dumps(verdict([item]), allow_nan=False)
