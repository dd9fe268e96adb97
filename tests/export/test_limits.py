"""What both versions refuse alike at the limits: numbers, points of time, states of the instance."""

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from tests.export.language import archive_of

VERSIONS = ("2", "3")


@pytest.fixture(params=VERSIONS)
def exported(request, tmp_path):
    """`exported(text)`: the FMU of a model, in either version."""
    opened = []

    def export(text):
        opened.append(archive_of(tmp_path, text, fmi=request.param))
        return opened[-1]

    yield export
    for archive in opened:
        archive.close()


def integer(instance, name):
    getter = "getInteger" if instance.archive.description.fmiVersion == "2.0" else "getInt32"
    return getattr(instance.fmu, getter)([instance.archive.references[name]])[0]


def test_an_integer_beyond_32_bits_is_refused(exported, capfd):
    archive = exported(
        "model M Integer k(start=-21, fixed=true); equation when sample(0.1, 0.1) then k = 10*pre(k); end when; end M;"
    )
    with archive.co_simulation() as instance:
        instance.step(0.0, 0.85)
        assert integer(instance, "k") == -2_100_000_000
        instance.step(0.85, 0.1)
        with pytest.raises(FMICallException):
            integer(instance, "k")
        assert "k is -2.1e+10: no Integer of 32 bits" in capfd.readouterr().out


def test_a_step_repeated_or_left_out_is_refused_however_late_and_round_off_is_not(exported, capfd):
    start, h = 2000.0, 1e-3
    archive = exported("model M Real x(start=1, fixed=true); equation der(x) = -x; end M;")
    with archive.co_simulation(start=start) as instance:
        for k in range(10):
            instance.step(np.nextafter(start + k * h, np.inf), h)
        for wrong in (9, 11):
            capfd.readouterr()
            with pytest.raises(FMICallException):
                instance.step(start + wrong * h, h)
            assert "but the instance stands at 2000.01 s" in capfd.readouterr().out
        instance.step(start + 10 * h, 0.0)
        instance.step(start + 10 * h, h)


def test_a_terminated_instance_still_tells_its_derivatives_and_indicators(exported):
    archive = exported("model M Real x(start=3, fixed=true); equation der(x) = if x > 1 then -x else 0; end M;")
    with archive.initialization_mode() as instance:
        instance.fmu.exitInitializationMode()
        instance.settle()
        instance.fmu.terminate()
        version_2 = archive.description.fmiVersion == "2.0"
        get = instance.fmu.getDerivatives if version_2 else instance.fmu.getContinuousStateDerivatives
        get(instance._dx, 1)
        assert instance.dx[0] == -3
        instance.fmu.getEventIndicators(instance._x, 1)
        assert instance.x[0] == pytest.approx(2 + 1e-12, abs=1e-15)
