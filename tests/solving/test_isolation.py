"""What `--isolate` keeps from a solver that wants truth, and how it ends."""

import io
import json
import os
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from tests.lib.commands import wait_until
from vbbench.errors import VbbenchError, VbbenchWarning
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.protocol import get_protocol
from vbbench.solver import Problem
from vbbench.solving import solve
from vbbench.solving.isolation import remote, serving
from vbbench.solving.isolation.confinement import folders_with, landlock_version, readable_paths
from vbbench.solving.isolation.remote import IsolatedSolver
from vbbench.solving.isolation.serving import MessageError, read_message, write_message
from vbbench.solving.runner import run_sequence

SECRET = b"truth"
needs_landlock = pytest.mark.skipif(landlock_version() == 0, reason="the kernel has no Landlock")
VBBENCH = [sys.executable, "-m", "vbbench"]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Where a user stands: a stranger's module next to datasets."""
    folder = tmp_path_factory.mktemp("user")
    shutil.copy(Path(__file__).parents[1] / "lib" / "hostile_solvers.py", folder / "hostile.py")
    generate("demo", folder / "demo", Options(limit=3))
    sys.path.insert(0, str(folder))
    yield folder
    sys.path.remove(str(folder))


@pytest.fixture(scope="module")
def dataset(place: Path) -> Dataset:
    return Dataset(place / "demo")


def answer(dataset: Dataset, name: str) -> Estimate:
    """What the isolated solver answers to the first sequence, with truth at hand."""
    sequence = dataset.sequence(0)
    with IsolatedSolver(name, [dataset.folder]) as solver:
        solver.is_now("solving sequence 0")
        return run_sequence(
            solver, dataset.problem(sequence), sequence, get_protocol("one-step"), dataset.truth(sequence)
        )[0]


@pytest.fixture(scope="module")
def targets(place: Path, dataset: Dataset) -> Iterator[dict[str, Any]]:
    """What there is to be had next to a stranger's solver, written down for it."""
    shutil.copytree(dataset.folder, place / "copies/another")  # its truth is that of the first
    (place / "link").symlink_to(dataset.folder)
    files = {
        "truth": "demo/truth/poses.parquet",
        "what is given": "demo/given.parquet",
        "dataset.json": "demo/dataset.json",
        "truth of a copy": "copies/another/truth/scenes.parquet",
        "truth by a link": "link/truth/people.parquet",
        "answers of others": "submission/poses.csv",
        "drafts": "demo.partial/parts/0.arrows",
        "source files": "data/biwi_hotel.txt",
        "keys": ".netrc",
        "dataset through root": f"/proc/self/root{place}/demo/dataset.json",
    }
    for name in ("answers of others", "drafts", "source files", "keys"):
        (place / files[name]).parent.mkdir(parents=True, exist_ok=True)
        (place / files[name]).write_text("secret")
    bytecode = Path(serving.__file__).parent / "__pycache__"
    bytecode.mkdir(exist_ok=True)
    folders = {
        "bytecode of vbbench": bytecode,
        "user's folder": place,
        "dataset": dataset.folder,
        "temporary folder": tempfile.gettempdir(),
    }
    with socket.create_server(("127.0.0.1", 0)) as server:
        Thread(target=_serve, args=(server,), daemon=True).start()
        known = {
            "dataset": str(dataset.folder),
            "truth": str(place / files["truth"]),
            "home": str(Path.home()),
            "port": server.getsockname()[1],
            "files": {name: str(place / path) for name, path in files.items()},
            "folders": {name: str(path) for name, path in folders.items()},
        }
        (place / "targets.json").write_text(json.dumps(known))
        yield known
    for folder in folders.values():
        Path(folder, "escaped.pyc").unlink(missing_ok=True)


def _serve(server: socket.socket) -> None:
    with suppress(OSError):  # until it is closed
        while True:
            server.accept()[0].send(SECRET)


@pytest.fixture(scope="module")
def loot(place: Path, dataset: Dataset, targets: dict[str, Any]) -> dict[str, str]:
    """What a burglar gets when `solve` runs it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VBBENCH_DATA", str(place / "data"))
        patch.setenv("OMP_STRANGE", str(dataset.folder))
        patch.chdir(place)
        with pytest.raises(Exception, match="RuntimeError") as caught:
            solve(dataset, "hostile:Burglar", "one-step", place / "answer", isolate=True)
    got: dict[str, str] = json.loads(str(caught.value).rpartition("RuntimeError: ")[2])
    return got


ALL = """import json, sys
sys.path.append('.')
import hostile
targets = json.loads(hostile.TARGETS_FILE.read_text())
print(json.dumps([list(json.loads(hostile.loot())), list(hostile.attempts(targets))]))"""


def test_a_burglar_who_is_not_isolated_gets_everything(place: Path, targets: dict[str, Any]) -> None:
    command = [sys.executable, "-c", ALL, targets["dataset"]]
    done = subprocess.run(command, cwd=place, capture_output=True, check=True)
    by_privilege = {"memory of the parent", "process_vm_readv", "ptrace", "open files of the parent"}
    got, tried = json.loads(done.stdout)
    assert len(tried) >= 27
    assert set(tried) - set(got) <= by_privilege


@pytest.mark.slow
def test_a_burglar_finds_no_path_that_leads_to_the_dataset(loot: dict[str, str]) -> None:
    assert "paths left over" not in loot


@needs_landlock
def test_a_burglar_gets_nothing_where_the_kernel_has_landlock(loot: dict[str, str]) -> None:
    assert set(loot) <= {"paths left over", "udp"}, loot


def test_there_is_no_network_where_the_kernel_has_namespaces(loot: dict[str, str]) -> None:
    code = "import sys; from vbbench.solving.isolation import confinement; sys.exit(not confinement.leave_namespaces())"
    if subprocess.run([sys.executable, "-c", code], check=False).returncode:
        pytest.skip("the kernel lets nobody here make namespaces")
    assert "udp" not in loot


def test_a_pickle_is_not_loaded(place: Path, dataset: Dataset) -> None:
    mark = place / "unpickled"
    (place / "targets.json").write_text(json.dumps({"mark": str(mark)}))
    np.testing.assert_array_equal(answer(dataset, "hostile:Pickler").poses, 1.0)
    assert not mark.exists()


@pytest.mark.slow
def test_the_solver_is_not_imported_where_truth_is(place: Path, dataset: Dataset) -> None:
    solve(dataset, "hostile:Honest", "one-step", place / "honest", isolate=True)
    assert "hostile" not in sys.modules


def test_arrays_come_as_plain_ones(dataset: Dataset) -> None:
    estimate = answer(dataset, "hostile:Subclasser")
    assert type(estimate.positions) is np.ndarray
    np.testing.assert_array_equal(estimate.poses[0], [1.0, 2.0, 3.0])


def test_all_frames_of_a_sequence_have_one_problem(dataset: Dataset) -> None:
    """A solver of whole sequences may go on from the frames before, under `one-step`."""
    assert (answer(dataset, "hostile:Counting").poses[2:, 0] == 1.0).all()


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("Greedy", r"sent 'positions' of shape \[68719476736, 2\], not \[\d+, 2\], while solving sequence 0"),
        ("Shapeless", r"sent 'positions' of shape \[\d+, 2\], not \[\d+, 2\], while solving sequence 0"),
        ("Poseless", r"sent an answer without 'pose', while solving sequence 0"),
        ("Quitter", r"left with exit status 3 while solving sequence 0; it printed last: .*good bye$"),
    ],
)
def test_what_is_no_answer_is_one_line(dataset: Dataset, name: str, says: str) -> None:
    with pytest.raises(VbbenchError, match=f"^solver 'hostile:{name}' {says}") as caught:
        answer(dataset, f"hostile:{name}")
    assert str(caught.value).isprintable()


@pytest.mark.slow
def test_the_sequence_that_a_solver_fails_at_is_named(place: Path, dataset: Dataset) -> None:
    assert len(dataset.sequence(1).tracks) < len(dataset.sequence(0).tracks)
    for name, says in {
        "Quitter": "left with exit status 3 while solving sequence 0;",
        "Disappointed": r"failed while solving sequence 1:(?s:.*)fewer people than before",
    }.items():
        with pytest.raises(VbbenchError, match=f"solver 'hostile:{name}' {says}"):
            solve(dataset, f"hostile:{name}", "one-step", place / name, isolate=True)


def test_a_failure_is_shown_within_limits_and_without_control_characters(dataset: Dataset) -> None:
    with pytest.raises(VbbenchError, match="failed while solving sequence 0:\n") as caught:
        answer(dataset, "hostile:Colourful")
    assert len(str(caught.value)) < 6000
    assert str(caught.value).replace("\n", "").isprintable()
    with pytest.raises(VbbenchError, match="TypeError: the solver returned a list, not a FrameEstimate"):
        answer(dataset, "hostile:Lister")


def test_printing_does_not_disturb_answers(dataset: Dataset) -> None:
    np.testing.assert_array_equal(answer(dataset, "hostile:Chatty").poses, 0.0)


@pytest.mark.slow
def test_what_cannot_be_loaded_is_said(place: Path) -> None:
    for name, says in {
        "hostile:Absent": "has no attribute 'Absent'",
        "nobody:Home": "cannot be imported: ModuleNotFoundError",
        "hostile:message": "is not a class that can be called without arguments",
        "builtins:dict": "dict is not a solver: it has neither start and step nor solve",
    }.items():
        with pytest.raises(VbbenchError, match=says), IsolatedSolver(name):
            pass


ASKED = {"pose": (serving.FLOAT, (3,)), "fallback": (serving.BOOL, ())}


def packed(facts: Any, body: bytes = b"") -> bytes:
    header = facts if isinstance(facts, bytes) else json.dumps(facts).encode()
    return struct.pack("<I", len(header)) + header + body


@pytest.mark.parametrize(
    ("message", "says"),
    [
        (b"\xff\xff\xff\xff{", "begins with 4294967295 bytes of facts"),
        (packed(b"\x80\x04cposix\nsystem\n"), "not JSON"),
        (packed(b"[" * 60_000), "not JSON"),
        (packed(b'{"arrays": ' + b"9" * 9_000 + b"}"), "not JSON"),
        (packed([]), "not a JSON object"),
        (packed({"said": "done"}), "without a list of arrays"),
        (packed({"arrays": {"pose": 1}}), "without a list of arrays"),
        (packed({"arrays": [["pose", "<f8", 3]]}), "list of arrays is garbled"),
        (packed({"arrays": [["pose", "<f8", [3.0]]]}), "list of arrays is garbled"),
        (packed({"arrays": [["pose", "<f8", [True]]]}), "list of arrays is garbled"),
        (packed({"arrays": [["pose", "<f8", [3]], ["pose", "<f8", [3]]]}), "list of arrays is garbled"),
        (packed({"arrays": [["loss\x1b", "<f8", [3]]]}), "an array 'loss ', which was not requested"),
        (packed({"arrays": [["pose", "|O", [3]]]}), r"'pose' of type \|O, not <f8"),
        (packed({"arrays": [["pose", "<f4", [3]]]}), "'pose' of type <f4, not <f8"),
        (packed({"arrays": [["pose", "<f8", [4]]]}), r"'pose' of shape \[4\], not \[3\]"),
        (packed({"arrays": [["pose", "<f8", [-3]]]}), r"'pose' of shape \[-3\], not \[3\]"),
        (packed({"arrays": [["pose", "<f8", [1 << 62]]]}), r"'pose' of shape \[4611686018427387904\], not \[3\]"),
        (packed({"arrays": [["pose", "<f8", [3]]]}, b"short"), "nothing more"),
        (b"\x05\x00\x00\x00{", "nothing more"),
    ],
)
def test_messages_are_checked(message: bytes, says: str) -> None:
    with pytest.raises(MessageError, match=says):
        read_message(io.BytesIO(message), ASKED)


def test_messages_come_as_they_were_sent() -> None:
    arrays = {"fallback": np.array(True), "empty": np.zeros((0, 2)), "pose": np.array([1.0, np.nan, -0.0])}
    pipe = io.BytesIO()
    write_message(pipe, {"said": "done"}, arrays)
    pipe.seek(0)
    facts, got = read_message(pipe)
    assert facts == {"said": "done"}
    for name, array in arrays.items():
        np.testing.assert_array_equal(got[name], array)
        assert got[name].dtype == array.dtype
        assert got[name].flags.aligned
    odd = packed({"arrays": [["fallback", serving.BOOL, []]]}, b"\x07")
    assert read_message(io.BytesIO(odd), ASKED)[1]["fallback"].tobytes() == b"\x01"


def test_rules_keep_around_what_is_hidden(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("mine.py", "weights/a.npz", "lib/b.py", "lib/data/truth/poses.parquet", "lib/data/c.txt", "d/e.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    for name in (".git/x", "truth/heights", "lib/data/dataset.json", "notes/.hidden", "notes/f.txt", "env/pyvenv.cfg"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "root").symlink_to("/")
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    granted = [Path(path) for path in readable_paths([tmp_path / "d"])]
    mine = sorted(str(path.relative_to(tmp_path)) for path in granted if path.is_relative_to(tmp_path))
    assert mine == ["lib/b.py", "mine.py", "notes/f.txt", "weights"]
    assert not any(tmp_path.is_relative_to(path) for path in granted)
    stdlib = Path(os.__file__).parent.resolve()
    spared = [Path(path) for path in readable_paths([stdlib / "json"])]
    assert not any((stdlib / "json/decoder.py").is_relative_to(path) for path in spared)
    assert any((stdlib / "csv.py").is_relative_to(path) for path in spared)
    assert tmp_path.resolve() / "x.truth" in folders_with(tmp_path / "x")


@pytest.mark.slow
def test_where_files_stay_open_it_is_said(monkeypatch: pytest.MonkeyPatch, dataset: Dataset, tmp_path: Path) -> None:
    monkeypatch.setattr(remote, "landlock_version", lambda: 0)
    with pytest.warns(VbbenchWarning, match="this system cannot keep files from an isolated solver"):
        solve(dataset, "cv", "rollout", tmp_path / "out", isolate=True)


OUTS: dict[str, Any] = {"here": {}, "apart": {"isolate": True}, "two": {"isolate": True, "jobs": 2}}


@pytest.mark.slow
def test_answers_do_not_depend_on_isolation_and_jobs(dataset: Dataset, tmp_path: Path) -> None:
    crowd = Dataset(generate("sim", tmp_path / "sim", Options(limit=70)).folder)
    for out, options in OUTS.items():
        solve(crowd, "cv", "one-step", tmp_path / out, **options)
    tables = [{path.name: path.read_bytes() for path in tmp_path.glob(f"{out}/*.parquet")} for out in OUTS]
    assert len(tables[0]) == 2
    assert tables[0] == tables[1] == tables[2]


def children_of(process: int) -> dict[int, str]:
    """Every process below another, and what it runs."""
    found: dict[int, str] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            name, _, rest = stat.read_text().partition("(")[2].rpartition(")")
            if int(rest.split()[1]) == process:
                found |= {int(stat.parent.name): name, **children_of(int(stat.parent.name))}
    return found


def alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL], ids=lambda how: how.name)
def test_it_ends_in_one_line_and_leaves_no_process(dataset: Dataset, place: Path, how: signal.Signals) -> None:
    command = ["solve", "demo", "--solver", "hostile:Endless", "--out", "endless", "--isolate", "--overwrite"]
    run = subprocess.Popen([*VBBENCH, *command], cwd=place, stderr=subprocess.PIPE, text=True, start_new_session=True)
    wait_until(lambda: "sleep" in children_of(run.pid).values())  # the solver is at work, and so is what it started
    left = children_of(run.pid)
    os.killpg(run.pid, how)  # as a terminal does
    _, errors = run.communicate(timeout=60)
    if how == signal.SIGINT:
        assert (run.returncode, errors.count("\n")) == (130, 1), errors
    else:  # nobody is left to end what the solver started
        sleeping = [process for process, name in left.items() if name == "sleep"]
        left = {process: name for process, name in left.items() if process not in sleeping}
        wait_until(lambda: not any(map(alive, left)))
        for process in sleeping:
            os.kill(process, signal.SIGKILL)
    wait_until(lambda: not any(map(alive, left)))


def test_nothing_is_left_in_the_temporary_folder(
    dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    answer(dataset, "hostile:Honest")
    with pytest.raises(VbbenchError):
        answer(dataset, "hostile:Quitter")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_modules_where_the_user_stands_do_not_pass_for_installed_ones(dataset: Dataset, tmp_path: Path) -> None:
    for name in ("tqdm", "pyarrow", "joblib"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('imported where truth is')\n")
    shutil.copy(Path(__file__).parents[1] / "lib" / "hostile_solvers.py", tmp_path / "hostile.py")
    command = [sys.executable, "-P", "-m", "vbbench", "solve", str(dataset.folder), "--solver", "hostile:Honest"]
    done = subprocess.run(
        [*command, "--out", "out", "--isolate"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_a_problem_names_no_path(dataset: Dataset) -> None:
    problem: Problem = dataset.problem(dataset.sequence(0))
    texts = {name: value for name, value in vars(problem).items() if isinstance(value, str | Path)}
    assert texts == {"carried_by": "unknown"}
    assert pq.read_table(dataset.table_path("truth/poses")).num_rows  # there is truth to be had
