"""The modifiers that the front end loses are found; the others are let through."""

from pipeline.export.redeclare import lost_modifiers

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


def places(model):
    return list(lost_modifiers(model, {1: ("P.mo", PACKAGE)}))


def test_a_redeclaration_in_a_modification_is_found():
    assert places("P.Lost") == [("P.mo", 13)]


def test_it_is_found_in_the_classes_of_components():
    assert places("P.Deep") == [("P.mo", 19)]


def test_what_is_kept_is_let_through():
    assert places("P.Kept") == [] and places("P.G") == []
