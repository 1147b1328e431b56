"""What the READMEs show is run, block by block."""

import re

import matplotlib
import pytest

import veribound as vb
from conftest import ROOT

matplotlib.use("Agg")


@pytest.mark.parametrize("page, blocks", [("README.md", 1), ("python/README.md", 2)])
def test_python_blocks_run(page, blocks, monkeypatch):
    text = (ROOT / page).read_text(encoding="utf-8")
    found = re.findall(r"^```python\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)
    assert len(found) == blocks
    monkeypatch.chdir(ROOT)
    names = {}
    for block in found:
        exec(block, names)  # noqa: S102
    assert -2 in names["result"]["alpha"]
    # The numbers that the pages tell.
    told = re.findall(r"\[-2\.0184, -1\.9863\]", text)
    assert told and str(names["result"]["alpha"]) == told[0]
    if page.startswith("python"):
        # The model built in Python is the one that the file tells with `friction`.
        file = vb.Model.load("examples/drive-train/model-friction.toml")
        built, read = names["model"].observe(names["frame"], to=5), file.observe(names["frame"], to=5)
        assert list(built["T_Fs"]) == list(read["T_Fs"])
