// Elements of the panel: sections and fields for lengths.

import { el, field } from "./dom.js";
import { lengthText, readLength } from "./units.js";

export const section = (title, ...children) => el("section", {}, el("h2", {}, title), ...children);

/** A field for a length; text that is not a length is refused with a message. */
export function lengthField(app, label, key, value, change) {
  return field(label, key, lengthText(value, app.feet), (text, input) => {
    const metres = readLength(text, app.feet);
    if (Number.isNaN(metres)) { app.say(`${label}: a length such as ${lengthText(2.4, app.feet)}, not ${text}`); input.value = lengthText(value, app.feet); } else change(Math.round(metres * 1000) / 1000);
  }, { inputMode: "decimal" });
}
