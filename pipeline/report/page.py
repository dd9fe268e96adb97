"""The page of a run: one HTML file that works offline from a folder, made from the run record and its signals alone."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from pipeline.report import checks, convergence, diagnostics, loop, motion, parameters, provenance, summary
from pipeline.report.html import Html, join, script_data, tag
from pipeline.report.intervals import interval_plots
from pipeline.report.panels import Panel, Store
from pipeline.report.record import read_run, write_text
from pipeline.report.run import Run, trusted

PAGE = "index.html"


def write_page(folder: Path | str) -> Path:
    """Make `index.html` in a run's folder from its record and signals. Raises DataError (see record.read_run)."""
    path = Path(folder) / PAGE
    write_text(path, page(*read_run(folder)), f"make room, then `fmuid report {folder}` remakes it")
    return path


def page(record: dict, signals: dict) -> str:
    """The whole page; the same record gives the same bytes."""
    run, store = Run(record, signals), Store()
    sections = [s for s in _sections(run, store) if s is not None]
    experiment = record["experiment"]
    title = record.get("title") or experiment.get("title") or experiment.get("name") or record["run_id"]
    word = summary.WORDS[summary.status(run)]
    scripts = [_bokeh(), *(_asset(name) for name in ("print.js", "plots.js", "page.js"))]
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", http_equiv="Content-Security-Policy", content=_policy(scripts)),
        tag("meta", name="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name="color-scheme", content="light dark"),
        tag("title", f"{word}: {title}, {record['run_id']}"),
        tag("link", rel="icon", href=summary.favicon(summary.status(run))),
        tag("style", Html(_asset("style.css"))),
    )
    body = tag(
        "body",
        tag("a", "Skip to the verdict", href="#verdict", class_="skip"),
        _header(run, title, [s.id for s in sections]),
        tag("main", summary.verdict(run), [s.html for s in sections]),
        tag(
            "script", script_data({"arrays": store.arrays, "panels": store.panels}), type="application/json", id="data"
        ),
        [tag("script", Html(s)) for s in scripts],
    )
    return "<!DOCTYPE html>\n" + tag("html", head, body, lang="en") + "\n"


class Section:
    """A titled part of the page; falls away (None from `section`) where it has no content."""

    def __init__(self, id: str, title: str, content: Html) -> None:
        self.id, self.title = id, title
        self.html = tag("section", tag("h2", title, id=f"{id}-t"), content, id=id, aria_labelledby=f"{id}-t")


def _section(id: str, title: str, *content: object) -> Section | None:
    shown = join(*content)
    return Section(id, title, shown) if shown else None


def _sections(run: Run, store: Store) -> Iterable[Section | None]:
    """The page's sections in reading order; what a run does not have leaves no gap."""

    def grid(panels: list[Panel], kind: str = "panels") -> Html | None:
        return tag("div", [store.add(p) for p in panels], class_=kind) if panels else None

    def part(title: str, panels: list[Panel]) -> Html | None:
        return join(tag("h3", title), grid(panels)) if panels else None

    def folded(title: str, panels: list[Panel], kind: str = "panels", opened: bool = False) -> Html | None:
        shown = grid(panels, kind)
        return tag("details", tag("summary", title), shown, class_="more", open=opened) if shown else None

    yield _section("findings", "What the comparison says", summary.findings(run))
    yield _section("errors", "What failed", summary.errors(run))
    yield _section(
        "parameters",
        "Parameters",
        tag("p", INTERVALS, class_="lead"),
        interval_plots(run),
        parameters.reference_tables(run),
        parameters.essential_table(run),
        tag("details", tag("summary", "Every estimate of this run"), parameters.estimates_table(run)),
    )
    yield _section("tunings", "Tunings of the filter", parameters.tuning_tables(run))
    yield _section("excitation", "Excitation", provenance.excitation(run))
    yield _section(
        "loop", "The loop and the filters", loop.margins(run), loop.filters(run), grid(loop.gain_panels(run))
    )
    yield _section(
        "motion",
        "What was measured, what was estimated",
        part(run.force, motion.force_panels(run)),
        [part(f"States, {name}", motion.state_panels(run, name)) for name in run.filters],
    )
    yield _section(
        "convergence",
        "Convergence of the parameters",
        [part(f"{name} and recursive least squares", convergence.parameter_panels(run, name)) for name in run.filters],
        part("Other tunings", convergence.tuning_panels(run)),
    )
    yield _section("euler", "Bias of the Euler step", _euler(run), grid(convergence.euler_panels(run)))
    yield _section(
        "validation",
        f"{run.force} prediction",
        provenance.validation(run),
        provenance.own_filters(run),
        grid(checks.prediction_panels(run)),
    )
    batch = run.by_method("WLS")
    best = run.recommended
    yield _section(
        "residuals",
        "Residuals of the least squares",
        diagnostics.residual_tests(run),
        grid(checks.residual_panels(run, best), "panels three") if best in batch else None,
        [folded(f"Residuals of {n}", checks.residual_panels(run, n), "panels three") for n in batch if n != best],
    )
    sound = next((n for n in run.by_method("EKF") if trusted(run.estimates[n])), None)
    yield _section(
        "innovations",
        "Innovations of the filters",
        diagnostics.filter_tests(run),
        diagnostics.jacobians(run),
        [
            folded(f"Innovations of {n}", checks.innovation_panels(run, n), opened=n == sound)
            for n in run.by_method("EKF")
        ],
    )
    yield _section(
        "closed-loop",
        "Closed loop, simulated against measured",
        provenance.closed_loop(run),
        [part(f"{w.capitalize()} run", motion.closed_loop_panels(run, w)) for w in ("identification", "validation")],
    )
    yield _section("timing", "Timing", _columns(provenance.timing(run)))
    yield _section("provenance", "Provenance", provenance.origin(run))


INTERVALS = (
    "Every estimate with ±2σ. Solid line: the truth where it is known, else the a-priori value. A hollow dot has no σ"
    " that may be shown; an arrow lies outside the range. Good: short bars on the line. Bad: a short bar beside it."
)


def _columns(tables: list[Html]) -> Html | None:
    return tag("div", tables, class_="columns") if tables else None


def _euler(run: Run) -> Html | None:
    pair = convergence.euler_pair(run)
    if pair is None:
        return None
    text = (
        f"{pair[0]} steps the plant by z + ż dt (Eq. 13), {pair[1]} by Runge–Kutta; all else is the same."
        " The difference is the bias of the step, not of the data."
    )
    return tag("p", text, class_="lead")


def _header(run: Run, title: str, links: list[str]) -> Html:
    experiment = run.record["experiment"]
    kind = {"simulated": "simulated data", "measured": "measured data"}.get(experiment.get("kind"), "")
    facts = [kind, f"{run.joints} joint{'s' * (run.joints > 1)}", f"{len(run.parameters)} parameters"]
    facts += [str(run.record.get("created") or "")[:16].replace("T", " "), run.record["run_id"]]
    return tag(
        "header",
        tag("h1", title),
        tag("p", " · ".join(f for f in facts if f), class_="facts"),
        tag(
            "div",
            tag("button", "Dark or light", type="button", id="theme"),
            tag("button", "All times", type="button", id="whole", hidden=True),
            class_="tools",
        ),
        tag("nav", [tag("a", id.replace("-", " ").capitalize(), href=f"#{id}") for id in links], aria_label="Sections"),
    )


def _policy(scripts: list[str]) -> str:
    """Nothing is fetched, and no script runs but the page's own, by hash."""
    hashes = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(s.encode()).digest()).decode()}'" for s in scripts)
    return f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data:"


@cache
def _asset(name: str) -> str:
    return files("pipeline.report").joinpath(name).read_text(encoding="utf-8")


@cache
def _bokeh() -> str:
    """BokehJS and its plotting interface out of the installed wheel: nothing of bokeh's Python is needed."""
    folder = Path(find_spec("bokeh").origin).parent / "server" / "static" / "js"
    parts = [(folder / f"{name}.min.js").read_text(encoding="utf-8") for name in ("bokeh", "bokeh-api")]
    return "\n".join(parts).replace("</script", "<\\/script")
