"use strict";
// Saves the photo table with the rooms that the user chose on the page.
const table = JSON.parse(document.getElementById("table").textContent);
const save = document.getElementById("save");
const [header] = table;
const [room, guess] = ["room_id", "guess"].map((name) => header.indexOf(name));

function chosen() {
  const rows = table.map((row) => [...row]);
  const gone = new Set();
  for (const select of document.querySelectorAll("select")) {
    const row = rows[Number(select.dataset.row)];
    if (select.value === select.dataset.first) continue;
    if (select.value === "-") gone.add(row);
    [row[room], row[guess]] = [select.value, ""];
  }
  return rows.filter((row) => !gone.has(row));
}

function csv(rows) {
  const cell = (text) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  return rows.map((row) => row.map(cell).join(",") + "\n").join("");
}

save.addEventListener("click", () => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([csv(chosen())], { type: "text/csv" }));
  link.download = "photos.csv";
  link.click();
  URL.revokeObjectURL(link.href);
});
