"""What a record can be."""

import datetime
from decimal import Decimal

import numpy as np
import pandas as pd
import polars as pl
import pytest

import veribound as vb
from conftest import SLED, push


def same(a, b):
    return list(a["m"]) == list(b["m"]) and list(a["Fc"]) == list(b["Fc"])


def test_narrow_floats_stand_for_their_own_decimals(sled):
    record = push()
    narrow = {name: np.array(values, dtype=np.float32) for name, values in record.items()}
    assert same(sled.observe(narrow), sled.observe(record))


def test_clocks_and_durations_are_exact_seconds(sled):
    record = push()
    plain = sled.observe(record)
    begin = pd.Timestamp("2026-03-29 01:59:59.5")
    clock = pd.DatetimeIndex([begin + pd.Timedelta(milliseconds=10 * k) for k in range(201)])
    for index in (clock, clock.tz_localize("UTC").tz_convert("Europe/Berlin"), clock - begin):
        frame = pd.DataFrame({"F": record["F"], "pos": record["pos"]}, index=index)
        result = sled.observe(frame)
        assert same(result, plain) and list(result.times) == record["t"], index.dtype
    frame = pl.DataFrame(
        {"time": [datetime.timedelta(milliseconds=10 * k) for k in range(201)], "F": record["F"], "pos": record["pos"]}
    )
    assert same(sled.observe(frame), plain)


def test_missing_values_are_missing_in_all_frames(sled):
    record = push()
    holes = [None if k % 3 == 1 else x for k, x in enumerate(record["pos"])]
    frame = pd.DataFrame({**record, "pos": pd.array(holes, dtype="Float64")})
    plain = sled.observe({**record, "pos": [float("nan") if x is None else x for x in holes]})
    assert plain.notes == ["pos: 67 values missing"]
    assert same(sled.observe(frame), plain)
    assert same(sled.observe({**record, "pos": holes}), plain)
    assert same(sled.observe(pl.DataFrame({**record, "pos": holes})), plain)
    assert np.isnan(plain.measured["pos.lo"].iloc[1])


def test_exact_numbers_of_python_are_exact(sled):
    record = push()
    exact = {name: [Decimal(str(x)) for x in values] for name, values in record.items()}
    assert same(sled.observe(exact), sled.observe(record))
    whole = {"t": np.arange(3), "F": np.zeros(3, dtype=np.int32), "pos": np.zeros(3, dtype=np.uint8)}
    assert sled.observe(whole).verdict == "consistent"


def test_units_in_column_names_are_converted(sled):
    record = push()
    scaled = {"t [s]": record["t"], "F [kN]": [x / 1000 for x in record["F"]], "pos [mm]": record["pos"]}
    result = sled.observe(scaled)
    assert result.verdict == "inconsistent"
    scaled["pos [mm]"] = [round(1000 * x, 1) for x in record["pos"]]
    result = sled.observe(scaled)
    assert result.verdict == "consistent"
    assert all(any(unit in said for said in result.assumptions) for unit in ("mm", "kN"))


def test_floats_of_a_binary_file_are_exact(sled, tmp_path):
    frame = pl.DataFrame(push())
    frame.write_parquet(tmp_path / "push.parquet")
    by_path, exact = sled.observe(tmp_path / "push.parquet"), sled.observe(frame, exact=True)
    assert by_path.states.to_numpy().tolist() == exact.states.drop("t").to_numpy().tolist()


def test_columns_with_other_names(sled):
    record = push()
    renamed = {"zeit": record["t"], "Kraft, N": record["F"], 'so "x"': record["pos"], "extra": record["pos"]}
    result = sled.observe(renamed, time="zeit", column={"F": "Kraft, N", "pos": 'so "x"'})
    assert same(result, sled.observe(record))
    assert result.notes == ["columns not used: extra"]


def test_what_is_no_record_is_refused(sled):
    with pytest.raises(TypeError, match="a record is a path"):
        sled.observe(7)
    with pytest.raises(ValueError, match="different lengths"):
        sled.observe({"t": [0, 1], "F": [0], "pos": [0, 0]})
    with pytest.raises(ValueError, match=r"shape \(1, 2\)"):
        sled.observe({"t": np.zeros((1, 2))})
    with pytest.raises(TypeError, match="is no number"):
        sled.observe({"t": [0, 1], "F": [0, object()], "pos": [0, 0]})
    with pytest.raises(ValueError, match="is not known"):
        sled.observe(push(), frames="excel")


def test_frames_come_back_as_they_were_given(sled):
    record = push(rows=61)
    assert isinstance(sled.observe(pd.DataFrame(record)).params, pd.DataFrame)
    assert isinstance(sled.observe(pl.DataFrame(record)).params, pl.DataFrame)
    columns = sled.observe(record, frames="numpy").states
    assert columns["x.lo"].shape == (61,) and set(columns["modes"][:10]) != set()
    assert sled.observe(pl.DataFrame(record), frames="pandas").params.index.name == "t"


def test_ten_lines_from_a_frame_to_bounds():
    frame = pd.DataFrame(push())
    result = vb.Model.from_toml(SLED).observe(frame, every=1)
    assert 2.0 in result["m"] and 1.0 in result["Fc"]
    assert result["m"].width < 2
