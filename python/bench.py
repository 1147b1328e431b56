"""What Python costs: a call beside the run of the program, and a step of the observer beside the step in Rust.

    python python/bench.py [PROGRAM]

Prints times and ratios; PROGRAM is `target/release/veribound` or whatever was built like the package. The step in Rust is
measured inside of the same calls, so that noise of the machine hits both sides.
"""

import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import pandas as pd

import veribound as vb

RIG = pathlib.Path(__file__).resolve().parents[1] / "examples" / "drive-train"


def seconds(run):
    begin = time.perf_counter()
    result = run()
    return time.perf_counter() - begin, result


def calls(repeats=5):
    """A whole call from a frame: how much longer it takes than the run inside of it, which the summary tells."""
    frame = pd.read_csv(RIG / "rig.csv", comment="#")
    model = vb.Model.load(RIG / "model.toml")
    print(f"observe, {len(frame)} samples: seconds of the call, of the run, and what is beside it")
    for name, record in (("frame", frame), ("path", RIG / "rig.csv")):
        parts = []
        for _ in range(repeats):
            whole, result = seconds(lambda: model.observe(record, progress=False))
            parts.append((whole, result.summary["work"]["wall_s"]))
        whole, inside = min(parts)
        print(f"  {name:6} {whole:.3f}  {inside:.3f}  {100 * (whole / inside - 1):.1f} %")
    tables, _ = seconds(lambda: (result.params, result.states))
    print(f"  tables as frames: {tables * 1e3:.1f} ms")


def against(program):
    """The same run by the program, which reads the record, too, and writes no figures."""
    with tempfile.TemporaryDirectory() as folder:
        words = [program, "observe", RIG / "model.toml", RIG / "rig.csv", "-o", folder, "--figures", "none", "-q"]
        best = {"program": float("inf"), "Python": float("inf")}
        for _ in range(5):
            best["program"] = min(best["program"], seconds(lambda: subprocess.run(words, check=True))[0])
            ours = lambda: vb.observe(RIG / "model.toml", RIG / "rig.csv", output=folder, figures="none", progress=False)
            best["Python"] = min(best["Python"], seconds(ours)[0])
        ratio = best["Python"] / best["program"] - 1
        print(f"program with files {best['program']:.3f} s, Python with files {best['Python']:.3f} s: {100 * ratio:+.1f} %")


def steps(samples=3000):
    """A step from Python, without the observer's own time, which is measured in Rust."""
    frame = pd.read_csv(RIG / "rig.csv", comment="#")[:samples]
    observer = vb.Observer(RIG / "model.toml", boxes=1, bisections=0)
    rows = [(t, {"u": u, "phi_m": phi, "still": bool(still)}) for t, u, phi, still in frame.itertuples(index=False)]
    beside = []
    for t, values in rows:
        begin = time.perf_counter_ns()
        step = observer.step(t, values)
        bounds = step["alpha"]
        whole = time.perf_counter_ns() - begin
        beside.append((whole - step.nanoseconds) / 1e3)
    assert bounds.lo <= -2 <= bounds.hi
    beside.sort()
    print(
        f"Observer.step and one bound of it: {statistics.median(beside):.1f} us above the step in Rust (median of {samples}),"
        f" {beside[int(0.99 * samples)]:.1f} us in 99 of 100"
    )


if __name__ == "__main__":
    calls()
    steps()
    if len(sys.argv) > 1:
        against(sys.argv[1])
