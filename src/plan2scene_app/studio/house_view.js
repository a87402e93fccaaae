// The house of a project: progress of its run, results, downloads.

import { labelsOf, readTable } from "./document.js";
import { button, download, el } from "./dom.js";
import { Finishes } from "./finishes.js";
import { photoCard } from "./photos.js";
import { asked } from "./server.js";

const WORDS = { none: "Make the house", done: "Make it again", failed: "Try again", cancelled: "Go on", interrupted: "Go on" };

const FILE_OF = { "3D": "viewer.html", Picture: "preview.png", Rooms: "rooms.jpg", "Beside photos": "views.jpg", Floors: "patterns.jpg", "Pieces of photos": "contact_sheet.png", "What is not sure": "doubts.html", Textures: "house.glb" };

export class HouseView {
  run = { state: "none", stages: [], results: { files: {}, tiles: [] }, settings: {} }; view = "3D"; shown = ""; folds = {}; turn = 0;

  constructor(app, host, rules) {
    Object.assign(this, { app, host, rules, box: document.getElementById("run"), results: document.getElementById("results"), make: document.getElementById("make") });
    this.choices = Object.fromEntries(Object.entries(rules.settings).map(([name, { title, values, value }]) =>
      [name, el("select", { "aria-label": title }, values.map((each) => el("option", { value: each, selected: each === value }, String(each))))]));
    this.research = el("details", {}, el("summary", {}, "For researchers"),
      Object.entries(rules.settings).map(([name, { title }]) => el("label", { className: "field" }, el("span", {}, title), this.choices[name])));
    this.finishes = new Finishes(this, rules.library);
    this.make.addEventListener("click", () => (this.run.state === "running" ? this.cancel() : this.start()));
    this.poll();
  }

  async poll() {
    clearTimeout(this.timer);
    const { turn } = this; // changes when a run is started meanwhile
    try {
      await this.take(await asked("run"));
      await this.host.look(this.run.revision);
      if (this.due && !this.starting && turn === this.turn && this.run.state !== "running") {
        this.due = false;
        if (this.run.state === "done" && this.run.settings.finishes !== this.run.finishes) { this.start(); return; }
      }
      if (this.away) this.tell("");
      this.away = false;
    } catch (error) {
      if (!this.away) this.tell(error.message);
      this.away = true;
    }
    this.timer = setTimeout(() => this.poll(), this.run.state === "running" ? 700 : 2000);
  }
  async take(run) {
    if (!this.started) this.settle(run.settings);
    this.started = true;
    await this.takeRooms(run.results.files["photos.csv"]);
    this.run = run;
    const text = JSON.stringify([run, this.app.problems.length, this.app.store.state.photos, this.view, this.host.revision]);
    if (text === this.shown) return;
    this.shown = text;
    this.render();
  }
  /** Read where the run put the photos whose room was not given, if its table is another one. */
  async takeRooms(time) {
    if (!time || time === this.tableTime) return;
    const answer = await fetch(`results/photos.csv?${time}`);
    if (!answer.ok) return;
    this.found = new Map(readTable(await answer.text()).map(({ name, rooms }) => [name, rooms[0]]));
    this.tableTime = time;
  }
  settle(settings) {
    for (const [name, choice] of Object.entries(this.choices)) if (name in settings) choice.value = settings[name];
  }
  async start() {
    document.getElementById("tab-house").click();
    if (this.starting) return; // a second click, or a scheduled run
    this.starting = true;
    try {
      await this.host.flush();
      const chosen = Object.entries(this.choices).map(([name, choice]) => [name, this.rules.settings[name].values[choice.selectedIndex]]);
      const body = JSON.stringify(Object.fromEntries(chosen));
      await this.take(await asked("run", { method: "POST", body }));
      this.tell("");
    } catch (error) { this.tell(error.message); }
    this.starting = false;
    this.turn++;
    this.poll();
  }
  /** Make an existing house again with newly set finishes, after the current run if there is one. */
  makeAgain() {
    this.due = true;
    this.poll();
  }
  async cancel() {
    try { await this.take(await asked("run", { method: "DELETE" })); } catch (error) { this.tell(error.message); }
  }
  /** Show a message of the server on both tabs; an empty one removes it. */
  tell(line) {
    if (line) this.app.say(line);
    this.line = line;
    this.render();
  }

  render() {
    const { run } = this, running = run.state === "running";
    const errors = this.app.problems.filter((p) => p.level === "error").length;
    const done = run.stages.filter((stage) => stage.state === "done").length;
    this.make.textContent = running ? "Cancel" : WORDS[run.state];
    this.make.className = running ? "" : "primary";
    document.getElementById("badge").textContent = running ? (run.stages.length ? `${done}/${run.stages.length}` : "\u2026") : "";
    this.box.replaceChildren(this.runSection(running, errors, done), ...(this.run.results.files["viewer.html"] ? [this.finishes.node] : []), this.photoSection());
    this.renderResults();
  }
  runSection(running, errors, done) {
    const { run } = this, changed = run.state === "done" && (run.settings.revision !== run.revision || run.settings.finishes !== run.finishes);
    const now = run.stages.find((stage) => stage.state === "running"), labels = labelsOf(this.app.store.state.plan.rooms);
    const told = new Set(this.app.problems.map((p) => `${p.room || "Plan"}: expected ${p.expected}, found ${p.found}`)); // already shown beside the plan, with links
    const lines = (run.warnings ?? []).filter((line) => !told.has(line)).map((line) => line.replace(/^[^:]+/, (room) => labels.get(room) ?? room));
    const titles = { none: run.results.files["house.glb"] ? "Made by plan2scene run" : "No house yet", running: "Being made", done: "Ready", failed: "The run failed", cancelled: "Cancelled", interrupted: "Interrupted" };
    return el("section", {}, el("h2", {}, titles[run.state]),
      el("div", { className: "row" }, running ? button("Cancel", () => this.cancel(), { id: "cancel" }) : button(WORDS[run.state], () => this.start(), { className: "primary", id: "start-run" })),
      errors && !running ? el("p", { className: "hint" }, `The plan has ${errors} problem${errors > 1 ? "s" : ""} that would stop a run: see Plan and photos.`) : null,
      changed ? el("p", { className: "hint" }, "Plan or photos changed since. Only what depends on the change is made again.") : null,
      this.line ? el("p", { className: "fault" }, this.line) : null,
      run.fault ? el("p", { className: "fault" }, run.fault) : null,
      ["cancelled", "interrupted"].includes(run.state) ? el("p", { className: "soft" }, "What is made stays; a run goes on from there.") : null,
      running ? null : this.research,
      running && !run.stages.length ? el("p", { className: "soft" }, "Reading plan and photos\u2026") : null,
      done < run.stages.length ? el("progress", { value: done, max: run.stages.length, "aria-label": "Stages done" }) : null,
      run.stages.length ? this.folding("stages", running && innerWidth > 860, now ? `${done + 1} of ${run.stages.length}: ${now.title}` : `${done} of ${run.stages.length} steps done`,
        el("ol", { className: "stages" }, run.stages.map((stage) => el("li", { className: stage.state }, stage.title)))) : null,
      lines.length ? this.folding("warnings", false, lines.length > 1 ? `${lines.length} things to know` : "One thing to know", lines.map((line) => el("p", {}, line))) : null);
  }
  /** A section that folds; it stays open or closed when the page is rebuilt. */
  folding(name, open, title, ...children) {
    const node = el("details", { open: this.folds[name] ?? open }, el("summary", { onclick: () => { this.folds[name] = !node.open; } }, title), ...children);
    return node;
  }
  photoSection() {
    const { photos } = this.app.store.state;
    return el("section", {}, el("h2", {}, "Photos and their rooms"), photos.length ? el("div", { className: "photos" }, photos.map((photo) => photoCard(this.app, photo, this.found?.get(photo.name)))) : el("p", { className: "soft" }, "None: every surface is made up from what homes are like."));
  }

  renderResults() {
    const { files, tiles } = this.run.results, views = Object.keys(FILE_OF).filter((view) => (view === "Textures" ? tiles.length : files[FILE_OF[view]]));
    if (!views.length) {
      this.results.replaceChildren(el("div", { className: "empty" }, "The house appears here when it is made."));
      this.pane = "";
      return;
    }
    if (!views.includes(this.view)) [this.view] = views;
    const choose = views.map((view) => button(view, () => { this.view = view; this.shown = ""; this.render(); }, { "aria-pressed": String(view === this.view) }));
    const links = [["house.glb", "GLB"], ["house.scene.json", "scene.json"]].filter(([name]) => files[name])
      .map(([name, title]) => el("a", { className: "button", href: `results/${name}`, download: name }, title));
    const bar = el("div", { className: "views" }, choose, el("span", { className: "grow" }), links, this.exportChoice(), el("a", { className: "button", href: "zip", download: "" }, "All as ZIP"));
    const pane = `${this.view} ${files[FILE_OF[this.view]]}`;
    if (pane === this.pane) this.results.firstChild.replaceWith(bar);
    else this.results.replaceChildren(bar, this.paneOf(files, tiles));
    this.pane = pane;
  }
  exportChoice() {
    const forms = Object.entries(this.rules.exports).map(([form, what]) => el("option", { value: form }, what));
    return el("select", { "aria-label": "Other formats", onchange: (event) => { this.exportAs(event.target.value); event.target.value = ""; } }, el("option", { value: "" }, "Other formats\u2026"), forms);
  }
  async exportAs(form) {
    this.tell("");
    const answer = await fetch(`export/${form}`);
    if (!answer.ok) { this.tell((await answer.json()).error); return; }
    const name = answer.headers.get("content-disposition").match(/filename="(.*)"/)[1];
    download(name, await answer.blob(), "application/octet-stream");
  }
  /** Link parameters that open the viewer where the last surface was clicked. */
  get place() { return this.finishes.surface?.place ? `#${this.finishes.surface.place}` : ""; }
  paneOf(files, tiles) {
    const at = (name) => `results/${name}?${files[name] ?? ""}`;
    if (FILE_OF[this.view].endsWith(".html")) return el("iframe", { src: at(FILE_OF[this.view]) + (this.view === "3D" ? this.place : ""), title: this.view === "3D" ? "The house in 3D" : this.view, sandbox: "allow-scripts allow-downloads", allow: "fullscreen; xr-spatial-tracking" });
    if (this.view !== "Textures") {
      const image = el("img", { src: at(FILE_OF[this.view]), alt: this.view, title: "Click: full size, or to fit", onclick: () => image.classList.toggle("full") });
      return el("div", { className: "pane", tabIndex: 0, role: "region", "aria-label": this.view }, image);
    }
    const time = files["house.glb"];
    return el("div", { className: "pane", tabIndex: 0, role: "region", "aria-label": this.view }, el("div", { className: "tiles" }, tiles.map((name) => {
      const tile = el("div", { className: "tile", role: "img", "aria-label": name });
      tile.style.backgroundImage = `url("results/textures/${name}?${time}")`;
      return el("figure", {}, tile, el("figcaption", {}, name.replace(/\.png$/, "").replaceAll("_", " ")));
    })));
  }
}
