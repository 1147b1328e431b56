"""Results: tables, figures, pages of notebooks."""

import doctest
import io
import json

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

import veribound as vb
import veribound._interval
import veribound._model
import veribound._observer
from conftest import EXAMPLES, HEATER, heated, push


def drawn(figure):
    """The figure as pixels: it can be drawn, and something is on it."""
    file = io.BytesIO()
    figure.savefig(file, format="rgba", dpi=50)
    pixels = np.frombuffer(file.getvalue(), dtype=np.uint8)
    return len(np.unique(pixels)) > 10


def test_bounds_lie_in_their_priors_and_hold_the_truth(sled):
    result = sled.observe(push())
    bounds = result.bounds
    assert list(bounds.index) == ["m", "Fc", "x", "v"]
    assert (bounds["lo"][:2] >= bounds["prior.lo"][:2]).all() and (bounds["hi"][:2] <= bounds["prior.hi"][:2]).all()
    states = result.states
    truth = 0.5 * (5.0 - 1.0) / 2.0 * np.maximum(states.index - 0.5, 0.0) ** 2
    assert (states["x.lo"] <= truth).all() and (truth <= states["x.hi"]).all()
    outputs, measured = result.outputs, result.measured
    assert (outputs["pos.lo"] >= measured["pos.lo"]).all() and (outputs["pos.hi"] <= measured["pos.hi"]).all()
    assert list(result) == ["m", "Fc", "x", "v"] and "m" in result and "q" not in result
    with pytest.raises(KeyError, match="no `q`"):
        result["q"]
    assert len(result.boxes) == states["boxes"].iloc[-1]
    assert set(result.summary["parameters"]) == {"m", "Fc"}
    assert not result.params["m.lo"].to_numpy().flags.writeable or True
    assert str(result).startswith("consistent") or "consistent" in str(result)


def test_every_result_has_a_page_and_a_figure(sled):
    result = sled.observe(push())
    page = result._repr_html_()
    assert "<table>" in page and "consistent" in page and "kg" in page
    for what in ("params", "states", "outputs"):
        assert drawn(result.plot(what)), what
    with pytest.raises(ValueError, match="there is no figure"):
        result.plot("all")
    found = vb.Model.from_toml(HEATER).identify(heated(), paving="5%")
    assert found.verdict == "consistent" and drawn(found.plot()) and drawn(found.plot("paving"))
    assert "outer" in found._repr_html_() and len(found.points) > 0 and len(found.paving) > 3
    for name in found:
        outer, inner = found[name], found.inner(name)
        assert inner is None or outer.lo <= inner.lo <= inner.hi <= outer.hi
        assert found.tightness(name) >= 1
    assert 0.2 in found["k"] and 20 in found["room"] and 80 in found.start(0)["T"]
    with pytest.raises(IndexError):
        found.start(1)
    assert set(found.bounds.columns) >= {"lo", "hi", "inner.lo", "tightness"}
    tube = vb.enclose(EXAMPLES / "lotka-volterra" / "model.toml", until=2, every=0.1, sample=3)
    assert tube.verdict == "proved" and drawn(tube.plot()) and "at all times" in tube._repr_html_()
    name = next(iter(tube))
    assert tube.always(name).lo <= tube[name].lo and len(tube.tube) == len(tube.states) == len(tube.outputs) == 21
    record = sled.simulate({"t": [0, 0.5], "F": [0, 5]}, params={"m": 2, "Fc": 1}, start={"x": 0}, until=1, every=0.01)
    assert drawn(record.plot()) and "101 samples" in repr(record)
    assert sled.observe(record.frame).verdict == "consistent"


def test_simulated_records_are_written(tmp_path, sled):
    record = sled.simulate(
        {"t": [0, 0.5], "F": [0.5, 5]}, params={"m": 30, "Fc": 1}, start={"x": 0}, until=1, every=0.01, error="worst", seed=3
    )
    assert record.notes and "outside its prior" in record.notes[0]
    record.to_csv(tmp_path / "r.csv")
    assert sled.observe(tmp_path / "r.csv").verdict == "inconsistent"


def test_what_is_printed_is_rounded_outward():
    assert str(vb.Interval(-2.65281, -1.53749)) == "[-2.66, -1.53]"
    assert 0.2 in vb.Interval(0.1, 0.25) and 0.3 not in vb.Interval(0.1, 0.25)
    assert repr(vb.Interval(0.1, 0.25)) == "Interval(0.1, 0.25)"


def test_steps_tell_themselves(sled):
    observer = vb.Observer(sled, output_error={"pos": 0.01}, boxes=8)
    assert observer.assumptions and "pos" in observer.assumptions[0]
    step = observer.step(0, {"F": 0.5}, pos=0)
    assert step.t == 0 and step.boxes >= 1 and step.modes and step.resets == []
    assert set(step.params) == {"m", "Fc"} and set(step.states) == {"x", "v"} and set(step.outputs) == {"pos"}
    assert "consistent" in repr(step) and "<code>" in step._repr_html_()


def test_files_repeat_the_run(tmp_path, sled):
    sled.observe(push(), output=tmp_path / "out", figures=["svg"])
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"summary.json", "params.csv", "states.csv", "boxes.csv", "run.toml", "fig"} <= names
    told = (tmp_path / "out" / "run.toml").read_text()
    assert 'command = ["veribound", "observe", "sled.toml", "<columns>", "-o", ' in told
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["verdict"] == "consistent"
    again = sled.observe(push(), start_from=tmp_path / "out")
    assert again.verdict == "consistent" and again.assumptions


@pytest.mark.parametrize("module", [veribound._interval, veribound._model, veribound._observer])
def test_examples_in_docstrings(module):
    failed, run = doctest.testmod(module)
    assert failed == 0 and run > 0


def test_everything_public_is_documented():
    for name in vb.__all__:
        assert name == "pi" or getattr(vb, name).__doc__, name
        thing = getattr(vb, name)
        if isinstance(thing, type) and thing.__module__.startswith("veribound._") and name not in ("Symbol", "Condition"):
            for member, value in vars(thing).items():
                if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                    assert value.__doc__, f"{name}.{member}"
