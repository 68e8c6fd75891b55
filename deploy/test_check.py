"""Tests deploy/check: what must not be is told."""

import importlib.machinery
import importlib.util
import pathlib
import shutil
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent


def load():
    sys.dont_write_bytecode = True
    loader = importlib.machinery.SourceFileLoader("check", str(HERE / "check"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("check", loader))
    loader.exec_module(module)
    return module


class Check(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.check = load()
        self.check.HERE = pathlib.Path(folder.name) / "deploy"
        shutil.copytree(HERE, self.check.HERE, ignore=shutil.ignore_patterns("identities", "__pycache__"))

    def told(self, check, path, before, after):
        """What a check says once there is something else in a file."""
        path = self.check.HERE / path
        text = path.read_text()
        self.assertIn(before, text)
        path.write_text(text.replace(before, after))
        return "\n".join(getattr(self.check, check)())

    def test_the_files_are_as_they_should_be(self):
        for check in ("of_configuration", "of_kubernetes", "of_tags", "of_passwords"):
            self.assertEqual(list(getattr(self.check, check)()), [], check)

    def test_cells_are_those_of_the_planner_and_of_the_access_table(self):
        for path in ("configuration/perception.toml", "configuration/bridge.toml", "secure/access.toml"):
            with self.subTest(path):
                self.setUp()
                self.assertIn("cell-2", self.told("of_configuration", path, "cell-1", "cell-2"))

    def test_grids_are_those_of_the_planner(self):
        told = self.told("of_configuration", "configuration/perception.toml", "yaws = 8", "yaws = 16")
        self.assertIn("other grids for cell-1", told)

    def test_kubernetes_speaks_mutual_tls_by_default(self):
        told = self.told("of_kubernetes", "kubernetes/base/zenoh.yaml", "tls/ppnpack-router", "tcp/ppnpack-router")
        self.assertIn("an endpoint without TLS", told)
        told = self.told("of_kubernetes", "kubernetes/base/planner.yaml", "identity-planner", "identity-bridge")
        self.assertIn("planner.yaml lacks its identity", told)

    def test_kubernetes_never_runs_two_routers(self):
        told = self.told("of_kubernetes", "kubernetes/base/router.yaml", "  strategy: {type: Recreate}\n", "")
        self.assertIn("router.yaml lacks the strategy Recreate", told)

    def test_kubernetes_lets_traces_out(self):
        told = self.told("of_kubernetes", "kubernetes/base/network.yaml", "port: 4318", "port: 4317")
        self.assertIn("lets no traces out", told)

    def test_every_pod_has_a_disruption_budget(self):
        told = self.told("of_services", "kubernetes/base/disruption.yaml", "bridge, ", "")
        self.assertIn("kubernetes/base/disruption.yaml lacks bridge", told)

    def test_images_are_named_by_digests(self):
        path = "kubernetes/images/kustomization.yaml"
        told = self.told("of_services", path, 'digest: "sha256:', 'newTag: latest, old: "sha256:')
        self.assertIn(f"{path} lacks router", told)
        self.assertEqual(list(self.check.of_tags()), [f"{path} names an image latest"])

    def test_no_password_has_a_default(self):
        told = self.told("of_passwords", "compose.observability.yaml", "${GRAFANA_PASSWORD:?", "${GRAFANA_PASSWORD:-")
        self.assertIn("lets in who knows no password: GF_SECURITY_ADMIN_PASSWORD", told)

    def test_every_process_is_missed(self):
        told = self.told("of_services", "observability/alerts.yaml", 'process="planner"', 'process="other"')
        self.assertIn("observability/alerts.yaml lacks planner", told)

    def test_every_alert_has_a_test(self):
        told = self.told("of_alerts", "observability/alerts_test.yaml", "alertname: SessionFailed\n", "alertname: Other\n")
        self.assertIn("alerts_test.yaml never has SessionFailed fire", told)


if __name__ == "__main__":
    unittest.main()
