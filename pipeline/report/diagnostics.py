"""Tables of the tests: NIS and whiteness of the filters, residuals of the least squares."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.report.html import Html, tag
from pipeline.report.parameters import table
from pipeline.report.run import Run, ok, trusted
from pipeline.report.text import DASH, number
from pipeline.units import unit_text


def filter_tests(run: Run) -> Html | None:
    """NIS and whiteness of every filter with their bands."""
    tested = {n: e.get("tests") or {} for n, e in run.estimates.items() if (e.get("tests") or {}).get("NIS")}
    if not tested:
        return None
    joints = range(1, run.joints + 1)
    head = [tag("th", h, scope="col") for h in ("Filter", "Tuning", "mean NIS", "band", "NIS")]
    for j in joints:
        head += [tag("th", h, scope="col") for h in (f"{run.joint_name(j)}: lag 1", "outside", "whiteness")]
    head += [tag("th", h, scope="col") for h in ("worst shift by its step", "σ")]
    rows = [tag("tr", _filter_row(run, n, t, joints)) for n, t in tested.items()]
    caption = (
        "Good: mean NIS inside its band, innovations white, and a worst shift below one σ; then σ may be believed."
        " NIS alone is not enough: a filter biased by its time step can pass it. The worst shift is how far the error"
        " of the transition, held against a finer one, could move an estimate if all of it added up."
    )
    return table("Consistency of the filters", [head], rows, caption)


def _filter_row(run: Run, name: str, tests: dict, joints: Sequence[int]) -> list[Html]:
    e, nis = run.estimates[name], tests["NIS"]
    cells = [tag("th", name, scope="row"), tag("td", e.get("tuning") or DASH, class_="text")]
    cells += [_cell(number(nis.get("mean"))), _cell(f"{number(nis.get('low'), 3)} … {number(nis.get('high'), 3)}")]
    cells.append(mark(nis.get("ok")))
    white = {w.get("joint"): w for w in tests.get("whiteness") or []}
    for j in joints:
        w = white.get(j) or {}
        outside = w.get("outside_percent")
        cells += [_cell(number(w.get("lag1"), 2)), _cell(DASH if outside is None else f"{number(outside, 2)} %")]
        cells.append(mark(w.get("ok")))
    shift = (tests.get("transition") or {}).get("worst_shift_sigma")
    cells.append(_cell(DASH if shift is None else f"{number(shift, 2)} σ"))
    cells.append(tag("td", "shown" if trusted(e) else ("failed" if not ok(e) else "withheld"), class_="text"))
    return cells


def jacobians(run: Run) -> Html | None:
    """By filter the transition, how its Jacobian was computed, and how far that is from another way."""
    ways: dict[tuple, list[str]] = {}
    for name, estimate in run.estimates.items():
        if jacobian := estimate.get("jacobian"):
            settings = estimate.get("settings") or {}
            transition = ", ".join(settings[key] for key in ("transition", "engine") if settings.get(key))
            way = (transition, *(jacobian.get(key) for key in ("used", "against", "difference", "reason")))
            ways.setdefault(way, []).append(name)
    if not ways:
        return None
    labels = ("Filters", "Transition, engine", "Jacobian", "compared with")
    head = [tag("th", h, scope="col", class_="text") for h in labels]
    head += [tag("th", "largest difference", scope="col"), tag("th", "Remark", scope="col", class_="text")]
    caption = (
        "The difference is relative, by columns, at ten points of the motion, seen before the filter ran; columns of"
        " states are compared as rates. Good: 1e-4 or less. Directional derivatives are the FMU's own, by states and"
        " inputs; columns of parameters are forward differences, unless the FMU has its parameters as inputs."
    )
    return table("Jacobians of the filters", [head], [_jacobian_row(n, w) for w, n in ways.items()], caption)


def _jacobian_row(names: list[str], way: tuple) -> Html:
    transition, used, against, difference, reason = way
    cells = [tag("th", ", ".join(names), scope="row", class_="names")]
    cells += [tag("td", word or DASH, class_="text") for word in (transition, used, against)]
    cells.append(_cell(DASH if difference is None else number(difference, 2)))
    return tag("tr", cells, tag("td", reason or DASH, class_="reason flat"))


def residual_tests(run: Run) -> Html | None:
    """Size, shape and whiteness of the residual of every batch estimate, per joint."""
    tested = {n: (e.get("tests") or {}).get("residual") for n, e in run.estimates.items()}
    rows = [_residual_row(run, n, t) for n, tests in tested.items() for t in tests or []]
    if not rows:
        return None
    rms = f"RMS in {unit_text(run.force_unit)}"
    labels = ("Estimate", "Joint", rms, "noise floor", "excess kurtosis", "lag 1", "outside", "whiteness")
    head = [tag("th", h, scope="col") for h in labels]
    caption = (
        "Good: RMS at the noise floor, excess kurtosis near 0, white. Bad: RMS well above the floor (the model misses"
        " something), or coloured residuals: their σ would claim too much."
    )
    return table("Residuals of the least squares", [head], rows, caption)


def _residual_row(run: Run, name: str, test: dict) -> Html:
    joint, outside = test.get("joint"), test.get("outside_percent")
    cells = [tag("th", name, scope="row"), tag("td", run.joint_name(joint) if joint else DASH, class_="text")]
    cells += [_cell(number(test.get(key), 3)) for key in ("rms", "floor", "kurtosis")]
    cells += [_cell(number(test.get("lag1"), 2)), _cell(DASH if outside is None else f"{number(outside, 2)} %")]
    return tag("tr", cells, mark(test.get("whiteness_ok")))


def mark(good: bool | None) -> Html:
    """A test's outcome in word and sign."""
    if good is None:
        return tag("td", DASH, class_="text")
    return tag("td", "✓ holds" if good else "✗ fails", class_="text good" if good else "text bad")


def _cell(text: str) -> Html:
    return tag("td", text)
