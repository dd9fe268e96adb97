"""The record as plain text for a terminal."""

from __future__ import annotations

from typing import TextIO

BAR = 30


class Progress:
    """Narration on a stream, below it on a terminal a bar with the best so far; a file or a pipe gets no bar."""

    def __init__(self, stream: TextIO):
        self.stream, self.live = stream, stream is not None and stream.isatty()

    def __call__(self, done: int, total: int, best: float) -> None:
        if self.live:
            filled = "#" * (BAR * done // total)
            text = f"  [{filled:<{BAR}}] {100 * done // total:3d} %  best log det {best:.2f}"
            print(f"\r{text}\033[K", end="", file=self.stream, flush=True)

    def narrate(self, text: str) -> None:
        """A line for the user, in place of the bar."""
        print(f"\r\033[K{text}" if self.live else text, file=self.stream, flush=True)


def design_text(design: dict) -> str:
    """What a designed trajectory is worth and how much of its limits it uses."""
    Phi, left_out = design["condition_number_Phi"], ", ".join(design["left_out_of_Phi"])
    worth = [f"log det {design['log_det']:.3f}", f"cond(W_w) {design['condition_number_W']:.1f}"]
    if Phi is not None:
        worth.append(f"cond(Phi) {Phi:.1f}" + (f" without {left_out}" if left_out else ""))
    used = [f"{name} {', '.join(f'{100 * u:.1f}' for u in joints)} %" for name, joints in design["used"].items()]
    checked = "plan and closed loop" if design["closed_loop_checked"] else "the plan alone: no [controller]"
    return f"{', '.join(worth)}\nof the limits, by joint ({checked}): {'; '.join(used)}"


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
