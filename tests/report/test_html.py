"""Elements escape what they are given."""

import json

import html5lib
from hypothesis import given
from hypothesis import strategies as st

from pipeline.report.html import Html, join, script_data, tag


def parsed(fragment: str):
    parser = html5lib.HTMLParser(strict=True, namespaceHTMLElements=False)
    return parser.parse("<!DOCTYPE html><title>t</title>" + fragment)


@given(st.text())
def test_any_text_stays_text(text):
    body = parsed(tag("p", text, title=text)).find("body")
    assert [e.tag for e in body.iter()] == ["body", "p"]
    if text.isprintable():
        assert "".join(body.itertext()) == text
        assert body[0].get("title") == text


@given(st.text())
def test_json_cannot_leave_its_script(text):
    data = script_data({text: text})
    assert json.loads(data) == {text: text}
    assert "<" not in data
    assert ">" not in data


def test_markup_goes_through_and_text_does_not():
    assert tag("p", Html("<b>x</b>"), "<b>", None, ["a", "b"]) == "<p><b>x</b>&lt;b&gt;ab</p>"
    assert join("&", None) == "&amp;"


def test_attributes():
    assert tag("a", class_="x", aria_label='"', hidden=True, title=None, open=False) == (
        '<a class="x" aria-label="&quot;" hidden></a>'
    )
    assert tag("br") == "<br>"
