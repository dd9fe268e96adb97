"""Where things stand: the checkout's rooms, found from this file."""

from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
ROOT = PACKAGE.parent
MODELICA = ROOT / "modelica" / "RobotIdentification"
FMUS = ROOT / "fmus"
REPORTS = ROOT / "reports"
EXPERIMENTS = PACKAGE / "experiments"
