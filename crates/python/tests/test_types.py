"""The stubs say what the native part has, and the rest of the package keeps to them."""

import pathlib
import subprocess
import sys

SETTINGS = pathlib.Path(__file__).resolve().parents[1] / "pyproject.toml"


def mypy(tmp_path, *arguments):
    done = subprocess.run([sys.executable, "-m", *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


def test_stubs_are_those_of_the_native_part(tmp_path):
    mypy(tmp_path, "mypy.stubtest", "ppnpack._native")


def test_the_package_keeps_to_its_types(tmp_path):
    mypy(tmp_path, "mypy", "--strict", "--config-file", str(SETTINGS), "--package", "ppnpack")
