"""What the comparison of WLS and EKF says, in sentences computed from the numbers of a run record (schema 1).

Every topic takes the record and yields sentences; one that lacks its numbers yields none.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import special

from pipeline.assess import lookup
from pipeline.assess.wording import figures, listed, signed, times, with_sigma

TRUTH_SIGMAS = 4.0
AS_GOOD = 1.02
"""Prediction errors within 2 % of each other count as equal."""


def findings(record: dict) -> list[str]:
    """All sentences in the order a reader asks: excitation, WLS, truth, EKF, cost, conclusion."""
    return [sentence for topic in TOPICS for sentence in topic(record)]


def excitation(record: dict) -> Iterator[str]:
    """Condition numbers beside the published ones."""
    found, published = record.get("excitation") or {}, record.get("reference") or {}
    parts = []
    for key, symbol in (("condition_number_W", "cond(W_w)"), ("condition_number_Phi", "cond(Phi)")):
        if found.get(key) is not None:
            beside = f" (published {figures(published[key])})" if published.get(key) else ""
            parts.append(f"{symbol} = {figures(found[key])}{beside}")
    left_out = found.get("left_out_of_Phi")
    without = f", Phi without {listed(left_out)}, whose a-priori value is 0" if left_out and len(parts) > 1 else ""
    if parts:
        yield f"Excitation: {listed(parts)}{without}."


def filtering(record: dict) -> Iterator[str]:
    """What the other WLS variants lose against the recommended one."""
    best, predicted, own = lookup.recommended(record), lookup.prediction_errors(record), lookup.own_errors(record)
    for name, e in lookup.batch(record).items():
        theirs = record["estimates"][best]
        gap = lookup.apart(e, theirs) if name != best else None
        if gap is None:
            continue
        a, b = e["parameters"][gap.parameter], theirs["parameters"][gap.parameter]
        values = f"{figures(a['value'])} against {with_sigma(b['value'], b.get('sigma'), b.get('unit') or '')}"
        told = f"{name} differs from {best} most in {gap.parameter}: {values}, {gap} apart"
        if name in predicted and best in predicted:
            errors = f"{figures(predicted[name])} % against {figures(predicted[best])} %"
            told += f"; on the validation run it errs by {errors}"
            told += f" ({figures(own[name])} % with its own filters)" if name in own else ""
        yield told + "."


def truth(record: dict) -> Iterator[str]:
    """Every estimate whose sigma is given, against the true parameters: is the printed sigma honest."""
    honest: dict[str, dict[str, float]] = {}
    for name, e in lookup.usable(record).items():
        errors = {} if e.get("sigma_reason") or e.get("method") == "RLS" else lookup.errors_in_sigma(e)
        if not errors:
            continue
        worst = max(errors, key=errors.get)
        if errors[worst] <= TRUTH_SIGMAS:
            honest[name] = errors
        else:
            yield f"{name} is {figures(errors[worst], 2)} of its own sigma off the truth in {worst}: it is too small."
    if honest:
        yield _farthest(honest)


def _farthest(honest: dict[str, dict[str, float]]) -> str:
    """The largest |error|/sigma by estimate and parameter, and how often one of so many is as large by chance.

    At most 1 − (1 − p)^m of m normal variables, however correlated, exceed what one does with probability p
    (Šidák, J. Am. Stat. Assoc. 62 (1967) 626).
    """
    distance, name, parameter = max((d, n, p) for n, errors in honest.items() for p, d in errors.items())
    amount = sum(map(len, honest.values()))
    chance = -100.0 * np.expm1(amount * np.log1p(-special.erfc(distance / np.sqrt(2.0))))
    return (
        f"{listed(list(honest))}: the largest distance from the truth is {figures(distance, 2)} of its own sigma "
        f"(limit {TRUTH_SIGMAS:g}), {parameter} of {name}; where sigma is right, one of {amount} distances is that "
        f"large in at most {figures(chance, 2)} % of runs."
    )


def published(record: dict) -> Iterator[str]:
    """For a measured plant: ours against the published values, in percent."""
    measured = (record.get("experiment") or {}).get("kind") == "measured"
    for table in ((record.get("reference") or {}).get("tables") or []) if measured else []:
        for column, values in (table.get("estimates") or {}).items():
            name = values.get("ours", column)
            off = (
                lookup.percent_off(record["estimates"][name], values["parameters"])
                if name in lookup.usable(record)
                else {}
            )
            if off:
                yield f"{name} against the published values: {listed([f'{p} {signed(x)} %' for p, x in off.items()])}."


def essential(record: dict) -> Iterator[str]:
    """Which parameters the record cannot tell from zero."""
    for name, e in lookup.usable(record).items():
        found = e.get("essential")
        if found:
            dropped = [f"{p} ({figures(percent, 2)} %)" for p, percent in found.get("dropped") or []]
            told = f"; dropped for a relative sigma above 20 %: {listed(dropped)}" if dropped else ""
            yield f"{len(found['kept'])} of {len(e['parameters'])} parameters of {name} are essential{told}."


def closeness(record: dict) -> Iterator[str]:
    """Each EKF against the recommended WLS, in the combined sigma of those that are trusted."""
    best, near, far = lookup.recommended(record), {}, []
    for name, e in lookup.filters(record).items() if best else []:
        gap = lookup.apart(e, record["estimates"][best])
        if gap is not None and gap.close:
            near[name] = gap
        elif gap is not None:
            far.append(f"{name} ({gap} in {gap.parameter})")
    if far:
        yield f"Apart from {best}: {listed(far)}."
    if near:
        farthest = max(near.values(), key=lambda gap: gap.distance)
        verb = "agrees" if len(near) == 1 else "agree"
        yield f"{listed(list(near))} {verb} with {best}: no parameter is more than {farthest} apart."


def starts(record: dict) -> Iterator[str]:
    """Where the filter ends from different starts with the same R and Q: how sensitive it is to chi0 and P0."""
    by_tuning: dict[tuple[str, str], list[str]] = {}
    for name, e in lookup.filters(record).items():
        settings = e.get("settings") or {}
        if not lookup.is_euler(e):
            noise = str((settings.get("R"), settings.get("Q")))
            by_tuning.setdefault((e.get("tuning") or "", noise), []).append(name)
    for (tuning, _), names in by_tuning.items():
        first, last = (record["estimates"][n] for n in (names[0], names[-1]))
        gap = lookup.apart(first, last) if len(names) > 1 else None
        if gap is not None:
            verdict = "the start is forgotten" if gap.close else "the result depends on the start"
            label = f"tuning “{tuning}”" if tuning else "the same tuning"
            yield f"With {label}, {names[0]} and {names[-1]} end {gap} apart in {gap.parameter}: {verdict}."


def euler(record: dict) -> Iterator[str]:
    """The bias of the first-order discretisation (Eq. 13) against RK4 with the same start and tuning."""
    for name, e in lookup.filters(record).items():
        partner = lookup.rk4_partner(record, name)
        gap = lookup.apart(e, record["estimates"][partner]) if partner else None
        if gap is None:
            continue
        a, b = e["parameters"][gap.parameter], record["estimates"][partner]["parameters"][gap.parameter]
        known = f", truth {figures(a['truth'])}" if a.get("truth") is not None else ""
        values = f"{figures(a['value'])} by Euler, {figures(b['value'])} by RK4{known}"
        biased = "shifts" if gap.close else "biases"
        yield (
            f"Euler's step (Eq. 13) {biased} {gap.parameter}: {values}, {gap} between {name} and {partner}"
            f"{_tests_say(e.get('tests') or {})}."
        )


def _tests_say(tests: dict) -> str:
    nis, white = tests.get("NIS") or {}, tests.get("whiteness") or []
    if nis.get("mean") is None or not white:
        return ""
    coloured = [str(w["joint"]) for w in white if not w.get("ok")]
    colour = f"the innovations of joint {listed(coloured)} are coloured" if coloured else "the innovations look white"
    mean = f"mean NIS {figures(nis['mean'])} {'passes' if nis.get('ok') else 'fails'}"
    return f"; {mean}, {colour}"


def failures(record: dict) -> Iterator[str]:
    """Which estimates failed, with the estimators' own reasons."""
    by_reason: dict[str, list[str]] = {}
    for name, e in (record.get("estimates") or {}).items():
        if e.get("status") == "failed":
            by_reason.setdefault(e.get("reason") or "no reason given", []).append(name)
    for reason, names in by_reason.items():
        yield f"{listed(names)} failed: {reason.rstrip('.')}."


def withheld(record: dict) -> Iterator[str]:
    """Whose sigma is withheld; the reasons stand with the estimates."""
    names = [name for name, e in lookup.usable(record).items() if e.get("sigma_reason")]
    if names:
        yield (
            f"The sigma of {listed(names)} is withheld: the residuals, the innovations, or the errors of the "
            "transition or its Jacobian contradict it; which of them stands with each estimate."
        )


def timing(record: dict) -> Iterator[str]:
    """CPU time of an EKF pass against WLS, beside the paper's."""
    best = lookup.recommended(record)
    slow = [e["elapsed_s"] for e in lookup.filters(record).values() if e.get("elapsed_s")]
    fast = record["estimates"][best].get("elapsed_s") if best else None
    if not slow or not fast:
        return
    one = float(np.median(slow))
    told = f"One EKF pass takes {figures(one, 2)} s of CPU, {times(one / fast)} the {figures(fast, 2)} s of {best}"
    paper = (record.get("reference") or {}).get("elapsed") or {}
    if paper.get("WLS") and paper.get("EKF"):
        ratio = times(paper["EKF"] / paper["WLS"])
        told += f"; the paper: {figures(paper['EKF'])} s against {figures(paper['WLS'])} s, {ratio}"
        told += f" ({paper['machine']})" if paper.get("machine") else ""
    yield told + "."


def prediction(record: dict) -> Iterator[str]:
    """Force prediction on the other trajectory: the best and the worst, beside the noise floor."""
    totals = lookup.prediction_errors(record)
    if not totals:
        return
    order = sorted(totals, key=totals.get)
    floor = ((record.get("validation") or {}).get("noise_floor") or {}).get("total")
    guessed = ", a guess" if (record.get("experiment") or {}).get("kind") == "measured" else ""
    beside = f" (noise alone: {figures(floor)} %{guessed})" if floor is not None else ""
    worst = f"; {order[-1]} is worst with {figures(totals[order[-1]])} %" if len(order) > 1 else ""
    yield f"On the validation run {order[0]} predicts the force best, to {figures(totals[order[0]])} %{beside}{worst}."


def conclusion(record: dict) -> Iterator[str]:
    """Does the paper's conclusion, WLS is better for off-line identification, hold in this run."""
    if not (record.get("reference") or {}).get("elapsed"):  # whose conclusion it is: the paper's comparison of costs
        return
    best, totals = lookup.recommended(record), lookup.prediction_errors(record)
    rivals = {n: totals[n] for n in lookup.filters(record) if n in totals}
    if best not in totals or not rivals:
        return
    rival = min(rivals, key=rivals.get)
    seconds = [record["estimates"][n].get("elapsed_s") or 0.0 for n in (best, rival)]
    as_good, cheaper = totals[best] <= AS_GOOD * rivals[rival], seconds[0] < seconds[1]
    holds = "holds" if as_good and cheaper else "does not hold in full"
    numbers = f"{best} predicts to {figures(totals[best])} %, the best filter ({rival}) to {figures(rivals[rival])} %"
    cost = "at a lower cost" if cheaper else "at no lower cost"
    yield (
        f"Gautier and Poignet's conclusion, WLS is the better choice off line, {holds} in this run: {numbers}; "
        f"WLS does so {cost} and needs no start values."
    )


TOPICS = (excitation, filtering, truth, published, essential, closeness, starts, euler)
TOPICS += (failures, withheld, timing, prediction, conclusion)
