"""The front end's messages in plain words: names with their places and remedies, no jargon."""

import re

import pytest

from pipeline.errors import ExportError
from pipeline.export.frontend import load
from pipeline.export.plain_words import find_name, in_plain_words
from tests.export.language import model_of

JARGON = re.compile("Flat|ToDae|canonical|checked|owner|b1c|lowering")
UNRESOLVED = {
    "a variable": ("Real x;\n// y\nequation\n x = y;", r"y is not declared \(M\.mo:4\): declare it"),
    "a class": ("Real x=time;\nFoo.Bar b;", r"the class Foo\.Bar is not found \(M\.mo:2\): correct its name"),
    "a function": ("Real x=f(time);", r"the function f is not found \(M\.mo:1\)"),
    "the standard library": (
        "Modelica.Blocks.Continuous.Integrator i; equation i.u = 1;",
        r"Modelica\.Blocks\.Continuous\.Integrator is not found \(M\.mo:1\): set MODELICAPATH to the folder",
    ),
    "an element of an array": (
        "function f input Real u; output Real T[2, 2]; algorithm T[1, 1] := u; end f; Real T[2, 2]=f(time);",
        r"the function f does not assign every element of its output T: begin with T := zeros",
    ),
}


@pytest.mark.parametrize("case", UNRESOLVED)
def test_a_name_that_is_not_found_is_told_with_its_place_and_a_remedy(tmp_path, case):
    body, message = UNRESOLVED[case]
    with pytest.raises(ExportError, match=f"M: the Modelica front end refuses it: {message}") as refusal:
        model_of(tmp_path, f"model M {body} end M;")
    assert not JARGON.search(str(refusal.value))


def test_a_place_in_a_package_names_its_file(tmp_path):
    (tmp_path / "P").mkdir()
    (tmp_path / "P" / "package.mo").write_text("package P end P;")
    (tmp_path / "P" / "A.mo").write_text("within P;\nmodel A\n Real x=gain*time;\nend A;")
    with pytest.raises(ExportError, match=r"gain is not declared \(P/A\.mo:3\)"):
        load(tmp_path / "P", "P.A")


def test_what_is_not_known_stays_behind_its_stage():
    assert in_plain_words("todae failed: M failed in ToDae: a novelty `x`", {}) == "a novelty `x`"


def test_names_in_comments_strings_and_longer_names_are_no_places():
    text = '// y\n"y" my ya a.y\n y = 1;'
    assert find_name("y", {"a.mo": text}) == "a.mo:3"
    assert find_name("z", {"a.mo": text}) is None
