"""Variants: parameters as continuous inputs; the plain FMU's numbers, derivatives by parameters at any time."""

import numpy as np
import pytest

from pipeline.errors import ExportError
from pipeline.export.build import build
from pipeline.export.variants import with_inputs
from pipeline.plant.binding import variants_of_bindings
from tests.export.driver import Archive
from tests.export.language import model_of, write_fmu
from tests.export.test_build import package  # noqa: F401
from tests.export.test_derivatives import EVERYTHING, check, jacobian, relative_error
from tests.export.test_fmus_states import DRIVEN, NEW, OLD, STARTS, inputs

VARIANTS = variants_of_bindings()
VERSIONS = ("", "_fmi3")
MODES = ("initialization", "event", "continuous", "step")


def test_the_variants_are_those_of_the_bindings():
    assert {name: base for name, (base, _) in VARIANTS.items()} == {"scara_inputs": "scara", "emps_inputs": "emps"}


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", VARIANTS)
def test_the_parameters_are_continuous_inputs_that_start_at_their_values_and_nothing_else_is_new(
    archives, name, version
):
    base, parameters = VARIANTS[name]
    plain, variant = ({v.name: v for v in archives(n + version).description.modelVariables} for n in (base, name))
    assert set(plain) == set(variant)
    for parameter in parameters:
        before, now = plain[parameter], variant[parameter]
        assert (now.causality, now.variability) == ("input", "continuous")
        assert (now.start, now.unit, now.description) == (before.start, before.unit, before.description)
    others = {
        n for n, v in variant.items() if (v.causality, v.variability) != (plain[n].causality, plain[n].variability)
    }
    followers = {n for n in others - set(parameters) if plain[n].causality == "calculatedParameter"}
    assert others == followers | set(parameters)
    assert archives(name + version).states == archives(base + version).states


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", VARIANTS)
def test_derivatives_and_directional_ones_are_the_plain_plants_to_the_last_bit(archives, name, version):
    base, parameters = VARIANTS[name]
    plain, variant = archives(base + version), archives(name + version)
    known = [*DRIVEN[base][0], *plain.states]
    rng = np.random.default_rng(5)
    with plain.model_exchange() as one, variant.model_exchange() as other:
        for k in range(50):
            values = {n: OLD[base][n] * rng.uniform(0.7, 1.4) for n in parameters}
            one.event(**values)
            other.set(**values)
            for instance in (one, other):
                instance.set(**inputs(base, k))
            x = rng.normal(size=len(plain.states))
            assert one.rhs(0.0, x).tobytes() == other.rhs(0.0, x).tobytes()
            matrices = [jacobian(instance, plain.derivatives, known).tobytes() for instance in (one, other)]
            assert matrices[0] == matrices[1]


@pytest.mark.parametrize("name", VARIANTS)
def test_co_simulation_is_the_plain_plants_to_the_last_bit(archives, name):
    base, parameters = VARIANTS[name]
    values, runs = {n: NEW[base][n] for n in parameters}, []
    for archive in (archives(base), archives(name)):
        with archive.co_simulation(**values) as instance:
            rows = []
            for k in range(40):
                instance.set(**inputs(base, k))
                instance.step(0.01 * k, 0.01)
                rows.append(instance.get(*DRIVEN[base][1]))
            runs.append(np.array(rows))
    assert np.ptp(runs[0], axis=0).min() > 0 and runs[0].tobytes() == runs[1].tobytes()


@pytest.mark.parametrize("name", VARIANTS)
def test_derivatives_by_parameters_are_those_that_the_plain_plant_gives_in_its_initialisation(archives, name):
    base, parameters = VARIANTS[name]
    plain, variant = archives(base), archives(name)
    values = inputs(base, 3) | dict(zip(STARTS[base], (0.3, 0.2, 0.5, -0.7), strict=False))
    with plain.initialization_mode(**values) as one, variant.model_exchange(**values) as other:
        expected = jacobian(one, plain.derivatives, parameters)
        found = jacobian(other, plain.derivatives, parameters)
    assert expected.any() and relative_error(found, expected) < 1e-13


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("version", ["2", "3"])
def test_what_is_calculated_or_starts_from_such_a_parameter_follows_the_input(tmp_path, version, mode):
    model = with_inputs(model_of(tmp_path, EVERYTHING), ["k", "x_start", "level"])
    archive = Archive(write_fmu(model, tmp_path / "M.fmu", version), tmp_path / "unpacked")
    kinds = {v.name: v.causality for v in archive.description.modelVariables}
    assert (kinds["k"], kinds["w2"], kinds["w3"], kinds["m"]) == ("input", "local", "local", "parameter")
    with archive.initialization_mode(k=60.0, x_start=0.75) as instance:
        assert instance.get("w2", "x") == pytest.approx([30.0, 1.5 - 3.0])
    with archive.model_exchange(k=60.0) as instance:
        instance.set(k=80.0)
        assert instance.get("w2", "w3") == pytest.approx([40.0, 40.0 * np.sqrt(80.0)])
    assert check(archive, mode).any()


def test_a_time_event_that_follows_from_such_a_parameter_follows_the_input(tmp_path):
    text = """model M parameter Real T=0.4; parameter Real half=T/2; Real x(start=0, fixed=true);
      equation der(x) = if time >= half then 1 else 0; end M;"""
    archive = Archive(
        write_fmu(with_inputs(model_of(tmp_path, text), ["T"]), tmp_path / "M.fmu"), tmp_path / "unpacked"
    )
    with archive.model_exchange() as instance:
        assert instance.next_event == pytest.approx(0.2)
        assert instance.event(T=1.0) == pytest.approx(0.5)
    with archive.co_simulation(T=1.0) as instance:
        instance.step(0.0, 0.8)
        assert instance.get("x") == pytest.approx([0.3], abs=1e-12)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mass", "mass is no parameter that could become an input; there are m, T"),
        ("internalStep", "internalStep is no parameter that could become an input"),
        ("internalOrder", "internalOrder is no parameter that could become an input"),
        ("n", "n is no parameter that could become an input"),
        ("T", "a sample period follows from T, which cannot become an input"),
    ],
)
def test_what_cannot_become_an_input_is_refused_by_name(tmp_path, name, message):
    text = """model M parameter Real m=1; parameter Real T=0.1; parameter Integer n=2;
      Real x(start=0, fixed=true); discrete Real z(start=0, fixed=true);
      equation m*der(x) = n; when sample(0, T) then z = x; end when; end M;"""
    with pytest.raises(ExportError, match=message):
        with_inputs(model_of(tmp_path, text), [name])


def test_a_variant_is_built_with_its_plants_start_values_and_up_to_date_by_itself(package, tmp_path):  # noqa: F811
    variants, lines = {"plant_inputs": ("plant", ("m",))}, []

    def made(**options):
        options = {"start_values": {"plant": {"m": 5.0}}, "variants": variants} | options
        built = build(["plant_inputs"], tmp_path, modelica=package, report=lines.append, **options)
        return [b.path.name for b in built if not b.skipped]

    assert made() == ["plant_inputs.fmu", "plant_inputs_fmi3.fmu"] and made() == []
    archive = Archive(tmp_path / "plant_inputs.fmu", tmp_path / "unpacked")
    (m,) = [v for v in archive.description.modelVariables if v.name == "m"]
    assert (m.causality, float(m.start)) == ("input", 5.0)
    assert archive.description.modelExchange.modelIdentifier == "plant_inputs"
    assert made(start_values={"plant": {"m": 5.0}, "plant_inputs": {"m": 6.0}}) != []
    with pytest.raises(ExportError, match="no FMU plant_inputs: there are plant, plant_loop"):
        made(variants={})
    with pytest.raises(ExportError, match="robot_inputs: no variant of robot can have this name"):
        made(variants={"robot_inputs": ("robot", ("m",))})
