//! The images, run by Docker as the manifests would have them run: their users, file systems, capabilities, limits, probes and
//! graces.

use super::{documents, folder, probes, typed};
use gonio_tests::captures;
use gonio_tests::cluster::PROGRAMS;
use gonio_tests::images::{docker, missing};
use gonio_tests::operations::wait_for;
use gonio_tests::pki::Authority;
use k8s_openapi::api::apps::v1::Deployment;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// The network and the containers, which go with the test.
struct Pods {
    top: tempfile::TempDir,
    network: String,
    names: Vec<String>,
}

impl Drop for Pods {
    fn drop(&mut self) {
        // What cannot be taken down here is for `docker ps` to show.
        let quiet = |arguments: &[&str]| drop(Command::new("docker").args(arguments).output());
        self.names.iter().for_each(|name| quiet(&["rm", "--force", name]));
        quiet(&["network", "rm", &self.network]);
    }
}

/// The deployment of a program in `k8s/base`.
fn deployment(file: &str) -> Deployment {
    let text = std::fs::read_to_string(folder().join("base").join(file)).unwrap();
    let found = documents(&text).into_iter().find(|d| d["kind"] == "Deployment").unwrap();
    typed(file, &found)
}

/// Certificates and tokens as the pods' secrets have them: a folder each, their files readable by the group of nobody.
fn secrets(top: &Path) {
    let authority = Authority::new(top, "farm");
    let write = |folder: &str, name: &str, bytes: &[u8]| {
        let folder = top.join(folder);
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        // Kubernetes makes them 0440 of the group; only root may give files away.
        let nobody = std::os::unix::fs::chown(&path, None, Some(65534)).is_ok();
        std::fs::set_permissions(&path, PermissionsExt::from_mode(if nobody { 0o440 } else { 0o444 })).unwrap();
    };
    let ca = std::fs::read(authority.certificate()).unwrap();
    for (folder, name) in [("coordinator-tls", "server"), ("worker-tls", "worker"), ("client-tls", "client")] {
        let signed = authority.sign(name);
        write(folder, "ca.crt", &ca);
        write(folder, "tls.crt", &std::fs::read(signed.cert).unwrap());
        write(folder, "tls.key", &std::fs::read(signed.key).unwrap());
    }
    let tokens = top.join("tokens.new");
    for (name, roles) in [("worker", "work"), ("client", "submit,watch")] {
        let made = Command::new(PROGRAMS.join("gonio-coordinator"))
            .args(["token", name, "--roles", roles, "--tokens"])
            .arg(&tokens)
            .output()
            .unwrap();
        assert!(made.status.success());
        write(&format!("{name}-token"), "token", &made.stdout);
    }
    write("tokens", "tokens", &std::fs::read(&tokens).unwrap());
}

impl Pods {
    fn new() -> Self {
        let top = tempfile::tempdir().unwrap();
        std::fs::set_permissions(top.path(), PermissionsExt::from_mode(0o755)).unwrap();
        secrets(top.path());
        let network = format!("gonio-pods-{}", std::process::id());
        docker(&["network", "create", &network]);
        Self { top, network, names: Vec::new() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.top.path().join(name)
    }

    /// Starts the pod of a deployment; `secret` says which folder stands for a volume.
    fn start(&mut self, deployment: &Deployment, name: &str, secret: &dyn Fn(&str) -> Option<&'static str>) -> String {
        let pod = deployment.spec.as_ref().unwrap().template.spec.as_ref().unwrap();
        let container = &pod.containers[0];
        let (whole, own) = (pod.security_context.as_ref().unwrap(), container.security_context.as_ref().unwrap());
        let user = format!("{}:{}", whole.run_as_user.unwrap(), whole.run_as_group.unwrap());
        let name = format!("{}-{name}", self.network);
        let mut arguments: Vec<String> =
            ["run", "--detach", "--name", &name, "--network", &self.network, "--user", &user]
                .map(str::to_owned)
                .to_vec();
        arguments.extend(["--network-alias".to_owned(), deployment.metadata.name.clone().unwrap()]);
        arguments
            .extend(own.capabilities.iter().flat_map(|c| c.drop.iter().flatten()).map(|c| format!("--cap-drop={c}")));
        if own.read_only_root_filesystem == Some(true) {
            arguments.push("--read-only".to_owned());
        }
        if own.allow_privilege_escalation == Some(false) {
            arguments.push("--security-opt=no-new-privileges".to_owned());
        }
        let limits = container.resources.as_ref().unwrap().limits.as_ref().unwrap();
        arguments.push(format!("--memory={}", limits["memory"].0.trim_end_matches('i').to_lowercase()));
        arguments.push(format!("--stop-timeout={}", pod.termination_grace_period_seconds.unwrap()));
        for mount in container.volume_mounts.iter().flatten() {
            match secret(&mount.name) {
                Some(folder) => {
                    arguments.push(format!("--volume={}:{}:ro", self.path(folder).display(), mount.mount_path));
                }
                None => arguments.push(format!("--tmpfs={}:uid=65534,gid=65534,mode=0770", mount.mount_path)),
            }
        }
        arguments.push(format!("{}:latest", container.image.as_deref().unwrap()));
        arguments.extend(container.args.iter().flatten().map(|a| a.replace("$(POD_NAME)", &name)));
        docker(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        self.names.push(name.clone());
        let address =
            docker(&["inspect", "--format", "{{range .NetworkSettings.Networks}}{{.IPAddress}}{{end}}", &name]);
        for (_, probe) in probes(container) {
            let path = probe.http_get.as_ref().unwrap().path.clone().unwrap();
            let patience = Duration::from_secs(u64::from(probe.failure_threshold.unwrap_or(3).unsigned_abs()) * 20);
            let asked = path.strip_prefix("/healthz/").unwrap();
            assert_eq!(wait_for(&format!("{address}:{}", super::OPERATIONS), asked, 200, patience), "ok\n", "{name}");
        }
        name
    }

    /// `docker stop`, as a kubelet does: how long it took, and the exit code.
    fn stop(name: &str) -> (Duration, String) {
        let begin = Instant::now();
        docker(&["stop", name]);
        (begin.elapsed(), docker(&["inspect", "--format", "{{.State.ExitCode}}", name]))
    }
}

#[test]
fn the_images_run_under_the_manifests_contexts_limits_probes_and_graces() {
    if let Some(why) = missing() {
        eprintln!("skipped: {why}");
        return;
    }
    let (coordinator, worker) = (deployment("coordinator.yaml"), deployment("worker.yaml"));
    let mut pods = Pods::new();
    let lead = pods.start(&coordinator, "coordinator", &|volume| match volume {
        "tls" => Some("coordinator-tls"),
        "tokens" => Some("tokens"),
        _ => None,
    });
    let of_worker = |volume: &str| match volume {
        "tls" => Some("worker-tls"),
        "token" => Some("worker-token"),
        _ => None,
    };
    let first = pods.start(&worker, "worker-0", &of_worker);
    let second = pods.start(&worker, "worker-1", &of_worker);

    let out = pods.path("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::set_permissions(&out, PermissionsExt::from_mode(0o777)).unwrap();
    let volume = |from: &Path, to: &str| format!("--volume={}:{to}", from.display());
    let mut client = Command::new("docker")
        .args(["run", "--rm", "--network", &pods.network, "--read-only", "--cap-drop=ALL"])
        .args([volume(&captures().join("none-201"), "/capture:ro"), volume(&out, "/out")])
        .args([volume(&pods.path("client-tls"), "/tls:ro"), volume(&pods.path("client-token"), "/token:ro")])
        .args(["gonio:latest", "fit", "/capture", "--out", "/out/fit", "--farm", "https://gonio-coordinator:7300"])
        .args(["--ca", "/tls/ca.crt", "--cert", "/tls/tls.crt", "--key", "/tls/tls.key", "--token", "/token/token"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // One leaves in the middle, as in a rollout: what it renders is finished or handed back.
    std::thread::sleep(Duration::from_secs(2));
    assert!(client.try_wait().unwrap().is_none(), "the fit had ended before");
    let (took, code) = Pods::stop(&second);
    assert_eq!(code, "0", "a worker that is told to end ends well");
    assert!(took < Duration::from_secs(30), "{took:?}: it was killed");
    let done = client.wait_with_output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));

    let here = pods.path("here");
    let fitted = Command::new(PROGRAMS.join("gonio"))
        .args(["fit", captures().join("none-201").to_str().unwrap(), "--out", here.to_str().unwrap()])
        .output()
        .unwrap();
    assert!(fitted.status.success());
    let json = |path: PathBuf| serde_json::from_slice::<serde_json::Value>(&std::fs::read(path).unwrap()).unwrap();
    let (through, here) = (json(out.join("fit/fit.json")), json(here.join("fit.json")));
    assert_eq!(through["parameters"], here["parameters"]);
    for name in [&first, &lead] {
        assert_eq!(Pods::stop(name).1, "0", "{name}");
    }
}
