"""Building FMUs: every class listed in the package's FMUs/package.order, named in snake_case, a file for each version.

One library holds the calls of FMI 2.0 and of 3.0: it is compiled once and packed twice, as `scara.fmu` and
`scara_fmi3.fmu`, so that both versions compute the same to the last bit.
"""

from __future__ import annotations

import hashlib
import json
import re
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from pipeline.errors import ExportError
from pipeline.export.archive import write_archive
from pipeline.export.catalogue import Recipe, benchmarks, recipes
from pipeline.export.claim import claimed
from pipeline.export.codegen import generate
from pipeline.export.compiler import compile_library, describe_compiler, find_compiler, platform
from pipeline.export.equations import Model, translate
from pipeline.export.freshness import WRAPPER, fingerprint, state
from pipeline.export.frontend import load
from pipeline.export.model_description_fmi2 import describe as describe_fmi2
from pipeline.export.model_description_fmi3 import describe as describe_fmi3
from pipeline.export.model_description_fmi3 import describe_build
from pipeline.export.variants import with_inputs
from pipeline.paths import MODELICA

VERSIONS = {"2": ("2",), "3": ("3",), "both": ("2", "3")}
SUFFIX = {"2": "", "3": "_fmi3"}  # of the file's name
ONE_AT_A_TIME = Lock()  # CasADi's expressions count their references without locks; the compilers run side by side


@dataclass(frozen=True)
class Built:
    """One file: its FMU's name, its path, the seconds that this FMU took in all versions; whether it was up to date."""

    name: str
    path: Path
    seconds: float
    skipped: bool


def build(
    names: Sequence[str] | None,
    out: Path,
    start_values: Mapping[str, Mapping[str, float]] | None = None,
    fmi: str = "both",
    force: bool = False,
    modelica: Path = MODELICA,
    report: Callable[[str], None] = lambda line: None,
    variants: Mapping[str, tuple[str, tuple[str, ...]]] | None = None,
) -> list[Built]:
    """Build the FMUs `names` (None: all but benchmarks) into `out`; those whose inputs have not changed are left alone.

    start_values: {FMU name: {parameter: value}} replace bindings of the Modelica text; the FMU must have the parameter.
    fmi: the version, "2", "3" or "both". variants: {FMU name: (name of its plain FMU, parameters)}: FMUs with these
    parameters as continuous inputs. Raises ExportError.
    """
    if fmi not in VERSIONS:
        raise ExportError(f"FMI version {fmi}: there are 2, 3 and both")
    offered = recipes(modelica, start_values, variants)
    unknown = sorted(set(names or ()) - set(offered))
    if unknown:
        what = f"no FMU {', '.join(unknown)}: there are {', '.join(offered)}"
        raise ExportError(f"{what}; --fmi chooses the version" if any("_fmi3" in name for name in unknown) else what)
    chosen = names or [name for name in offered if name not in benchmarks(modelica)]
    with claimed(out):
        return _build({name: offered[name] for name in chosen}, out, fmi, force, modelica, report)


def _build(
    chosen: Mapping[str, Recipe],
    out: Path,
    fmi: str,
    force: bool,
    modelica: Path,
    report: Callable[[str], None],
) -> list[Built]:
    """Build those of the FMUs that are not up to date."""
    compiler = describe_compiler()
    inputs = {name: fingerprint(modelica, recipe) for name, recipe in chosen.items()}
    files = {name: {version: out / f"{name}{SUFFIX[version]}.fmu" for version in VERSIONS[fmi]} for name in chosen}
    todo = {
        name: {v: p for v, p in paths.items() if force or state(p, inputs[name], compiler) != "fresh"}
        for name, paths in files.items()
    }
    todo = {name: paths for name, paths in todo.items() if paths}
    if todo:
        find_compiler()

    def make(name: str) -> list[Built]:
        started = time.perf_counter()
        export(modelica, chosen[name], todo[name], name, {"inputs": inputs[name], "compiler": compiler})
        seconds = time.perf_counter() - started
        return [Built(name, path, seconds, False) for path in todo[name].values()]

    with ThreadPoolExecutor(max_workers=2) as pool:
        made = {}
        for several in pool.map(make, todo):
            made |= {built.path: built for built in several}
            report(f"built {', '.join(b.path.name for b in several)} in {several[0].seconds:.1f} s")
    return [made.get(path) or Built(name, path, 0.0, True) for name in files for path in files[name].values()]


def export(
    modelica: Path,
    recipe: Recipe,
    files: Mapping[str, Path],
    name: str = "",
    note: Mapping[str, str] | None = None,
) -> None:
    """Export one class as FMUs for Model Exchange and Co-Simulation; files: {FMI version: path}.

    name: of the library; the first file's without one. note: what each file is to remember. Raises ExportError.
    """
    with ONE_AT_A_TIME:
        model = with_inputs(translate(load(modelica, recipe.model), recipe.starts), recipe.inputs)
        contents = write_contents(model, name or library_name(files))
    compile_fmus(contents, files, note)


def library_name(files: Mapping[str, Path]) -> str:
    """The modelIdentifier of an FMU in these files: the first one's stem as a C identifier."""
    return re.sub(r"\W|^(?=\d)", "_", next(iter(files.values())).stem, flags=re.ASCII)


@dataclass(frozen=True)
class Contents:
    """The texts of an FMU: its library's name, C sources and headers by file name; what describes it, by version."""

    name: str
    sources: dict[str, str]
    descriptions: dict[str, dict[str, str]]


def write_contents(model: Model, name: str) -> Contents:
    """C code and descriptions of a sorted model."""
    wrapper = {file.name: file.read_text(encoding="utf-8") for file in sorted(WRAPPER.glob("*.[ch]"))}
    files = [*wrapper, "model.c", "model_counts.h"]
    parts = wrapper | generate(model, "") | {"descriptions": describe(model, name, "", files)}
    guid = guid_of(parts)
    return Contents(name, wrapper | generate(model, guid), describe(model, name, guid, files))


def describe(model: Model, name: str, guid: str, files: list[str]) -> dict[str, dict[str, str]]:
    """{FMI version: {file in the archive: text}}: what says what is in the FMU."""
    sources = {version: [f for f in sources_of(version, files) if f.endswith(".c")] for version in VERSIONS["both"]}
    return {
        "2": {"modelDescription.xml": describe_fmi2(model, name, guid, sources["2"])},
        "3": {
            "modelDescription.xml": describe_fmi3(model, name, guid),
            "sources/buildDescription.xml": describe_build(name, sources["3"]),
        },
    }


def sources_of(version: str, files: list[str]) -> list[str]:
    """The files that an FMU of this version carries: the other version's layer needs headers that importers lack."""
    other = "fmi3_" if version == "2" else "fmi2_"
    return sorted(file for file in files if not file.startswith(other))


def compile_fmus(contents: Contents, files: Mapping[str, Path], note: Mapping[str, str] | None = None) -> None:
    """Compile the sources and write an archive for each version; files: {FMI version: path}."""
    suffix, log = platform("2")[1], next(iter(files.values())).with_name(f"{contents.name}.log")
    library = compile_sources(contents.sources, contents.name + suffix, log)
    for version, path in files.items():
        sources = sources_of(version, list(contents.sources))
        members = {f"sources/{file}": contents.sources[file].encode() for file in sources}
        members |= {file: text.encode() for file, text in contents.descriptions[version].items()}
        members[f"binaries/{platform(version)[0]}/{contents.name}{suffix}"] = library
        write_archive(path, members, note)


def compile_sources(sources: Mapping[str, str], library: str, log: Path) -> bytes:
    """The bytes of the library compiled from these sources."""
    with tempfile.TemporaryDirectory(prefix="fmuid-") as folder:
        paths = [Path(folder) / name for name in sources]
        for path, text in zip(paths, sources.values(), strict=True):
            path.write_text(text, encoding="utf-8")
        log.parent.mkdir(parents=True, exist_ok=True)
        compile_library(paths, Path(folder) / library, log)
        return (Path(folder) / library).read_bytes()


def guid_of(parts: Mapping[str, object]) -> str:
    """A GUID made from content: the same sources give the same."""
    h = hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()
    return f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"
