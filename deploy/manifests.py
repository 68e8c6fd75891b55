"""What Kubernetes manifests say, as kubectl renders them: what confines a pod, and which pods may reach which."""

import json
import subprocess

NAMESPACE = "ppnpack"


def rendered(folder):
    """What kubectl would apply; ValueError where it would not."""
    # To annotate is a way to have them as JSON without a cluster.
    command = ["kubectl", "annotate", "--local", "--kustomize", folder, "--output", "json", "checked=yes"]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode:
        raise ValueError(f"kubernetes/{folder.name}: {run.stderr.strip()}")
    objects, text = [], run.stdout.strip()
    while text:
        found, end = json.JSONDecoder().raw_decode(text)
        objects.append(found)
        text = text[end:].lstrip()
    return objects


def of_kind(objects, *kinds):
    return [found for found in objects if found["kind"] in kinds]


def workloads(objects):
    """What runs pods, by the name that their label gives them."""
    found = {}
    for workload in of_kind(objects, "Deployment", "StatefulSet", "DaemonSet", "Job", "CronJob", "Pod"):
        found[labels(workload).get("app.kubernetes.io/name", workload["metadata"]["name"])] = workload
    return found


def template(workload):
    if workload["kind"] == "CronJob":
        return workload["spec"]["jobTemplate"]["spec"]["template"]
    return workload if workload["kind"] == "Pod" else workload["spec"]["template"]


def labels(workload):
    return template(workload)["metadata"].get("labels", {})


def ports(workload):
    """The ports of a workload's containers."""
    return [{"name": port.get("name"), "number": port["containerPort"]}
            for container in template(workload)["spec"]["containers"] for port in container.get("ports", [])]


def unconfined(workload):
    """What a workload lacks of what confines it."""
    pod = template(workload)["spec"]
    security = pod.get("securityContext", {})
    checks = {
        "runAsNonRoot": security.get("runAsNonRoot") is True,
        "a user and a group": security.get("runAsUser", 0) > 0 and security.get("runAsGroup", 0) > 0,
        "the seccomp profile": security.get("seccompProfile") == {"type": "RuntimeDefault"},
        "automountServiceAccountToken: false": pod.get("automountServiceAccountToken") is False,
        "the namespace": workload["metadata"].get("namespace") == NAMESPACE,
        "separation from the host": not any(pod.get(key) for key in ("hostNetwork", "hostPID", "hostIPC"))
        and not any("hostPath" in volume for volume in pod.get("volumes", [])),
    }
    for container in [*pod["containers"], *pod.get("initContainers", [])]:
        own, resources = container.get("securityContext", {}), container.get("resources", {})
        of_container = {
            "readOnlyRootFilesystem": own.get("readOnlyRootFilesystem") is True,
            "allowPrivilegeEscalation: false": own.get("allowPrivilegeEscalation") is False,
            "capabilities: {drop: [ALL]}": own.get("capabilities") == {"drop": ["ALL"]},
            "the user of its pod": not {"runAsUser", "runAsNonRoot", "privileged"} & set(own),
            "requests": {"cpu", "memory"} <= set(resources.get("requests", {})),
            "a limit of memory": "memory" in resources.get("limits", {}),
        }
        if container in pod["containers"]:
            of_container |= {probe: probe in container for probe in ("startupProbe", "livenessProbe", "readinessProbe")}
        checks |= {what: has and checks.get(what, True) for what, has in of_container.items()}
    return [what for what, has in checks.items() if not has]


OPERATORS = {
    "In": lambda value, values: value in values,
    "NotIn": lambda value, values: value not in values,
    "Exists": lambda value, _: value is not None,
    "DoesNotExist": lambda value, _: value is None,
}


def selects(selector, has):
    """Whether a selector takes what has these labels."""
    return all(has.get(key) == value for key, value in selector.get("matchLabels", {}).items()) and all(
        OPERATORS[one["operator"]](has.get(one["key"]), one.get("values")) for one in selector.get("matchExpressions", []))


def lets(policies, direction, own, other, port):
    """Whether policies let what has the labels `own` speak with what has the labels `other`, in one namespace."""
    concerned = [policy["spec"] for policy in policies if direction in policy["spec"].get("policyTypes", ["Ingress"])
                 and selects(policy["spec"]["podSelector"], own)]
    if not concerned:
        return True
    for rule in (rule for spec in concerned for rule in spec.get(direction.lower(), [])):
        if rule.get("ports") and not any(one.get("port", port["name"]) in port.values() for one in rule["ports"]):
            continue
        # None are all; and addresses are those of others.
        for peer in rule.get({"Ingress": "from", "Egress": "to"}[direction]) or [{}]:
            if "ipBlock" not in peer and selects(peer.get("podSelector", {}), other) and selects(
                    peer.get("namespaceSelector", {}), {"kubernetes.io/metadata.name": NAMESPACE}):
                return True
    return False


def reached(objects):
    """Who may reach whom on which port, in the namespace."""
    policies, of, found = of_kind(objects, "NetworkPolicy"), workloads(objects), set()
    for name, workload in of.items():
        found |= {(other, name, port["number"]) for port in ports(workload) for other in of if other != name
                  and lets(policies, "Egress", labels(of[other]), labels(workload), port)
                  and lets(policies, "Ingress", labels(workload), labels(of[other]), port)}
    return found
