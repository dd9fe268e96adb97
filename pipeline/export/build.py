"""Building FMUs: every class listed in the package's FMUs/package.order, each a file in snake_case."""

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

from pipeline import __version__
from pipeline.errors import ExportError
from pipeline.export.archive import write_archive
from pipeline.export.codegen import generate, identifier
from pipeline.export.compiler import compile_library, describe_compiler, find_compiler, platform
from pipeline.export.equations import Model, translate
from pipeline.export.frontend import load
from pipeline.export.model_description import describe
from pipeline.paths import MODELICA

HERE = Path(__file__).resolve().parent
WRAPPER = HERE / "wrapper"
EXPORTER = [*sorted(HERE.glob("*.py")), HERE.parent / "units.py", *sorted(WRAPPER.glob("*.[ch]"))]
RECORD = ".build.json"
ONE_AT_A_TIME = Lock()  # CasADi's expressions count their references without locks; the compilers run side by side


@dataclass(frozen=True)
class Built:
    """One FMU: its name, its file, the seconds it took, and whether it was up to date already."""

    name: str
    path: Path
    seconds: float
    skipped: bool


def exported(modelica: Path) -> dict[str, str]:
    """FMU name → class, for every class of FMUs/package.order."""
    order = modelica / "FMUs" / "package.order"
    if not order.is_file():
        raise ExportError(f"{modelica}: no FMUs/package.order, which lists the classes to export")
    classes = order.read_text().split()
    return {identifier(leaf): f"{modelica.name}.FMUs.{leaf}" for leaf in classes}


def build(
    names: Sequence[str] | None,
    out: Path,
    start_values: Mapping[str, Mapping[str, float]] | None = None,
    fmi: str = "2",
    force: bool = False,
    modelica: Path = MODELICA,
    report: Callable[[str], None] = lambda line: None,
) -> list[Built]:
    """Build the FMUs `names` (None: all) into `out`; those whose inputs have not changed are left alone.

    start_values: {FMU name: {parameter: value}} replace bindings of the Modelica text; the FMU must have the parameter.
    Raises ExportError.
    """
    if fmi != "2":
        raise ExportError(f"FMI version {fmi}: only FMI 2 can be built")
    classes = exported(modelica)
    unknown = sorted(set(names or ()) - set(classes))
    if unknown:
        raise ExportError(f"no FMU {', '.join(unknown)}: there are {', '.join(classes)}")
    record = read_record(out / RECORD)
    starts = {name: dict((start_values or {}).get(name, {})) for name in names or classes}
    compiler = describe_compiler()
    inputs = {name: fingerprint(modelica, starts[name]) for name in starts}
    todo = [name for name in inputs if force or not up_to_date(out, name, inputs[name], compiler, record)]
    if todo:
        find_compiler()

    def make(name: str) -> Built:
        started = time.perf_counter()
        path = export(modelica, classes[name], out / f"{name}.fmu", starts[name])
        return Built(name, path, time.perf_counter() - started, False)

    with ThreadPoolExecutor(max_workers=2) as pool:
        made = {}
        for built in pool.map(make, todo):
            made[built.name] = built
            known = {"inputs": inputs[built.name], "compiler": compiler, "sha256": digest(built.path)}
            record[built.name] = known
            write_record(out / RECORD, record)
            report(f"built {built.path.name} in {built.seconds:.1f} s")
    return [made.get(name) or Built(name, out / f"{name}.fmu", 0.0, True) for name in inputs]


def export(modelica: Path, model: str, path: Path, starts: Mapping[str, float] | None = None) -> Path:
    """Export one class as an FMU (FMI 2.0, Model Exchange and Co-Simulation), named after the file."""
    with ONE_AT_A_TIME:
        contents = write_contents(translate(load(modelica, model), starts), library_name(path))
    return pack(contents, path)


def write_fmu(model: Model, path: Path) -> Path:
    """The FMU of a sorted model."""
    return pack(write_contents(model, library_name(path)), path)


def library_name(path: Path) -> str:
    """The modelIdentifier of an FMU in this file: its stem as a C identifier."""
    return re.sub(r"\W|^(?=\d)", "_", path.stem, flags=re.ASCII)


@dataclass(frozen=True)
class Contents:
    """The texts of an FMU: its C sources and headers by file name, its model description."""

    sources: dict[str, str]
    description: str


def write_contents(model: Model, name: str) -> Contents:
    """C code and model description of a sorted model."""
    wrapper = {file.name: file.read_text(encoding="utf-8") for file in sorted(WRAPPER.glob("*.[ch]"))}
    compiled = sorted(file for file in [*wrapper, "model.c"] if file.endswith(".c"))
    guid = guid_of(wrapper | generate(model, "") | {"description": describe(model, name, "", compiled)})
    return Contents(wrapper | generate(model, guid), describe(model, name, guid, compiled))


def pack(contents: Contents, path: Path) -> Path:
    """Compile the sources and write the archive."""
    folder, suffix = platform()
    library = library_name(path) + suffix
    files = {f"sources/{file}": text.encode() for file, text in contents.sources.items()}
    files["modelDescription.xml"] = contents.description.encode()
    files[f"binaries/{folder}/{library}"] = compile_sources(contents.sources, library, path.with_suffix(".log"))
    write_archive(path, files)
    return path


def compile_sources(sources: Mapping[str, str], library: str, log: Path) -> bytes:
    """The bytes of the library compiled from these sources."""
    with tempfile.TemporaryDirectory(prefix="fmuid-") as folder:
        paths = [Path(folder) / name for name in sources]
        for path, text in zip(paths, sources.values(), strict=True):
            path.write_text(text, encoding="utf-8")
        log.parent.mkdir(parents=True, exist_ok=True)
        compile_library(paths, Path(folder) / library, log)
        return (Path(folder) / library).read_bytes()


def guid_of(parts: Mapping[str, str]) -> str:
    """A GUID made from content: the same sources give the same."""
    h = hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()
    return f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"


def fingerprint(modelica: Path, starts: Mapping[str, float]) -> str:
    """A hash of all an FMU is made from but the compiler: sources of model and exporter, start values, versions."""
    from importlib.metadata import version

    h = hashlib.sha256()
    for root, files in ((modelica, sorted(modelica.rglob("*.mo"))), (HERE.parent, EXPORTER)):
        for file in files:
            h.update(file.relative_to(root).as_posix().encode())
            h.update(file.read_bytes())
    tools = {tool: version(tool) for tool in ("rumoca", "casadi", "fmpy")}
    h.update(json.dumps([starts, tools, __version__, platform()], sort_keys=True).encode())
    return h.hexdigest()


def up_to_date(out: Path, name: str, inputs: str, compiler: str | None, record: Mapping[str, dict]) -> bool:
    """The FMU is there, made from these inputs, and nobody has changed it since.

    It was made by this compiler, too; a machine without one (None) takes the FMU as it is.
    """
    path, known = out / f"{name}.fmu", record.get(name, {})
    if compiler is not None and known.get("compiler") != compiler:
        return False
    return known.get("inputs") == inputs and path.is_file() and known.get("sha256") == digest(path)


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def read_record(path: Path) -> dict[str, dict]:
    """What was built from what; empty where nothing is known."""
    try:
        return json.loads(path.read_text())
    except (FileNotFoundError, json.JSONDecodeError):
        return {}


def write_record(path: Path, record: Mapping[str, dict]) -> None:
    """Write the record beside the FMUs."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(record, indent=2, sort_keys=True) + "\n")
