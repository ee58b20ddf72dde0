// The page of one fit, diagnosis or sweep.

import { showRanking, showTried, showVerdict } from "./causes.js";
import { showLoss } from "./chart.js";
import { showParameters } from "./parameters.js";
import { loaded, showPictures, showSheet } from "./pictures.js";
import { act, follow } from "./stream.js";
import { at, element, rows, say, show } from "./table.js";
import { duration, grouped, metric, plural, significant } from "./text.js";

const STATUS = {
  connecting: "Connecting",
  live: "Running",
  reconnecting: "Reconnecting \u2026",
  over: "Ended",
};

function status(word) {
  document.body.dataset.status = word;
  say(at("status"), STATUS[word] ?? word);
}

const has = (object) => object !== undefined && Object.keys(object).length > 0;

function summary(state) {
  const parts = [];
  const fit = state.fit;
  if (fit) {
    parts.push(`${plural(state.names?.length ?? 0, "parameter")} to ${plural(fit.photos, "photo")} by ${fit.solver}`);
    if (fit.held_out) parts.push(`${fit.held_out} held out`);
  }
  if (state.result) {
    const r = state.result;
    parts.push(`${r.converged ? "converged" : "not converged"} after ${plural(r.iterations, "iteration")}`);
    parts.push(`reduced chi-square ${significant(r.reduced_chi_square, 5)}`);
    if (r.held_out !== undefined) parts.push(`held out ${significant(r.held_out, 5)}`);
    parts.push(duration(r.seconds));
  }
  return parts.join(" \u00b7 ");
}

function progress(state) {
  const now = state.progress;
  show(at("progress"), Boolean(now) && !state.ended);
  if (!now) return;
  const bar = at("bar");
  bar.max = Math.max(1, now.total);
  bar.value = now.done;
  const parts = [state.phase ?? now.label, `${grouped(now.done)} of ${plural(now.total, now.unit ?? "task")}`];
  if (now.rate > 0) parts.push(`${metric(now.rate)} samples/s`);
  if (now.workers > 1) parts.push(plural(now.workers, "worker"));
  if (now.left > 0) parts.push(`about ${duration(now.left)} left`);
  say(at("progress-text"), parts.join(" \u00b7 "));
}

// What a screen reader should hear: steps, not the percentages between.
function announce(state) {
  if (state.ended) return say(at("news"), state.ended.text);
  const iterations = Object.entries(state.iterations ?? {});
  const last = iterations.at(-1);
  if (last) say(at("news"), `Iteration ${last[0]}: loss ${significant(last[1].loss, 4)}`);
  else if (state.phase) say(at("news"), state.phase);
}

function changed(state) {
  const title = `${state.title} of ${state.capture}`;
  document.title = state.ended ? `${title} \u2013 ended` : title;
  say(at("title"), title);
  say(at("summary"), summary(state));
  say(at("phase"), state.ended?.text ?? (state.progress ? "" : (state.phase ?? "Getting ready")));
  at("phase").dataset.how = state.ended?.how ?? "";
  progress(state);
  show(at("loss"), has(state.iterations));
  if (has(state.iterations)) showLoss(state.iterations);
  show(at("parameters"), has(state.names) || Boolean(state.result));
  showParameters(state);
  show(at("pictures"), has(state.pictures));
  if (has(state.pictures)) showPictures(state.pictures);
  show(at("ranking"), has(state.ranking));
  if (has(state.ranking)) showRanking(state.ranking);
  show(at("tried"), has(state.tried));
  if (has(state.tried)) showTried(state.tried);
  if (state.verdict) showVerdict(state.verdict);
  show(at("sheet"), Boolean(state.sheet));
  if (state.sheet) showSheet(state.sheet);
  const warnings = state.result?.warnings ?? state.warnings ?? [];
  show(at("warnings"), warnings.length > 0);
  rows(at("warning-list"), warnings.map((w, i) => [String(i), w]), () => element("li"), (li, w) => say(li, w));
  show(at("stop"), !state.ended);
  at("stop").disabled = Boolean(state.stopping);
  announce(state);
}

at("stop").addEventListener("click", () => at("sure").showModal());
at("sure").addEventListener("close", async () => {
  if (at("sure").returnValue !== "stop") return;
  try {
    say(at("problem"), "");
    say(at("news"), await act("stop", {}));
  } catch (error) {
    say(at("problem"), error instanceof TypeError ? "The program does not answer; nothing was stopped." : error.message);
  }
});

const stream = follow({ changed, status, refused: (text) => say(at("problem"), text), over: loaded });
status("connecting");
stream.open();
