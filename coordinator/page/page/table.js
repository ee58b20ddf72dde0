// Elements, and tables whose rows stay while their cells change: nothing moves under a reader's eye or cursor.

export const at = (id) => document.getElementById(id);

export function element(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

export function svg(tag, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function filled(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

// Sets a text that may be there already: a live region that is set again would be read again.
export function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function show(node, visible) {
  if (node.hidden === visible) node.hidden = !visible;
}

// A number for people, which keeps all of its digits for programs.
export function number(node, value, text) {
  const digits = String(value);
  if (node.value !== digits) node.value = digits;
  say(node, text);
}

// Makes `body` hold one row for each entry `[key, value]`, in order: `make()` a new row, `update(row, value, key)` any.
export function rows(body, entries, make, update) {
  const there = new Map([...body.children].map((row) => [row.dataset.key, row]));
  let place = body.firstElementChild;
  for (const [key, value] of entries) {
    let row = there.get(key);
    if (row) {
      there.delete(key);
    } else {
      row = make(key);
      row.dataset.key = key;
    }
    if (row === place) place = place.nextElementSibling;
    else body.insertBefore(row, place);
    update(row, value, key);
  }
  for (const row of there.values()) row.remove();
}

// A dotted name that may break after its dots, and nowhere else.
export function dotted(node, name) {
  if (node.textContent === name) return;
  const parts = name.split(/(?<=\.)/);
  node.replaceChildren(...parts.flatMap((part) => [part, element("wbr")]));
}

// A row of a table: a heading, then cells, each of a class.
export function row(heading, ...cells) {
  const made = element("tr", {}, element("th", { scope: "row", class: heading }));
  for (const kind of cells) made.append(element("td", { class: kind }));
  return made;
}
