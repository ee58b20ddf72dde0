// A diagnosis: which causes promise most, which were tried, what was found.

import { at, element, number, row, rows, say, show, svg } from "./table.js";
import { measured, significant } from "./text.js";

function words(effect) {
  return effect.replaceAll("_", " ").replaceAll("-", " ");
}

// A bar from nothing to the largest gain; for the eye alone.
function bar(part) {
  const width = Math.max(0, Math.min(1, part)) * 100;
  const box = svg("svg", { class: "bar", viewBox: "0 0 100 10", preserveAspectRatio: "none", "aria-hidden": "true" });
  box.append(svg("rect", { width: width.toFixed(1), height: 10 }));
  return box;
}

function makeRanked() {
  const tr = row("name", "number", "wide bars");
  tr.children[1].append(element("data"));
  return tr;
}

export function showRanking(ranking) {
  const list = Object.values(ranking);
  const largest = Math.max(...list.map((r) => r.gain), 1e-12);
  rows(at("ranking-rows"), list.map((r) => [r.effect, r]), makeRanked, (tr, r) => {
    say(tr.children[0], words(r.effect));
    number(tr.children[1].firstChild, r.gain, significant(r.gain, 3));
    if (tr.dataset.part !== String(r.gain / largest)) {
      tr.dataset.part = String(r.gain / largest);
      tr.children[2].replaceChildren(bar(r.gain / largest));
    }
  });
}

export function showTried(tried) {
  rows(at("tried-rows"), Object.entries(tried), () => row("name", "number", "number wide", ""), (tr, t) => {
    say(tr.children[0], words(t.effect));
    say(tr.children[1], `${measured(t.gain, t.standard_error)} \u00b1 ${significant(t.standard_error, 2)}`);
    say(tr.children[2], significant(t.chi_square, 5));
    say(tr.children[3], t.added ? "added to the model" : "");
  });
}

export function showVerdict(verdict) {
  const box = at("verdict-text");
  const lines = [verdict.text, ...(verdict.more ?? [])];
  rows(box, lines.map((line, i) => [String(i), line]), () => element("p"), (p, line) => say(p, line));
  show(at("verdict"), true);
}
