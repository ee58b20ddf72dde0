//! What is deployed fits what is built: every manifest has the types of the Kubernetes API and no key beside them, and its flags,
//! ports, files and times are those of the real programs. Where `kubectl` is, every overlay is built by it as well.

#![allow(clippy::unwrap_used)] // Its helpers may do what its tests may.
#![cfg(unix)]

use gonio_tests::cluster::{Cluster, command};
use gonio_tests::operations::{free_address, wait_for};
use k8s_openapi::api::apps::v1::Deployment;
use k8s_openapi::api::autoscaling::v2::HorizontalPodAutoscaler;
use k8s_openapi::api::core::v1::{Container, PersistentVolumeClaim, PodSpec, Probe, Service};
use k8s_openapi::api::networking::v1::NetworkPolicy;
use k8s_openapi::api::policy::v1::PodDisruptionBudget;
use k8s_openapi::apimachinery::pkg::util::intstr::IntOrString;
use keda::{ScaledObject, TriggerAuthentication};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

#[path = "kubernetes/keda.rs"]
mod keda;
#[path = "kubernetes/pod.rs"]
mod pod;
#[path = "kubernetes/slurm.rs"]
mod slurm;

const PORT: i32 = 7300;
/// Of probes and metrics.
const OPERATIONS: i32 = 7301;
const SCALER: i32 = 7302;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("k8s")
}

fn documents(text: &str) -> Vec<Value> {
    let parsed = serde_yaml_ng::Deserializer::from_str(text).map(|d| Value::deserialize(d).unwrap());
    parsed.filter(|value| !value.is_null()).collect()
}

/// All manifests as they are written; patches have types too.
fn written() -> Vec<(String, Value)> {
    let mut all = Vec::new();
    for place in ["base", "overlays/local", "overlays/cloud", "overlays/keda"] {
        for entry in std::fs::read_dir(folder().join(place)).unwrap() {
            let path = entry.unwrap().path();
            if !path.ends_with("kustomization.yaml") {
                let text = std::fs::read_to_string(&path).unwrap();
                all.extend(documents(&text).into_iter().map(|d| (path.display().to_string(), d)));
            }
        }
    }
    all
}

/// Fails unless all that `written` says is in `known`, what the types have kept of it.
fn kept(path: &str, written: &Value, known: &Value) {
    match (written, known) {
        (Value::Object(a), Value::Object(b)) => {
            for (key, value) in a {
                let there = b.get(key).unwrap_or_else(|| panic!("{path}.{key} is no key of the API"));
                kept(&format!("{path}.{key}"), value, there);
            }
        }
        (Value::Array(a), Value::Array(b)) => a.iter().zip(b).for_each(|(a, b)| kept(path, a, b)),
        _ => {}
    }
}

fn typed<T: serde::de::DeserializeOwned + serde::Serialize>(path: &str, document: &Value) -> T {
    let value: T = serde_json::from_value(document.clone()).unwrap_or_else(|error| panic!("{path}: {error}"));
    kept(path, document, &serde_json::to_value(&value).unwrap());
    value
}

fn check_types(path: &str, document: &Value) {
    let kind = document["kind"].as_str().unwrap();
    let path = format!("{path}: {kind}");
    match kind {
        "Deployment" => drop(typed::<Deployment>(&path, document)),
        "Service" => drop(typed::<Service>(&path, document)),
        "PodDisruptionBudget" => drop(typed::<PodDisruptionBudget>(&path, document)),
        "NetworkPolicy" => drop(typed::<NetworkPolicy>(&path, document)),
        "HorizontalPodAutoscaler" => drop(typed::<HorizontalPodAutoscaler>(&path, document)),
        "PersistentVolumeClaim" => drop(typed::<PersistentVolumeClaim>(&path, document)),
        // Not of Kubernetes' own API: their types here refuse every key that they do not know.
        "ScaledObject" => {
            let object: ScaledObject = serde_json::from_value(document.clone()).expect(&path);
            object.metadata.check();
        }
        "TriggerAuthentication" => {
            let object: TriggerAuthentication = serde_json::from_value(document.clone()).expect(&path);
            object.metadata.check();
        }
        other => panic!("{path}: {other} is checked by nobody"),
    }
}

/// The flags of a program, by its own help.
fn help(program: &str) -> String {
    String::from_utf8(command(program, &["--help"]).output().unwrap().stdout).unwrap()
}

fn flags(arguments: &[String]) -> BTreeMap<&str, &str> {
    arguments.iter().map(|a| a.strip_prefix("--").unwrap()).map(|a| a.split_once('=').unwrap_or((a, ""))).collect()
}

fn check_pod(program: &str, pod: &PodSpec, container: &Container, arguments: &[String]) {
    let help = help(program);
    let flags = flags(arguments);
    for (name, value) in &flags {
        assert!(help.contains(&format!("--{name}")), "{program} has no --{name}");
        if value.starts_with('/') {
            let mounts = container.volume_mounts.iter().flatten();
            assert!(mounts.clone().any(|m| value.starts_with(&m.mount_path)), "{program}: {value} is mounted nowhere");
        }
    }
    let grace: f64 = flags["grace"].parse().unwrap();
    let patience = pod.termination_grace_period_seconds.unwrap();
    // Two seconds of farewell, and some to begin.
    assert!(grace + 5.0 <= patience as f64, "{program} is killed before its grace has ended");
    assert_eq!(pod.automount_service_account_token, Some(false));
    let security = pod.security_context.as_ref().unwrap();
    assert_eq!(security.run_as_non_root, Some(true));
    let own = container.security_context.as_ref().unwrap();
    assert_eq!((own.allow_privilege_escalation, own.read_only_root_filesystem), (Some(false), Some(true)));
    assert_eq!(own.capabilities.as_ref().unwrap().drop.as_deref(), Some(&["ALL".to_owned()][..]));
    let resources = container.resources.as_ref().unwrap();
    assert!(resources.requests.is_some() && resources.limits.is_some());
    let mounted: Vec<&str> = container.volume_mounts.iter().flatten().map(|m| m.name.as_str()).collect();
    let volumes: Vec<&str> = pod.volumes.iter().flatten().map(|v| v.name.as_str()).collect();
    assert_eq!(mounted, volumes);
}

/// A container's port by its name.
fn port(container: &Container, name: &str) -> Option<i32> {
    let ports = container.ports.iter().flatten();
    ports.clone().find(|port| port.name.as_deref() == Some(name)).map(|port| port.container_port)
}

fn probes(container: &Container) -> [(&'static str, &Probe); 3] {
    let Container { startup_probe, readiness_probe, liveness_probe, .. } = container;
    [("startup", startup_probe), ("ready", readiness_probe), ("live", liveness_probe)]
        .map(|(name, probe)| (name, probe.as_ref().unwrap_or_else(|| panic!("no probe for {name}"))))
}

/// Every probe asks its own path of the port that the program is told to answer at.
fn check_probes(container: &Container, flags: &BTreeMap<&str, &str>) {
    assert!(flags["operations"].ends_with(&format!(":{OPERATIONS}")));
    assert_eq!(port(container, "operations"), Some(OPERATIONS));
    for (name, probe) in probes(container) {
        let http = probe.http_get.as_ref().unwrap();
        assert_eq!(http.path.as_deref(), Some(&*format!("/healthz/{name}")));
        assert_eq!(http.port, IntOrString::String("operations".to_owned()));
        assert_eq!(http.scheme, None, "it is plain HTTP");
    }
}

/// The deployments of a list of manifests that are whole.
fn check_deployments(manifests: &[Value]) {
    let mut seen = 0;
    for document in manifests.iter().filter(|d| d["kind"] == "Deployment") {
        let deployment: Deployment = typed("deployment", document);
        let spec = deployment.spec.unwrap();
        let (pod, labels) = (spec.template.spec.unwrap(), spec.template.metadata.unwrap().labels.unwrap());
        let selected = spec.selector.match_labels.unwrap();
        assert!(selected.iter().all(|(key, value)| labels.get(key) == Some(value)));
        let container = &pod.containers[0];
        let program = container.image.as_deref().unwrap().split(':').next().unwrap();
        let arguments = container.args.clone().unwrap();
        check_pod(program, &pod, container, &arguments);
        let flags = flags(&arguments);
        check_probes(container, &flags);
        if program == "gonio-coordinator" {
            assert!(flags["listen"].ends_with(&format!(":{PORT}")));
            assert_eq!(port(container, "grpc"), Some(PORT));
            let scaler = flags.get("scaler").map(|_| SCALER);
            assert_eq!(port(container, "scaler"), scaler);
            assert!(scaler.is_none_or(|port| flags["scaler"].ends_with(&format!(":{port}"))));
        } else {
            assert!(flags["coordinator"].ends_with(&format!("//gonio-coordinator:{PORT}")));
            // A variable in an argument is one of the container.
            let variable = flags["name"].strip_prefix("$(").and_then(|name| name.strip_suffix(')')).unwrap();
            assert!(container.env.iter().flatten().any(|env| env.name == variable));
        }
        seen += 1;
    }
    assert_eq!(seen, 2);
    for document in manifests.iter().filter(|d| d["kind"] == "Service") {
        let service: Service = typed("service", document);
        assert_eq!(service.metadata.name.as_deref(), Some("gonio-coordinator"));
        assert_eq!(service.spec.unwrap().ports.unwrap()[0].port, PORT);
    }
    let denied = manifests.iter().filter(|d| d["kind"] == "NetworkPolicy").any(|d| {
        let policy: NetworkPolicy = typed("policy", d);
        let spec = policy.spec.unwrap();
        spec.ingress.is_none() && spec.egress.is_none() && spec.policy_types.unwrap().len() == 2
    });
    assert!(denied, "nothing denies by default");
}

#[test]
fn manifests_have_the_types_of_the_api_and_the_flags_of_the_programs() {
    let written = written();
    written.iter().for_each(|(path, document)| check_types(path, document));
    let base = written.iter().filter(|(path, _)| path.contains("/base/")).map(|(_, d)| d.clone());
    check_deployments(&base.collect::<Vec<_>>());
}

/// What the manifests ask, asked of the programs that they start.
#[test]
fn probes_are_answered_by_the_programs() {
    let written = written();
    let mut cluster = Cluster::start_with_more(&["--operations", "127.0.0.1:0"], 0);
    let (coordinator, worker) = (cluster.port("operations").to_owned(), free_address());
    cluster.add_worker_with(&["--operations", &worker]);
    let mut asked = 0;
    for (_, document) in written.iter().filter(|(path, d)| path.contains("/base/") && d["kind"] == "Deployment") {
        let deployment: Deployment = typed("deployment", document);
        let container = &deployment.spec.unwrap().template.spec.unwrap().containers[0];
        let address = if container.name == "coordinator" { &coordinator } else { &worker };
        for (_, probe) in probes(container) {
            let path = probe.http_get.as_ref().unwrap().path.clone().unwrap();
            let name = path.strip_prefix("/healthz/").unwrap();
            assert_eq!(wait_for(address, name, 200, Duration::from_secs(10)), "ok\n");
            asked += 1;
        }
    }
    assert_eq!(asked, 6);
}

#[test]
fn keda_finds_the_scaler_and_a_certificate() {
    let of_overlay = |name: &str| std::fs::read_to_string(folder().join("overlays/keda").join(name)).unwrap();
    let namespace = documents(&of_overlay("kustomization.yaml"))[0]["namespace"].as_str().unwrap().to_owned();
    let documents = documents(&of_overlay("scaling.yaml"));
    let scaled: ScaledObject = serde_json::from_value(documents[0].clone()).unwrap();
    let authentication: TriggerAuthentication = serde_json::from_value(documents[1].clone()).unwrap();
    keda::check(&scaled, &authentication);
    let trigger = &scaled.spec.triggers[0];
    assert_eq!(trigger.metadata.scaler_address, format!("gonio-coordinator.{namespace}.svc:{SCALER}"));
    // A worker has something to do on every thread.
    let written = written();
    let worker = written.iter().find(|(path, d)| path.ends_with("worker.yaml") && d["kind"] == "Deployment").unwrap();
    let worker: Deployment = typed("worker", &worker.1);
    assert_eq!(worker.metadata.name.as_deref(), Some(scaled.spec.scale_target_ref.name.as_str()));
    let pod = worker.spec.unwrap().template.spec.unwrap();
    let arguments = pod.containers[0].args.clone().unwrap();
    let threads: u32 = flags(&arguments)["threads"].parse().unwrap();
    assert!(trigger.metadata.slots.parse::<u32>().unwrap() >= threads);
    // The secret that it shows is one that the farm's members have.
    let secrets: Vec<_> = pod.volumes.unwrap().into_iter().filter_map(|v| v.secret?.secret_name).collect();
    assert!(authentication.spec.secret_target_ref.iter().all(|target| secrets.contains(&target.name)));
    assert_eq!(help("gonio-coordinator").matches("--scaler <ADDRESS>").count(), 1);
}

/// What Prometheus is told to scrape is where the programs serve their metrics.
#[test]
fn prometheus_is_sent_to_the_operations_port() {
    let text = |name: &str| std::fs::read_to_string(folder().join("grafana").join(name)).unwrap();
    let scrape = &documents(&text("prometheus.yaml"))[0]["scrape_configs"][0]["dns_sd_configs"][0];
    assert_eq!(scrape["port"], OPERATIONS);
    let compose = std::fs::read_to_string(folder().join("compose/compose.yaml")).unwrap();
    let services = documents(&compose)[0]["services"].clone();
    for name in scrape["names"].as_array().unwrap() {
        let arguments = services[name.as_str().unwrap()]["command"].as_array().unwrap();
        assert!(arguments.contains(&Value::from(format!("--operations=0.0.0.0:{OPERATIONS}"))), "{name}");
    }
    let monitor = &documents(&text("podmonitor.yaml"))[0]["spec"];
    assert_eq!(monitor["podMetricsEndpoints"][0]["port"], "operations");
    assert_eq!(monitor["podMetricsEndpoints"][0]["path"], "/metrics");
    assert_eq!(monitor["selector"]["matchLabels"]["app.kubernetes.io/part-of"], "gonio");
    let config = folder().join("grafana/prometheus.yaml");
    match Command::new("promtool").args(["check", "config"]).arg(config).output() {
        Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr)),
        Err(_) => println!("skipped: there is no promtool here"),
    }
}

#[test]
fn every_overlay_is_built() {
    if Command::new("kubectl").arg("version").arg("--client").output().is_err() {
        println!("skipped: there is no kubectl here");
        return;
    }
    for overlay in std::fs::read_dir(folder().join("overlays")).unwrap() {
        let overlay = overlay.unwrap().path();
        let built = Command::new("kubectl").arg("kustomize").arg(&overlay).output().unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        let manifests = documents(&String::from_utf8(built.stdout).unwrap());
        manifests.iter().for_each(|document| check_types(&overlay.display().to_string(), document));
        check_deployments(&manifests);
        let pods = manifests.iter().filter(|d| d["kind"] == "Deployment");
        // What is denied by default is what has this label.
        for pod in pods {
            assert_eq!(pod["spec"]["template"]["metadata"]["labels"]["app.kubernetes.io/part-of"], "gonio");
        }
    }
}

/// By the schemas of another project, strictly; its program comes from PyPI.
#[test]
fn kubernetes_validate_accepts_what_the_overlays_render_to() {
    let python = std::env::var("GONIO_TEST_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let there = |program: &str, arguments: &[&str]| {
        Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
    };
    if !there(&python, &["-c", "import kubernetes_validate"]) || !there("kubectl", &["version", "--client"]) {
        println!("skipped: there is no kubectl, or {python} has no kubernetes_validate");
        return;
    }
    let program = "import sys, yaml, kubernetes_validate as k\n\
        for d in yaml.safe_load_all(sys.stdin):\n\
        \x20   if 'keda.sh' not in d['apiVersion']:\n\
        \x20       k.validate(d, k.latest_version(), strict=True); print(d['kind'])\n";
    for overlay in std::fs::read_dir(folder().join("overlays")).unwrap() {
        let overlay = overlay.unwrap().path();
        let mut built = Command::new("kubectl").arg("kustomize").arg(&overlay).stdout(Stdio::piped()).spawn().unwrap();
        let manifests = built.stdout.take().unwrap();
        let checked = Command::new(&python).args(["-c", program]).stdin(manifests).output().unwrap();
        assert!(built.wait().unwrap().success());
        assert!(checked.status.success(), "{}: {}", overlay.display(), String::from_utf8_lossy(&checked.stderr));
        assert!(String::from_utf8_lossy(&checked.stdout).matches("Deployment").count() == 2);
    }
}

#[test]
fn compose_starts_the_programs_as_they_are() {
    let text = std::fs::read_to_string(folder().join("compose/compose.yaml")).unwrap();
    let compose = &documents(&text)[0];
    for (service, program) in [("coordinator", "gonio-coordinator"), ("worker", "gonio-worker")] {
        let service = &compose["services"][service];
        assert_eq!(service["image"], format!("{program}:latest"));
        let arguments: Vec<String> = serde_json::from_value(service["command"].clone()).unwrap();
        let (flags, help) = (flags(&arguments), help(program));
        for name in flags.keys() {
            assert!(help.contains(&format!("--{name}")), "{program} has no --{name}");
        }
        let patience: f64 = service["stop_grace_period"].as_str().unwrap().trim_end_matches('s').parse().unwrap();
        assert!(flags["grace"].parse::<f64>().unwrap() + 5.0 <= patience);
    }
    // The client learns of the farm by variables, which its help names.
    let help = String::from_utf8(command("gonio", &["fit", "--help"]).output().unwrap().stdout).unwrap();
    for name in compose["services"]["client"]["environment"].as_object().unwrap().keys() {
        assert!(help.contains(name.as_str()), "gonio does not read {name}");
    }
}
