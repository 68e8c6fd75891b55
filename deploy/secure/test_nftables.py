"""Tests nftables.conf: between two networks of their own, nobody connects too fast or too often.

    sudo python3 -m unittest discover --start-directory deploy/secure --pattern test_nftables.py
"""

import os
import pathlib
import shutil
import socket
import struct
import subprocess
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
TOOLS = ("nft", "ip", "unshare", "nsenter")
MISSING = [tool for tool in TOOLS if not shutil.which(tool)] + (["root"] if os.geteuid() != 0 else [])
ROUTER, CLIENT = "10.9.0.1", "10.9.0.2"
BURST, MOST = 20, 32
# For a connection that is let in, and one that is not: what is dropped is sent again after 1 s, 3 s, 7 s.
PATIENCE_S, QUICK_S, SILENCE_S = 10.0, 0.1, 4.0


def connect(timeout_s):
    """A connection to the router, or None."""
    try:
        return socket.create_connection((ROUTER, 7447), timeout_s)
    except TimeoutError:
        return None


def client():
    """Says how many of many quick connections are let in, how many of slow ones, and whether one more is where one has gone."""
    quick = [own for own in (connect(QUICK_S) for _ in range(2 * BURST)) if own]
    slow = [connect(PATIENCE_S) for _ in range(MOST - len(quick))]
    more = connect(SILENCE_S)
    # At once, where else the other side has to close it too.
    quick[0].setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    quick[0].close()
    print(len(quick), sum(own is not None for own in slow), more is None, connect(PATIENCE_S) is not None)


def router():
    """Runs the client in a network beside this one."""
    def run(*command):
        subprocess.run(command, check=True)

    listener = socket.create_server(("0.0.0.0", 7447), backlog=2 * MOST)
    beside = subprocess.Popen(["unshare", "--net", "sh", "-c", "echo; exec cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    beside.stdout.readline()
    there = ("nsenter", "--net", "--target", str(beside.pid))
    run("ip", "link", "add", "ppnpack0", "type", "veth", "peer", "name", "ppnpack1", "netns", str(beside.pid))
    run("ip", "address", "add", f"{ROUTER}/24", "dev", "ppnpack0")
    run("ip", "link", "set", "ppnpack0", "up")
    run(*there, "ip", "address", "add", f"{CLIENT}/24", "dev", "ppnpack1")
    run(*there, "ip", "link", "set", "ppnpack1", "up")
    run("nft", "--file", HERE / "nftables.conf")
    run(*there, sys.executable, __file__, "client")
    listener.close()
    beside.communicate()


class Filter(unittest.TestCase):
    @unittest.skipIf(MISSING, f"without {', '.join(MISSING)}")
    def test_an_address_connects_neither_too_fast_nor_too_often(self):
        command = ["unshare", "--net", sys.executable, __file__, "router"]
        run = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        quick, slow, is_full, has_room = run.stdout.split()
        # Five more each second: those that were not let in took 0.1 s each.
        self.assertTrue(BURST <= int(quick) < 2 * BURST, run.stdout)
        self.assertEqual((int(quick) + int(slow), is_full, has_room), (MOST, "True", "True"), run.stdout)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["client"]:
            client()
        case ["router"]:
            router()
        case _:
            unittest.main()
