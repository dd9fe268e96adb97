"""`make bench`: what the compiled engine costs; prints asked, measured, held, writes results.json; exit 1 on a miss."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from pipeline.errors import ConfigError
from tests.benchmarks import chains, filters, loop, processes, regressor, seeds
from tests.benchmarks.environment import environment
from tests.benchmarks.figure import Figure

SECTIONS = {
    "filters": filters.measure,
    "chains": chains.measure,
    "regressor": regressor.measure,
    "loop": loop.measure,
    "processes": processes.measure,
    "seeds": seeds.measure,
}
RESULTS = Path(__file__).with_name("results.json")


def main(
    names: list[str],
    sections: Mapping[str, Callable[[], Iterable[Figure]]] = SECTIONS,
    results: Path = RESULTS,
) -> int:
    """Measure the sections called `names` (default: all) and write what was measured to `results`."""
    unknown = set(names) - set(sections)
    if unknown:
        raise ConfigError(f"no section {', '.join(unknown)}; there are {', '.join(sections)}")
    where, figures = environment(), []
    print(f"{where['cpu']}, {where['cores']} cores, load {where['load'][0]:.1f}, {where['compiler']}")
    for name, measure in sections.items():
        if names and name not in names:
            continue
        print(f"\n{name:<64}{'asked':>13}  {'median':>10}   min … max")
        for figure in measure():
            figures.append(figure)
            print(figure.line, flush=True)
    missed = [figure.name for figure in figures if not figure.held]
    print(f"\n{len(missed)} missed")
    results.write_text(json.dumps({"environment": where, "figures": [f.entry() for f in figures]}, indent=1) + "\n")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
