"""Models built in Python."""

import pickle
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import veribound as vb
from conftest import EXAMPLES, push


def sled(mass=(0.5, 5)):
    model = vb.ModelBuilder("sled")
    x = model.state("x", unit="m", init=(-0.01, 0.01))
    v = model.state("v", unit="m/s", init=0)
    force = model.input("F", unit="N")
    m = model.param("m", *mass, unit="kg")
    level = model.param("Fc", 0, 3, unit="N")
    model.der(x, v)
    model.der(v, (force - vb.friction(v, force, level)) / m)
    model.output("pos", x, error=0.001)
    return model


def test_a_built_model_is_its_file(tmp_path):
    model = sled().build()
    model.save(tmp_path / "sled.toml")
    built, read = model.observe(push()), vb.observe(tmp_path / "sled.toml", push())
    assert list(built["m"]) == list(read["m"]) and list(built["Fc"]) == list(read["Fc"])
    assert repr(model) == "<veribound.Model 'sled': 2 states, 2 parameters, 1 input, 1 output>"
    assert [mode for mode in model.modes] and "forms" in model.check()
    assert pickle.loads(pickle.dumps(model)).to_toml() == model.to_toml()
    assert vb.observe(sled(), push())["m"] == built["m"]


def test_numbers_are_exact():
    x = vb.ModelBuilder("m").state("x", init=0)
    assert str(0.1 * x) == "0.1*x"
    assert str(x * 1e-7) in ("x*0.0000001", "x*1e-7")
    assert str(x + np.float32(0.1)) == "x + 0.1"
    assert str(x - np.int64(3)) == "x - 3"
    assert str(Decimal("0.30") * x) in ("0.3*x", "0.30*x")
    assert str(Decimal(0.1) * x).startswith("0.1000000000000000055511151231257827")
    assert str(x * Fraction(1, 3)) == "x*(1/3)"
    assert str(2 / x - x**2) == "2/x - x^2"
    assert str(2**x) == "2^x" and str(-x) == "-x" and str(abs(x)) == "abs(x)"
    with pytest.raises(TypeError, match="is no number"):
        x + object()


def test_conditions_have_no_truth_value():
    model = vb.ModelBuilder("rig")
    omega, u = model.state("omega", init=0), model.input("u")
    level = model.param("T", 0, 0.3)
    stick = (omega == 0) & (abs(u) <= level)
    assert str(stick) == "omega == 0 and abs(u) <= T"
    assert str(~stick | (u != 1)) == "not (omega == 0 and abs(u) <= T) or u != 1"
    with pytest.raises(vb.Error, match="no truth value while a model is built"):
        if omega > 0:
            pass
    with pytest.raises(vb.Error, match="if_else"):
        bool(stick)
    with pytest.raises(TypeError, match="is a condition"):
        omega + stick
    assert str(vb.if_else(omega > 0, 1, u)) == "if omega > 0 then 1 else u"


def test_everything_a_file_can_say():
    model = vb.ModelBuilder("all of it")
    h = model.state("h", init=(1, vb.pi / 2), domain=(0, 100))
    v = model.state("v", init=0)
    u = model.input("u", error=0.1, relative_error="0.01", error_hold="level", column="drive", domain=(-5, 5))
    w = model.disturbance("w", -1, 1, hold=True)
    k = model.param("k", 0, 2, nominal=1)
    g = model.fixed("g", 9.81)
    drag = model.define("drag", k * v * abs(v) + vb.sat(u, -1, 1) + vb.table(h, [(0, 0), (1, 0.5)]))
    model.mode("low", h <= 1, der={h: v, v: -g - drag + w})
    model.mode("high", h >= 1, der={h: v, v: -g})
    model.jump("bounce", (h <= 0) & (v < 0), sets={v: -v * 0.5})
    model.output("h_m", h, error="0.01", relative_error=0.1, outliers=(2, 100), column="height")
    model.signal("still", proves=v == 0, latency=0.02)
    model.event("again", "still", resets=k, lasts=0.5)
    built = model.build()
    assert built.signals == ["still"] and built.modes == ["low", "high"]
    assert [q.name for q in built.disturbances] == ["w"] and built.disturbances[0].bounds == (-1, 1)
    assert 'error = { absolute = 0.1, relative = 0.01, hold = "level" }' in built.to_toml()
    assert 'outliers = "2 in 100"' in built.to_toml()
    assert 'still = { proves = ["v == 0"], latency = 0.02 }' in built.to_toml()
    assert 'again = { when = "still", lasts = 0.5, action = "reset k" }' in built.to_toml()


def test_problems_are_shown_in_the_text():
    model = sled(mass=(float("nan"), 5))
    with pytest.raises(vb.Error, match="built in Python") as caught:
        model.build()
    assert "nan" in str(caught.value)
    with pytest.raises(ValueError, match="3 entries"):
        model.state("z", init=(1, 2, 3))
    with pytest.raises(ValueError, match="no error_hold `forever`"):
        model.input("f", error=1, error_hold="forever")


@pytest.mark.parametrize("name", sorted(path.parent.name for path in EXAMPLES.glob("*/model.toml")))
def test_all_examples_are_read(name):
    model = vb.Model.load(EXAMPLES / name / "model.toml")
    assert model.states and model.check()
