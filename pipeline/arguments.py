"""The command line of `fmuid`: its commands and their options. Nothing heavy is imported here."""

from __future__ import annotations

import argparse

from pipeline import __version__

EXIT_CODES = (
    "exit codes: 0 pass, 1 a limit of the verdict is violated, 2 usage, configuration or data, "
    "3 FMU or simulation, 4 identification"
)


def parser() -> argparse.ArgumentParser:
    """The parser; `command` of what it returns names the command."""
    parser = argparse.ArgumentParser(
        prog="fmuid",
        description="Identify a robot's parameters by weighted least squares and by an EKF that calls the plant FMU.",
        epilog=EXIT_CODES,
    )
    parser.add_argument("--version", action="version", version=f"fmuid {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND", dest="command")

    build = commands.add_parser("build", help="export the FMUs from the Modelica sources", epilog=EXIT_CODES)
    build.add_argument(
        "names", nargs="*", metavar="NAME", help="FMUs to build, for example scara (default: all but chains)"
    )
    build.add_argument("--fmi", choices=("2", "3", "both"), default="both", help="FMI version (default: both)")
    build.add_argument("--force", action="store_true", help="build even what is up to date")
    build.add_argument("--json", action="store_true", help="print the result as JSON")
    build.add_argument("--modelica", metavar="DIR", help="other sources: the folder of a package, or a .mo file")
    build.add_argument("--model", metavar="PKG.MODEL", help="the one class to export, by its full name")
    build.add_argument("--output", metavar="FILE", help="the FMU of --model (default: <model_in_snake_case>.fmu here)")

    simulate = _experiment_command(commands, "simulate", "simulate the closed loop and write the measured frame")
    simulate.add_argument("--validation", action="store_true", help="the validation trajectory instead")
    simulate.add_argument("--output", metavar="FILE", help="write there, .csv or .parquet (default: CSV on stdout)")

    _experiment_command(commands, "identify", "identify, and print the estimates without a report")

    run = _experiment_command(commands, "run", "run the whole experiment and write its report")
    run.add_argument("--output", metavar="DIR", help="folder of the run (default: reports/<run-id>)")

    excite = commands.add_parser(
        "excite", help="design the trajectory that excites the plant best, as CSV", epilog=EXIT_CODES
    )
    _common(excite, seed="seed of the random starts")
    excite.add_argument("--validation", action="store_true", help="the validation trajectory instead")
    excite.add_argument("--output", metavar="FILE", help="write there (default: stdout)")

    report = commands.add_parser("report", help="rebuild a run's page from its record alone", epilog=EXIT_CODES)
    report.add_argument("run", metavar="RUN", help="the run's folder, or its name in reports/")
    report.add_argument("--json", action="store_true", help="print the result as JSON")
    return parser


def _experiment_command(commands, name: str, help_text: str) -> argparse.ArgumentParser:
    command = commands.add_parser(name, help=help_text, epilog=EXIT_CODES)
    _common(command, seed="seed of the noise")
    command.add_argument("--data", metavar="PATH", help="folder of the measured data")
    command.add_argument(
        "--simulated", action="store_true", help="simulated data, where the experiment has measured ones"
    )
    command.add_argument(
        "--jacobian", choices=("forward", "central", "directional"), help="how the EKF differentiates the plant"
    )
    return command


def _common(command: argparse.ArgumentParser, seed: str) -> None:
    command.add_argument("experiment", metavar="EXPERIMENT", help="scara, emps, or a path to a .toml file")
    command.add_argument("--fmi", choices=("2", "3"), help="FMI version of our FMUs to run on (default: 2)")
    command.add_argument("--seed", type=int, help=seed)
    command.add_argument(
        "--engine", choices=("compiled", "python", "filterpy"), help="what computes (default: compiled)"
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="override a setting, e.g. ekf.substeps=8"
    )
    command.add_argument(
        "--dry-run", action="store_true", help="run nothing: print the whole configuration, and what would run"
    )
    command.add_argument("--json", action="store_true", help="print the result as JSON")
