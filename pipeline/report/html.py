"""Elements of HTML that escape by construction: only `Html` goes through as markup, every other text is escaped."""

from __future__ import annotations

import json
from html import escape

VOID = frozenset({"meta", "link", "br", "hr", "col"})


class Html(str):
    """Text that is markup already."""


def tag(name: str, /, *children: object, **attributes: object) -> Html:
    """One element. A trailing `_` of an attribute goes, other `_` become `-`; None and False leave it out."""
    shown = "".join(_attribute(key, value) for key, value in attributes.items() if value is not None)
    if name in VOID:
        return Html(f"<{name}{shown}>")
    return Html(f"<{name}{shown}>{join(*children)}</{name}>")


def join(*children: object) -> Html:
    """Children one after another: None is left out, lists are flattened, plain text is escaped."""
    return Html("".join(_child(child) for child in children))


def script_data(value: object) -> Html:
    """JSON that may stand inside <script>: nothing in it can end the element or start another."""
    text = json.dumps(value, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return Html(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))


def _child(child: object) -> str:
    if child is None:
        return ""
    if isinstance(child, Html):
        return child
    if isinstance(child, list | tuple) or hasattr(child, "__next__"):
        return join(*child)
    return escape(_printable(str(child)))


def _attribute(key: str, value: object) -> str:
    key = key.rstrip("_").replace("_", "-")
    if value is False:
        return ""
    if value is True:
        return f" {key}"
    return f' {key}="{escape(_printable(str(value)))}"'


def _printable(text: str) -> str:
    """Without characters that HTML does not allow (controls, surrogates, noncharacters)."""
    if text.isprintable():
        return text
    return "".join(c if c in "\n\t" or c.isprintable() or c.isspace() and c >= "\xa0" else "\ufffd" for c in text)
