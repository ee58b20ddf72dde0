//! `k8s/slurm/workers.sbatch` under a stand-in that does to its jobs what SLURM does: their variables, a signal before the time
//! limit, preemption without one, and another start.

use super::folder;
use gonio::farm::Farm;
use gonio_tests::cluster::{Cluster, PROGRAMS, Process, fitted};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// Longest that a job may take to end; its worker's grace is 45 s.
const PATIENCE: Duration = Duration::from_secs(60);

/// One array of jobs.
struct Slurm<'a> {
    coordinator: &'a str,
    /// Holds the stand-in for `scontrol`, and what was asked of it.
    folder: &'a Path,
}

impl<'a> Slurm<'a> {
    fn new(coordinator: &'a str, folder: &'a Path) -> Self {
        let scontrol = folder.join("scontrol");
        std::fs::write(&scontrol, format!("#!/bin/sh\necho \"$@\" >> {}\n", folder.join("asked").display())).unwrap();
        std::fs::set_permissions(&scontrol, PermissionsExt::from_mode(0o755)).unwrap();
        Self { coordinator, folder }
    }

    /// Starts a task of the array for the `restarts`-th time again.
    fn start(&self, task: u32, restarts: u32) -> Process {
        let path = format!("{}:{}", self.folder.display(), std::env::var("PATH").unwrap());
        let mut command = Command::new(folder().join("slurm/workers.sbatch"));
        command.arg(self.coordinator).env("PATH", path).env("GONIO_WORKER", PROGRAMS.join("gonio-worker"));
        command.env("SLURM_JOB_ID", (700 + task).to_string()).env("SLURM_ARRAY_JOB_ID", "700");
        command.env("SLURM_ARRAY_TASK_ID", task.to_string()).env("SLURM_CPUS_PER_TASK", "1");
        if restarts > 0 {
            command.env("SLURM_RESTART_COUNT", restarts.to_string());
        }
        Process::spawn(command.env("RUST_LOG", "error"))
    }

    /// What `scontrol` was asked.
    fn asked(&self) -> String {
        std::fs::read_to_string(self.folder.join("asked")).unwrap_or_default()
    }
}

/// Kills a process and what it started, as SLURM kills a job's whole group of processes.
fn kill_job(job: &Process) {
    let children = Command::new("pkill").args(["-KILL", "-P", &job.id().to_string()]).status().unwrap();
    assert!(children.success(), "the job had no worker");
    job.signal("KILL");
}

#[test]
fn jobs_of_slurm_are_workers_that_may_be_signalled_killed_and_requeued() {
    let expected = fitted(&Farm::embedded(2).unwrap(), &mut || {});
    let cluster = Cluster::start(0);
    let folder = tempfile::tempdir().unwrap();
    let slurm = Slurm::new(&cluster.url, folder.path());
    let mut jobs = vec![slurm.start(0, 0), slurm.start(1, 0)];
    let farm = Farm::connect(&cluster.url).unwrap();
    let mut in_between = || {
        // The time limit comes near: the job ends well, and asks to be queued again.
        jobs[0].signal("TERM");
        let ended = jobs[0].wait_for(PATIENCE).expect("the job ends before SLURM kills it");
        assert!(ended.success(), "{ended}");
        assert_eq!(slurm.asked(), "requeue 700_0\n");
        // A preemption without a word.
        kill_job(&jobs[1]);
        jobs = vec![slurm.start(0, 1), slurm.start(1, 1)];
    };
    assert_eq!(fitted(&farm, &mut in_between), expected);
    for job in &mut jobs {
        job.signal("TERM");
        assert!(job.wait_for(PATIENCE).expect("it ends").success());
    }
    assert_eq!(slurm.asked(), "requeue 700_0\nrequeue 700_0\nrequeue 700_1\n");
}

#[test]
fn the_script_says_what_it_lacks() {
    let script = folder().join("slurm/workers.sbatch");
    let run = |arguments: &[&str]| Command::new(&script).args(arguments).env_remove("SLURM_JOB_ID").output().unwrap();
    let without = run(&[]);
    assert!(!without.status.success());
    assert!(String::from_utf8_lossy(&without.stderr).contains("sbatch workers.sbatch https://HOST:7300"));
    let outside = run(&["https://host:7300"]);
    assert!(String::from_utf8_lossy(&outside.stderr).contains("this script is for sbatch"));
}
