// The page of a farm: what runs, who works. Only the rows that are looked at are sent.

import { act, follow } from "./stream.js";
import { at, element, row, rows, say, show } from "./table.js";
import { duration, grouped, metric, plural, significant } from "./text.js";

const ROWS = 50;
const TOKEN = "gonio-token";

const STATUS = {
  connecting: "Connecting",
  live: "Live",
  reconnecting: "Reconnecting \u2026",
  refused: "Not let in",
  paused: "Paused",
  over: "Ended",
};

// The first row of each table, and what its names must contain.
const view = { jobs: 0, workers: 0, findJobs: "", findWorkers: "" };
let token = sessionStorage.getItem(TOKEN) ?? "";
let state = {};
let chosen = null;

function status(word) {
  document.body.dataset.status = word;
  say(at("status"), STATUS[word] ?? word);
}

function open() {
  stream.open(
    {
      jobs: `${view.jobs},${ROWS}`,
      workers: `${view.workers},${ROWS}`,
      find_jobs: view.findJobs,
      find_workers: view.findWorkers,
    },
    token,
  );
}

function numbers() {
  say(at("workers"), grouped(state.strength.workers));
  say(at("threads"), `${grouped(state.strength.busy)} / ${grouped(state.strength.slots)}`);
  say(at("evaluations"), grouped(state.jobs.total));
  say(at("waiting"), grouped(state.queue.waiting));
  say(at("leased"), grouped(state.queue.leased));
  say(at("speed"), metric(state.speed));
  const silent = state.strength.silent;
  const up = `This coordinator is up for ${duration(state.time - state.started)}.`;
  say(at("summary"), silent ? `${up} ${plural(silent, "worker")} silent.` : up);
}

function makeJob() {
  const tr = row("name", "wide", "", "number wide", "number wide", "number wide", "acts");
  tr.children[2].append(element("progress"), element("span"));
  for (const [name, text] of [["retry", "Retry"], ["cancel", "Cancel"]]) {
    tr.children[6].append(element("button", { type: "button", "data-act": name }, text), " ");
  }
  return tr;
}

function updateJob(tr, job, key) {
  const nobody = job.listeners ? "" : " (nobody listens)";
  say(tr.children[0], `${job.client || "unnamed"}${nobody}`);
  say(tr.children[1], job.class);
  const [bar, count] = tr.children[2].children;
  bar.max = Math.max(1, job.tasks);
  bar.value = job.done;
  bar.setAttribute("aria-label", `Tasks of evaluation ${key}`);
  say(count, job.tasks ? ` ${grouped(job.done)} / ${grouped(job.tasks)}` : " being prepared");
  say(tr.children[3], metric(job.speed));
  say(tr.children[4], job.loss ? `${significant(job.loss, 4)} \u00b1 ${significant(job.error, 2)}` : "\u2013");
  say(tr.children[5], duration(state.time - job.since));
  for (const button of tr.children[6].children) {
    show(button, Boolean(state.may_act));
    button.setAttribute("aria-label", `${button.textContent} evaluation ${key} of ${job.client || "an unnamed client"}`);
  }
}

function updateWorker(tr, worker) {
  say(tr.children[0], worker.name);
  say(tr.children[1], worker.state);
  say(tr.children[2], grouped(worker.slots));
  say(tr.children[3], grouped(worker.held));
  say(tr.children[4], metric(worker.speed));
  say(tr.children[5], metric(worker.samples));
  say(tr.children[6], duration(state.time - worker.since));
}

function pager(name, list) {
  const { from, found, total } = list;
  const count = Object.keys(list.rows ?? {}).length;
  const of = found === total ? grouped(total) : `${grouped(found)} found of ${grouped(total)}`;
  say(at(`${name}-range`), count ? `${grouped(from + 1)}\u2013${grouped(from + count)} of ${of}` : `none of ${of}`);
  at(`${name}-back`).disabled = from === 0;
  at(`${name}-on`).disabled = from + count >= found;
  show(at(`no-${name}`), total === 0);
}

function changed(now) {
  state = now;
  show(at("ask"), false);
  show(at("farm"), true);
  show(at("forget"), token !== "");
  numbers();
  rows(at("job-rows"), Object.entries(state.jobs.rows ?? {}), makeJob, updateJob);
  const makeWorker = () => row("name", "", "number wide", "number", "number", "number wide", "number wide");
  rows(at("worker-rows"), Object.entries(state.workers.rows ?? {}), makeWorker, updateWorker);
  show(at("acts"), Boolean(state.may_act) && state.jobs.total > 0);
  pager("jobs", state.jobs);
  pager("workers", state.workers);
}

function refused(text) {
  show(at("farm"), false);
  show(at("ask"), true);
  show(at("forget"), false);
  say(at("refusal"), token ? text : "");
  at("token").focus();
}

async function perform(action, key) {
  try {
    say(at("problem"), "");
    say(at("news"), await act(action, { epoch: state.epoch, evaluation: Number(key) }, token));
  } catch (error) {
    say(at("problem"), error instanceof TypeError ? "The coordinator does not answer; nothing was changed." : error.message);
  }
}

at("job-rows").addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (!button) return;
  const { key } = button.closest("tr").dataset;
  if (button.dataset.act === "retry") {
    perform("retry", key);
    return;
  }
  chosen = key;
  const client = state.jobs.rows?.[key]?.client || "an unnamed client";
  say(at("sure-text"), `Evaluation ${key} of ${client}: its program stops, and keeps what it had done.`);
  at("sure").showModal();
});
at("sure").addEventListener("close", () => {
  if (at("sure").returnValue === "cancel" && chosen !== null) perform("cancel", chosen);
  at("sure").returnValue = "";
});
at("token-form").addEventListener("submit", (event) => {
  event.preventDefault();
  token = at("token").value.trim();
  at("token").value = "";
  sessionStorage.setItem(TOKEN, token);
  open();
});
at("forget").addEventListener("click", () => {
  token = "";
  sessionStorage.removeItem(TOKEN);
  open();
});
for (const [name, find] of [["jobs", "findJobs"], ["workers", "findWorkers"]]) {
  const turn = (by) => {
    view[name] = Math.max(0, view[name] + by * ROWS);
    open();
  };
  at(`${name}-back`).addEventListener("click", () => turn(-1));
  at(`${name}-on`).addEventListener("click", () => turn(1));
  let timer = 0;
  at(`find-${name}`).addEventListener("input", () => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      view[find] = at(`find-${name}`).value.trim();
      view[name] = 0;
      open();
    }, 250);
  });
}
// A page that nobody sees asks for nothing; browsers hold few connections to one server.
document.addEventListener("visibilitychange", () => {
  if (document.hidden) stream.close();
  else open();
});

const stream = follow({ changed, status, refused });
status("connecting");
open();
