"use strict";
// One trial at a time; the server alone knows the order and what was answered.
const at = (id) => document.getElementById(id);
let trial = null;
let shown = 0;

function show(section) {
  for (const id of ["welcome", "trial", "done"]) at(id).hidden = id !== section;
}

async function ask(path, body) {
  const answer = await fetch(path, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(body),
  });
  const text = await answer.text();
  if (!answer.ok) throw new Error(text);
  return JSON.parse(text);
}

function problem(error) {
  at("problem").textContent = error instanceof TypeError
    ? "The server does not answer. Your last click may not be kept; answer again once it is back."
    : error.message;
  at("levels").disabled = !trial || at("image").hidden;
}

async function next(state) {
  trial = state;
  at("problem").textContent = "";
  at("levels").disabled = true;
  if (state.position === state.count) {
    show("done");
    at("status").textContent = "All images are rated.";
    at("thanks").focus();
    return;
  }
  show("trial");
  const text = `Image ${state.position + 1} of ${state.count}`;
  at("progress").textContent = text;
  at("bar").value = state.position / state.count;
  const image = at("image");
  image.hidden = true;
  image.src = state.image;
  image.alt = text;
  await image.decode();
  image.hidden = false;
  shown = performance.now();
  at("levels").disabled = false;
  at("status").textContent = text;
}

async function answer(rating) {
  // A key that is held down, or a hand that is too quick, does not rate an image that nobody has seen.
  if (at("levels").disabled || !trial || performance.now() - shown < 200) return;
  at("levels").disabled = true;
  try {
    await next(await ask("answer", { observer: trial.observer, position: trial.position, rating }));
  } catch (error) {
    problem(error);
  }
}

async function begin(observer) {
  try {
    await next(await ask("begin", { observer }));
    sessionStorage.setItem("observer", trial.observer);
  } catch (error) {
    problem(error);
  }
}

at("begin").addEventListener("submit", (event) => {
  event.preventDefault();
  begin(at("observer").value);
});
at("levels").addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (button) answer(Number(button.dataset.rating));
});
document.addEventListener("keydown", (event) => {
  if (event.repeat || event.ctrlKey || event.altKey || event.metaKey || at("trial").hidden) return;
  if (/^[1-5]$/.test(event.key)) answer(Number(event.key));
});
const known = sessionStorage.getItem("observer");
if (known) begin(known);
