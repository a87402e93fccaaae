// Photos of rooms: photos are dropped on rooms or added in the panel; checks of the photo table.

import { labelOf, labelsOf } from "./document.js";
import { ask, button, el, isPicture, readPicture } from "./dom.js";
import { isZip, unzipped } from "./zip.js";

const THUMB = 240; // pixels

/** Problems of the photo table, with the texts of its reader (datasets/assignments.py). */
export function photoProblems(photos, rooms) {
  const found = [], stems = new Map(), known = new Set(rooms.map((room) => room.id));
  const tell = (level, expected, text, photo) => found.push({ level, expected, found: text, room: "", opening: "", photo });
  for (const { name, rooms: shown } of photos) {
    if (/[\\:*?"<>|{}\u0000-\u001f]/.test(name) || name !== name.trim() || name.startsWith("/") || name.split("/").some((part) => ["", ".", ".."].includes(part)))
      tell("error", "a plain file name without '..', a leading '/', end spaces or any of \\:*?\"<>|{}", `'${name}'`, name);
    const stem = name.split("/").at(-1).replace(/(?<=.)\.[^.]*$/, "");
    if (stems.has(stem)) tell("error", "photo names that differ before the extension", `${stems.get(stem)} and ${name}`, name);
    stems.set(stem, name);
    for (const id of shown) if (!known.has(id)) tell("error", `a room of the plan (${[...known].sort().join(", ").slice(0, 150)})`, `'${id}' for photo ${name}`, name);
  }
  const loose = photos.filter(({ rooms: shown }) => !shown.length);
  if (loose.length) tell("note", "a room for each photo", `${loose.length} without one, which is looked for when the house is made`, "Photos");
  return found;
}

/** Add photos to the document and assign them to a room (null: to none yet). */
export async function addPhotos(app, files, room) {
  const added = [];
  for (const file of files) {
    app.refused.delete(file.name);
    try {
      const thumb = await (app.host.photo?.(file) ?? thumbOf(file));
      if (!app.thumbs.has(file.name)) app.thumbs.set(file.name, thumb);
    } catch (error) {
      app.refused.set(file.name, error.message);
      continue;
    }
    added.push(file.name);
    const photos = app.store.state.photos, known = photos.find((photo) => photo.name === file.name);
    const rooms = room && !known?.rooms.includes(room) ? [...(known?.rooms ?? []), room] : (known?.rooms ?? []);
    app.store.change({ photos: known ? photos.map((p) => (p === known ? { ...p, rooms } : p)) : [...photos, { name: file.name, rooms }] });
  }
  const none = app.refused.size ? `${app.refused.size} not added: see Photos. ` : "";
  const names = added.length === 1 ? added[0] : `${added.length} photos`, shown = app.store.state.plan.rooms.find(({ id }) => id === room);
  const loose = app.store.state.photos.some(({ name, rooms }) => !rooms.length && added.includes(name));
  app.say(none + (added.length ? `${names} ${room ? `in ${labelOf(shown)}` : `added${loose ? "; a room that you do not choose is looked for" : ""}`}` : ""));
  app.renderPanel();
}

async function thumbOf(file) {
  try { return (await readPicture(file, THUMB)).url; } catch { throw new Error(`no picture that can be read here${/\.(hei[cf]|avif)$/i.test(file.name) ? " (HEIC)" : ""}: save it as JPEG`); }
}

/** Lines for the files that were not added, each with the reason; a click removes a line. */
export function refusedLines(app) {
  const drop = (name) => { app.refused.delete(name); app.renderPanel(); };
  return [...app.refused].map(([name, why]) => el("p", { className: "fault", role: "alert" }, el("b", {}, name), ` is not added: ${why} `,
    button("\u00d7", () => drop(name), { "aria-label": `Take the line on ${name} away` })));
}

export function setRooms(app, name, rooms) {
  app.store.change({ photos: app.store.state.photos.map((photo) => (photo.name === name ? { ...photo, rooms: [...new Set(rooms)] } : photo)) });
}

/** The card of a photo: its picture, its rooms (or the one `found` by a run), a choice to add a room. */
export function photoCard(app, photo, found) {
  const labels = labelsOf(app.store.state.plan.rooms);
  const rooms = [...labels.keys()].filter((id) => !photo.rooms.includes(id)), label = (id) => labels.get(id) ?? id;
  const thumb = app.thumbs.get(photo.name);
  const chips = photo.rooms.map((id) => el("span", { className: "chip" }, label(id),
    button("\u00d7", () => setRooms(app, photo.name, photo.rooms.filter((r) => r !== id)), { title: `${photo.name} does not show ${label(id)}`, "aria-label": `Remove ${label(id)} from ${photo.name}` })));
  const choice = el("select", { "data-key": `photo ${photo.name}`, "aria-label": `Room of ${photo.name}`, onchange: (event) => setRooms(app, photo.name, [...photo.rooms, event.target.value]) },
    el("option", { value: "", selected: true }, photo.rooms.length ? "+ room" : labels.has(found) ? `Found: ${label(found)}` : "Which room?"), rooms.map((id) => el("option", { value: id }, label(id))));
  const card = el("figure", { className: `photo${photo.rooms.length ? "" : " loose"}`, draggable: true, "data-photo": photo.name },
    thumb ? el("img", { src: thumb, alt: photo.name, draggable: false }) : el("div", { className: "blank" }, photo.name.slice(0, 18)),
    el("figcaption", {}, el("span", { className: "file", title: photo.name }, photo.name), el("div", { className: "chips" }, chips, rooms.length ? choice : null)),
    button("\u00d7", () => app.store.change({ photos: app.store.state.photos.filter((p) => p.name !== photo.name) }), { className: "remove", title: `Take ${photo.name} out`, "aria-label": `Take ${photo.name} out` }));
  card.addEventListener("dragstart", (event) => { event.dataTransfer.setData("text/x-photo", photo.name); event.dataTransfer.effectAllowed = "copyMove"; });
  return card;
}

/** Handle drops on the drawing: files, and photo cards on rooms. On an empty page a picture is the plan. */
export function listenToDrops(app, target) {
  const roomAt = (event) => app.roomAt(app.view.at(event))?.id ?? null;
  target.addEventListener("dragover", (event) => {
    event.preventDefault();
    event.dataTransfer.dropEffect = "copy";
    app.dropRoom = roomAt(event);
    app.refresh();
  });
  target.addEventListener("dragleave", () => { app.dropRoom = null; app.refresh(); });
  target.addEventListener("drop", async (event) => {
    event.preventDefault();
    const room = roomAt(event), name = event.dataTransfer.getData("text/x-photo");
    app.dropRoom = null;
    if (name) {
      const photo = app.store.state.photos.find((p) => p.name === name);
      if (room && photo) setRooms(app, name, event.shiftKey || event.ctrlKey ? [...photo.rooms, room] : [room]);
      app.refresh();
      return;
    }
    let files;
    try { files = await droppedFiles(event.dataTransfer); } catch { app.say("This page cannot read folders: drop the files in it"); return; }
    if (!files.length) return;
    await takeFiles(app, files, room);
  });
}

/** The dropped files, also those in folders: of several folders each names its files, kitchen_1.jpg. */
async function droppedFiles({ items, files }) {
  const entries = [...items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (!entries.some((entry) => entry.isDirectory)) return [...files];
  const found = [];
  const take = async (entry, before) => {
    if (entry.name.startsWith(".")) return;
    if (entry.isDirectory) {
      const reader = entry.createReader();
      for (let some; (some = await new Promise((...ends) => reader.readEntries(...ends))).length;)
        for (const one of some) await take(one, before === null ? "" : `${before}${entry.name}_`);
    } else {
      const file = await new Promise((...ends) => entry.file(...ends));
      found.push(before ? new File([file], before + file.name, { type: file.type }) : file);
    }
  };
  for (const entry of entries) await take(entry, entries.length === 1 ? null : "");
  return found.sort((a, b) => (a.name < b.name ? -1 : 1));
}

/** Open files that were dropped or chosen together: a plan or its picture, a photo table, photos. */
export async function takeFiles(app, given, room = null) {
  const files = [];
  for (const file of given) {
    try { files.push(...(isZip(file) ? await unzipped(file) : [file])); } catch (error) { app.say(`${file.name}: ${error.message}`); return; }
  }
  const isPhoto = (file) => isPicture(file) || /\.(hei[cf]|avif)$/i.test(file.name);
  let photos = files.filter(isPhoto);
  const empty = () => !app.store.state.plan.rooms.length && !app.picture;
  const isTable = (file) => /\.csv$/i.test(file.name); // opened after the plan, because its rooms are the plan's
  for (const file of files.filter((one) => !isPhoto(one)).sort((a, b) => isTable(a) - isTable(b))) {
    const why = await app.openFile(file);
    if (why) app.refused.set(file.name, why);
  }
  if (empty() && photos.length) {
    const plans = await plansAmong(photos, Boolean(app.host.picture));
    if (plans === null) return;
    photos = photos.filter((file) => !plans.includes(file));
    if (plans.length) await app.openPicture(...plans);
  }
  if (photos.length) await addPhotos(app, photos, room);
  else app.renderPanel();
}

/** The pictures that are the plan: the only one that is mostly paper, else asked. Null if the dialog is closed. */
async function plansAmong(pictures, several) {
  if (pictures.length === 1) return pictures;
  const paper = await Promise.all(pictures.map((file) => paperShare(file).catch(() => 0)));
  const drawn = pictures.filter((_, k) => paper[k] >= MOSTLY_PAPER);
  if (drawn.length === 1) return drawn;
  const named = ({ name }) => /plan|grundriss|floor|layout|piso|etage/i.test(name);
  const likely = (drawn.length ? drawn : pictures.filter(named)).sort((a, b) => named(b) - named(a));
  const order = [...likely, ...pictures.filter((file) => !likely.includes(file))];
  const ticked = new Set(several ? likely : likely.slice(0, 1));
  const rows = order.map((file, k) => el("label", {}, el("input", { type: several ? "checkbox" : "radio", name: "plan", value: k, checked: ticked.has(file) }), ` ${file.name}`));
  const words = several ? "Tick the plan, or the plan of each storey. The others are kept as photos." : "The others are kept as photos.";
  const answer = await ask(several ? "Which pictures are the plan?" : "Which picture is the plan?", [el("p", { className: "soft" }, words), el("div", { className: "names" }, rows)], "Open", { other: { text: "None of them", value: "none" } });
  if (answer === "none") return [];
  return answer && answer.getAll("plan").map((k) => order[Number(k)]);
}

const MOSTLY_PAPER = 0.65; // least share of its main colour that makes a picture a drawing (tracing/settings.py: page_paper)

/** The share of a picture that has its most frequent colour, within 6 of 255. */
async function paperShare(file) {
  const bitmap = await createImageBitmap(file);
  const share = Math.min(1, 384 / Math.max(bitmap.width, bitmap.height));
  const canvas = el("canvas", { width: Math.max(1, Math.round(bitmap.width * share)), height: Math.max(1, Math.round(bitmap.height * share)) });
  const drawing = canvas.getContext("2d");
  drawing.imageSmoothingQuality = "high";
  drawing.fillStyle = "white"; // below what is transparent
  drawing.fillRect(0, 0, canvas.width, canvas.height);
  drawing.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  bitmap.close();
  const { data } = drawing.getImageData(0, 0, canvas.width, canvas.height), counts = new Map();
  for (let k = 0; k < data.length; k += 4) {
    const colour = ((data[k] >> 2) << 12) | ((data[k + 1] >> 2) << 6) | (data[k + 2] >> 2);
    counts.set(colour, (counts.get(colour) ?? 0) + 1);
  }
  const [main] = [...counts].reduce((a, b) => (b[1] > a[1] ? b : a)), of = [main >> 12, (main >> 6) & 63, main & 63].map((v) => 4 * v + 2);
  let near = 0;
  for (let k = 0; k < data.length; k += 4) if (of.every((v, c) => Math.abs(data[k + c] - v) <= 6)) near += 1;
  return (4 * near) / data.length;
}
