"""The record as plain text for a terminal."""

from __future__ import annotations


def verdict_text(record: dict) -> str:
    """The verdict in one word, and below it every item that is not a pass."""
    verdict = record["verdict"]
    lines = [f"{verdict['status'].upper()}  {record['title']}"]
    for item in verdict["items"]:
        if item["status"] != "pass" and not item["name"].startswith("stage "):
            lines.append(f"  {item['status']}: {item['name']}: {_number(item['value'])}, limit {_limit(item['limit'])}")
    return "\n".join(lines)


def estimates_text(record: dict) -> str:
    """Every estimate, a line per parameter; reasons stand where numbers must not."""
    lines = []
    for name, estimate in record["estimates"].items():
        if estimate["status"] != "ok":
            lines += [f"{name}: failed: {estimate['reason']}", ""]
            continue
        lines.append(name)
        if estimate["sigma_reason"]:
            lines.append(f"  sigma withheld: {estimate['sigma_reason']}")
        for parameter, p in estimate["parameters"].items():
            sigma = "" if p["sigma"] is None else f" ± {p['sigma']:.2g}"
            lines.append(f"  {parameter:<8}{p['value']:>12.5g}{sigma} {p['unit']}")
        lines.append("")
    return "\n".join(lines).rstrip()


def _number(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _limit(limit: object) -> str:
    return " to ".join(map(_number, limit)) if isinstance(limit, list) else _number(limit)
