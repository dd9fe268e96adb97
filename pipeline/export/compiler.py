"""The C compiler: sources → one shared library, everything hidden that FMI does not name."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from platform import uname

from pipeline.errors import ExportError

# -O3 compiles for half as long again as -O1, and a filter through the FMU runs a tenth faster
FLAGS = ["-O3", "-fPIC", "-shared", "-std=c11", "-ffp-contract=off", "-fvisibility=hidden", "-fno-math-errno"]
PLATFORMS = {"linux": ("linux64", ".so"), "darwin": ("darwin64", ".dylib"), "win32": ("win64", ".dll")}

ARCHITECTURES = {"amd64": "x86_64", "arm64": "aarch64", "i386": "x86", "i686": "x86"}


def find_compiler() -> list[str]:
    """The compiler's command: $CC, else cc, gcc or clang; ExportError without one."""
    chosen = shlex.split(os.environ.get("CC", ""))
    for command in [chosen] if chosen else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(command[0]):
            return command
    tried = f"CC={chosen[0]} is not there" if chosen else "none of cc, gcc, clang is there"
    raise ExportError(f"no C compiler: {tried}; install one (Debian: apt install gcc) or name it in CC")


def describe_compiler() -> str | None:
    """The compiler's command and the first line of its `--version`, for example `gcc -O0: gcc (Debian …) 12.2.0`.

    None where there is no compiler.
    """
    try:
        command = find_compiler()
    except ExportError:
        return None
    try:
        said = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False).stdout
    except OSError:
        said = ""
    return f"{shlex.join(command)}: {said.partition(chr(10))[0]}"


def headers() -> Path:
    """The folder of the FMI headers, which come with fmpy (found without importing it)."""
    spec = find_spec("fmpy")
    if spec is None or spec.origin is None:
        raise ExportError("the FMI headers come with fmpy, which is not installed: pip install fmpy")
    return Path(spec.origin).parent / "c-code"


def platform(fmi: str = "2") -> tuple[str, str]:
    """(folder under binaries/, suffix of a library) of this machine, as FMI 2.0 or 3.0 (3.0.2, 2.5.1.4) names them."""
    folder, suffix = PLATFORMS.get(sys.platform, PLATFORMS["linux"])
    return (folder if fmi == "2" else platform_tuple(), suffix)


def platform_tuple() -> str:
    """Architecture and operating system, for example `x86_64-linux`."""
    machine = uname().machine.lower()
    system = {"darwin": "darwin", "win32": "windows"}.get(sys.platform, "linux")
    return f"{ARCHITECTURES.get(machine, machine)}-{system}"


def compile_library(sources: list[Path], library: Path, log: Path) -> None:
    """Compile C sources into `library`. What the compiler says goes to `log`; ExportError names it when it fails."""
    include = ["-I", str(sources[0].parent), "-I", str(headers())]
    files = [str(unit) for unit in write_units(sources)]
    command = [*find_compiler(), *FLAGS, *include, "-o", str(library), *files, "-lm"]
    log.unlink(missing_ok=True)
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        log.write_text(f"{shlex.join(command)}\n{done.stdout}{done.stderr}")
        raise ExportError(f"{library.stem}: the C compiler failed (exit code {done.returncode}), see {log}")


def write_units(sources: list[Path]) -> list[Path]:
    """Files beside the sources that include them, one for each layer: they compile in three quarters of the time."""
    units: dict[str, list[str]] = {}
    for source in sources:
        if source.suffix == ".c":
            layer = next((layer for layer in ("fmi2", "fmi3") if source.name.startswith(f"{layer}_")), "instance")
            units.setdefault(layer, []).append(f'#include "{source.name}"\n')
    paths = {sources[0].with_name(f"unit_{layer}.c"): lines for layer, lines in units.items()}
    for path, lines in paths.items():
        path.write_text("".join(lines), encoding="utf-8")
    return list(paths)
