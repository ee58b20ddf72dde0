// The parameters: where they started, where they are, how sure that is.

import { spark } from "./chart.js";
import { at, dotted, element, number, row, rows, say } from "./table.js";
import { measured, significant } from "./text.js";

// Standard errors on either side of an estimate that 95 % of such intervals need to hold the truth.
const NORMAL = 1.96;

// What is known now: the result's estimates, or else those of the last iteration.
export function estimates(state) {
  if (state.result) return state.result.parameters;
  const iterations = Object.values(state.iterations ?? {});
  const last = iterations.at(-1);
  return (state.names ?? []).map((name, i) => ({
    name,
    start: state.start?.[i],
    value: last ? last.values[i] : state.start?.[i],
    standard_error: last?.errors?.[i] ?? undefined,
  }));
}

function make() {
  const tr = row("name", "number wide", "number", "number", "number wide", "wide course");
  tr.children[2].append(element("data"));
  tr.children[3].append(element("data"));
  return tr;
}

export function showParameters(state) {
  const iterations = Object.values(state.iterations ?? {});
  const list = estimates(state).map((p, i) => [String(i), p]);
  rows(at("parameter-rows"), list, make, (tr, p, key) => {
    const error = p.standard_error;
    const known = error > 0;
    dotted(tr.children[0], p.name);
    say(tr.children[1], p.start === undefined ? "" : significant(p.start, 4));
    number(tr.children[2].firstChild, p.value, measured(p.value, error));
    if (known) {
      number(tr.children[3].firstChild, error, `\u00b1 ${significant(error, 2)}`);
      say(tr.children[4], `${measured(p.value - NORMAL * error, error)} \u2026 ${measured(p.value + NORMAL * error, error)}`);
    } else {
      const why = state.result ? "undetermined" : "\u2013";
      number(tr.children[3].firstChild, "", why);
      say(tr.children[4], "");
    }
    const course = iterations.map((it) => it.values?.[key]).filter((v) => v !== undefined);
    const drawn = course.join(" ");
    if (tr.dataset.course !== drawn) {
      tr.dataset.course = drawn;
      tr.children[5].replaceChildren(spark([p.start ?? course[0], ...course]));
    }
  });
}
