"""What the tests share: the examples, the program, and small models."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import veribound as vb

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"

#: A mass on a rough table: F moves it, friction stops it.
SLED = """
format = 1
name = "sled"
states = ["x [m]", "v [m/s]"]
init   = { x = [-0.01, 0.01], v = 0 }
inputs = ["F [N]"]
[params]
m  = { unit = "kg", bounds = [0.5, 5] }
Fc = { unit = "N",  bounds = [0, 3] }
[der]
x = "v"
v = "(F - friction(v, F, Fc)) / m"
[outputs]
pos = "x +- 0.001"
"""


def push(rows=201, decimals=4):
    """The record of a true mass of 2 kg and a friction of 1 N: at rest, then pushed with 5 N."""
    times = [k / 100 for k in range(rows)]
    force = [0.5 if t < 0.5 else 5.0 for t in times]
    place = [round(0.5 * (5.0 - 1.0) / 2.0 * max(t - 0.5, 0.0) ** 2, decimals) for t in times]
    return {"t": times, "F": force, "pos": place}


#: A heater that cools down to a room of unknown temperature.
HEATER = """
format = 1
name = "heater"
states = ["T [K]"]
init   = { T = [79, 81] }
[params]
k = { unit = "1/s", bounds = [0.01, 1] }
room = { unit = "K", bounds = [0, 40] }
[der]
T = "-k*(T - room)"
[outputs]
T_m = "T +- 0.5"
"""


def heated(rows=21):
    """The record of k = 0.2 and a room of 20."""
    times = np.arange(rows) * 0.5
    return {"t": times, "T_m": np.round(20 + 60 * np.exp(-0.2 * times), 2)}


def program():
    """The program, built by ./check; the tests that compare with it are skipped loudly without it."""
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    path = pathlib.Path(os.environ.get("VERIBOUND_PROGRAM", target / "debug" / "veribound"))
    if not path.exists():
        pytest.skip(f"no program at {path}: cargo build -p veribound")
    return path


def run(*words, code=0):
    """Runs the program; what it prints."""
    done = subprocess.run([program(), *map(str, words)], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == code, done.stderr
    return done


@pytest.fixture
def sled():
    return vb.Model.from_toml(SLED, "sled.toml")


@pytest.fixture
def rig():
    return vb.Model.load(EXAMPLES / "drive-train" / "model.toml")
