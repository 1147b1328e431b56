#!/usr/bin/env python3
"""Widths and times of other validated integrators beside ours: Lorenz, Lotka-Volterra, van der Pol.

    peers/integrators.py [CASE...]

Needs nothing but Python: the peers are installed from PyPI into `target/peers/python`, each if it can be. CAPD
(`uj-capdpy`) is compiled there from source, which needs CMake, a C++ compiler and about half an hour;
`--without capd` leaves it out. Codac (`codac`) comes as a wheel. Ours is run by
`cargo bench -p veribound-flow --bench forms`. A ratio above one says how many times the peer is wider or slower.

A peer that has not answered after `--limit` seconds of CPU time (120) is given up, and its row says so: the table
always comes to its end.

Nothing depends on this script: no test, no build, and not the product.
"""

import argparse
import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PLACE = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "peers" / "python"

# Equations, start box, time; how often CAPD's start box is divided in every direction; Codac's time step.
CASES = {
    "Lorenz": {
        "names": "x,y,z",
        "rates": ["10*(y-x)", "x*(28-z)-y", "x*y-8*z/3"],
        "start": [["15", "15"], ["15", "15"], ["36", "36"]],
        "time": "10",
        "divided": [1],
        "step": 0.001,
    },
    "LV": {
        "names": "x,y",
        "rates": ["3*x-3*x*y", "x*y-y"],
        "start": [["1.292", "1.308"], ["0.992", "1.008"]],
        "time": "3.64",
        "divided": [1, 8],
        "step": 0.01,
    },
    "VdP": {
        "names": "x,y",
        "rates": ["y", "(1-x*x)*y-x"],
        "start": [["1.25", "1.55"], ["2.35", "2.45"]],
        "time": "7",
        "divided": [1, 12],
        "step": 0.01,
    },
}
PEERS = {"capd": ("uj-capdpy", "capdpy"), "codac": ("codac", "codac")}


def capd(case, divided):
    """CPU seconds and widths: doubletons of order 25, the start box divided evenly."""
    import itertools
    import time

    import capdpy

    number = lambda text: capdpy.Interval(text, text)
    text = f"var:{case['names']};fun:{','.join(case['rates'])};"
    hull = None
    begin = time.process_time()
    sides = []
    for lo, hi in case["start"]:
        lo, hi = float(lo), float(hi)
        cuts = [lo + (hi - lo) * k / divided for k in range(divided)] + [hi]
        sides.append(list(zip(cuts, cuts[1:])) if lo < hi else [(lo, hi)])
    for part in itertools.product(*sides):
        field = capdpy.IMap(text, 1)
        solver = capdpy.IOdeSolver(field, 25)
        move = capdpy.ITimeMap(solver)
        start = capdpy.IVector([capdpy.Interval(lo, hi) for lo, hi in part])
        end = move(number(case["time"]), capdpy.C0Rect2Set(start))
        ends = [(end[i].leftBound(), end[i].rightBound()) for i in range(len(part))]
        hull = ends if hull is None else [
            (min(a[0], b[0]), max(a[1], b[1])) for a, b in zip(hull, ends)
        ]
    return time.process_time() - begin, [hi - lo for lo, hi in hull]


def codac_lohner(case, _):
    """CPU seconds and widths of Codac's Lohner contractor, forward."""
    import time

    import codac

    states = len(case["start"])
    x = codac.VectorVar(states)
    names = {name: x[i] for i, name in enumerate(case["names"].split(","))}
    rates = [eval(rate, {}, names) for rate in case["rates"]]  # The fixed texts above.
    field = codac.AnalyticFunction([x], codac.vec(*rates))
    until = float(case["time"])
    tube = codac.SlicedTube(
        codac.create_tdomain([0, until], case["step"], True), codac.IntervalVector(states)
    )
    start = [[float(end) for end in ends] for ends in case["start"]]
    tube.set(codac.IntervalVector(start), 0.0)
    begin = time.process_time()
    codac.CtcLohner(field).contract(tube, codac.TimePropag.FWD)
    spent = time.process_time() - begin
    end = tube(until)
    return spent, [end[i].diam() for i in range(states)]


def install(name):
    """Installs a peer into its own environment; returns what went wrong."""
    package, module = PEERS[name]
    python = PLACE / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(PLACE)], check=True)
    known = subprocess.run([python, "-c", f"import {module}"], capture_output=True)
    if known.returncode == 0:
        return None
    print(f"installing {package} ...", file=sys.stderr, flush=True)
    command = [python, "-m", "pip", "install", "--quiet", "--prefer-binary", package]
    done = subprocess.run(command, capture_output=True, text=True)
    lines = (done.stderr or done.stdout).strip().splitlines()
    return None if done.returncode == 0 else (lines[-1] if lines else "pip failed")


def ask(name, case, divided, limit):
    """Runs one peer in its environment, in a process of its own: some of them crash, and some do not end."""
    command = [PLACE / "bin" / "python", __file__, "--worker", name, case, str(divided)]

    def bound():
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))

    # What waits takes no CPU time, and a busy machine gives little of it.
    patience = 20 * limit
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=patience, preexec_fn=bound
        )
    except subprocess.TimeoutExpired:
        return f"gave up after {patience} s of waiting"
    if done.returncode == 0:
        return json.loads(done.stdout)
    if -done.returncode in (signal.SIGXCPU, signal.SIGKILL):
        return f"gave up after {limit} s"
    lines = done.stderr.strip().splitlines()
    return f"fails: {lines[-1] if lines else f'exit code {done.returncode}'}"


def ours(names):
    """Milliseconds and widths of our benchmark."""
    command = ["cargo", "bench", "--locked", "-p", "veribound-flow", "--bench", "forms", "--"]
    done = subprocess.run(command + names, cwd=ROOT, capture_output=True, text=True, check=True)
    found = {}
    for line in done.stdout.splitlines():
        head = re.match(r"(\S.*?)\s+([\d.]+) ms of", line)
        width = re.search(r"width\s+(\S+)", line)
        if head:
            now = found[head[1]] = {"seconds": float(head[2]) / 1e3, "widths": []}
        elif width:
            now["widths"].append(float(width[1]))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)}")
    parser.add_argument("--without", action="append", default=[], choices=PEERS)
    parser.add_argument(
        "--limit", type=int, default=120, metavar="SECONDS", help="CPU time for a row of a peer"
    )
    parser.add_argument("--worker", nargs=3, help=argparse.SUPPRESS)
    words = parser.parse_args()
    if words.worker:
        name, case, divided = words.worker
        answer = {"capd": capd, "codac": codac_lohner}[name](CASES[case], int(divided))
        print(json.dumps(answer))
        return
    names = words.cases or list(CASES)
    peers = [name for name in PEERS if name not in words.without]
    missing = {name: install(name) for name in peers}
    known = ours(names)
    for name in names:
        own = known[name]
        widths = " ".join(f"{width:.4g}" for width in own["widths"])
        print(f"{name:8} veribound              {1e3 * own['seconds']:10.2f} ms   width {widths}")
        for peer in peers:
            counts = CASES[name]["divided"] if peer == "capd" else [1]
            for divided in [] if missing[peer] else counts:
                label = peer if divided == 1 else f"{peer} {divided} parts each"
                answer = ask(peer, name, divided, words.limit)
                if isinstance(answer, str):
                    print(f"{'':8} {label:22} {answer}")
                    continue
                seconds, widths = answer
                ratios = [w / o for w, o in zip(widths, own["widths"])]
                wider = " ".join(f"{ratio:.3g}" for ratio in ratios)
                slower = seconds / own["seconds"]
                widths = " ".join(f"{width:.4g}" for width in widths)
                print(
                    f"{'':8} {label:22} {1e3 * seconds:10.2f} ms   width {widths}   "
                    f"ratios: width {wider}, time {slower:.3g}"
                )
    for name, why in missing.items():
        if why:
            print(f"{name} could not be installed: {why}")


if __name__ == "__main__":
    main()
