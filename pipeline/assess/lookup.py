"""What a run record (schema 1) holds, looked up and set against each other."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pipeline.assess.wording import figures

CLOSE_SIGMAS, CLOSE_PERCENT = 3.0, 2.0


class Apart(NamedTuple):
    """The parameter in which two estimates differ most, by how much, in sigma (or in %, where no sigma is known)."""

    parameter: str
    distance: float
    in_sigma: bool

    @property
    def close(self) -> bool:
        return self.distance <= (CLOSE_SIGMAS if self.in_sigma else CLOSE_PERCENT)

    def __str__(self) -> str:
        return f"{figures(self.distance, 2)} {'sigma' if self.in_sigma else '%'}"


def usable(record: dict) -> dict[str, dict]:
    """The estimates that did not fail, by name."""
    return {n: e for n, e in (record.get("estimates") or {}).items() if e.get("status") == "ok" and e.get("parameters")}


def batch(record: dict) -> dict[str, dict]:
    """The usable WLS variants."""
    return {n: e for n, e in usable(record).items() if e.get("method") == "WLS"}


def filters(record: dict) -> dict[str, dict]:
    """The usable EKF runs."""
    return {n: e for n, e in usable(record).items() if e.get("method") == "EKF"}


def recommended(record: dict) -> str | None:
    """Name of the recommended WLS: the experiment's, else the one with essential parameters, else the last WLS."""
    found = batch(record)
    named = ((record.get("experiment") or {}).get("configuration") or {}).get("recommended")
    if named in found:
        return named
    with_essential = [name for name, e in found.items() if e.get("essential")]
    return (with_essential or list(found) or [None])[-1]


def apart(ours: dict, theirs: dict) -> Apart | None:
    """Where two estimates differ most, in the combined sigma of those that are known; None with nothing in common."""
    sigmas, percents = {}, {}
    for name in ours["parameters"].keys() & theirs["parameters"].keys():
        a, b = ours["parameters"][name], theirs["parameters"][name]
        if a.get("value") is None or b.get("value") is None:
            continue
        sigma = float(np.hypot(a.get("sigma") or 0.0, b.get("sigma") or 0.0))
        if sigma > 0.0:
            sigmas[name] = abs(a["value"] - b["value"]) / sigma
        # A parameter that is expected to be zero has no size to be a percentage of.
        if b["value"] != 0.0 and b.get("a_priori") != 0.0:
            percents[name] = 100.0 * abs(a["value"] / b["value"] - 1.0)
    found = sigmas or percents
    if not found:
        return None
    worst = max(found, key=found.get)
    return Apart(worst, found[worst], bool(sigmas))


def errors_in_sigma(estimate: dict) -> dict[str, float]:
    """|value − truth|/sigma by parameter, where truth and sigma are known."""
    return {
        name: abs(p["value"] - p["truth"]) / p["sigma"]
        for name, p in estimate["parameters"].items()
        if p.get("sigma") and p.get("truth") is not None and p.get("value") is not None
    }


def percent_off(estimate: dict, published: dict) -> dict[str, float]:
    """100 (ours − published)/|published| by parameter."""
    ours = estimate["parameters"]
    return {
        name: 100.0 * (ours[name]["value"] - p["value"]) / abs(p["value"])
        for name, p in published.items()
        if name in ours and ours[name].get("value") is not None and p.get("value")
    }


def prediction_errors(record: dict) -> dict[str, float]:
    """Total force prediction error (%) on the validation run, by usable estimate."""
    found = (record.get("validation") or {}).get("validation") or {}
    alive = usable(record)
    return {n: e["total"] for n, e in found.items() if n in alive and (e or {}).get("total") is not None}


def own_errors(record: dict) -> dict[str, float]:
    """Force prediction error (%) of each WLS variant on the validation run, filtered as the variant filters."""
    found = (record.get("validation") or {}).get("own_filters") or {}
    return {n: e["validation"] for n, e in found.items() if (e or {}).get("validation") is not None}


def is_euler(estimate: dict) -> bool:
    """Whether the filter discretised by Eq. 13."""
    return "euler" in str((estimate.get("settings") or {}).get("transition", "")).lower()


def rk4_partner(record: dict, name: str) -> str | None:
    """The RK4 run with the start and the tuning of an Euler run: EKF(3) known for EKF(3) Euler."""
    found = filters(record)
    if not is_euler(found[name]):
        return None
    base, tuning = name.split(" ")[0], found[name].get("tuning")
    same = (n for n, e in found.items() if n.split(" ")[0] == base and e.get("tuning") == tuning and not is_euler(e))
    return next(same, None)
