"""Runs: what the program does, on frames, arrays and files."""

from __future__ import annotations

import os
from typing import Any, Callable, Mapping, Optional, Sequence, Union

from . import _frames, _progress, _veribound, _words
from ._errors import Interrupted
from ._results import Enclosure, Identification, Observation, Simulation

Text = Union[str, float, int, Any]
Names = Mapping[str, Text]


def _model(model: Any) -> Any:
    """A model, its builder, or the path of its file."""
    from ._model import Model, ModelBuilder

    if isinstance(model, ModelBuilder):
        return model.build()
    if isinstance(model, (str, os.PathLike)):
        return Model.load(model)
    if not isinstance(model, Model):
        raise TypeError(f"a model is a veribound.Model, a ModelBuilder or the path of a model file, not {model!r}")
    return model


def _name(model: Any) -> str:
    return _words.place(model._model.source)


def _ended(done: Any, result: Any) -> Any:
    """The result; raised with the exception where the user wanted an end."""
    if done.asked_to_end:
        raise Interrupted(result)
    return result


def _show(progress: Any, run: "Callable[[Any], Any]") -> Any:
    bar = _progress.bar(progress)
    try:
        return run(bar)
    finally:
        _progress.close(bar)


def _output(output: Any) -> "tuple[list[str], bool]":
    # The program writes a folder always; without one nothing is written.
    return ["-o", _words.place(os.fspath(output or "nowhere"))], output is not None


def _inputs(given: "dict[str, Any]", exact: bool) -> Any:
    """The inputs among the arguments of a call, named there as the program's option."""
    if given["inputs"] is None:
        return None
    source = _frames.source(given["inputs"], exact)
    given["input"] = source.name
    return source


def observe(
    model: Any,
    record: Any,
    *,
    time: Optional[str] = None,
    column: Optional["Mapping[str, str]"] = None,
    from_: Optional[Text] = None,
    to: Optional[Text] = None,
    reset: "Union[None, str, Sequence[str]]" = None,
    input_error: Optional[Names] = None,
    output_error: Optional[Names] = None,
    start_from: Any = None,
    boxes: Optional[int] = None,
    bisections: Optional[int] = None,
    every: Optional[int] = None,
    epsilon: Optional[float] = None,
    velocity_horizon: Optional[float] = None,
    windows: Optional["Sequence[int]"] = None,
    trisect: bool = False,
    parameter_rule: Optional[str] = None,
    merge_across_modes: bool = False,
    order: Optional[int] = None,
    halvings: Optional[int] = None,
    longest_step: Optional[float] = None,
    engine: Optional[str] = None,
    method: Optional[str] = None,
    rows: Optional[int] = None,
    replay: Optional[int] = None,
    history: Optional[int] = None,
    budget: Optional[int] = None,
    output: Any = None,
    figures: Any = None,
    report: Optional[str] = None,
    parquet: bool = False,
    zoom: Optional[str] = None,
    overlay: Any = None,
    exact: bool = False,
    frames: Optional[str] = None,
    progress: Any = None,
) -> Observation:
    """Bounds parameters and states from a record, sample by sample.

    Guarantee: if the true start values and parameters lie in the bounds of the model and every error of the record
    in its declared bound, then after every sample the true values lie in the returned bounds.

    Parameters
    ----------
    model : a `Model`, a `ModelBuilder`, or the path of a model file.
    record : path of a CSV, MAT, HDF5 or Parquet file; pandas or polars frame; or dictionary of columns, each of shape ``(m,)``.
        It has a time column (``t`` or ``time``, in seconds; a frame may be indexed by it, or by a clock) and one for
        every input, output and signal of the model, in the model's units or with their own in brackets, as
        ``"phi [deg]"``. NaN is a missing value.
    time, column : names of columns, where they are not those of the model: ``column={"phi": "angle"}``.
    from_, to : first and last time to use, in seconds on the record's clock.
    reset : ``"T_Fs@still:0.2"``: that parameter may have a new value whenever that signal was true so long.
    input_error, output_error : larger errors than the model says: ``{"u": "10%"}`` or ``{"u": 0.02}``.
    start_from : folder of an earlier run, whose parameter boxes to start from.
    boxes, bisections, every, epsilon, velocity_horizon, windows, trisect, parameter_rule, merge_across_modes,
    order, halvings, longest_step : how the observer works; no option changes what is proved. They are those of the
        program, ``veribound observe --help``.
    engine : ``"auto"`` (boxes alone), ``"forms"``, ``"closed"``, ``"comparison"`` or ``"boxes"``: what moves boxes besides
        their own step. Forms keep from sample to sample how boxes depend on parameters, which narrows more with few
        boxes and takes many times as long.
    method : ``"boxes"`` or ``"polytope"``: what all samples say together is kept, too, which narrows parameters much more;
        `rows`, `replay` and `history` bound its memory, and `budget` the work of a sample, in products of coefficients.
    output : folder for the files that the program writes, with the page `report.html`; `figures`, `report`, `parquet`,
        `zoom` and `overlay` are about these.
    exact : a float of a frame stands for the number that it holds, digit for digit. By default it stands for its
        shortest decimal, so that a frame and the CSV file it was read from give the same bounds to the bit.
    frames : ``"pandas"``, ``"polars"`` or ``"numpy"``: what the result's tables are; by default as the record.
    progress : True, False, or a function of ``(done, whole, text)``; by default a bar where somebody watches.

    Raises
    ------
    Error : what is wrong with model, record or options, in the words of the program.
    Interrupted : Ctrl-C; the exception's ``result`` has what was proved until then.
    """
    given = dict(locals())
    model = _model(model)
    source = _frames.source(record, exact)
    folder, wants_files = _output(output)
    words = ["observe", _name(model), _words.place(source.name), *folder, *_words.words(given)]
    done = _show(progress, lambda bar: _veribound.observe(model._model, source, words, wants_files, bar))
    return _ended(done, Observation(done, model, _frames.choose(frames, record), output))


def identify(
    model: Any,
    records: Any,
    *,
    time: Optional[str] = None,
    column: Optional["Mapping[str, str]"] = None,
    from_: Optional[Text] = None,
    to: Optional[Text] = None,
    reset: "Union[None, str, Sequence[str]]" = None,
    input_error: Optional[Names] = None,
    output_error: Optional[Names] = None,
    tightness: Optional[float] = None,
    paving: Optional[str] = None,
    least_error: bool = False,
    least_disturbance: bool = False,
    sets: Optional[int] = None,
    threads: Optional[int] = None,
    memory: Optional[int] = None,
    resume: bool = False,
    output: Any = None,
    figures: Any = None,
    report: Optional[str] = None,
    parquet: bool = False,
    exact: bool = False,
    frames: Optional[str] = None,
    progress: Any = None,
) -> Identification:
    """Bounds parameters from whole records, from both sides.

    Guarantee: every value that agrees with the model and all records lies in the outer bounds; both ends of the inner
    ones are proved to be reached. The result does not depend on the number of threads.

    Parameters
    ----------
    records : one record or a list of them, of one machine: they share the parameters, each has start states of its
        own. What a record can be, see `observe`.
    tightness : outer bounds that are proved to be at most so many times as wide as possible are tight enough.
    paving : divide the prior into tiles inside, outside and undecided, until the undecided ones are this share of
        what is left, as ``"1%"``.
    least_error : also tell how large measurement errors must be at least for anything to agree, as
        `Identification.least_error`; this is always told where nothing agrees.
    least_disturbance : the same of errors of inputs and of disturbances, in ``summary``.
    sets : most sets of parameters that are looked at.
    threads : as many as the machine has if not given.
    memory : MiB for sets and tiles, beside those in work; nothing is divided further when it is taken.
    resume : go on where an earlier call with the same arguments was ended by force or by Ctrl-C, from the checkpoint in
        the folder `output`; the result is that of a call that was never ended.

    The other parameters, and what is raised, are those of `observe`.
    """
    given = dict(locals())
    model = _model(model)
    several = isinstance(records, (list, tuple))
    sources = [_frames.source(record, exact) for record in (records if several else [records])]
    if not sources:
        raise ValueError("there is no record; give one or more")
    if resume and output is None:
        raise ValueError("a run without a folder keeps nothing to resume from; give `output`")
    folder, wants_files = _output(output)
    names = [_words.place(source.name) for source in sources]
    words = ["identify", _name(model), *names, *folder, *_words.words(given)]
    done = _show(progress, lambda bar: _veribound.identify(model._model, sources, words, wants_files, bar))
    first = records[0] if several else records
    return _ended(done, Identification(done, model, _frames.choose(frames, first), output))


def enclose(
    model: Any,
    inputs: Any = None,
    *,
    until: Optional[Text] = None,
    every: Optional[Text] = None,
    parts: Optional[int] = None,
    engine: Optional[str] = None,
    sample: Optional[int] = None,
    seed: Optional[int] = None,
    plane: Any = None,
    output: Any = None,
    figures: Any = None,
    report: Optional[str] = None,
    parquet: bool = False,
    exact: bool = False,
    frames: Optional[str] = None,
    progress: Any = None,
) -> Enclosure:
    """Bounds all solutions of a model: every start, parameter, disturbance and input error that it allows.

    Parameters
    ----------
    inputs : inputs over time, each value held until the next row: what a record can be, see `observe`. Not needed
        for a model without inputs.
    until, every : time of the last row, and between two rows, in seconds.
    parts : parts that the set may be divided into where it is too wide.
    engine : ``"auto"``, ``"forms"``, ``"closed"`` (for modes that are affine in the states), ``"comparison"`` or
        ``"boxes"``; what is proved is true whichever is taken.
    sample, seed : draw so many random true trajectories and compare them with the bounds.
    plane : the two states of the phase plane among the files.

    The other parameters, and what is raised, are those of `observe`.
    """
    given = dict(locals())
    model = _model(model)
    source = _inputs(given, exact)
    folder, wants_files = _output(output)
    words = ["enclose", _name(model), *folder, *_words.words(given)]
    done = _show(progress, lambda bar: _veribound.enclose(model._model, source, words, wants_files, bar))
    return _ended(done, Enclosure(done, model, _frames.choose(frames, inputs), output))


def simulate(
    model: Any,
    inputs: Any = None,
    *,
    params: Optional[Names] = None,
    start: Optional[Names] = None,
    change: "Union[None, str, Sequence[str]]" = None,
    until: Optional[Text] = None,
    every: Optional[Text] = None,
    error: Optional[Text] = None,
    disturbance: Optional[Names] = None,
    random: bool = False,
    seed: Optional[int] = None,
    decimals: Optional[int] = None,
    steps: Optional[int] = None,
    trajectory: Any = None,
    figures: Any = None,
    exact: bool = False,
    frames: Optional[str] = None,
    progress: Any = None,
) -> Simulation:
    """Makes a record of a model with known parameters; its errors are proved to stay in their bounds.

    Parameters
    ----------
    inputs : inputs over time, each value held until the next row: what a record can be, see `observe`.
    params : value of every parameter, ``{"alpha": -2}``.
    start : start value of the states whose model has an interval.
    change : new values from a time on, ``"40:T_Fs=0.2"``.
    until, every : time of the last sample, and between two, in seconds.
    error : largest error of a written output, in its unit, or ``"worst"``.
    disturbance : values of disturbances; the middle of their bounds where none is given.
    random : draw what is not given from the model file: parameters and start values once, disturbances and errors of
        inputs anew at every sample; the first line of the record tells what was drawn.
    seed : chooses the errors, and what is drawn.
    decimals : decimal places of the written outputs.
    steps : internal steps for each sample: more make the enclosure narrower and take longer.
    trajectory : folder for the trajectory itself: states, outputs and modes over time, and its `figures`.

    The other parameters, and what is raised, are those of `observe`.
    """
    given = dict(locals())
    model = _model(model)
    source = _inputs(given, exact)
    words = ["simulate", _name(model), "-o", "record.csv", *_words.words(given)]
    done = _show(progress, lambda bar: _veribound.simulate(model._model, source, words, bar))
    if done.interrupted:
        raise Interrupted(None)
    return _ended(done, Simulation(done.text, model, _frames.choose(frames, inputs), done.notes))
