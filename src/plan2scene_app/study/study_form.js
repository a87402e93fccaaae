"use strict";
const study = JSON.parse(document.getElementById("data").textContent);
const get = (id) => document.getElementById(id);
const source = (index) => "data:image/jpeg;base64," + study.images[index];
const slot = "plan2scene-study-" + study.form;
let state = { at: 0, answers: {} };
try { state = JSON.parse(localStorage.getItem(slot)) || state; } catch (error) { /* no storage: answers are kept only while the page is open */ }
let shownSince = 0;

function keep() {
  try { localStorage.setItem(slot, JSON.stringify(state)); } catch (error) { /* as above */ }
}

function show() {
  const question = study.questions[state.at];
  get("plan").src = source(question.plan);
  get("photos").replaceChildren(...question.photos.map((index, i) => {
    const figure = document.createElement("figure");
    const image = document.createElement("img");
    const caption = document.createElement("figcaption");
    image.src = source(index);
    image.alt = "Photo " + (i + 1);
    caption.textContent = "photo " + (i + 1);
    figure.append(image, caption);
    return figure;
  }));
  const answer = state.answers[question.id];
  for (const side of ["left", "right"]) {
    get(side).querySelector("img").src = source(question[side]);
    get(side).setAttribute("aria-pressed", String(Boolean(answer) && answer.choice === side));
  }
  const count = Object.keys(state.answers).length;
  get("progress").textContent = "Question " + (state.at + 1) + " of " + study.questions.length + ", " + count + " answered";
  get("done").textContent = count === study.questions.length ? "All answered: please save." : "";
  get("back").disabled = state.at === 0;
  shownSince = performance.now();
}

function choose(side) {
  const question = study.questions[state.at];
  const seconds = (performance.now() - shownSince) / 1000;
  state.answers[question.id] = { choice: side, seconds: Math.round(seconds * 10) / 10 };
  if (state.at < study.questions.length - 1) state.at += 1;
  keep();
  show();
}

function csv(participant) {
  const lines = ["form,participant,question,choice,seconds"];
  for (const question of study.questions) {
    const answer = state.answers[question.id];
    if (answer) lines.push([study.form, participant, question.id, answer.choice, answer.seconds].join(","));
  }
  return lines.join("\n") + "\n";
}

get("left").addEventListener("click", () => choose("left"));
get("right").addEventListener("click", () => choose("right"));
get("back").addEventListener("click", () => { state.at = Math.max(0, state.at - 1); keep(); show(); });
get("save").addEventListener("click", () => {
  const participant = get("participant").value.trim();
  if (!/^[A-Za-z0-9_-]{1,40}$/.test(participant)) {
    get("done").textContent = "Please give a code of letters and digits first.";
    get("participant").focus();
    return;
  }
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([csv(participant)], { type: "text/csv" }));
  link.download = "answers_" + participant + ".csv";
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
});
document.addEventListener("keydown", (event) => {
  if (event.target.tagName === "INPUT") return;
  if (event.key === "ArrowLeft") choose("left");
  if (event.key === "ArrowRight") choose("right");
});
show();
