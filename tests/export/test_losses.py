"""What the front end loses is found in the text; the rest is let through."""

import pytest

from pipeline.export.losses import find_losses

PACKAGE = """package P
  model F1
    parameter Real c=1;
  end F1;
  model F2
    extends F1;
  end F2;
  model G
    replaceable model F = F1;
    F f;
  end G;
  model Lost
    extends G(redeclare model F = F2(c=5));
  end Lost;
  model Deep
    Middle middle;
  end Deep;
  model Middle
    G g(a=1, redeclare replaceable model F = P.F2(c=5));
  end Middle;
  model Kept "redeclare model F = F2(c=5)" // (redeclare model F = F2(c=5))
    extends G;
    redeclare model F = F2(c=5);
    G g(redeclare model F = F2, f(c=5));
  end Kept;
end P;
"""


def places(model, text=PACKAGE):
    return [(name, line) for _, name, line in find_losses(model, {1: ("P.mo", text)})]


def test_a_redeclaration_in_a_modification_is_found():
    assert places("P.Lost") == [("P.mo", 13)]


def test_it_is_found_in_the_classes_of_components():
    assert places("P.Deep") == [("P.mo", 19)]


def test_what_is_kept_is_let_through():
    assert places("P.Kept") == [] and places("P.G") == []


LOST = (
    'G g(redeclare Real y(unit="m") = 2*time);',
    "extends G(redeclare parameter Real k[2] = {1, 2});",
    "B b(g(redeclare F2 f));",
    "B b(g(redeclare model F = F2));",
    "replaceable F1 f constrainedby P.F1(c=3);",
    "B b(g.c=5);",
    "B b(a=1, each final g . f(c=5));",
    "Real x[2, 3] = {i*j for j in 1:3, i in 1:2};",
    "model V = F1[3];",
)
KEPT = (
    "G g(redeclare F2 f(c=5), redeclare F2 h[2](each c=5));",
    "redeclare Real y = 2*time;",
    "redeclare F2 f(c=5);",
    "replaceable F1 f constrainedby P.F1;",
    "B b(g(c=5)); Real y = max(g.c, P.f(time)); Boolean c = (g.c == 5);",
    "Real x[2]; equation for i in 1:2, j in 1:2 loop x[i] = j; end for;",
    "type V = Real[3];",
    "annotation(choices(choice(redeclare F2 f=2, g.c=3)));",
)


@pytest.mark.parametrize("line", LOST)
def test_what_is_lost_is_found(line):
    assert places("M", f"model M\n\n{line}\nend M;") == [("P.mo", 3)]


@pytest.mark.parametrize("line", KEPT)
def test_what_is_not_lost_is_let_through(line):
    assert places("M", f"model M\n\n{line}\nend M;") == []
