// The tray: orders that wait until the clock runs, and what comes after them. Below it what a key or a tap would plan.

import { badge, byId, make } from "../dom";
import { readOrder, sayOrder } from "./orders";
import type { Play } from "./play";
import { rebuilt } from "./rebuilt";

export function showTray(play: Play): void {
  const { state, over } = play.session;
  const aim = play.cursor >= 0 && play.hover < 0 ? play.aimAt(play.cursor, play.then) : null;
  const key = JSON.stringify([state.tray, state.plans, state.clock.running, state.undo > 0, play.told, aim?.lines, aim?.steps, play.picked?.index, over !== null, play.looking]);
  byId("tray").classList.toggle("bare", Object.keys({ ...state.tray, ...state.plans }).length === 0 && state.undo === 0);
  rebuilt(byId("tray"), key, () => [head(play), list(play), ...(aim ? [offer(play)] : []), told(play), buttons(play)]);
}

function head(play: Play): HTMLElement {
  const count = play.session.waiting;
  const text = count === 0 ? "No orders wait" : count === 1 ? "1 order waits" : `${count} orders wait`;
  return make("h2", {}, text, make("span", { class: "soft small" }, `for tick ${play.session.tick}`));
}

function list(play: Play): HTMLElement {
  const rows = make("ol");
  for (const piece of play.own()) {
    const order = play.session.state.tray[piece.short];
    const steps = play.session.state.plans[piece.short] ?? [];
    if (order === undefined && steps.length === 0) continue;
    const [first, ...later] = toldSteps(order, steps);
    const after = later.length ? `then ${later.map(sayOrder).join(", then ")}` : "";
    const text = make("span", {}, make("b", {}, piece.short), ` ${sayOrder(first)}`, make("small", {}, order === undefined ? ["under way", after].filter(Boolean).join("; ") : after));
    const away = make("button", { type: "button", title: "Forget it", "aria-label": `Forget the plan of ${piece.short}`, id: `cancel-${piece.short}` }, "×");
    away.addEventListener("click", () => void play.send("cancel", { piece: piece.short }));
    rows.append(make("li", {}, badge(piece.camp, piece.letter), text, away));
  }
  return rows;
}

/** The order that waits and the steps after it; a waypoint says where its own first move leads. */
function toldSteps(order: string | undefined, steps: string[]): string[] {
  const leads = order !== undefined && readOrder(order).verb === "move" && steps.length > 0 && readOrder(steps[0]).verb === "go";
  return order === undefined || leads ? steps : [order, ...steps];
}

/** What Enter would plan at the cursor; a tap shows it first, too. */
function offer(play: Play): HTMLElement {
  const aim = play.aimAt(play.cursor, play.then);
  const lines = make("p", { class: "small" }, (aim?.lines ?? []).join(". "));
  const plan = make("button", { type: "button", id: "plan", class: "strong" }, play.then ? "Then this" : "Plan this", make("kbd", {}, "⏎"));
  plan.addEventListener("click", () => void play.planAt(play.cursor, play.then));
  const later = make("button", { type: "button", id: "plan-then", title: "After what is planned (shift Enter)" }, "Then");
  later.addEventListener("click", () => void play.planAt(play.cursor, true));
  const can = aim?.steps && play.picked;
  const row = make("div", { class: "tray-keys" }, plan, play.picked && play.hasPlan(play.picked.short) && !play.then ? later : null);
  return make("div", { class: "offer" }, lines, can ? row : null);
}

function told(play: Play): HTMLElement {
  return make("p", { class: "told", id: "told" }, play.told);
}

function buttons(play: Play): HTMLElement {
  const { state, waiting } = play.session;
  const { running } = state.clock;
  const text = running ? "Pause" : waiting ? `Give ${waiting === 1 ? "the order" : `${waiting} orders`} and run` : "Run";
  const go = make("button", { type: "button", id: "go", class: "strong" }, text, make("kbd", {}, running ? "space" : "⏎"));
  go.addEventListener("click", () => play.toggleClock());
  const undo = make("button", { type: "button", id: "undo", title: "Take back the last order that waits (Backspace)" }, "Take back");
  undo.addEventListener("click", () => play.undo());
  undo.disabled = state.undo === 0;
  go.disabled = !play.session.commands;
  return make("div", { class: "tray-keys buttons-row" }, go, undo);
}
