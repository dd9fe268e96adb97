"""The linear closed loop of plant and controller: bandwidth, margins, the filters that follow, Bode's magnitude."""

from __future__ import annotations

import numpy as np

from pipeline.report.html import Html, tag
from pipeline.report.panels import Level, Line, Panel
from pipeline.report.parameters import table
from pipeline.report.run import Run
from pipeline.report.text import DASH, number
from pipeline.units import unit_text

FACTORS = (("f_dyn", 1.0, (2, 3)), ("2 f_dyn", 2.0, (5, 4)), ("5 f_dyn", 5.0, (10, 3, 2, 3)))  # each in its dashes


def margins(run: Run) -> Html | None:
    """Bandwidth and margins of each joint: over the configurations the range of the one, the worst of the others."""
    found = run.record.get("loop") or {}
    if found.get("reason"):
        return tag("p", f"No loop was analysed: {found['reason']}.", class_="lead")
    configurations = found.get("configurations")
    if not configurations:
        return None
    rows = [_joint_row(run, configurations, j) for j in range(run.joints)]
    heads = ("", "bandwidth in Hz", "phase margin", "at", "gain margin", "modulus margin", "worst at q")
    head = [tag("th", h, scope="col") for h in heads]
    caption = (
        f"f_dyn = {number(found.get('f_dyn'), 3)} Hz: the largest −3 dB bandwidth of a joint, reference position to"
        f" position, the reference velocity held at 0; the median over {len(configurations)} configurations spread over"
        " the motion. Plant and controller FMU are linearised at rest, Coulomb friction off, the input held over each"
        " period. Margins: each joint's loop broken at the plant's input, the others closed; the worst configuration."
        " Good: a phase margin above 45°, a modulus margin above 0.5. Bad: below 30°, where the loop rings, and the"
        " record with it."
    )
    return table("Bandwidth and margins", [head], rows, caption)


def _joint_row(run: Run, configurations: list[dict], joint: int) -> Html:
    bandwidth = [c["bandwidth"][joint] for c in configurations]
    worst = min(configurations, key=lambda c: c["margins"][joint]["modulus"])
    found = [c["margins"][joint] for c in configurations]
    phase = min((m for m in found if m["phase"] is not None), key=lambda m: abs(m["phase"]), default=None)
    gains = [m["gain"] for m in found if m["gain"]]
    gain = min(gains, key=lambda g: abs(np.log(g)), default=None)
    cells = [
        _range(min(bandwidth), max(bandwidth)),
        f"{number(phase['phase'], 3)}°" if phase else DASH,
        f"{number(phase['phase_at'], 3)} Hz" if phase else DASH,
        f"{number(gain, 3)} ({number(20.0 * np.log10(gain), 3)} dB)" if gain else DASH,
        number(worst["margins"][joint]["modulus"], 2),
        f"{', '.join(number(q, 2) for q in worst['q'])} {unit_text(run.position_unit)}",
    ]
    return _row(run.joint_name(joint + 1), cells)


def filters(run: Run) -> Html | None:
    """What each WLS variant filters with, and where the numbers come from."""
    found = (run.record.get("loop") or {}).get("filters") or {}
    if not found:
        return None
    rows = [
        _row(name, [*(_cutoff(f[which]) for which in ("position", "parallel")), _decimation(f["decimation"])])
        for name, f in found.items()
    ]
    head = [tag("th", h, scope="col") for h in ("", "position filter", "parallel filter", "decimation")]
    caption = (
        "Cut-offs that are not set follow the loop: 5 f_dyn for the position, 2 f_dyn for the parallel filter. Good:"
        " the position filter well above the loop's bandwidth, the parallel one about twice it, the decimated Nyquist"
        " above that. Bad: a position filter that cuts the motion (bias), a parallel one that lets noise pass."
    )
    return table("Filters", [head], rows, caption)


def _cutoff(found: dict) -> str:
    if found["value"] is None:
        return found["source"]
    return f"{number(found['value'], 3)} Hz, {found['source']}"


def _decimation(found: dict) -> str:
    return f"1 of {found['value']}, {found['source']}" if found["value"] != 1 else DASH


def gain_panels(run: Run) -> list[Panel]:
    """Bode's magnitude from reference to position of each joint, as a band over the configurations."""
    found = run.record.get("loop") or {}
    curves = found.get("gain")
    return [_gain_panel(run, found, curves, j) for j in range(run.joints)] if curves else []


def _gain_panel(run: Run, found: dict, curves: dict, joint: int) -> Panel:
    f = np.asarray(curves["f"], float)
    low, high = (20.0 * np.log10(np.asarray(curves[k][joint], float)) for k in ("lowest", "highest"))
    bandwidth = [c["bandwidth"][joint] for c in found["configurations"]]
    bottom, top = -45.0, max(6.0, 1.1 * float(high.max()))
    marks = [
        Line(label, np.full(2, factor * found["f_dyn"]), np.array([bottom, top]), "prior", dash=dash)
        for label, factor, dash in FACTORS
        if factor * found["f_dyn"] <= f[-1]
    ]
    return Panel(
        key=f"loop-{joint + 1}",
        title=f"{run.joint_name(joint + 1)}, reference to position",
        series=(Line("gain", f, 0.5 * (low + high), "ekf", 0.5 * (high - low)), Level("−3 dB", (-3.0,)), *marks),
        x_label="Frequency in Hz",
        y_label="Gain in dB",
        link="loop",
        log=True,
        y_range=(bottom, top),
        summary=f"−3 dB at {_range(min(bandwidth), max(bandwidth))} Hz, peak {max(0.0, high.max()):.1f} dB.",
        caption="Linear closed loop, relative to rest; the band spans the configurations. Good: flat, then falling,"
        " with little overshoot. Bad: a peak of more than 6 dB (hardly damped), or a band so wide that one cut-off"
        " cannot suit all configurations.",
    )


def _range(low: float, high: float) -> str:
    shown = number(low, 3), number(high, 3)
    return shown[0] if shown[0] == shown[1] else f"{shown[0]} to {shown[1]}"


def _row(label: str, cells: list[str]) -> Html:
    return tag("tr", tag("th", label, scope="row"), [tag("td", c) for c in cells])
