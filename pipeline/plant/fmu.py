"""An FMU on disk, opened: its description, its unpacked folder, its instances. Loading is fmpy's."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
import zipfile
from ctypes import CDLL
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.model_description import ModelDescription, ScalarVariable

from pipeline.errors import FmuError
from pipeline.plant.log import callbacks, close_log, open_log

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
INTERFACES = {"ME": "ModelExchange", "CS": "CoSimulation"}


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

    def variable(self, name: str) -> ScalarVariable:
        """The variable called `name`; FmuError with the nearest names where there is none."""
        table = {v.name: v for v in self.description.modelVariables}
        if name not in table:
            near = get_close_matches(name, table, n=3, cutoff=0.4)
            hint = f"; nearest: {', '.join(near)}" if near else ""
            raise FmuError(f"{self.path.name}: no variable `{name}`{hint}; correct the name in the binding")
        return table[name]

    def reference(self, name: str) -> int:
        """The value reference of the variable called `name`."""
        return self.variable(name).valueReference

    def supports(self, interface: str) -> bool:
        """Whether the FMU offers "ME" (Model Exchange) or "CS" (Co-Simulation)."""
        field = {"ME": "modelExchange", "CS": "coSimulation"}[interface]
        return getattr(self.description, field) is not None


def open_fmu(path: str | os.PathLike) -> Fmu:
    """Open the FMU at `path`; FmuError in one line where it is missing, broken or of a version not handled."""
    path = Path(path)
    if not path.is_file():
        raise FmuError(f"{path}: no such FMU; build ours with `fmuid build`, or correct its name")
    try:
        description = fmpy.read_model_description(str(path), validate=False)
    except zipfile.BadZipFile as error:
        raise FmuError(f"{path}: not a zip archive ({error}); an FMU is one, so get the file again") from error
    except Exception as error:  # fmpy raises bare Exception for whatever a description may hold
        raise FmuError(f"{path}: its model description cannot be read ({_one_line(error)})") from error
    if description.fmiVersion != "2.0":
        raise FmuError(f"{path}: FMI {description.fmiVersion} is not handled yet; export the plant as FMI 2.0")
    folder = Path(tempfile.mkdtemp(prefix=f"fmuid-{path.stem}-"))
    try:
        fmpy.extract(str(path), str(folder))
    except Exception as error:
        shutil.rmtree(folder, ignore_errors=True)
        raise FmuError(f"{path}: cannot be unpacked ({_one_line(error)})") from error
    return Fmu(path, description, folder, hashlib.sha256(path.read_bytes()).hexdigest())


class Instance:
    """A loaded instance of an FMI 2.0 FMU; freed at the end of its `with`. Given `start`, it is initialised with it.

    `fmu` is fmpy's object (its methods raise), `dll` the shared library for calls in a hot loop (they return a
    status, to be checked with `check`), `component` the instance's pointer, `log` the FMU's last messages.
    """

    def __init__(self, file: Fmu, interface: str, start: dict[str, float] | None = None):
        if not file.supports(interface):
            raise FmuError(f"{file.path.name}: offers no {INTERFACES[interface]}; choose the other interface")
        self.file, self.interface = file, interface
        self._name, self.log = open_log(file.name)
        working_directory = os.getcwd()
        kind, offered = {
            "ME": (FMU2Model, file.description.modelExchange),
            "CS": (FMU2Slave, file.description.coSimulation),
        }[interface]
        try:
            self.fmu: FMU2Model | FMU2Slave = kind(
                guid=file.description.guid,
                modelIdentifier=offered.modelIdentifier,
                unzipDirectory=str(file.folder),
                instanceName=self._name,
            )
            self.fmu.instantiate(callbacks=callbacks)
        except Exception as error:  # fmpy: bare Exception for a missing or unloadable library
            os.chdir(working_directory)
            close_log(self._name)
            raise FmuError(f"{file.path.name}: cannot be instantiated ({_one_line(error)})") from error
        self.dll: CDLL = self.fmu.dll
        self.component = self.fmu.component
        if start is not None:
            try:
                self.initialize(start)
            except FmuError:
                self.__exit__()
                raise

    def __enter__(self) -> Instance:
        return self

    def __exit__(self, *exc) -> None:
        self.fmu.freeInstance()
        close_log(self._name)

    def initialize(self, start: dict[str, float] | None = None, t0: float = 0.0) -> None:
        """Run initialisation at t0 (s) with `start` values by variable name (FMI 2.0.5, §3.2.3, §4.2.4)."""
        self.call("setupExperiment", startTime=t0)
        for name, value in (start or {}).items():
            self.call("setReal", [self.file.reference(name)], [value])
        self.call("enterInitializationMode")
        self.call("exitInitializationMode")
        if self.interface == "ME":
            self.settle()
            self.call("enterContinuousTimeMode")

    def settle(self) -> None:
        """In Event Mode: iterate newDiscreteStates until none is needed (FMI 2.0.5, §3.2.2)."""
        for _ in range(100):
            needed, terminate, *_ = self.call("newDiscreteStates")
            if terminate:
                raise FmuError(f"{self.file.path.name}: asks to terminate in Event Mode{self.last_message()}")
            if not needed:
                return
        raise FmuError(f"{self.file.path.name}: 100 event iterations without an end; the model chatters")

    def call(self, method: str, *args, **kwargs):
        """Call a method of fmpy's object; its exception becomes an FmuError that names the FMU and the call."""
        try:
            return getattr(self.fmu, method)(*args, **kwargs)
        except FMICallException as error:
            raise FmuError(f"{self.file.path.name}: {_one_line(error)}{self.last_message()}") from error

    def check(self, status: int, function: str, t: float) -> None:
        """Raise FmuError unless `status`, the maximum over one or more raw calls at time t (s), is OK."""
        if status != 0:
            word = STATUS[status] if 0 <= status < len(STATUS) else f"an illegal status {status}"
            raise FmuError(f"{self.file.path.name}: {function} at t = {t:g} s returned {word}{self.last_message()}")

    def last_message(self) -> str:
        """The FMU's last log message in brackets, or ""."""
        return f" ({self.log[-1]})" if self.log else ""


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:300] or type(error).__name__
