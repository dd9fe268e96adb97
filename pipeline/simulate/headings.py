"""Headings of a table: `angle [deg]` and `angle (deg)` name a column and its unit."""

from __future__ import annotations

import re

from pipeline.errors import ConfigError
from pipeline.units import parse

BRACKETS = re.compile(r"(.*\S)\s*\[([^\[\]]+)\]")
PARENTHESES = re.compile(r"(.*\S)\s*\(([^()]+)\)")
INDEX = re.compile(r"[\d\s,:+-]*")


def split_heading(heading: str) -> tuple[str, str]:
    """(name, unit) of a heading; without a unit ("") the name is the whole heading.

    Brackets hold a unit unless they hold an index (`q[1]`); parentheses may hold anything, and count as a unit only
    where they are one (`angle (deg)`, not `angle (filtered)`).
    """
    heading = " ".join(heading.split())
    match = BRACKETS.fullmatch(heading)
    if match and not INDEX.fullmatch(match[2]):
        return match[1], match[2].strip()
    match = PARENTHESES.fullmatch(heading)
    if match and not INDEX.fullmatch(match[2]) and is_unit(match[2]):
        return match[1], match[2].strip()
    return heading, ""


def is_unit(text: str) -> bool:
    """Whether a text is a unit that we know."""
    try:
        parse(text)
    except ConfigError:
        return False
    return True
