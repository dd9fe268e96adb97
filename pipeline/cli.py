"""The console command `fmuid`. Results go to stdout, narration to stderr; heavy imports stay inside the commands."""

from __future__ import annotations

import argparse
import atexit
import gc
import json
import os
import sys

from pipeline.arguments import parser
from pipeline.errors import ConfigError, DataError, FmuidError
from pipeline.interrupts import install


def main(argv: list[str] | None = None) -> int:
    """Run `fmuid`; returns the exit code. Every error a user can meet is one line on stderr."""
    for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(threads, "1")  # the matrices are small: threads only spin, and spoil CPU times
    gc.set_threshold(100_000)  # what is imported stays: looked through for cycles time and again it costs 0.3 s
    atexit.register(gc.freeze)  # … and once more at the end
    arguments = parser().parse_args(argv)
    command = _plan if vars(arguments).get("dry_run") else COMMANDS[arguments.command]
    install()
    try:
        code = command(arguments)
        if sys.stdout is not None:
            sys.stdout.flush()
        return code
    except FmuidError as error:
        print(f"fmuid: {error}", file=sys.stderr)
        return error.exit_code
    except SystemExit:
        print("fmuid: terminated", file=sys.stderr)
        raise
    except KeyboardInterrupt:
        print("fmuid: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader has seen enough (| head); nothing more may be flushed at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        print(
            f"fmuid: {error.filename or 'output'}: {error.strerror or error}; check permissions and room",
            file=sys.stderr,
        )
        return 2


def _session(arguments: argparse.Namespace, narrate=None):
    from pipeline.workflow.session import open_session

    given = vars(arguments)
    overrides = list(arguments.set)
    if arguments.seed is not None:
        overrides.append(f"seed={arguments.seed}")
    if given.get("jacobian") is not None:
        overrides.append(f'ekf.jacobian="{arguments.jacobian}"')
    if arguments.engine is not None:
        overrides.append(f"engine='{arguments.engine}'")
    if arguments.fmi is not None:
        overrides.append(f"fmi='{arguments.fmi}'")
    simulated, data = given.get("simulated", False), given.get("data")
    return open_session(arguments.experiment, overrides, narrate or _narrate, simulated, data)


def _narrate(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _build(arguments: argparse.Namespace) -> int:
    built = _build_foreign(arguments) if arguments.modelica or arguments.model else _build_own(arguments)
    if arguments.json:
        print(
            json.dumps(
                [{"name": b.name, "path": str(b.path), "seconds": b.seconds, "skipped": b.skipped} for b in built]
            )
        )
    else:
        for b in built:
            print(f"{b.path}  {'up to date' if b.skipped else f'built in {b.seconds:.1f} s'}")
    return 0


def _build_own(arguments: argparse.Namespace) -> list:
    from pipeline.export.build import build
    from pipeline.paths import FMUS
    from pipeline.plant.binding import gains_of_bindings, variants_of_bindings

    if arguments.output:
        raise ConfigError("--output names the FMU of one --model: give that too")
    options = {"fmi": arguments.fmi, "force": arguments.force, "report": _narrate, "variants": variants_of_bindings()}
    return build(arguments.names or None, FMUS, gains_of_bindings(), **options)


def _build_foreign(arguments: argparse.Namespace) -> list:
    from pathlib import Path

    from pipeline.export.foreign import build_foreign
    from pipeline.paths import MODELICA

    if arguments.names:
        raise ConfigError(f"{' '.join(arguments.names)}: with --modelica give the class by --model")
    modelica = Path(arguments.modelica) if arguments.modelica else MODELICA
    output = Path(arguments.output) if arguments.output else None
    return build_foreign(modelica, arguments.model, output, arguments.fmi)


def _simulate(arguments: argparse.Namespace) -> int:
    from pipeline.simulate.writing import check_output, write_frame
    from pipeline.workflow.acquire import acquire, frame_units
    from pipeline.workflow.building import prepare

    check_output(arguments.output)
    session = _session(arguments)
    prepare(session, (arguments.validation,))
    frame = acquire(session, validation=arguments.validation)
    if arguments.output or not arguments.json:
        write_frame(frame, frame_units(session.binding), arguments.output or sys.stdout)
    if arguments.json:
        print(json.dumps({"time": list(frame.index), **{c: list(frame[c]) for c in frame}}))
    return 0


def _identify(arguments: argparse.Namespace) -> int:
    session = _session(arguments)
    from pipeline.report.console import estimates_text
    from pipeline.report.record import plain
    from pipeline.workflow.run import identify

    record, _ = identify(session)
    record = plain(record)
    print(json.dumps(record["estimates"]) if arguments.json else estimates_text(record))
    _tell_errors(record)
    failed = [item["name"] for item in record["verdict"]["items"] if item["status"] == "fail"]
    if failed:
        _narrate(f"fmuid: verdict FAIL: {', '.join(failed)}; `fmuid run` shows the limits")
    return exit_code(record)


def _run(arguments: argparse.Namespace) -> int:
    session = _session(arguments)  # first of all: a mistake is answered before the slow imports
    from pipeline.report.console import verdict_text
    from pipeline.workflow.run import run

    folder, record = run(session, arguments.output)
    page = folder / "index.html"
    if arguments.json:
        print(json.dumps({"report": str(page), "record": str(folder / "result.json"), "verdict": record["verdict"]}))
    else:
        print(verdict_text(record))
        print(page)
    _tell_errors(record)
    return exit_code(record)


def _tell_errors(record: dict) -> None:
    for error in record["errors"]:
        _narrate(f"fmuid: {error['stage']}: {error['message']}")


def exit_code(record: dict) -> int:
    """0 for pass or warn, 1 for fail; a failed stage gives its own code."""
    if record["errors"]:
        return record["errors"][0]["exit_code"]
    return 1 if record["verdict"]["status"] == "fail" else 0


def _excite(arguments: argparse.Namespace) -> int:
    from pipeline.report.console import Progress, design_text
    from pipeline.simulate.trajectory import waypoints_text
    from pipeline.workflow.excitation_settings import check_output
    from pipeline.workflow.exciting import entry, excite

    progress = Progress(sys.stderr)
    check_output(arguments.output)
    session = _session(arguments, progress.narrate)
    design = excite(session, arguments.validation, progress)
    found = {"seed": session.experiment.seed, **entry(design)}
    progress.narrate(design_text(found))
    written = arguments.output and _written(arguments.output, design.waypoints)
    shown = arguments.output if written else waypoints_text(design.waypoints)
    print(json.dumps({**found, "trajectory": shown}) if arguments.json else shown.rstrip())
    if arguments.output and not written:
        return 2
    return 130 if design.interrupted else 0


def _written(output: str, waypoints) -> bool:
    """Whether a design could be written; else its place is stdout, and this is said."""
    from pipeline.simulate.trajectory import write_waypoints

    try:
        write_waypoints(output, waypoints)
    except OSError as error:
        _narrate(f"fmuid: {output}: cannot be written ({error.strerror or error}); the design goes to stdout instead")
        return False
    return True


def _report(arguments: argparse.Namespace) -> int:
    from pathlib import Path

    from pipeline.paths import REPORTS
    from pipeline.report.page import write_page

    folder = Path(arguments.run) if Path(arguments.run).is_dir() else REPORTS / arguments.run
    try:
        page = write_page(folder)
    except FmuidError:
        raise
    except (LookupError, TypeError, AttributeError, ValueError) as error:  # a record that another hand has changed
        raise DataError(f"run {folder}: its record is damaged ({error!r:.120}); run the experiment again") from error
    print(json.dumps({"report": str(page)}) if arguments.json else page)
    return 0


def _plan(arguments: argparse.Namespace) -> int:
    from pipeline.workflow.plan import plan, plan_text

    found = plan(_session(arguments), arguments.command, arguments.output if "output" in arguments else None)
    print(json.dumps(found) if arguments.json else plan_text(found))
    return 0


COMMANDS = {
    "build": _build,
    "simulate": _simulate,
    "identify": _identify,
    "run": _run,
    "excite": _excite,
    "report": _report,
}

if __name__ == "__main__":
    sys.exit(main())
