"""The same run by program and by Python gives the same bounds, to the bit."""

import csv
import inspect
import re

import numpy as np
import pandas as pd
import polars as pl
import pytest

import veribound as vb
from conftest import EXAMPLES, HEATER, heated, push, run

RIG = EXAMPLES / "drive-train"
#: The rig's first ten seconds: two starts, a stop, a reversal.
UNTIL = "10"


def head(path, last):
    """The lines of a record up to a time, as the program would read them with --to."""
    frame = pd.read_csv(path, comment="#")
    return frame[frame["t [s]"] <= float(last)]


def bits(frame):
    """Every float of a frame, bit by bit."""
    if isinstance(frame, pl.DataFrame):
        frame = pd.DataFrame(frame.to_dict(as_series=False)).set_index("t")
    numbers = frame.select_dtypes("number").to_numpy(dtype=float)
    return numbers.tobytes()


@pytest.fixture(scope="module")
def by_path():
    return vb.observe(RIG / "model.toml", RIG / "rig.csv", to=UNTIL)


#: Flags that are about a terminal, or that other arguments of a call stand for.
NOT_OPTIONS = {"output", "json", "quiet", "color", "help", "version", "input"}


@pytest.mark.parametrize("command", ["observe", "identify", "enclose", "simulate"])
def test_every_flag_of_the_program_is_an_option(command):
    told = run(command, "--help").stdout
    flags = {flag.replace("-", "_") for flag in re.findall(r"^ +(?:-\w, )?--([a-z-]+)", told, flags=re.MULTILINE)}
    assert len(flags) > 10
    options = {name.strip("_") for name in inspect.signature(getattr(vb, command)).parameters} - vb._words.OWN
    assert options == flags - NOT_OPTIONS
    if command == "observe":
        followed = {name.strip("_") for name in inspect.signature(vb.Observer).parameters} - vb._words.OWN
        # What a stream has none of: a file, its times, and what is written of it.
        record = {"time", "column", "from", "to", "start_from"}
        assert followed == options - record - {"figures", "report", "parquet", "zoom", "overlay"}


def test_files_are_those_of_the_program(tmp_path):
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    vb.observe(RIG / "model.toml", head(RIG / "rig.csv", UNTIL), output=ours, figures="svg")
    run("observe", RIG / "model.toml", RIG / "rig.csv", "--to", UNTIL, "-o", theirs, "--figures", "svg")
    for name in ("params.csv", "states.csv", "boxes.csv", "fig/params.svg", "fig/states.svg", "fig/modes.svg"):
        assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name


def test_a_frame_is_its_csv_file_to_the_bit(by_path):
    frame = head(RIG / "rig.csv", UNTIL)
    model = vb.Model.load(RIG / "model.toml")
    ways = {
        "pandas": frame,
        "indexed": frame.set_index("t [s]"),
        "polars": pl.from_pandas(frame),
        "columns": {name: frame[name].to_numpy() for name in frame},
        "lists": {name: frame[name].tolist() for name in frame},
        "shuffled": frame[["still", "phi_m [rad]", "t [s]", "u [N*m]"]],
    }
    for name, record in ways.items():
        result = model.observe(record)
        assert bits(result.params) == bits(by_path.params), name
        assert bits(result.states) == bits(by_path.states), name
        assert list(result["alpha"]) == list(by_path["alpha"]), name


def test_the_tables_hold_what_the_program_prints(tmp_path, by_path):
    """Rounded outward: each printed bound lies outside of the float, by less than the last of its 12 digits."""
    run("observe", RIG / "model.toml", RIG / "rig.csv", "--to", UNTIL, "-o", tmp_path / "out", "--figures", "none")
    with open(tmp_path / "out" / "params.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    frame = by_path.params
    assert len(rows) == len(frame) == 1001
    for name in ("alpha", "beta", "T_Fs"):
        for end, sign in (("lo", -1), ("hi", 1)):
            printed = np.array([float(row[f"{name}.{end}"]) for row in rows])
            proved = frame[f"{name}.{end}"].to_numpy()
            # An end that nothing has cut off is printed as the decimal of the prior, inside of its enclosure.
            assert (sign * (printed - proved) >= -np.spacing(abs(proved))).all(), (name, end)
            assert (abs(printed - proved) <= 1e-11 * abs(proved) + 1e-300).all(), (name, end)


def test_summary_and_table_are_the_programs(tmp_path, by_path):
    done = run("observe", RIG / "model.toml", RIG / "rig.csv", "--to", UNTIL, "-o", tmp_path, "--figures", "none")
    printed = [line for line in done.stdout.splitlines() if line.startswith("  ") and "results in" not in line]
    ours = by_path.table().splitlines()
    assert [line.rstrip() for line in ours[1:]] == [line.rstrip() for line in printed[1:]]


def test_identify_agrees(tmp_path):
    folder = EXAMPLES / "compartments"
    ours = vb.identify(folder / "model.toml", pd.read_csv(folder / "record.csv", comment="#"), output=tmp_path / "a", figures="none")
    run("identify", folder / "model.toml", folder / "record.csv", "-o", tmp_path / "b", "--figures", "none")
    assert (tmp_path / "a" / "points.csv").read_bytes() == (tmp_path / "b" / "points.csv").read_bytes()
    again = vb.identify(folder / "model.toml", folder / "record.csv", threads=2)
    assert bits(again.bounds) == bits(ours.bounds)


def test_an_identification_goes_on_and_tells_the_least_error(tmp_path):
    folder = EXAMPLES / "compartments"
    given = {"records": folder / "record.csv", "least_error": True, "memory": 64, "figures": "none", "report": "none"}
    ours = vb.identify(folder / "model.toml", **given, output=tmp_path / "a")
    words = "--least-error --memory 64 --figures none --report none".split()
    run("identify", folder / "model.toml", folder / "record.csv", *words, "-o", tmp_path / "b")
    assert (tmp_path / "a" / "points.csv").read_bytes() == (tmp_path / "b" / "points.csv").read_bytes()
    least = ours.least_error
    # The record agrees, so that the declared errors are enough.
    assert 0.9 < least.lo <= 1 and least.lo <= least.hi < 1.1
    told = ours.summary["least_error"]
    assert told["at_least"] <= least.lo and least.hi <= told["enough"]
    assert vb.identify(folder / "model.toml", folder / "record.csv", sets=1).least_error is None
    # Nothing is kept of a run that is done: it begins anew.
    again = vb.identify(folder / "model.toml", **given, output=tmp_path / "a", resume=True)
    assert bits(again.bounds) == bits(ours.bounds)
    with pytest.raises(ValueError, match="give `output`"):
        vb.identify(folder / "model.toml", folder / "record.csv", resume=True)


def test_an_interrupted_identification_goes_on(tmp_path, rig):
    given = {"to": 20, "sets": 12, "tightness": 1.0001, "figures": "none", "report": "none", "output": tmp_path / "out"}

    class Enough(Exception):
        pass

    def end(sets, *_):
        if sets > 2:
            raise Enough

    with pytest.raises(Enough):
        rig.identify(RIG / "rig.csv", **given, progress=end)
    assert (tmp_path / "out" / "checkpoint.bin").exists()
    whole = rig.identify(RIG / "rig.csv", **{**given, "output": None})
    gone_on = rig.identify(RIG / "rig.csv", **given, resume=True)
    assert bits(gone_on.bounds) == bits(whole.bounds)


def test_engines_are_those_of_the_program(tmp_path):
    model, record = tmp_path / "heater.toml", tmp_path / "record.csv"
    model.write_text(HEATER)
    pd.DataFrame(heated()).to_csv(record, index=False)
    given = {"engine": "forms", "boxes": 4, "figures": "none", "report": "none"}
    run("observe", model, record, *"--engine forms --boxes 4 --figures none --report none -o".split(), tmp_path / "b")
    forms = vb.observe(model, record, **given, output=tmp_path / "a")
    assert (tmp_path / "a" / "params.csv").read_bytes() == (tmp_path / "b" / "params.csv").read_bytes()
    assert forms["k"].width < vb.observe(model, record, boxes=4)["k"].width
    observer = vb.Observer(model, engine="forms", boxes=4)
    for t, temperature in zip(*heated().values()):
        step = observer.step(t, T_m=temperature)
    assert list(step["k"]) == list(forms["k"])
    with pytest.raises(vb.Error, match="fastest"):
        vb.observe(model, record, engine="fastest")


def test_enclose_agrees(tmp_path):
    model = EXAMPLES / "lotka-volterra" / "model.toml"
    vb.enclose(model, until=2, every=0.1, output=tmp_path / "a", figures="none")
    run("enclose", model, "--until", 2, "--every", 0.1, "-o", tmp_path / "b", "--figures", "none")
    for name in ("tube.csv", "parts.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name


def test_simulate_agrees(tmp_path, rig):
    profile = pd.read_csv(RIG / "profile.csv", comment="#")
    ours = rig.simulate(
        profile,
        params={"alpha": -2, "beta": 200, "T_Fs": 0.15},
        start={"phi": 0},
        until=5,
        every=0.01,
        error=0.0999,
        seed=1,
        decimals=4,
        steps=20,
    )
    theirs = tmp_path / "rig.csv"
    words = "--params alpha=-2,beta=200,T_Fs=0.15 --start phi=0 --until 5 --every 0.01 --error 0.0999 --seed 1"
    run("simulate", RIG / "model.toml", *words.split(), "--decimals", 4, "--steps", 20, "--input", RIG / "profile.csv", "-o", theirs)
    # The first line tells the command, with the name of the profile.
    assert ours.text.splitlines()[1:] == theirs.read_text().splitlines()[1:]
    assert len(ours.frame) == 501


def test_drawn_records_and_their_trajectories_agree(tmp_path):
    model = EXAMPLES / "bouncing-ball" / "model.toml"
    ours = vb.simulate(model, random=True, seed=4, until=1, every=0.01, trajectory=tmp_path / "a", figures="svg")
    words = "--random --seed 4 --until 1 --every 0.01 --figures svg".split()
    run("simulate", model, *words, "--trajectory", tmp_path / "b", "-o", tmp_path / "drawn.csv")
    assert ours.text.splitlines()[1:] == (tmp_path / "drawn.csv").read_text().splitlines()[1:]
    for name in ("trajectory.csv", "fig/states.svg"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    with pytest.raises(vb.Error, match="E0612"):
        vb.simulate(model, random=True, until=1, every=0.1, trajectory=tmp_path / "c", figures="none,svg")


def test_a_stream_of_samples_is_a_record(rig, by_path):
    frame = head(RIG / "rig.csv", UNTIL)
    observer = vb.Observer(rig)
    for t, u, phi_m, still in frame.itertuples(index=False):
        step = observer.step(t, u=u, phi_m=phi_m, still=still)
    assert step.verdict == "consistent"
    for name in ("alpha", "beta", "T_Fs", "phi", "omega"):
        assert list(step[name]) == list(by_path[name]), name


def test_exact_floats_are_other_numbers(sled):
    record = push()
    near = sled.observe(record, every=1)
    exact = sled.observe(record, every=1, exact=True)
    # What is within half an ulp of the decimals gives nearly, not exactly, the same bounds.
    assert bits(near.states) != bits(exact.states)
    assert abs(near["x"].lo - exact["x"].lo) < 1e-12


def test_exact_floats_are_taken_for_what_they_hold(sled):
    from decimal import Decimal

    record = push(rows=161)
    as_text = {name: [str(Decimal(x)) for x in values] for name, values in record.items()}
    exact = sled.observe(record, every=1, exact=True)
    assert bits(exact.params) == bits(sled.observe(as_text, every=1).params)
    observer = vb.Observer(sled, every=1, exact=True)
    for t, force, place in zip(*record.values()):
        step = observer.step(t, F=force, pos=place)
    assert list(step["m"]) == list(exact["m"])
