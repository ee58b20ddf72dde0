// Photo, render and residual of each photo; a sweep's contact sheet.

import { at, element, rows, say } from "./table.js";
import { significant } from "./text.js";

const KINDS = [
  ["photo", "Photo", "the photograph"],
  ["render", "Render", "the render at these values"],
  ["residual", "Residual", "what differs, in standard deviations: blue where the photo is darker, red where it is brighter"],
];

function make() {
  const card = element("article", { class: "photo" }, element("h3"), element("p"), element("div", { class: "triple" }));
  for (const [, caption] of KINDS) {
    const picture = element("figure", {}, element("img", { alt: "" }), element("figcaption", {}, caption));
    card.lastChild.append(picture);
  }
  return card;
}

// Replaces a picture once the new one is here, so that nothing flickers.
function load(image, address, alternative) {
  if (image.dataset.address === address) return;
  image.dataset.address = address;
  const next = new Image();
  next.src = address;
  const done = next.decode().then(() => {
    if (image.dataset.address !== address) return;
    image.src = address;
    image.alt = alternative;
    image.width = next.naturalWidth;
    image.height = next.naturalHeight;
  }, () => undefined);
  pending.add(done);
  done.finally(() => pending.delete(done));
}

const pending = new Set();

// Completes when every picture that was asked for is here.
export function loaded() {
  return Promise.all(pending);
}

export function showPictures(pictures) {
  const list = Object.entries(pictures);
  rows(at("photo-list"), list, make, (card, photo, id) => {
    say(card.children[0], `Photo ${photo.name}${photo.held_out ? ", held out" : ""}`);
    const live = photo.iteration > 0 ? ` after iteration ${photo.iteration}` : " at the start";
    const when = photo.iteration === undefined ? " at the end" : live;
    say(card.children[1], `Chi-square per observation ${significant(photo.chi_square, 4)}, RMSE ${significant(photo.rmse, 3)}${when}`);
    const images = card.querySelectorAll("img");
    KINDS.forEach(([kind, , what], i) => {
      load(images[i], `picture/${id}-${kind}-${photo.version}`, `Photo ${photo.name}: ${what}`);
    });
  });
}

export function showSheet(sheet) {
  load(at("sheet-image"), `picture/sheet-${sheet.version}`, `Contact sheet: ${sheet.frames} of ${sheet.of} frames in small`);
  say(at("sheet-caption"), `${sheet.frames} of ${sheet.of} frames, all equally bright.`);
}
