// Functions that make elements of the page without HTML markup, so that text is never parsed.

/** A new HTML element; `on...` properties are listeners, `data-...` and `aria-...` attributes. */
export function el(name, properties = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (key.includes("-") || key === "for" || key === "role" || key === "list") element.setAttribute(key, value);
    else element[key] = value;
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

export const button = (text, onclick, properties = {}) => el("button", { type: "button", onclick, ...properties }, text);

/** A labelled field; `key` identifies it, so that it keeps the focus when the panel is rebuilt. */
export function field(label, key, value, onchange, properties = {}) {
  const input = el("input", { defaultValue: value, autocomplete: "off", spellcheck: false, "data-key": key, onchange: (event) => onchange(event.target.value, event.target), ...properties });
  return el("label", { className: "field" }, el("span", {}, label), input);
}

/** Show a dialog with a form; resolves to its data, or to null when it is closed.
 *
 * `check` takes the form and returns its errors as nodes to show, or null to accept it. `other` is a
 * second button {text, value}; the promise resolves to its value.
 */
export function ask(title, children, confirm = "OK", { check, other } = {}) {
  return new Promise((resolve) => {
    const told = el("p", { className: "fault", role: "alert", hidden: true });
    const away = other ? button(other.text, () => { resolve(other.value); dialog.close(); }) : button("Cancel", () => dialog.close());
    const form = el("form", { method: "dialog" }, el("h2", {}, title), ...children, told,
      el("div", { className: "row end" }, away, el("button", { type: "submit", className: "primary" }, confirm)));
    const dialog = el("dialog", { onclose: () => { dialog.remove(); resolve(null); } }, form);
    form.addEventListener("submit", (event) => {
      const fault = check?.(form);
      if (!fault) { resolve(new FormData(form)); return; }
      event.preventDefault();
      told.replaceChildren(...fault);
      told.hidden = false;
    });
    document.body.append(dialog);
    dialog.showModal();
    const first = form.querySelector("input, select, button.primary");
    first?.focus();
    if (first?.type === "text") first.select();
  });
}

/** Let the browser save a text as a file. */
export function download(name, text, type) {
  const link = el("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

export const readFile = (file) => file.text();
/** Whether a file is a picture of pixels; a drawing (SVG, image/vnd.dxf) is a plan. */
export const isPicture = (file) => /^image\/(?!svg|vnd)/.test(file.type);

/** A picture file as {url (data), width, height}, its longer side at most `side` pixels. */
export async function readPicture(file, side, type = "image/jpeg") {
  const bitmap = await createImageBitmap(file);
  const share = Math.min(1, side / Math.max(bitmap.width, bitmap.height));
  const canvas = el("canvas", { width: Math.round(bitmap.width * share), height: Math.round(bitmap.height * share) });
  canvas.getContext("2d").drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  bitmap.close();
  return { url: canvas.toDataURL(type, 0.85), width: canvas.width, height: canvas.height };
}
