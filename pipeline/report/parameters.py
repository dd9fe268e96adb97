"""Tables of parameters: the reference's beside ours, every estimate, and the tunings side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from textwrap import shorten

from pipeline.report.html import Html, tag
from pipeline.report.run import Run, ok
from pipeline.report.text import DASH, estimate, number, plus_minus, short, sigma_text
from pipeline.units import unit_text

BRIEF = 70  # characters of a reason that a cell shows
OURS = ("value", "σ", "%σ")


def reference_tables(run: Run) -> list[Html]:
    """Each table of the reference, every column of it followed by ours."""
    return [_reference_table(run, t) for t in run.reference.get("tables") or []]


def _reference_table(run: Run, printed: dict) -> Html:
    theirs = printed.get("estimates") or {}
    ours = {name: column.get("ours", name) for name, column in theirs.items()}
    names = list(run.parameters)
    top = [tag("th", "", colspan=str(len(_lead_head(run))), scope="colgroup")]
    head = _lead_head(run)
    for name in theirs:
        title = name if ours[name] == name else f"{name} (ours: {ours[name]})"
        top.append(tag("th", title, colspan="5", scope="colgroup", class_="group"))
        head.append(tag("th", "printed", scope="col", class_="group"))
        head += [tag("th", h, scope="col") for h in ("%σ", *("ours" if h == "value" else h for h in OURS))]
    rows = []
    for i, p in enumerate(names):
        cells = _lead(run, p)
        for name, column in theirs.items():
            cells += _printed((column.get("parameters") or {}).get(p) or {})
            cells += _ours(run, ours[name], p, i, len(names))
        rows.append(tag("tr", cells))
    caption = (
        "Printed: as the reference gives it. Good: ours near the truth, or near the a-priori value, by few σ;"
        " where the reference shows a bias, ours shows the same one. Bad: a value many of its own σ away."
    )
    return table(printed.get("title") or "Reference", [top, head], rows, caption, _notes(run, ours.values()))


def estimates_table(run: Run) -> Html:
    """Every estimate of this run as a row, the parameters as columns; a failure's reason stands in their place."""
    names = list(run.parameters)
    units = {p: unit_text(about.get("unit", "")) for p, about in run.parameters.items()}
    head = [tag("th", "Estimate", scope="col")]
    head += [tag("th", p, tag("small", units[p]), scope="col") for p in names]
    rows = []
    for key, label in (("truth", "truth"), ("a_priori", "a priori")):
        if any(about.get(key) is not None for about in run.parameters.values()):
            cells = [_cell(short(about.get(key))) for about in run.parameters.values()]
            rows.append(tag("tr", tag("th", label, scope="row"), cells, class_="aim"))
    rows += [_estimate_row(run, n, e, names) for n, e in run.estimates.items()]
    caption = (
        "Value ± σ, and below it 100 σ/|value|. Good: one column, one value. Bad: estimates that exclude each other."
    )
    return table("Every estimate of this run", [head], rows, caption, _notes(run, run.estimates, every=True))


def _estimate_row(run: Run, name: str, found: dict, parameters: list[str]) -> Html:
    head = tag("th", name, tag("small", "σ withheld") if found.get("sigma_reason") else None, scope="row")
    if not ok(found):
        return tag("tr", head, _reason("failed", found.get("reason"), 1, len(parameters)))
    cells = []
    for p in parameters:
        about = (found.get("parameters") or {}).get(p) or {}
        if about.get("value") is None:
            cells.append(tag("td", (found.get("held") or {}).get(p) or "not estimated", class_="reason flat"))
            continue
        relative = about.get("relative_sigma_percent")
        small = tag("small", f"{number(relative, 2)} %") if relative is not None and about.get("sigma") else None
        cells.append(tag("td", plus_minus(about["value"], about.get("sigma"), run.resolution(p)), small))
    return tag("tr", head, cells)


def essential_table(run: Run) -> Html | None:
    """The essential parameters of the recommended estimate: what was left out, and the rest estimated again."""
    name = run.recommended
    found = run.estimates[name].get("essential") if name else None
    if not found or not found.get("dropped"):
        return None
    dropped, again = dict(found["dropped"]), found.get("parameters") or {}
    rows = []
    for p, about in run.estimates[name]["parameters"].items():
        why = f"left out, {number(dropped[p], 2)} %" if p in dropped else None
        new = again.get(p) or {}
        cells = [_cell(plus_minus(about.get("value"), about.get("sigma"))), _cell(short(about.get("a_priori")))]
        cells.append(tag("td", why, class_="printed") if why else _cell(plus_minus(new.get("value"), new.get("sigma"))))
        rows.append(tag("tr", _lead(run, p)[0], cells))
    head = [tag("th", h, scope="col") for h in ("Parameter", name, "a priori", "essential ones only")]
    caption = (
        "The parameter with the largest relative σ goes first, while it exceeds the limit; the rest is estimated again."
        " Good: the others hardly move. Bad: they do: the parameter left out mattered."
    )
    return table("Essential parameters", [head], rows, caption)


def tuning_tables(run: Run) -> list[Html]:
    """For every filter that ran with more than one tuning, or from more than one start: the runs side by side."""
    filters = [n for n, e in run.estimates.items() if e.get("method") == "EKF" and not run.is_euler(n)]
    groups: dict[str, list[str]] = {}
    for name in filters:
        groups.setdefault(name.partition(")")[0] + ")", []).append(name)
    if len(filters) > 1 and not any(names[1:] for names in groups.values()):
        groups = {"EKF": filters}
    caption = (
        "Good: the consistent tunings (known noise; derived from the data) agree and pass NIS and whiteness."
        " Bad: the answer depends on the tuning. σ is shown only where the tests support it."
    )
    return [_tuning_table(run, f"{stem}, side by side", names, caption) for stem, names in groups.items() if names[1:]]


def _tuning_table(run: Run, title: str, names: list[str], caption: str) -> Html:
    parameters = list(run.parameters)
    top = [tag("th", "", colspan=str(len(_lead_head(run))), scope="colgroup")]
    head = _lead_head(run)
    for name in names:
        top.append(tag("th", name, colspan="4", scope="colgroup", class_="group"))
        head += [tag("th", h, scope="col", class_="group" if h == "start" else None) for h in ("start", *OURS)]
    rows = []
    for i, p in enumerate(parameters):
        cells = _lead(run, p)
        for name in names:
            start = ((run.estimates[name].get("parameters") or {}).get(p) or {}).get("start")
            cells.append(tag("td", short(start, 4), class_="group printed"))
            cells += _ours(run, name, p, i, len(parameters))
        rows.append(tag("tr", cells))
    return table(title, [top, head], rows + _settings_rows(run, names), caption, _notes(run, names))


def _settings_rows(run: Run, names: list[str]) -> list[Html]:
    """The noise that each tuning assumes: P0, Q and R (diagonals) where the record has them."""
    settings = [run.estimates[n].get("settings") or {} for n in names]
    keys = [k for k in ("P0", "Q", "R", "sigma_q", "sigma_tau") if any(s.get(k) is not None for s in settings)]
    lead = str(len(_lead_head(run)))
    return [
        tag(
            "tr",
            tag("th", k.replace("sigma_", "σ_"), colspan=lead, scope="row"),
            [tag("td", _setting(s.get(k)), colspan="4", class_="group setting") for s in settings],
        )
        for k in keys
    ]


def _setting(value: object) -> str:
    if isinstance(value, list):
        return ", ".join(_setting(v) for v in value)
    return short(value, 3) if isinstance(value, int | float) else str(DASH if value is None else value)


def _truths(run: Run) -> bool:
    return any(p.get("truth") is not None for p in run.parameters.values())


def _lead_head(run: Run) -> list[Html]:
    heads = ("Parameter", "a priori") + (("truth",) if _truths(run) else ())
    return [tag("th", h, scope="col") for h in heads]


def _lead(run: Run, parameter: str) -> list[Html]:
    about = run.parameters[parameter]
    unit = tag("span", unit_text(about.get("unit", "")), class_="unit")
    cells = [tag("th", parameter, " ", unit, scope="row"), _cell(short(about.get("a_priori")))]
    return cells + ([_cell(short(about.get("truth")))] if _truths(run) else [])


def _printed(parameter: dict) -> list[Html]:
    return [
        tag("td", short(parameter.get("value")), class_="group printed"),
        tag("td", short(parameter.get("relative_sigma_percent")), class_="printed"),
    ]


def _ours(run: Run, name: str, parameter: str, row: int, rows: int) -> list[Html]:
    """The three cells of our estimate; a reason spans all rows where there is no value or no sigma to show."""
    found = run.estimates.get(name)
    if found is None:
        return [_reason("", f"{name} was not run", rows, 3)] if row == 0 else []
    if not ok(found):
        return [_reason("failed", _brief(found.get("reason")), rows, 3)] if row == 0 else []
    about = (found.get("parameters") or {}).get(parameter) or {}
    value, sigma = about.get("value"), about.get("sigma")
    if value is None:
        held = (found.get("held") or {}).get(parameter) or "not estimated"
        cells = [tag("td", held, colspan="1" if found.get("sigma_reason") else "3", class_="reason flat")]
    else:
        cells = [_cell(estimate(value, sigma or run.resolution(parameter)))]
    if found.get("sigma_reason"):
        return cells + ([_reason("σ withheld", _brief(found["sigma_reason"]), rows, 2)] if row == 0 else [])
    if value is None:
        return cells
    relative = about.get("relative_sigma_percent")
    return [*cells, _cell(sigma_text(sigma)), _cell(number(relative, 3 if relative and relative < 1000 else 2))]


def _reason(word: str, why: str | None, rows: int, columns: int) -> Html:
    text = [tag("b", word), ": " if why else ""] if word else []
    return tag("td", tag("div", *text, why or ""), rowspan=str(rows), colspan=str(columns), class_="reason")


def _brief(why: str | None) -> str:
    """The first clause of a long reason, or as many whole words as there is room for; the rest stands in _notes."""
    first = shorten((why or "").split("; ")[0], BRIEF, placeholder="")
    return first if len(first) == len(why or "") else f"{first.rstrip(',:')} …"


def _notes(run: Run, names: Iterable[str], every: bool = False) -> list[Html]:
    """In full the reasons of which a table shows the first clause; every: all why sigma is withheld."""
    notes = []
    for name in names:
        found = run.estimates.get(name) or {}
        why = found.get("sigma_reason") or ("" if every else found.get("reason")) or ""
        if why and (every or _brief(why) != why):
            notes.append(tag("p", tag("b", name), f": {why}", class_="note"))
    return notes


def _cell(text: str) -> Html:
    return tag("td", text)


def table(title: str, heads: list[list[Html]], rows: list[Html], caption: str, notes: Sequence[Html] = ()) -> Html:
    """A titled table that scrolls in its own box, with its caption and notes below."""
    inner = tag("table", tag("thead", [tag("tr", h) for h in heads]), tag("tbody", rows))
    return tag(
        "figure",
        tag("h4", title),
        tag("div", inner, class_="scroll", tabindex="0", role="region", aria_label=title),
        tag("figcaption", caption, *notes),
        class_="sheet",
    )
