"""What is said of compiling, to whom, and how often."""

import os
import pty
import select
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.make_dataset import Crowd, write_dataset
from vbbench.kernel_sources import _source
from vbbench.kernels import MESSAGE

KERNEL = """
import sys
sys.path.insert(0, sys.argv[1])
from kernels_of_a_test import twice
assert twice(2.0) == 4.0 and twice(3) == 6
"""

MODULE = """
from vbbench.kernels import kernel

@kernel
def twice(value):
    return 2 * value
"""

UNCACHED = """
from numba import njit
import vbbench.kernels

assert njit(lambda value: 2 * value)(2) == 4
"""


def on_terminal(command: list[str], cache: Path, patience: float = 300.0) -> str:
    """What a command writes to a terminal on which are its standard output and error."""
    ours, theirs = pty.openpty()
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    with subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, env=environment) as process:
        os.close(theirs)
        written, ends = b"", time.monotonic() + patience
        while time.monotonic() < ends:
            if not select.select([ours], [], [], 1.0)[0]:
                continue
            try:
                chunk = os.read(ours, 65536)
            except OSError:  # closed: nobody writes any more
                break
            if not chunk:
                break
            written += chunk
        assert process.wait(timeout=60) == 0, written.decode()
    os.close(ours)
    return written.decode()


@pytest.fixture
def kernel_script(tmp_path: Path) -> list[str]:
    (tmp_path / "kernels_of_a_test.py").write_text(MODULE)
    return [sys.executable, "-c", KERNEL, str(tmp_path)]


@pytest.mark.slow
def test_compiling_is_said_once_on_a_terminal_and_not_where_the_cache_has_it(
    kernel_script: list[str], tmp_path: Path
) -> None:
    assert on_terminal(kernel_script, tmp_path / "cache").count(MESSAGE) == 1
    assert MESSAGE not in on_terminal(kernel_script, tmp_path / "cache")


@pytest.mark.slow
def test_nothing_is_said_where_nobody_reads_it(kernel_script: list[str], tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    run = subprocess.run(kernel_script, capture_output=True, text=True, check=True, env=environment)
    assert (run.stdout, run.stderr) == ("", "")


def test_what_others_compile_is_theirs_to_tell(tmp_path: Path) -> None:
    assert MESSAGE not in on_terminal([sys.executable, "-c", UNCACHED], tmp_path / "cache")


@pytest.mark.slow
def test_workers_say_it_once_in_all(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data", Crowd(scenes=16, sequences=96))
    vbbench = [sys.executable, "-m", "vbbench", "solve", str(tmp_path / "data"), "--solver", "sf"]
    how = ["--protocol", "rollout", "--jobs", "2", "--out", str(tmp_path / "out")]
    assert on_terminal([*vbbench, *how], tmp_path / "cache").count(MESSAGE) == 1
    assert MESSAGE not in on_terminal([*vbbench, *how, "--overwrite"], tmp_path / "cache")


COUNTED = """
import sys
sys.path.insert(0, sys.argv[1])
from kernels_of_a_test import twice
print("ready", flush=True)
sys.stdin.readline()
assert twice(2.0) == 4.0 and twice(3) == 6
print(sum(twice.stats.cache_misses.values()))
"""


@pytest.mark.slow
def test_of_several_processes_one_compiles(kernel_script: list[str], tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-c", COUNTED, str(tmp_path)]
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    processes = [subprocess.Popen(command, env=environment, **pipes) for _ in range(3)]
    for process in processes:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    compiled = [int(process.communicate("now\n", timeout=300)[0]) for process in processes]
    assert sum(compiled) == 2  # the float and the whole number


@pytest.mark.slow
def test_an_index_never_names_code_of_an_older_source(tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    run = partial(subprocess.run, capture_output=True, text=True, env=environment)
    (tmp_path / "kernels_of_a_test.py").write_text(MODULE.replace("2 * value", "3 * value"))
    call = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from kernels_of_a_test import twice; print(twice(2.0))"
    assert run([sys.executable, "-c", call]).stdout == "6.0\n"
    (tmp_path / "kernels_of_a_test.py").write_text(MODULE + "\n# another source\n")
    killed = "from vbbench import kernels; import os; kernels._CacheFile._save_data = lambda *_: os._exit(9)\n"
    assert run([sys.executable, "-c", killed + call]).returncode == 9
    assert run([sys.executable, "-c", call]).stdout == "4.0\n"


INNER = """
from vbbench.kernels import kernel

FACTOR = 2.0

@kernel
def scaled(value):
    return FACTOR * value
"""

CALLER = """
from vbbench.kernels import kernel
from vbbench_of_a_test.{0} import (
    {1},
)

@kernel
def {2}(value):
    return {1}(value)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "answer"), [("FACTOR = 2.0", "FACTOR = 3.0", "6.0\n"), ("* value", "* value + 1.0", "5.0\n")]
)
def test_a_kernel_is_compiled_anew_where_another_file_of_its_code_changed(
    old: str, new: str, answer: str, tmp_path: Path
) -> None:
    """A constant or a callee, imported by way of a third file."""
    package = tmp_path / "vbbench_of_a_test"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "inner.py").write_text(INNER)
    (package / "between.py").write_text(CALLER.format("inner", "scaled", "passed_on"))
    (package / "outer.py").write_text(CALLER.format("between", "passed_on", "asked"))
    call = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from vbbench_of_a_test.outer import asked"
    command = [sys.executable, "-c", f"{call}; print(asked(2.0))"]
    # Python takes bytecode for up to date if the source was changed within a second and is as long as before
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    run = partial(subprocess.run, command, capture_output=True, text=True, env=environment)
    assert run().stdout == "4.0\n"
    (package / "inner.py").write_text(INNER.replace(old, new))
    assert run().stdout == answer


@pytest.mark.slow
def test_a_cache_that_names_a_class_that_has_moved_is_compiled_anew(tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    pair = "from typing import NamedTuple\nclass Pair(NamedTuple):\n    left: float\n    right: float\n"
    total = "from vbbench.kernels import kernel\n@kernel\ndef total(pair):\n    return pair.left + pair.right\n"
    call = "import sys; sys.path.insert(0, '.'); import sums; print(sums.total(sums.Pair(2.0, 3.0)))"
    run = partial(subprocess.run, [sys.executable, "-c", call], capture_output=True, text=True, env=environment)
    for place in ("pairs", "moved_pairs"):  # Python tells sources of one second apart by size
        (tmp_path / "pairs.py").unlink(missing_ok=True)
        (tmp_path / f"{place}.py").write_text(pair)
        (tmp_path / "sums.py").write_text(f"from {place} import Pair\n{total}")
        done = run(cwd=tmp_path)
        assert done.stdout == "5.0\n", done.stderr


TREE = """
from vbbench.kernels import kernel

@kernel
def leaf(value):
    if value < 0.0:
        raise ValueError("negative")
    return 2.0 * value

@kernel
def branch(value):
    return leaf(value) + leaf(value + 1.0)

@kernel
def root(value):
    return branch(value) + leaf(value)
"""


@pytest.mark.slow
def test_inner_kernels_have_no_code_of_their_own_until_python_calls_them(tmp_path: Path) -> None:
    (tmp_path / "tree.py").write_text(TREE)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    run = partial(subprocess.run, capture_output=True, text=True, cwd=tmp_path, env=environment)

    def tried(*calls: str) -> list[str]:
        misses = "print(*(sum(f.stats.cache_misses.values()) for f in (root, branch, leaf)))"
        code = "\n".join(["import sys; sys.path.insert(0, '.')", "from tree import *", *calls, misses])
        done = run([sys.executable, "-c", code])
        assert done.returncode == 0, done.stderr
        cached = {path.name.split(".")[1].split("-")[0] for path in (tmp_path / "cache").rglob("*.nbc")}
        return [*sorted(cached), done.stdout.strip()]

    assert tried("assert root(1.0) == 8.0") == ["root", "1 1 1"]
    refused = "try: leaf(-1.0)\nexcept ValueError as error: assert str(error) == 'negative'\nelse: assert False"
    assert tried("assert root(1.0) == 8.0", "assert leaf(1.0) == 2.0", refused) == ["leaf", "root", "0 0 1"]
    assert tried("assert branch(1.0) == 6.0", "assert root(1.0) == 8.0") == ["branch", "leaf", "root", "0 1 0"]
    assert tried("assert leaf(1.0) == 2.0", "assert branch(2.0) == 10.0") == ["branch", "leaf", "root", "0 0 0"]


def test_a_kernel_called_first_by_another_and_then_by_python_is_compiled_for_both(tmp_path: Path) -> None:
    (tmp_path / "tree.py").write_text(TREE)
    code = "import sys; sys.path.insert(0, '.'); from tree import *; print(root(1.0), leaf(1.0), branch(1), root(2.0))"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert done.stdout == "8.0 2.0 6.0 14.0\n", done.stderr


SHARED = """
import numpy as np
from numba import njit
from vbbench.kernels import kernel

def middle(values):
    doubled = np.zeros(len(values))
    doubled[:] = 2.0 * values
    return doubled[1] + np.mean(values)

ours, theirs = kernel(middle), njit(middle)
values = np.array((3.0, 1.0, 2.0, 5.0))
"""


@pytest.mark.slow
@pytest.mark.parametrize("first", ["ours", "theirs"])
def test_what_is_numbas_serves_kernels_and_what_others_compile(first: str, tmp_path: Path) -> None:
    (tmp_path / "shared.py").write_text(SHARED)
    second = {"ours": "theirs", "theirs": "ours"}[first]
    code = f"import sys; sys.path.insert(0, '.'); from shared import *; print({first}(values), {second}(values))"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    run = partial(subprocess.run, capture_output=True, text=True, cwd=tmp_path, env=environment)
    for _ in ("compiled", "from the cache"):
        done = run([sys.executable, "-c", code])
        assert done.stdout == "4.75 4.75\n", done.stderr


@pytest.mark.slow
def test_numba_is_as_it_was_after_a_kernel_that_does_not_compile(tmp_path: Path) -> None:
    (tmp_path / "faulty.py").write_text(
        "from vbbench.kernels import kernel\n\n@kernel\ndef faulty(x):\n    return x.y\n"
    )
    code = """
import sys; sys.path.insert(0, '.')
import numba
from numba.core.compiler import Compiler
from numba.core.dispatcher import Dispatcher
before = Compiler.define_pipelines, Dispatcher.add_overload
from faulty import faulty
try: faulty(1.0)
except numba.TypingError: print((Compiler.define_pipelines, Dispatcher.add_overload) == before)
"""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert done.stdout == "True\n", done.stderr


RETURNING = """
from typing import NamedTuple
import numpy as np
from vbbench.geometry import FloatArray
from vbbench.kernels import kernel

class Inner(NamedTuple):
    values: FloatArray
    number: int

class Outer(NamedTuple):
    one: Inner
    pair: tuple[FloatArray, FloatArray]
    values: FloatArray

@kernel
def summed(values, rounds):
    total = 0.0
    for n in range(rounds):
        total += np.sin(n * values[0])
    return total

@kernel
def named(values, rounds):
    return Outer(Inner(values + summed(values, rounds), 3), (values, values), values)

@kernel
def plain(values, rounds):
    return values + summed(values, rounds), 3, values

ones = np.ones(3)
"""

STOPPING = """
import os, signal, sys, threading
sys.path.insert(0, ".")
from returning import Outer, named, ones, plain

for function in (named, plain):
    function(ones, 1)
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    try:
        while True:
            function(ones, 3_000_000)
    except KeyboardInterrupt:
        print("stopped")
    assert type(function(ones, 1)) is (Outer if function is named else tuple)
"""

OLDER = """
import contextlib, sys
import vbbench.inner_kernels, vbbench.kernels

sys.path.insert(0, ".")
vbbench.kernels._HOW, vbbench.inner_kernels.tuples_made_safely = "as an older version does", contextlib.nullcontext
from returning import named, ones, plain
print(named(ones, 1), plain(ones, 1))
"""


@pytest.mark.slow
def test_a_signal_while_a_kernel_runs_is_an_exception_whatever_it_returns(tmp_path: Path) -> None:
    """Also where an older version compiled the same kernels, and from the cache."""
    (tmp_path / "returning.py").write_text(RETURNING)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def run(code: str) -> str:
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, env=environment
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "Outer" in run(OLDER)
    assert [run(STOPPING), run(STOPPING)] == 2 * ["stopped\nstopped\n"]


def test_a_bracket_in_a_comment_does_not_end_an_import(tmp_path: Path) -> None:
    (tmp_path / "one.py").write_text("from vbbench import (  # all (of it)\n    geometry,\n    boxes,  # and :)\n)\n")
    _, imported = _source(tmp_path / "one.py")
    assert {path.stem for path in imported} >= {"geometry", "boxes"}
