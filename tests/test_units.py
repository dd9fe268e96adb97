"""Units: factors of the table, products, prefixes, refusals."""

from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import ConfigError
from pipeline.units import OFFSETS, PREFIXED, PREFIXES, SYMBOLS, Unit, conversion, parse


@pytest.mark.parametrize(
    ("unit", "wanted", "factor"),
    [
        ("deg", "rad", pi / 180),
        ("°", "rad", pi / 180),
        ("rpm", "rad/s", 2 * pi / 60),
        ("rev/min", "rpm", 1.0),
        ("deg/s", "rad/s", pi / 180),
        ("mm", "m", 1e-3),
        ("mm/s", "m/s", 1e-3),
        ("mm/s2", "m/s2", 1e-3),
        ("mm/s²", "m/s2", 1e-3),
        ("mV", "V", 1e-3),
        ("kN", "N", 1e3),
        ("N.cm", "N.m", 1e-2),
        ("Ncm", "N.m", 1e-2),
        ("mN.m", "N.m", 1e-3),
        ("mNm", "N.m", 1e-3),
        ("N·m", "N*m", 1.0),
        ("ms", "s", 1e-3),
        ("us", "s", 1e-6),
        ("µs", "s", 1e-6),
        ("μs", "s", 1e-6),
        ("min", "s", 60.0),
        ("kg.m2", "g.cm^2", 1e7),
        ("N.m.s/rad", "N.m/(rad/s)", None),
        ("N.m.s/rad", "kg.m2/(rad.s)", 1.0),
        ("1/s", "Hz", 1.0),
        ("m/s^-1", "m.s", 1.0),
        ("V", "W/A", 1.0),
        ("kOhm", "kohm", 1.0),
        ("mΩ", "V/A", 1e-3),
        ("mdeg", "deg", 1e-3),
        ("N/V", "N/mV", 1e-3),
        ("%", "1", 0.01),
    ],
)
def test_conversion_factors(unit, wanted, factor):
    if factor is None:
        with pytest.raises(ConfigError, match="one `/`"):
            conversion(unit, wanted)
    else:
        assert conversion(unit, wanted) == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize(
    "unit",
    ["", "furlong", "N.", "/s", "m//s", "m/s/s", "m/s.kg", "mkg", "N m", "kmin", "m0.5", "2"]
    + ["12", "m/(s", "m/s)", "m/()", "km999"],
)
def test_unknown_units_are_refused_by_name(unit):
    with pytest.raises(ConfigError) as caught:
        conversion(unit, "m")
    assert f"`{unit}`" in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(("unit", "wanted"), [("V", "N"), ("1/s", "rad/s"), ("m", "rad"), ("N", "N.m"), ("s", "Hz")])
def test_units_of_another_dimension_do_not_convert(unit, wanted):
    with pytest.raises(ConfigError, match=f"`{unit}` does not convert to `{wanted}`"):
        conversion(unit, wanted)


def test_a_temperature_with_another_zero_does_not_convert_by_a_factor():
    assert parse("degC") == Unit(1.0, 273.15, {"K": 1})
    assert conversion("W/(m2.degC)", "W/(m2.K)") == 1.0
    with pytest.raises(ConfigError, match="`degC` does not convert to `K` by a factor"):
        conversion("degC", "K")


@given(st.sampled_from(sorted(PREFIXED)), st.sampled_from(sorted(PREFIXES)), st.integers(1, 3))
def test_every_prefix_scales_every_symbol_that_takes_one(symbol, prefix, power):
    if prefix + symbol not in SYMBOLS:  # `min` is a minute, not a milli-inch
        assert conversion(f"{prefix}{symbol}{power}", f"{symbol}{power}") == pytest.approx(PREFIXES[prefix] ** power)


@given(st.sampled_from(sorted(SYMBOLS.keys() - OFFSETS.keys())), st.sampled_from(sorted(SYMBOLS)))
def test_a_product_divided_by_one_factor_is_the_other(a, b):
    assert conversion(f"{a}.{b}/{b}", a) == pytest.approx(1.0)


@given(st.text(max_size=12))
def test_any_text_is_a_unit_or_a_one_line_refusal(text):
    try:
        conversion(text, "m")
    except ConfigError as error:
        assert len(str(error).splitlines()) == 1
