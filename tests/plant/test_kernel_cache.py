"""The machine code that is kept: what is damaged is compiled again; where nothing can be kept it runs all the same."""

import json
import os
import subprocess
import sys

import pytest

CODE = """
import json, sys
from pipeline.plant import kernel
told = []
kernel.compiles(lambda: told.append(1))
from pipeline.plant.fmi_kernel import _cleared
from pipeline.plant.kernel import array_at, kernel as compiled
from pipeline.identify.ekf_kernel import factor
import numpy as np
L = np.zeros((2, 2))
print(json.dumps([bool(factor(np.array([[4.0, 1.0], [1.0, 2.0]]), L)), L.tolist(), len(told), str(kernel._folder)]))
"""
RIGHT = [True, [[4.0, 0.0], [0.25, 1.75]]]


def factored(cache, **variables):
    """What a kernel gives in a process of its own, whether compiling was announced, and the cache's folder."""
    environment = {**os.environ, "FMUID_CACHE": str(cache), **variables}
    done = subprocess.run([sys.executable, "-c", CODE], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    *found, told, folder = json.loads(done.stdout)
    assert found == RIGHT
    return told, folder


def test_compiling_is_announced_once_and_what_is_kept_is_used(tmp_path):
    assert factored(tmp_path)[0] == 1
    assert factored(tmp_path)[0] == 0


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("content", [b"", b"garbage\n", None], ids=["empty", "garbage", "truncated"])
def test_a_damaged_cache_is_compiled_again(tmp_path, suffix, content):
    _, folder = factored(tmp_path)
    files = [os.path.join(root, name) for root, _, names in os.walk(folder) for name in names if name.endswith(suffix)]
    assert files
    for file in files:
        with open(file, "rb") as old:
            whole = old.read()
        with open(file, "wb") as new:
            new.write(whole[: len(whole) // 2] if content is None else content)
    assert factored(tmp_path)[0] == 1
    assert factored(tmp_path)[0] == 0  # and kept again


def test_where_nothing_can_be_kept_it_runs_all_the_same(tmp_path):
    (tmp_path / "file").write_text("no folder")
    told, folder = factored(tmp_path / "file", HOME="/proc/nowhere", XDG_CACHE_HOME="/proc/nowhere")
    assert told == 1 and folder == "None"
