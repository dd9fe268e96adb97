"""The top of the page: the verdict with what offends it, the findings, and the errors of stages that failed."""

from __future__ import annotations

from pipeline.report.html import Html, tag
from pipeline.report.run import Run, ok, trusted
from pipeline.report.text import count

WORDS = {"pass": "PASS", "warn": "WARN", "fail": "FAIL"}
ICONS = {
    "pass": "M12 2a10 10 0 1 0 0 20 10 10 0 0 0 0-20zm-1.4 14.4-4.2-4.2 1.5-1.5 2.7 2.7 5.6-5.6 1.5 1.5z",
    "warn": "M12 2.5 1.2 21.5h21.6zm-1.1 6.8h2.2v6h-2.2zm0 7.6h2.2v2.2h-2.2z",
    "fail": "M7.9 2h8.2L22 7.9v8.2L16.1 22H7.9L2 16.1V7.9zm.6 5L7 8.5l3.5 3.5L7 15.5 8.5 17l3.5-3.5 3.5 3.5"
    " 1.5-1.5-3.5-3.5L17 8.5 15.5 7 12 10.5z",
}
COLOURS = {"pass": "#1a7f4b", "warn": "#b36b00", "fail": "#c02b22"}


def status(run: Run) -> str:
    """pass, warn or fail; a record that says something else counts as fail."""
    shown = str(run.record["verdict"].get("status", "")).lower()
    return shown if shown in WORDS else "fail"


def icon(name: str) -> Html:
    """The verdict's sign as inline SVG: "pass", "warn" or "fail"."""
    return tag("svg", tag("path", d=ICONS[name]), viewBox="0 0 24 24", class_="icon", aria_hidden="true")


def favicon(name: str) -> str:
    """A data URI of the verdict's icon, so that a browser's tab shows it."""
    colour = COLOURS[name].replace("#", "%23")
    path = f"<path fill-rule='evenodd' fill='{colour}' d='{ICONS[name]}'/>"
    svg = f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 24 24'>{path}</svg>"
    return "data:image/svg+xml," + svg.replace("<", "%3C").replace(">", "%3E").replace(" ", "%20")


def verdict(run: Run) -> Html:
    """The verdict in word, icon and colour; offending items open, the others folded."""
    name, items = status(run), run.record["verdict"].get("items") or []
    bad = [i for i in items if i.get("status") != "pass"]
    good = [i for i in items if i.get("status") == "pass"]
    return tag(
        "section",
        tag("p", icon(name), tag("strong", WORDS[name]), tag("span", _sentence(run, items, bad)), class_="word"),
        _items(bad) if bad else None,
        _without(run),
        tag("details", tag("summary", f"{count(len(good), 'check')} that hold"), _items(good)) if good else None,
        class_=f"verdict {name}",
        id="verdict",
        aria_label="Verdict",
    )


def _without(run: Run) -> Html | None:
    """How many estimates failed or are shown without sigma, whatever the checks ask of them; their names folded."""
    failed = [n for n, e in run.estimates.items() if not ok(e)]
    withheld = [n for n, e in run.estimates.items() if ok(e) and not trusted(e)]
    left = len(run.estimates) - len(failed)
    told = [f"{len(failed)} of {count(len(run.estimates), 'estimate')} failed"] if failed else []
    if withheld:
        whole = f"the other {left}" if failed else count(left, "estimate")
        told.append(f"σ is withheld for {len(withheld)} of {whole}")
    lists = [
        tag("p", tag("b", word), f": {', '.join(n)}") for word, n in (("Failed", failed), ("σ withheld", withheld)) if n
    ]
    return tag("details", tag("summary", "; ".join(told)), lists, class_="without") if told else None


def _sentence(run: Run, items: list[dict], bad: list[dict]) -> str:
    errors = run.record.get("errors") or []
    failed = f" {count(len(errors), 'stage')} failed." if errors else ""
    if not items:
        return "No check was made." + failed
    if not bad:
        return f"All {count(len(items), 'check')} hold." + failed
    kinds = [(k, sum(i.get("status") == k for i in bad)) for k in ("fail", "warn")]
    counts = ", ".join(
        f"{n} {'fails' if n == 1 else 'fail'}" if k == "fail" else f"{n} to watch" for k, n in kinds if n
    )
    return f"Of {count(len(items), 'check')}: {counts}.{failed}"


def _items(items: list[dict]) -> Html:
    head = tag("tr", [tag("th", h, scope="col") for h in ("Status", "Check", "Value", "Limit")])
    return tag("div", tag("table", tag("thead", head), tag("tbody", [_item(i) for i in items])), class_="scroll items")


def _item(item: dict) -> Html:
    name = item.get("status") if item.get("status") in WORDS else "fail"
    return tag(
        "tr",
        tag("td", icon(name), tag("span", WORDS[name]), class_=f"state {name}"),
        tag("td", item.get("name", ""), class_="text"),
        tag("td", _value(item.get("value"))),
        tag("td", _value(item.get("limit"))),
    )


def _value(value: object) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "–"}[value]
    if isinstance(value, list) and len(value) == 2:
        return " … ".join(_value(v) for v in value)
    if isinstance(value, int | float):
        return f"{value:.4g}".replace("-", "−")
    return str(value)


def findings(run: Run) -> Html | None:
    """What the comparison says, in the sentences that were computed from the numbers."""
    sentences = run.record.get("findings") or []
    return tag("ul", [tag("li", s) for s in sentences], class_="findings") if sentences else None


def _error(found: dict) -> list[Html]:
    """A failed stage: its message, and the traceback of a defect of ours folded below."""
    trace = found.get("traceback")
    folded = tag("details", tag("summary", "Traceback"), tag("pre", trace)) if trace else ""
    return [tag("dt", found.get("stage", "")), tag("dd", found.get("message", ""), folded)]


def errors(run: Run) -> Html | None:
    """The stages that failed, with their messages."""
    found = run.record.get("errors") or []
    if not found:
        return None
    return tag("dl", [_error(e) for e in found], class_="errors")
