"""Tests what is made of access.toml: the rules, and the keys of those who have them.

    python3 -m unittest discover --start-directory deploy/secure --pattern test_table.py
"""

import copy
import os
import pathlib
import subprocess
import tempfile
import tomllib
import unittest

import access

WIRE = access.Wire(access.WIRE)


class Table(unittest.TestCase):
    def setUp(self):
        self.table = tomllib.loads((access.HERE / "access.toml").read_text())

    def refusal(self, change):
        """What is said to a table after a change."""
        table = copy.deepcopy(self.table)
        change(table)
        with self.assertRaises(access.Wrong) as refused:
            access.check(WIRE, table)
        return str(refused.exception)

    def keys(self, name, flow, message):
        rules = access.rules_of(WIRE, name, self.table[name])
        return [key for _, own, messages, keys in rules if own == flow and message in messages for key in keys]

    def test_the_table_is_as_it_should_be(self):
        access.check(WIRE, self.table)

    def test_every_identity_names_its_cells(self):
        for name in self.table:
            self.assertIn(f"{name}: name its cells", self.refusal(lambda table: table[name].pop("cells")))
        self.assertIn("controller: name its cells", self.refusal(lambda table: table["controller"].update(cells=["a/b"])))

    def test_who_changes_something_is_not_for_every_cell(self):
        for name in ("perception", "bridge", "planner", "controller", "sensor"):
            told = self.refusal(lambda table: table[name].update(cells=["*"]))
            self.assertIn(f"{name}: name its cells, as it changes", told)
        told = self.refusal(lambda table: table["observer"]["asks"].append("bridge/hold"))
        self.assertIn("observer: name its cells, as it changes what is in them, by bridge/hold", told)

    def test_who_answers_what_decisions_rest_on_is_not_for_every_cell(self):
        self.assertEqual(self.keys("ppn", "ingress", "put"), [])
        for name, method in (("ppn", "propose"), ("heuristic", "evaluate")):
            told = self.refusal(lambda table: table[name].update(cells=["*"]))
            self.assertIn(f"{name}: name its cells, as it changes what is in them, by answers of {name}/{method}", told)

    def test_identities_have_names_of_their_own(self):
        for name in ("authority", "router", "a/b", "*", "Controller", ""):
            told = self.refusal(lambda table: table.update({name: table["sensor"]}))
            self.assertIn(f"'{name}' can be no identity", told)

    def test_a_controller_reaches_no_other_cell(self):
        sent = self.keys("controller", "ingress", "query")
        self.assertIn("ppnpack/v1/cell-1/rpc/bridge/place", sent)
        others = [key for key in sent if not key.startswith("ppnpack/v1/cell-1/") and "/health" not in key]
        self.assertEqual(others, [])

    def test_a_sensor_fills_no_other_cell(self):
        self.assertEqual(self.keys("sensor", "ingress", "put"), ["ppnpack/v1/cell-1/cloud", "ppnpack/v1/cell-1/tray_cloud"])

    def test_a_service_answers_for_its_cells(self):
        for name in ("perception", "bridge", "planner", "heuristic", "ppn"):
            for message in ("reply", "declare_queryable", "liveliness_token"):
                own = [key for key in self.keys(name, "ingress", message) if "/health" not in key]
                self.assertTrue(own)
                self.assertEqual([key for key in own if not key.startswith("ppnpack/v1/cell-1/")], [])

    def test_services_publish_and_read_what_their_sources_do(self):
        told = self.refusal(lambda table: table["planner"]["publishes"].append("cloud"))
        self.assertIn("planner.publishes lists ['cloud', 'plan', 'record', 'session']", told)
        told = self.refusal(lambda table: table["bridge"]["publishes"].remove("cloud"))
        self.assertIn("bridge.publishes", told)
        told = self.refusal(lambda table: table["perception"]["subscribes"].remove("tray_cloud"))
        self.assertIn("perception.subscribes", told)

    def test_keys_are_for_their_owners_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([access.HERE / "make", folder], check=True, capture_output=True)
            found = {path.parent.name: path.stat() for path in pathlib.Path(folder).rglob("key.pem")}
            self.assertEqual(set(found), {"authority", "router", *self.table})
            self.assertEqual({name: oct(own.st_mode & 0o777) for name, own in found.items()}, dict.fromkeys(found, "0o600"))
            if os.getuid() == 0:
                services = {"router", *(name for name, entry in self.table.items() if "serves" in entry)}
                self.assertEqual({name for name, own in found.items() if own.st_uid == 10001}, services)


if __name__ == "__main__":
    unittest.main()
