"""An FMU on disk, opened: its description, its unpacked folder, its instances. Loading is fmpy's."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
import zipfile
from ctypes import byref, c_double, c_uint
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property, lru_cache
from pathlib import Path
from xml.etree import ElementTree

import fmpy
from fmpy.model_description import ModelDescription, ScalarVariable

from pipeline.errors import ConfigError, FmuError
from pipeline.interrupts import raise_kept
from pipeline.plant.fmi2 import Fmi2
from pipeline.plant.fmi3 import Fmi3
from pipeline.plant.log import close_log, open_log

NOT_FINITE, TERMINATE, CHATTER = 100, 101, 102
"""Statuses of our own, beyond the standard's."""

STATUS = {
    **{i: f"returned {w}" for i, w in enumerate(("OK", "Warning", "Discard", "Error", "Fatal", "Pending"))},
    NOT_FINITE: "gave a value that is not finite",
    TERMINATE: "asked to terminate",
    CHATTER: "did not end after 100 iterations: the model chatters",
}
ITERATIONS = 100
VERSIONS = {"2.0": Fmi2, "3.0": Fmi3}
REAL = ("Real", "Float64")
INTERFACES = {"ME": "ModelExchange", "CS": "CoSimulation"}
UNUSED = ("sources/", "documentation/")  # of an archive: nothing that runs needs them


@dataclass(frozen=True)
class Fmu:
    """An opened FMU: `path`, its `description` (fmpy's), its unpacked `folder` and the archive's `sha256`.

    Use as a context manager: leaving it removes the folder. Opened by `open_fmu`.
    """

    path: Path
    description: ModelDescription
    folder: Path
    sha256: str

    def __enter__(self) -> Fmu:
        return self

    def __exit__(self, *exc) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)

    @property
    def name(self) -> str:
        """The file's name without `.fmu`."""
        return self.path.stem

    @property
    def version(self) -> str:
        """The FMI version: "2.0" or "3.0"."""
        return self.description.fmiVersion[:3]

    def variable(self, name: str) -> ScalarVariable:
        """The variable called `name`; ConfigError with the nearest names where there is none."""
        if name not in self._variables:
            near = get_close_matches(name, self._variables, n=3, cutoff=0.4)
            hint = f"; nearest: {', '.join(near)}" if near else ""
            raise ConfigError(f"{self.path.name}: no variable `{name}`{hint}; correct the name")
        return self._variables[name]

    @cached_property
    def _variables(self) -> dict[str, ScalarVariable]:
        return {v.name: v for v in self.description.modelVariables}

    def reference(self, name: str) -> int:
        """The value reference of the variable called `name`."""
        return self.variable(name).valueReference

    def supports(self, interface: str) -> bool:
        """Whether the FMU offers "ME" (Model Exchange) or "CS" (Co-Simulation)."""
        field = {"ME": "modelExchange", "CS": "coSimulation"}[interface]
        return getattr(self.description, field) is not None

    def directional(self, interface: str) -> bool:
        """Whether the FMU says that it provides directional derivatives by "ME" or "CS".

        Read from the file: fmpy knows the flag by its name of FMI 2.0, and 3.0 has it in the plural.
        """
        root = ElementTree.parse(self.folder / "modelDescription.xml").getroot()
        element = root.find(INTERFACES[interface])
        flags = ("providesDirectionalDerivative", "providesDirectionalDerivatives")
        return element is not None and any(element.get(flag) in ("true", "1") for flag in flags)


def open_fmu(path: str | os.PathLike) -> Fmu:
    """Open the FMU at `path`; FmuError in one line where it is missing, broken or of a version not handled."""
    path = Path(path)
    if not path.is_file():
        raise FmuError(f"{path}: no such FMU; build ours with `fmuid build`, or correct its name")
    try:
        sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
        description = _described(str(path), sha256)
    except zipfile.BadZipFile as error:
        raise FmuError(f"{path}: not a zip archive ({error}); an FMU is one, so get the file again") from error
    except Exception as error:  # fmpy raises bare Exception for whatever a description may hold
        raise FmuError(f"{path}: its model description cannot be read ({_one_line(error)})") from error
    if description.fmiVersion[:3] not in VERSIONS:
        raise FmuError(f"{path}: FMI {description.fmiVersion} is not handled; export the plant as FMI 2.0 or 3.0")
    folder = Path(tempfile.mkdtemp(prefix=f"fmuid-{path.stem}-"))
    try:
        fmpy.extract(str(path), str(folder), lambda name: not name.startswith(UNUSED))
    except Exception as error:
        shutil.rmtree(folder, ignore_errors=True)
        raise FmuError(f"{path}: cannot be unpacked ({_one_line(error)})") from error
    return Fmu(path, description, folder, sha256)


@lru_cache(maxsize=16)
def _described(path: str, sha256: str) -> ModelDescription:
    """The description in the archive at `path`, read once for as long as its content stays the same."""
    return fmpy.read_model_description(path, validate=False)


class Instance:
    """A loaded instance of an FMU; freed at the end of its `with`. Given `start`, it is initialised with it.

    `calls` are the raw calls of its FMI version (they return a status, to be checked with `check`), `log` holds the
    FMU's last messages.
    """

    def __init__(self, file: Fmu, interface: str, start: dict[str, float] | None = None):
        if not file.supports(interface):
            raise FmuError(f"{file.path.name}: offers no {INTERFACES[interface]}; choose the other interface")
        self.file, self.interface = file, interface
        self._name, self.log = open_log(file.name)
        working_directory = os.getcwd()
        try:
            self.calls = VERSIONS[file.version](file.description, interface, str(file.folder), self._name, self.log)
        except Exception as error:  # fmpy: bare Exception for a missing or unloadable library
            os.chdir(working_directory)
            close_log(self._name)
            raise FmuError(f"{file.path.name}: cannot be instantiated ({_one_line(error)})") from error
        if start is not None:
            try:
                self.initialize(start)
            except BaseException:
                self.__exit__()
                raise

    def __enter__(self) -> Instance:
        return self

    def __exit__(self, *exc) -> None:
        self.calls.free()
        close_log(self._name)

    def initialize(self, start: dict[str, float] | None = None, t0: float = 0.0) -> None:
        """Run initialisation at t0 (s) with `start` values by variable name (2.0.5, §3.2.3, §4.2.4; 3.0.2, §2.3.2)."""
        calls, start = self.calls, start or {}
        fed = [name for name in start if self.file.variable(name).causality == "input"]
        self.check(calls.setup(t0), "SetupExperiment", t0)
        self.set({name: value for name, value in start.items() if name not in fed}, t0)
        self.check(calls.enter_initialization(t0), "EnterInitializationMode", t0)
        self.set({name: start[name] for name in fed}, t0)  # no input is set before it (2.0.5, §4.2.4)
        self.check(calls.exit_initialization(), "ExitInitializationMode", t0)
        if self.interface == "ME":
            self.settle(t0)
            self.check(calls.enter_continuous_time_mode(), "EnterContinuousTimeMode", t0)

    def set(self, values: dict[str, float], t: float = 0.0) -> None:
        """Set Real variables by name, one by one, so that a refusal names the variable."""
        for name, value in values.items():
            reference, number = c_uint(self.file.reference(name)), c_double(value)
            status = self.calls.set(*self.calls.values(byref(reference), 1, byref(number)))
            self.check(status, f"{self.calls.set.__name__[4:]} of `{name}`", t)

    def settle(self, t: float) -> None:
        """In Event Mode: iterate until no further discrete state changes (2.0.5, §3.2.2; 3.0.2, §3.2.1)."""
        for _ in range(ITERATIONS):
            status, needed, terminate = self.calls.update_discrete_states()
            self.check(status or TERMINATE * terminate, "the event iteration", t)
            if not needed:
                return
        self.check(CHATTER, "the event iteration", t)

    def check(self, status: int, function: str, t: float) -> None:
        """Raise FmuError unless `status`, of a raw call at time t (s) or one of our own, is OK.

        function: what was called; the name of one of the standard's functions goes without its prefix.
        """
        raise_kept()
        if status != 0:
            word = STATUS.get(status, f"returned an illegal status {status}")
            function = f"{self.calls.prefix}{function}" if function[0].isupper() else function
            raise FmuError(f"{self.file.path.name}: {function} at t = {t:g} s {word}{self.last_message()}")

    def last_message(self) -> str:
        """The FMU's last log message in brackets, or ""."""
        return f" ({self.log[-1]})" if self.log else ""


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:300] or type(error).__name__
