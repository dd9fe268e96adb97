"""Excitation, timing, validation numbers, and where the run comes from, as tables."""

from __future__ import annotations

import json

from pipeline.report.html import Html, tag
from pipeline.report.parameters import table
from pipeline.report.run import Run, ok
from pipeline.report.text import DASH, number, seconds, short


def excitation(run: Run) -> Html | None:
    """Condition numbers of this run beside the reference trajectory's and the printed ones."""
    found = run.record.get("excitation") or {}
    if not found:
        return None
    columns = {"this run": found}
    if found.get("reference"):
        columns["reference trajectory, no noise"] = found["reference"]
    if run.reference.get("metrics"):
        columns["printed"] = run.reference["metrics"]
    rows = [
        _row("cond(W)", [number(c.get("condition_number_W")) for c in columns.values()]),
        _row("cond(Φ)", [number(c.get("condition_number_Phi")) for c in columns.values()]),
        _row(
            "left out of Φ (a-priori value 0)",
            [", ".join(c.get("left_out_of_Phi") or []) or DASH for c in columns.values()],
        ),
        _row("singular values of W", [_values(c.get("singular_values")) for c in columns.values()]),
    ]
    head = [tag("th", h, scope="col") for h in ("", *columns)]
    caption = (
        "W: the weighted observation matrix; Φ: its columns times the a-priori values. Good: up to a few hundred, so"
        " that all parameters are found with like accuracy. Bad: thousands."
    )
    return table("Condition numbers", [head], rows, caption)


def validation(run: Run) -> Html | None:
    """Relative force prediction errors by run, estimate and joint beside the noise floor."""
    found = run.record.get("validation") or {}
    floor = found.get("noise_floor") or {}
    runs = {k: v for k, v in found.items() if k in ("identification", "validation") and v}
    if not runs:
        return None
    signals = list(dict.fromkeys(s for errors in runs.values() for e in errors.values() for s in e))
    names = list(dict.fromkeys(n for errors in runs.values() for n in errors))
    top = [tag("th", "", scope="col")] + [
        tag("th", f"{k} run", colspan=str(len(signals)), class_="group") for k in runs
    ]
    labels = {f"tau_{j}": run.joint_name(j) for j in range(1, run.joints + 1)}
    head = [tag("th", "Estimate", scope="col")]
    for _ in runs:
        head += [tag("th", labels.get(s, s), scope="col", class_=None if k else "group") for k, s in enumerate(signals)]
    rows = [
        _row(n, [f"{_percent((errors.get(n) or {}).get(s))}" for errors in runs.values() for s in signals])
        for n in names
    ]
    if floor:
        rows.append(
            _row(run.floor_name, [_percent(floor.get(s)) if k == "validation" else DASH for k in runs for s in signals])
        )
    caption = (
        "100 ‖y − ŷ‖ / ‖y‖. Good: on the validation run close to the noise floor, and not much larger than on the"
        " identification run. Bad: far above the floor (bias), or good on the identification run alone (overfitting)."
    )
    return table("Relative error", [top, head], rows, caption)


def own_filters(run: Run) -> Html | None:
    """Total errors of each batch estimate on regressions filtered its own way, beside the published ones."""
    found = (run.record.get("validation") or {}).get("own_filters") or {}
    if not found:
        return None
    runs = list(dict.fromkeys(k for errors in found.values() for k in errors))
    rows = [_row(n, [_percent(errors.get(k)) for k in runs]) for n, errors in found.items()]
    published = run.reference.get("force_error_percent")
    if published:
        rows.append(_row("as printed", [_percent(published.get(k)) for k in runs]))
    head = [tag("th", h, scope="col") for h in ("Estimate", *(f"{k} run" for k in runs))]
    caption = (
        "Total relative error where data and regressor are filtered as that estimate filters them. Good for comparing"
        " with printed figures; not for ranking the estimates, since a harder filter leaves less to explain."
    )
    return table("Relative error, each estimate on its own filters", [head], rows, caption)


def closed_loop(run: Run) -> Html | None:
    """Relative differences of the simulated closed loop, by run and signal."""
    found = (run.record.get("validation") or {}).get("closed_loop") or {}
    if not found:
        return None
    signals = list(dict.fromkeys(s for errors in found.values() for s in errors))
    rows = [_row(f"{k} run", [_percent(errors.get(s)) for s in signals]) for k, errors in found.items()]
    for k, errors in (run.reference.get("closed_loop") or {}).items():
        rows.append(_row(f"{k} run, as printed", [_percent(errors.get(s)) for s in signals]))
    head = [tag("th", h, scope="col") for h in ("", *signals)]
    caption = (
        "Relative difference of measurement and simulation. Good: position far below velocity,"
        " velocity below force. Bad: a position that drifts away."
    )
    return table("Relative differences", [head], rows, caption)


def timing(run: Run) -> list[Html]:
    """What every estimate cost, beside the reference's times, and what every stage cost."""
    done = {n: e for n, e in run.estimates.items() if e.get("elapsed_s") is not None}
    batch = done.get(run.recommended or "", {}).get("elapsed_s")
    elapsed = {k: v for k, v in (run.reference.get("elapsed") or {}).items() if isinstance(v, int | float)}
    rows = [_estimate_time(n, e, batch) for n, e in done.items()]
    where = (run.reference.get("elapsed") or {}).get("machine")
    rows += [
        _row(f"{k} as printed{f' ({where})' if where else ''}", [seconds(v), _ratio(v, elapsed.get("WLS")), DASH])
        for k, v in elapsed.items()
    ]
    head = [tag("th", h, scope="col") for h in ("Estimate", "CPU time", f"÷ {run.recommended or 'WLS'}", "FMU calls")]
    caption = (
        "CPU time of the estimate alone. What matters is the ratio of filter to least squares: machines differ,"
        " the ratio tells of the method and of how the plant is called."
    )
    shown = [table("What each estimate cost", [head], rows, caption)] if rows else []
    stages = (run.record.get("timing") or {}).get("stages") or {}
    if stages:
        total = sum(v for v in stages.values() if v)
        body = [_row(k, [seconds(v), _share(v, total)]) for k, v in stages.items()] + [
            _row("all", [seconds(total), ""])
        ]
        heads = [tag("th", h, scope="col") for h in ("Stage", "CPU time", "share")]
        shown.append(
            table(
                "What each stage cost",
                [heads],
                body,
                "Good: the filters take most of it. Bad: a stage that grew since the last run.",
            )
        )
    return shown


def _estimate_time(name: str, estimate: dict, batch: float | None) -> Html:
    calls = estimate.get("fmu_calls")
    label = name if ok(estimate) else f"{name} (failed)"
    return _row(
        label, [seconds(estimate["elapsed_s"]), _ratio(estimate["elapsed_s"], batch), f"{calls:,}" if calls else DASH]
    )


def _ratio(value: float | None, base: float | None) -> str:
    return number(value / base, 2 if value / base < 100 else 3) if value and base else DASH


def _share(value: float | None, total: float) -> Html:
    share = 100.0 * (value or 0.0) / total if total else 0.0
    return tag("span", f"{share:.0f} %", class_="share", style=f"--w:{share:.1f}%")


def origin(run: Run) -> Html:
    """Provenance: the plant, versions, hashes, seed, the whole configuration and the command to repeat it."""
    source, plant, experiment = (run.record.get(k) or {} for k in ("provenance", "plant", "experiment"))
    commit = source.get("commit")
    pairs = [
        ("To repeat it", tag("code", source.get("command") or DASH)),
        ("Run", f"{run.record['run_id']}, {run.record.get('created') or 'undated'}"),
        ("Commit", f"{commit or 'unknown'}{' with uncommitted changes' if source.get('dirty') else ''}"),
        ("Seed", str(source.get("seed", experiment.get("seed", DASH)))),
        ("Data", experiment.get("kind") or DASH),
        ("Engine of regressor and loop", source.get("engine") or DASH),
        ("Compared with", run.reference.get("source") or DASH),
        *(
            (f"Plant: {k.replace('_', ' ')}", short(v) if isinstance(v, float) else str(v))
            for k, v in plant.items()
            if v
        ),
        *((f"FMU {k}", tag("code", _fmu(v))) for k, v in (source.get("fmus") or {}).items()),
        *((f"Data {k}", tag("code", f"sha256 {v}")) for k, v in (source.get("data") or {}).items()),
        ("Python", f"{source.get('python') or DASH}, {source.get('platform') or ''}".strip(", ")),
        ("Packages", ", ".join(f"{k} {v}" for k, v in (source.get("versions") or {}).items()) or DASH),
    ]
    listing = tag("dl", [[tag("dt", k), tag("dd", v)] for k, v in pairs], class_="origin")
    configuration = "\n".join(flat(experiment.get("configuration") or {}))
    settings = {n: e["settings"] for n, e in run.estimates.items() if e.get("settings")}
    return tag("div", listing, _folded("Whole configuration", configuration), _folded_settings(settings))


def flat(value: object, path: str = "") -> list[str]:
    """Nested settings as lines `ekf.case[0].R = [1e-06, 1e-06]`, one for each number, text or plain list."""
    if isinstance(value, dict):
        return [line for key, item in value.items() for line in flat(item, f"{path}.{key}" if path else str(key))]
    if isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        return [line for i, item in enumerate(value) for line in flat(item, f"{path}[{i}]")]
    return [f"{path} = {json.dumps(value, ensure_ascii=False)}"]


def _folded_settings(settings: dict) -> Html | None:
    return _folded("Settings of every estimate", "\n".join(flat(settings))) if settings else None


def _folded(title: str, text: str) -> Html:
    return tag("details", tag("summary", title), tag("pre", text, tabindex="0"))


def _fmu(about: dict) -> str:
    return f"sha256 {about.get('sha256') or DASH}, guid {about.get('guid') or DASH}"


def _row(label: str, cells: list[str | Html]) -> Html:
    return tag("tr", tag("th", label, scope="row"), [tag("td", c) for c in cells])


def _percent(value: float | None) -> str:
    return DASH if value is None else f"{number(value, 3)} %"


def _values(values: list[float] | None) -> str:
    return ", ".join(number(v, 3) for v in values) if values else DASH
