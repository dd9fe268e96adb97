"""Classes are found in Modelica texts without a parser."""

from pipeline.export.classes import find_models, hide

TEXT = """within Lib.Sub;
package P "model Hidden end Hidden;"
  // model Commented end Commented;
  partial model Base
  end Base;
  model A
    block Inside
    end Inside;
  end A;
  package Q
    block B
    end B;
  end Q;
  function f
  end f;
  model Short = A;
end P;
"""


def test_the_models_of_a_file_have_their_full_names():
    assert find_models({"P.mo": TEXT}) == ["Lib.Sub.P.A", "Lib.Sub.P.Q.B"]


def test_a_model_without_a_package():
    assert find_models({"M.mo": "model M\nend M;", "N.mo": "within ;\nblock N\nend N;"}) == ["M", "N"]


def test_hidden_text_keeps_its_length_and_lines():
    assert hide('a /* b\nc */ "d" // e') == "a     \n         " + " " * 4
