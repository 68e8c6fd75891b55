"""Tests deploy/check: what must not be is told."""

import importlib.machinery
import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import manifests  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent


def load():
    loader = importlib.machinery.SourceFileLoader("check", str(HERE / "check"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("check", loader))
    loader.exec_module(module)
    return module


READ = {"base": ("kubernetes/base", "kubernetes/images"), "monitoring": ("kubernetes/monitoring", "observability")}


def once(render):
    """Renders the same files only once: most tests change what one of the two does not read."""
    known = {}

    def rendered(folder):
        files = [path for name in READ[folder.name] for path in sorted((folder.parents[1] / name).glob("*.*"))]
        key = tuple(path.read_text() for path in files)
        if key not in known:
            known[key] = render(folder)
        return known[key]

    return rendered


manifests.rendered = once(manifests.rendered)


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
        for check in ("of_configuration", "of_page", "of_kubernetes", "of_monitoring", "of_tags", "of_passwords"):
            self.assertEqual(list(getattr(self.check, check)()), [], check)

    def test_cells_are_those_of_the_planner_and_of_the_access_table(self):
        for path in (*(f"configuration/{name}.toml" for name in ("perception", "bridge", "heuristic", "ppn")), "secure/access.toml"):
            with self.subTest(path):
                self.setUp()
                self.assertIn("cell-2", self.told("of_configuration", path, "cell-1", "cell-2"))

    def test_the_page_is_on_a_network_of_its_own(self):
        told = "compose.yaml: other containers reach the operator's page, past the access control"
        for path, before, after in (
            ("compose.yaml", "networks: {cell: {}, page: {aliases: [page]}}", "networks: [cell, outside]"),
            ("compose.yaml", "LISTEN=$$(getent ahostsv4 page | head -n 1 | cut -d \" \" -f 1)", "LISTEN=0.0.0.0"),
            ("compose.observability.yaml", "networks: [cell, outside]", "networks: [cell, page]"),
        ):
            with self.subTest(path):
                self.setUp()
                self.assertEqual(self.told("of_page", path, before, after), told)

    def test_grids_are_those_of_the_planner(self):
        told = self.told("of_configuration", "configuration/perception.toml", "z_m = 0.30", "z_m = 0.40")
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

    def missed(self, *breaks):
        """Whether each of these, with the files as they are otherwise, is told: where it is, what is there, what is put there
        for it, and what is told."""
        for path, before, after, wanted in breaks:
            with self.subTest(wanted):
                self.setUp()
                self.assertIn(wanted, self.told("of_monitoring", path, before, after).splitlines())

    def test_whatever_an_alert_speaks_of_is_scraped(self):
        self.missed(
            ("observability/alerts.yaml", 'job="ppnpack", process="ppn"', 'job="other", process="ppn"',
             "alerts.yaml speaks of other, which prometheus.yaml has no job for"),
            ("observability/prometheus.yaml", "job_name: ppnpack", "job_name: other",
             "alerts.yaml speaks of ppnpack, which prometheus.yaml has no job for"),
            ("observability/prometheus.yaml", "heuristic, ", "",
             "alerts.yaml speaks of heuristic, which prometheus.yaml has no target for"),
        )

    def test_a_receiver_has_to_be_given(self):
        place = "kubernetes/monitoring/alertmanager.yaml"
        secret = "{secretKeyRef: {name: ppnpack-alerts-receiver, key: url}}"
        without = f"{place} takes its receiver from no secret that has to be there"
        self.missed(
            ("observability/alertmanager.sh", "${RECEIVER:?", "${RECEIVER:-", "alertmanager.sh starts without a receiver"),
            ("observability/alertmanager.yaml", "http://receiver.invalid/", "http://other.invalid/",
             "alertmanager.sh does not find the receiver of alertmanager.yaml"),
            ("observability/alertmanager.sh", "s|http://receiver.invalid/|", "s#http://receiver.invalid/#",
             "alertmanager.sh does not find the receiver of alertmanager.yaml"),
        )
        if shutil.which("kubectl"):
            self.missed(
                (place, f"valueFrom: {secret}", "value: http://receiver.invalid/", without),
                (place, "key: url}}", "key: url, optional: true}}", without),
                (place, "name: RECEIVER", "name: OTHER", without),
                ("kubernetes/monitoring/targets.yaml", "# The", "{apiVersion: v1, kind: Secret, metadata: {name: a}}\n---\n#",
                 "kubernetes/monitoring has what it should not: a Secret"),
            )

    def test_alertmanager_starts_with_the_receiver_that_is_given(self):
        folder = self.check.HERE / "observability"
        (folder / "alertmanager").write_text('#!/bin/sh\necho "$@"\n')
        (folder / "alertmanager").chmod(0o755)
        environment = {"PATH": f"{folder}:/usr/bin:/bin", "TMPDIR": self.check.HERE}
        command = ["sh", folder / "alertmanager.sh", "--storage.path=/a"]
        for receiver in (None, ""):
            given = {} if receiver is None else {"RECEIVER": receiver}
            run = subprocess.run(command, env=environment | given, capture_output=True, text=True)
            self.assertNotEqual(run.returncode, 0)
            self.assertIn("set it to the URL of the webhook", run.stderr)
        receiver = "https://alerts.example/?a=1&b=|\\1"
        run = subprocess.run(command, env=environment | {"RECEIVER": receiver + "\n"}, capture_output=True, text=True)
        written = self.check.HERE / "alertmanager.yaml"
        self.assertEqual(run.stdout, f"--config.file={written} --storage.path=/a\n", run.stderr)
        self.assertEqual(written.read_text(),
                         (folder / "alertmanager.yaml").read_text().replace("http://receiver.invalid/", receiver))
        self.assertEqual(written.stat().st_mode & 0o077, 0)

    @unittest.skipUnless(shutil.which("kubectl"), "kubectl is not here")
    def test_kubernetes_runs_the_monitoring_of_compose(self):
        of = "kubernetes/monitoring/{}.yaml".format
        other_alerts = f"{of('prometheus')} does not have observability/alerts.yaml as it is"
        own = "--from-literal=url=https://...\n"
        with_copies = "configMapGenerator: [{name: prometheus, behavior: merge, literals: [alerts.yaml=none]}]\n"
        self.missed(
            (of("kustomization"), own, own + with_copies, other_alerts),
            ("observability/kustomization.yaml", "prometheus.yaml, alerts.yaml", "prometheus.yaml", other_alerts),
            (of("alertmanager"), "configMap: {name: alertmanager}", "configMap: {name: prometheus}",
             f"{of('alertmanager')} does not have observability/alertmanager.sh as it is"),
            (of("prometheus"), "prometheus:v3.4.0", "prometheus:v3.4.1",
             f"{of('prometheus')} does not run the image of compose.observability.yaml, prom/prometheus:v3.4.0"),
            ("compose.observability.yaml", "alertmanager:v0.28.1", "alertmanager:v0.28.2",
             f"{of('alertmanager')} does not run the image of compose.observability.yaml, prom/alertmanager:v0.28.2"),
            (of("prometheus"), "  strategy: {type: Recreate}\n", "", f"{of('prometheus')} may run twice"),
            (of("alertmanager"), "replicas: 1", "replicas: 2", f"{of('alertmanager')} may run twice"),
            (of("prometheus"), "claimName: ppnpack-metrics", "claimName: other",
             f"{of('prometheus')} has no claim for what it keeps"),
            (of("kustomization"), "  - alertmanager.yaml\n", "", "kubernetes/monitoring runs no alertmanager"),
            (of("prometheus"), "app.kubernetes.io/name: prometheus", "app.kubernetes.io/name: other",
             "kubernetes/monitoring runs other, too"),
        )
        told = self.told("of_monitoring", "observability/kustomization.yaml", "alerts.yaml]", "none.yaml]")
        self.assertIn("none.yaml", told)

    @unittest.skipUnless(shutil.which("kubectl"), "kubectl is not here")
    def test_kubernetes_has_the_names_that_prometheus_asks_for(self):
        targets, name = "kubernetes/monitoring/targets.yaml", "kubernetes/monitoring: the name {}".format
        spec = "publishNotReadyAddresses: true\n  selector: {app.kubernetes.io/name: bridge}"
        every = f"{name('bridge')} does not stand for every pod, ready or not"
        self.missed(
            (targets, "  name: planner\n", "  name: other\n", f"{name('planner')} is missing, which prometheus.yaml asks for"),
            (targets, "selector: {app.kubernetes.io/name: ppn}", "selector: {app.kubernetes.io/name: planner}",
             f"{name('ppn')} stands for ['planner']"),
            (targets, spec, spec.replace("true", "false"), every),
            (targets, f"  clusterIP: None\n  {spec}", f"  {spec}", every),
            ("observability/prometheus.yaml", "port: 9100", "port: 9101", f"{name('router')} leads to no port 9101"),
            ("observability/prometheus.yaml", "alertmanager:9093", "alertmanager:9094",
             f"{name('alertmanager')} leads to no port 9094"),
            ("kubernetes/monitoring/alertmanager.yaml", "targetPort: alerts", "targetPort: other",
             f"{name('alertmanager')} leads to no port 9093"),
        )
        self.assertIn("kubernetes/monitoring/targets.yaml lacks bridge",
                      self.told("of_services", targets, "{app.kubernetes.io/name: bridge}", "{app.kubernetes.io/name: other}"))

    @unittest.skipUnless(shutil.which("kubectl"), "kubectl is not here")
    def test_kubernetes_lets_prometheus_in_and_nobody_else(self):
        place, base = "kubernetes/monitoring/network.yaml", "kubernetes/base/network.yaml"
        prometheus = "        - podSelector:\n            matchLabels: {app.kubernetes.io/name: prometheus}\n      ports: [{port: "
        anyone = "        - podSelector: {}\n      ports: [{port: "
        others = f"{place}: {{}} lets in others than pods of the namespace".format
        self.missed(
            (place, "bridge, planner, console]", "bridge, console]",
             "kubernetes: prometheus cannot reach planner at 9100"),
            (place, "port: 9100", "port: 9101", "kubernetes: prometheus cannot reach router at 9100"),
            (place, "port: 9093", "port: 9094", "kubernetes: prometheus cannot reach alertmanager at 9093"),
            (place, "port: alerts", "port: other", "kubernetes: prometheus cannot reach alertmanager at 9093"),
            (place, "port: admin", "port: other", "kubernetes: prometheus cannot reach bridge at 9100"),
            (place, f"{prometheus}admin", f"{anyone}admin", "kubernetes: alertmanager may reach planner at 9100"),
            (place, f"    - from:\n{prometheus}admin", "    - ports: [{port: admin", others("admin")),
            (place, f"{prometheus}alerts", anyone.replace("pod", "namespace") + "alerts", others("alertmanager")),
            (base, "values: [prometheus, alertmanager]", "values: [prometheus]",
             "kubernetes: alertmanager may reach router at 7447"),
            (base, "ports: [{port: 7447", "ports: [{port: 7448", "kubernetes: planner cannot reach router at 7447"),
        )

    @unittest.skipUnless(shutil.which("kubectl"), "kubectl is not here")
    def test_kubernetes_confines_every_pod(self):
        lines = {
            "runAsNonRoot: true": ("runAsNonRoot: false", "runAsNonRoot"),
            "seccompProfile: {type: RuntimeDefault}": ("seccompProfile: {type: Unconfined}", "the seccomp profile"),
            "automountServiceAccountToken: false": ("shareProcessNamespace: false", "automountServiceAccountToken: false"),
            "enableServiceLinks: false": ("hostNetwork: true", "separation from the host"),
            "readOnlyRootFilesystem: true": ("readOnlyRootFilesystem: false", "readOnlyRootFilesystem"),
            "allowPrivilegeEscalation: false": ("privileged: true", "allowPrivilegeEscalation: false"),
            "capabilities: {drop: [ALL]}": ("capabilities: {drop: [NET_RAW]}", "capabilities: {drop: [ALL]}"),
            "limits: {memory:": ("limits: {cpu:", "a limit of memory"),
            "requests: {cpu:": ("requests: {other:", "requests"),
            "startupProbe:": ("other:", "startupProbe"),
            "livenessProbe:": ("lifecycle:", "livenessProbe"),
            "readinessProbe:": ("more:", "readinessProbe"),
        }
        for place in ("monitoring/prometheus", "monitoring/alertmanager", "base/ppn", "base/bridge"):
            # All at once: each is told for itself.
            self.setUp()
            path = f"kubernetes/{place}.yaml"
            text = (self.check.HERE / path).read_text()
            for before, (after, _) in lines.items():
                self.assertIn(before, text)
                text = text.replace(before, after)
            told = self.told("of_monitoring", path, (self.check.HERE / path).read_text(), text).splitlines()
            for _, lacks in lines.values():
                self.assertIn(f"{path} lacks {lacks}", told)
        planner, monitoring = "kubernetes/base/planner.yaml", "kubernetes/monitoring"
        self.missed(
            (planner, "runAsUser: 10001", "runAsUser: 0", f"{planner} lacks a user and a group"),
            (planner, "runAsGroup: 10001", "runAsGroup: 0", f"{planner} lacks a user and a group"),
            (planner, "emptyDir: {sizeLimit: 16Mi}", "hostPath: {path: /tmp}", f"{planner} lacks separation from the host"),
            (planner, "allowPrivilegeEscalation: false", "runAsUser: 0", f"{planner} lacks the user of its pod"),
            (f"{monitoring}/kustomization.yaml", "namespace: ppnpack", "namespace: other",
             f"{monitoring}/alertmanager.yaml lacks the namespace"),
        )

    def test_every_alert_has_a_test(self):
        told = self.told("of_alerts", "observability/alerts_test.yaml", "alertname: SessionFailed\n", "alertname: Other\n")
        self.assertIn("alerts_test.yaml never has SessionFailed fire", told)


if __name__ == "__main__":
    unittest.main()
