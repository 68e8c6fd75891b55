"""Pages of results: what a script measured, and notes by hand that a new run keeps."""

import datetime
import json
import pathlib
import platform
import shlex
import sys

# Everything from this line on is written by hand.
NOTES = "<!-- Notes: what follows is kept when the experiment is run again. -->"


def row(*cells):
    return f"| {' | '.join(map(str, cells))} |\n"


def table(heads, rows):
    """A table of lines that `row` made."""
    return row(*heads) + f"|{'---|' * len(heads)}\n" + "".join(rows)


def publish(path, text, results, version):
    """Writes a page and its figures as JSON beside it, each with what made it."""
    origin = {
        "command": shlex.join(["python", *sys.argv]),
        "version": version,
        "machine": f"{platform.machine()}, {platform.system()}",
        "made": f"{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%dT%H:%M:%SZ}",
    }
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.with_suffix(".json").write_text(json.dumps({**results, "origin": origin}, indent=2, ensure_ascii=False))
    made = "Made by `{command}` on {made} ({machine}), version {version}.".format(**origin)
    notes = path.read_text().partition(NOTES)[2] if path.exists() else ""
    path.write_text(f"{text.rstrip()}\n\n{made}\n\n{NOTES}{notes or chr(10)}")
    print(path)
