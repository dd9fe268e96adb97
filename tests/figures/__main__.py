"""`make figures`: measure every promised figure, over all its seeds; print asked, measured, held; exit 1 on a miss."""

from __future__ import annotations

import sys

from tests.figures import commands, emps, engines, fmus, scara

SECTIONS = {"FMUs": fmus, "SCARA": scara, "EMPS": emps, "Engines": engines, "Commands": commands}


def main(names: list[str]) -> int:
    """Measure the sections called `names` (default: all)."""
    missed = 0
    for name, section in SECTIONS.items():
        if names and name not in names:
            continue
        print(f"\n{name}")
        for row in section.measure():
            missed += not row.held
            print(f"  {'held' if row.held else 'MISSED':<7}{row.name:<66}{row.asked:>16}   {row.measured}", flush=True)
    print(f"\n{missed} missed")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
