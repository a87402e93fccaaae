// The dialog that asks for data that a plan file lacks: its scale, the layers of a DXF drawing.

import { ask, button, el, field } from "./dom.js";
import { readLength } from "./units.js";

const number = (text) => (Number.isNaN(Number(text.replace(",", "."))) ? text : Number(text.replace(",", ".")));
const sizeText = (value) => String(Number(value.toPrecision(4)));
const exact = (name) => name.replace(/[[*?]/g, "[$&]").replaceAll(",", "?");

/** Show the reader's message and ask; resolves to {data, given}, or to null when closed.
 *
 * `reading` is the server's answer, `typed` the data of the last try (a FormData), `line` the error.
 * `given` is {metres_per_pixel, width, dxf_layers}.
 */
export async function askReading(reading, typed, line, feet) {
  const { unit, size, metres_per_pixel: now } = reading;
  const text = (name, first) => typed?.get(name) ?? first;
  const input = (label, name, value, more) => field(label, `reading ${name}`, value, () => {}, { name, ...more });
  const scale = input(`${unit === "pixel" ? "or metres" : "Metres"} a ${unit}`, "scale", text("scale", now === null ? "" : String(now)), { inputMode: "decimal" });
  const width = input(unit === "pixel" ? "Its whole width" : "or its whole width", "width", text("width", ""), { inputMode: "decimal", placeholder: feet ? "32' 6\"" : "9.8 m" });
  const wide = size || reading.names.length ? width : null;
  const parts = [line ? el("p", { className: "fault", role: "alert" }, line) : null, ...(unit === "pixel" ? [wide, scale] : [scale, wide]), size ? el("p", { className: "soft" }, `It is drawn ${sizeText(size[0])} x ${sizeText(size[1])} ${unit}s. Its width: from left to right.`) : null,
    ...layerFields(reading, text, input)];
  const data = await ask("How the plan file is read", parts.filter(Boolean), "Read again");
  return data && { data, given: given(data, reading, feet) };
}

function given(data, { patterns, metres_per_pixel: now }, feet) {
  const scale = data.get("scale").trim(), wide = (data.get("width") ?? "").trim();
  const metres = readLength(wide, feet);
  const kept = wide && scale === String(now); // a typed width replaces an unchanged scale
  return {
    metres_per_pixel: scale && !kept ? number(scale) : null,
    width: wide ? (Number.isNaN(metres) ? wide : metres) : null,
    dxf_layers: Object.fromEntries(Object.keys(patterns).map((kind) => [kind, data.get(kind)]).filter(([, pattern]) => pattern)),
  };
}

/** A field for each kind's pattern, and the names in the file: a click adds one to the last used field. */
function layerFields({ names, patterns, dxf_layers: layers }, text, input) {
  const kinds = Object.keys(patterns);
  if (!kinds.length) return [];
  const fields = kinds.map((kind) => input(kind, kind, text(kind, layers[kind] ?? ""), { placeholder: patterns[kind] }));
  let used = fields[0].querySelector("input");
  for (const node of fields) node.addEventListener("focusin", (event) => { used = event.target; });
  const take = (name) => { used.value = [used.value, exact(name)].filter(Boolean).join(","); used.focus(); };
  const lines = names.map(({ name, block, count, kind }) => el("li", {}, button([el("span", {}, block ? `block ${name}` : name), el("span", { className: "soft" }, `${count}, ${kind || "not read"}`)], () => take(name), { className: "line" })));
  return [el("p", { className: "soft" }, "Patterns of the layers' and blocks' names, parted by commas (* stands for any letters); empty: the usual words. A click on a name takes it into the field used last."),
    ...fields, el("ul", { className: "list names", "aria-label": "Layers and blocks in the file" }, lines)];
}
