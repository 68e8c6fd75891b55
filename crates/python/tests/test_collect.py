"""A dataset of packings is the same, byte for byte, whoever packs it and whatever is lost on the way."""

import importlib.util
import os
import pathlib
import secrets
import signal
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np
import pytest

SCRIPT = pathlib.Path(__file__).resolve().parents[3] / "examples" / "python" / "collect_packings.py"
WITHIN_S = 180


def command(out, way, *more):
    sizes = ["--packings", "11", "--per-shard", "2", "--workers", "2"]
    return [sys.executable, str(SCRIPT), "--out", str(out), "--way", way, *sizes, *more]


def files(out):
    return {path.name: path.read_bytes() for path in out.iterdir()}


def collect(out, way, *more):
    done = subprocess.run(command(out, way, *more), capture_output=True, text=True, timeout=WITHIN_S)
    assert done.returncode == 0, done.stderr
    return files(out)


@pytest.fixture(scope="module")
def sequential(tmp_path_factory):
    """What packing one after the other makes."""
    out = tmp_path_factory.mktemp("sequential")
    made = collect(out, "sequence")
    assert len(made) == 6 + 1
    return out, made


def test_shards_say_of_each_step_what_was_chosen_on_what(sequential):
    out, _ = sequential
    with np.load(out / "seeds-000000004-000000005.npz") as shard:
        assert shard["seed"].tolist() == [4, 5]
        steps = int(shard["steps"].sum())
        assert steps > 4 and len(shard["heightmap"]) == len(shard["buffer"]) == len(shard["value"]) == steps
        # A packing begins with an empty container, and each step raises what lies there.
        first = shard["heightmap"][: shard["steps"][0]]
        heights = first.astype(np.int64).sum((1, 2))
        assert heights[0] == 0 and (np.diff(heights) > 0).all()
        slots = shard["placement"][:, 0]
        assert (shard["buffer"][np.arange(steps), slots] >= 0).all()


def test_processes_make_the_same_bytes(tmp_path, sequential):
    assert collect(tmp_path, "processes") == sequential[1]


def test_what_was_cut_off_goes_on_where_it_was(tmp_path, sequential):
    with subprocess.Popen(command(tmp_path, "sequence"), stdout=subprocess.PIPE, text=True) as cut:
        assert cut.stdout.readline().endswith("written\n")
        cut.kill()
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.npz")}
    assert 0 < len(kept) < 6
    assert collect(tmp_path, "sequence") == sequential[1]
    assert all(path.stat().st_mtime_ns == time for path, time in kept.items())


def test_shards_of_other_settings_are_not_mixed_in(sequential):
    refused = subprocess.run(command(sequential[0], "sequence", "--physics"), capture_output=True, text=True, timeout=WITHIN_S)
    assert refused.returncode == 1 and "other settings" in refused.stderr
    assert files(sequential[0]) == sequential[1]


def parent(pid):
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(status.partition("PPid:")[2].split()[0])


def is_below(pid, ancestor):
    while pid > 1 and pid != ancestor:
        pid = parent(pid)
    return pid == ancestor


def busy_worker(driver):
    """A process of Ray that packs a shard for this program, where there is one."""
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if (folder / "cmdline").read_bytes().startswith(b"ray::shard") and is_below(int(folder.name), driver):
                return int(folder.name)
        except (FileNotFoundError, ProcessLookupError):
            continue  # It ended.
    return None


def test_tasks_of_ray_make_the_same_bytes_though_a_worker_is_lost(tmp_path, sequential):
    if importlib.util.find_spec("ray") is None:
        pytest.skip("ray is not installed: the same shards are made by processes alone, in the tests above")
    with (
        # Its sockets need short paths.
        tempfile.TemporaryDirectory(prefix="ray-", ignore_cleanup_errors=True) as folder,
        subprocess.Popen(
            command(tmp_path, "ray"),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # It listens at all addresses of the machine: nobody else has the token.
            env=os.environ | {"RAY_TMPDIR": folder, "RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)},
        ) as driver,
    ):
        limit = threading.Timer(WITHIN_S, driver.kill)
        limit.start()
        try:
            lost = None
            while lost is None and driver.poll() is None:
                lost = busy_worker(driver.pid)
                time.sleep(0.01)  # Nobody tells when a task begins.
            if lost is not None:
                os.kill(lost, signal.SIGKILL)
            printed, errors = driver.communicate()
        finally:
            limit.cancel()
    assert driver.returncode == 0 and lost is not None, f"{printed}{errors}"
    assert files(tmp_path) == sequential[1]
