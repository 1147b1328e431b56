"""Long runs: other threads go on, Ctrl-C ends them with what is proved, progress is told."""

import _thread
import signal
import threading
import time

import pytest

import veribound as vb
from conftest import EXAMPLES, push

RIG = EXAMPLES / "drive-train"


def test_other_threads_go_on():
    """A thread that counts gets on during a run about as fast as without one."""
    ticks = []
    is_over = threading.Event()

    def tick():
        while not is_over.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    vb.observe(RIG / "model.toml", RIG / "rig.csv", boxes=200, bisections=200, to=40)
    end = time.monotonic()
    is_over.set()
    thread.join()
    during = [t for t in ticks if begin <= t <= end]
    gaps = [b - a for a, b in zip(during, during[1:])]
    # With the interpreter held, one gap would be the whole run.
    assert len(during) > 10
    assert max(gaps) < 0.5 * (end - begin)


def test_runs_at_the_same_time_agree(sled):
    found = []
    work = [threading.Thread(target=lambda: found.append(tuple(sled.observe(push())["m"]))) for _ in range(3)]
    for thread in work:
        thread.start()
    for thread in work:
        thread.join()
    assert len(found) == 3 and len(set(found)) == 1


def test_ctrl_c_keeps_what_is_proved(rig):
    threading.Timer(0.3, _thread.interrupt_main).start()
    begin = time.monotonic()
    with pytest.raises(vb.Interrupted) as caught:
        rig.observe(RIG / "rig.csv", boxes=2000, bisections=2000, every=1)
    assert time.monotonic() - begin < 20
    result = caught.value.result
    assert isinstance(caught.value, KeyboardInterrupt) and result.interrupted
    assert 0 < len(result.params) < 8001
    assert -2 in result["alpha"] and "until interrupted" in str(result)


def test_ctrl_c_ends_identification_enclosure_and_simulation(rig):
    def interrupted(run):
        threading.Timer(0.3, _thread.interrupt_main).start()
        with pytest.raises(vb.Interrupted) as caught:
            run()
        return caught.value.result

    found = interrupted(lambda: rig.identify(RIG / "rig.csv", sets=100_000, tightness=1.0001))
    assert found.interrupted and -2 in found["alpha"]
    model = vb.Model.load(EXAMPLES / "lotka-volterra" / "model.toml")
    tube = interrupted(lambda: model.enclose(until=500, every=0.01, parts=10_000))
    assert tube.interrupted and "interrupted" in tube.message
    truth = {"alpha": -2, "beta": 200, "T_Fs": 0.15}
    run = lambda: rig.simulate(RIG / "profile.csv", params=truth, start={"phi": 0}, until=80, every=0.01, steps=5000)
    assert interrupted(run) is None


def test_other_signals_raise_what_their_handlers_raise(rig):
    class Stop(Exception):
        pass

    def handler(*_):
        raise Stop

    before = signal.signal(signal.SIGUSR1, handler)
    try:
        threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGUSR1)).start()
        with pytest.raises(Stop):
            rig.observe(RIG / "rig.csv", boxes=2000, bisections=2000, every=1)
    finally:
        signal.signal(signal.SIGUSR1, before)


def test_progress_is_told(rig):
    told = []
    rig.observe(RIG / "rig.csv", to=30, progress=lambda *standing: told.append(standing))
    samples = [done for done, _, text in told if text == "samples"]
    assert samples == sorted(samples) and samples and all(whole == 3001 for _, whole, text in told if text == "samples")

    def broken(*_):
        raise RuntimeError("no bar")

    with pytest.raises(RuntimeError, match="no bar"):
        rig.observe(RIG / "rig.csv", boxes=500, every=1, progress=broken)


def test_bars_are_drawn_and_taken_away(rig, capsys):
    rig.observe(RIG / "rig.csv", boxes=300, bisections=300, every=1, to=60, progress=True)
    assert "samples" in capsys.readouterr().err
