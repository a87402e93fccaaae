import { Files } from "./files.js";
import { startEditor } from "./start.js";

startEditor(JSON.parse(document.getElementById("start").textContent), new Files());
