"""Wrong input is told in the words of the program: file, line, text, one thing to do."""

import pickle

import pandas as pd
import pytest

import veribound as vb
from conftest import EXAMPLES, SLED, push, run


def told_by_program(*words):
    """What the program says, without its last line about terminals."""
    said = run(*words, code=2).stderr
    return said.split("for more about", maxsplit=1)[0].rstrip()


def test_a_bad_model_is_told_like_the_program_does(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(SLED.replace("x = \"v\"", "x = \"w\""))
    with pytest.raises(vb.Error) as caught:
        vb.Model.load(path)
    assert str(caught.value).rstrip() == told_by_program("check", path)
    problem = caught.value.problems[0]
    assert problem.file == str(path) and problem.line == 11 and problem.text == 'x = "w"'
    assert problem.code in caught.value.codes and problem.help
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.problems == caught.value.problems and str(again) == str(caught.value)


def test_a_bad_record_is_told_like_the_program_does(tmp_path):
    model, path = tmp_path / "sled.toml", tmp_path / "r.csv"
    model.write_text(SLED)
    path.write_text("t,F,pos\n0,0,0\n0.01,fast,0\n0.005,0,0\n")
    with pytest.raises(vb.Error) as caught:
        vb.observe(model, path)
    assert str(caught.value).rstrip() == told_by_program("observe", model, path, "-o", tmp_path / "out")
    assert [problem.line for problem in caught.value.problems] == [3, 4]


def test_a_bad_frame_names_row_and_text(sled):
    record = push(rows=5)
    record["F"][3] = float("nan")
    with pytest.raises(vb.Error, match="<columns>:5:") as caught:
        sled.observe(record)
    assert caught.value.problems[0].text == "0.03,,0.0"
    with pytest.raises(vb.Error, match="column"):
        sled.observe({"t": [0], "pos": [0]})


def test_a_flag_is_refused_in_the_words_of_the_program(sled):
    with pytest.raises(vb.Error, match="E0603") as caught:
        sled.observe(push(), input_error={"w": "1%"})
    assert "the model has no input `w`" in str(caught.value)
    with pytest.raises(vb.Error, match="invalid value '0' for '--boxes <L>'") as caught:
        sled.observe(push(), boxes=0)
    assert caught.value.problems == [] and "Usage" not in str(caught.value)
    with pytest.raises(TypeError, match="boxess"):
        sled.observe(push(), boxess=3)


def test_results_do_not_go_over_what_was_read(tmp_path):
    model = tmp_path / "summary.json"
    model.write_text(SLED)
    with pytest.raises(vb.Error):
        vb.observe(model, push(), output=tmp_path)
    assert model.read_text() == SLED


def test_a_contradiction_is_a_verdict(sled):
    record = push()
    record["pos"] = [x + (0.5 if t > 1 else 0) for t, x in zip(record["t"], record["pos"])]
    result = sled.observe(record)
    assert result.verdict == "inconsistent"
    assert "<columns>:103" in result.message and "E0301" in result.message and "(proved)" in result.message
    assert result["m"].is_empty and str(result["m"]) == "none"
    assert "inconsistent" in result._repr_html_() and len(result.params) == 101
    observer = vb.Observer(sled)
    for t, force, place in zip(*record.values()):
        step = observer.step(t, F=force, pos=place)
        if step.verdict != "consistent":
            break
    assert step.verdict == "inconsistent" and "gap" in step.message and step.params == {}
    with pytest.raises(vb.Error, match="final verdict"):
        observer.step(9, F=0, pos=0)


def test_an_open_end_is_a_verdict():
    model = vb.Model.from_toml(
        'format = 1\nstates = ["x"]\ninit.x = 1\nparams.k = [1, 2]\nder.x = "k*x*x"\noutputs.y = "x +- 100"\n'
    )
    result = model.observe({"t": [0, 0.1, 5.0], "y": [1.0, 1.1, 9.0]})
    assert result.verdict == "undecided" and "E0302" in result.message
    assert result["k"].lo <= 1 <= result["k"].hi
    assert model.enclose(until=5, every=0.5).verdict == "undecided"


def test_a_step_says_what_is_missing(sled):
    observer = vb.Observer(sled)
    with pytest.raises(vb.Error, match="the input `F` has no value"):
        observer.step(0, pos=0)
    with pytest.raises(vb.Error, match="no input, output or signal `speed`"):
        observer.step(0, F=0, pos=0, speed=1)
    with pytest.raises(vb.Error, match="given twice"):
        observer.step(0, {"F": 0}, F=0)
    with pytest.raises(vb.Error, match="is no number"):
        observer.step("now", F=0)
    with pytest.raises(vb.Error, match="is no number"):
        observer.step(0, F=float("inf"))
    assert observer.step(0, F=0, pos=None).verdict == "consistent"
    with pytest.raises(vb.Error, match="not later"):
        observer.step(0, F=0, pos=0)
    assert observer.samples == 1
    with pytest.raises(KeyError):
        observer.step(1, {"F": 0})["speed"]


def test_names_are_no_options(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pd.DataFrame(push(rows=5)).to_csv("--quiet", index=False)
    model = vb.Model.from_toml(SLED, "-o")
    assert model.observe("--quiet", output="-x").verdict == "consistent"
    assert (tmp_path / "-x" / "summary.json").is_file()
    assert vb.Observer(model).step(0, F=0).verdict == "consistent"


def test_nothing_else_is_made_of_a_model():
    with pytest.raises(TypeError, match="Model.load"):
        vb.Model("rig.toml")
    with pytest.raises(TypeError, match="a model is"):
        vb.observe(3, push())
    with pytest.raises(vb.Error, match="E01"):
        vb.Model.load(EXAMPLES / "nowhere.toml")
