// What stands on the page around the map: names, notices, layers, tabs, and the dialogs.

import { badge, byId, make, say } from "../dom";
import { signed } from "../log";
import { CAMPS, type Camp } from "../story";
import { KEYS } from "./command";
import type { Play, Tab } from "./play";
import type { LadderDoc, OverDoc, StopsDoc } from "./protocol";

const LAYERS: [string, string, string][] = [["fog", "Fog", "g"], ["los", "Sight", "l"], ["ranges", "Ranges", "r"], ["mortar", "Mortar", "m"], ["follow", "Follow", "f"]];
const TABS: [Tab, string, string][] = [["orders", "Orders", "e"], ["pieces", "Pieces", "i"], ["log", "Log", "t"], ["hints", "Hints", "q"]];
const STOPS: [keyof StopsDoc, string][] = [["first_sight", "an enemy comes into sight for the first time"], ["own_loss", "a piece of yours loses a vehicle or a squad"], ["idle", "a piece of yours has nothing left to do"]];

export function buildDesk(play: Play): void {
  for (const [name, text, key] of LAYERS) {
    const button = make("button", { type: "button", id: `on-${name}`, title: `${text} (${key})`, "aria-pressed": "false" }, text);
    button.addEventListener("click", () => play.toggle(name));
    byId("layers").append(button);
  }
  for (const [tab, text, key] of TABS) {
    const button = make("button", { type: "button", role: "tab", id: `tab-${tab}`, title: `${text} (${key})`, "aria-controls": "panel" }, text);
    button.addEventListener("click", () => play.openTab(tab));
    byId("tabs").append(button);
  }
  buildKeys();
}

export function showScore(play: Play): void {
  const { camp, story } = play.session;
  const side = (one: Camp) => {
    const { name, kind } = story.players[one];
    const who = make("span", { class: "who" }, make("bdi", { class: "name", title: name }, name), make("span", { class: "kind" }, `${one}${kind ? `, ${kind}` : ""}`));
    const margin = one === camp ? make("span", { class: "margin", id: `margin-${one}`, title: "margin, as you know it" }) : make("span", { id: `margin-${one}` });
    return make("div", { class: `side ${one}${one === camp ? " you" : ""}` }, badge(one, one[0].toUpperCase()), who, margin);
  };
  const enemy = CAMPS.find((one) => one !== camp) as Camp;
  byId("score").replaceChildren(side(camp), make("span", { class: "versus" }, "against"), side(enemy));
  document.title = `${play.session.hello.name}: ${camp} against ${play.session.hello.opponent}`;
}

/** How the clock stands, in one sentence. */
export function sayStanding(play: Play): void {
  const { session } = play;
  const { clock } = session.state;
  const { ladder } = session.hello;
  const rung = ladder && !session.over ? ` Rung ${ladder.rung + 1} of ${ladder.rungs.length}.` : "";
  let text = `Paused${session.stopped ? `: ${session.stopped}` : ""}.`;
  if (session.over) text = `The game is over: ${session.over.result}.`;
  else if (play.looking) text = "You look back. End leads to now.";
  else if (clock.running) text = "The clock runs.";
  say(byId("said"), `${text.replace("..", ".")}${rung}`);
  byId("said").title = text;
  byId("show-stop").hidden = session.stoppedAt < 0 || clock.running || play.looking;
}

export function showNotice(text: string, again: (() => void) | null): void {
  const notice = byId("notice");
  byId("app").hidden = false;
  byId("fallback").hidden = true;
  notice.hidden = text === "";
  const button = make("button", { type: "button", id: "again" }, "Try now");
  button.addEventListener("click", () => again?.());
  notice.replaceChildren(make("span", {}, again ? `${text} Trying again …` : text), again ? button : "");
}

function dialog(id: string, ...children: (Node | string)[]): HTMLDialogElement {
  const found = byId<HTMLDialogElement>(id);
  found.replaceChildren(...children);
  return found;
}

function closing(found: HTMLDialogElement, text: string): HTMLElement {
  const button = make("button", { type: "button", class: "strong" }, text);
  button.addEventListener("click", () => found.close());
  return button;
}

function buildKeys(): void {
  const rows = KEYS.map(([key, says]) => make("div", { class: "key" }, make("kbd", {}, key), make("span", {}, says)));
  const found = dialog("keys", make("h2", {}, "Keys"), make("div", { class: "columns" }, ...rows), make("p", { class: "small soft" }, "Squares are red, discs are blue; T tank, C chariot, S soldier, A aerocraft. A dashed rim hides, a triangle is suppressed, a pale token is where an enemy was last seen, with the ticks since then, in the ring that it can have reached. Fog lies where a vehicle that does not hide would not be seen. An orange dot on a button: nobody has told this piece what to do. Shift-click a piece of yours to go to its cell."));
  const first = make("button", { type: "button", id: "show-first" }, "Your first order");
  first.addEventListener("click", () => {
    found.close();
    showFirst();
  });
  found.append(make("div", { class: "buttons" }, closing(found, "Close"), first));
}

const BY_MOUSE = [
  "Pick a piece of yours: click it, or press its number.",
  "Point at a cell: you see the way, when it arrives, and which known enemies would see it there. Click, and the order waits in the tray. Click an enemy to fire at it: you see the chances first.",
  "Shift-click plans what comes after that. Backspace takes back. Nothing happens before the clock runs.",
  "Enter gives the orders and lets the clock run.",
];
const BY_TOUCH = [
  "Pick a piece of yours: tap it, or its button.",
  "Tap a cell: you see the way, when it arrives, and which known enemies would see it there. Tap it again, and the order waits in the tray. Tap an enemy to see the chances of a shot.",
  "“Then” plans what comes after that, “Take back” takes back. Nothing happens before the clock runs.",
  "“Give the orders and run” does what it says.",
];

/** How to give a first order. */
export function showFirst(): void {
  const touch = matchMedia("(pointer: coarse)").matches;
  const steps = touch ? BY_TOUCH : BY_MOUSE;
  const found = dialog("first", make("h2", { id: "first-title" }, "Your first order"), make("ol", {}, ...steps.map((step) => make("li", {}, step))), make("p", { class: "soft" }, "The clock stops by itself when an enemy comes into sight, when you lose something, and when a piece has nothing left to do. You win by points: what your pieces and your control points are worth, less theirs. A piece takes a point by the order Occupy in its cell."), touch ? "" : make("p", { class: "soft" }, "All can be done by keys alone: ? lists them."));
  const rules = make("a", { href: "/rules", target: "_blank", rel: "noopener" }, "The rules");
  found.append(make("div", { class: "buttons" }, closing(found, "Begin"), rules));
  found.showModal();
}

export function showStops(play: Play): void {
  const { stops } = play.session.state;
  const boxes = STOPS.map(([name, text]) => {
    const box = make("input", { type: "checkbox", id: `stop-${name}` });
    box.checked = stops[name];
    box.addEventListener("change", () => {
      stops[name] = box.checked;
      void play.send("stops", { ...stops });
    });
    return make("label", {}, box, text);
  });
  const found = dialog("when", make("h2", { id: "when-title" }, "The clock stops by itself when"), ...boxes);
  const rest = make("button", { type: "button", id: "finish", title: "Without further orders and stops" }, "Play on to the end");
  rest.disabled = !play.session.commands;
  rest.addEventListener("click", () => {
    found.close();
    void play.send("finish");
  });
  found.append(make("div", { class: "buttons" }, closing(found, "Close"), rest));
  found.showModal();
}

const RESULTS = { won: "You have won.", lost: "You have lost.", drawn: "A draw." };

export function showEnding(play: Play, over: OverDoc): void {
  const { camp } = play.session;
  const enemy = CAMPS.find((one) => one !== camp) as Camp;
  const found = dialog("ending",
    make("h2", { id: "ending-title" }, RESULTS[over.result]),
    make("p", { class: "big" }, make("span", { class: `t-${camp}` }, `${camp} ${signed(over.margin[camp])}`), " : ", make("span", { class: `t-${enemy}` }, `${enemy} ${signed(over.margin[enemy])}`)),
    make("p", {}, `These are the true margins. Against ${play.session.hello.opponent}, with ${over.hints} ${over.hints === 1 ? "hint" : "hints"}. The replay is ${over.file}.`),
    ...(over.ladder ? [ladderText(over.ladder)] : []),
    make("div", { class: "buttons" }, make("a", { class: "button", id: "after", href: over.after }, "See the whole game"), make("a", { id: "replay", href: over.replay, download: over.file }, "The replay as a file")),
  );
  const close = make("button", { type: "button" }, "Stay here");
  close.addEventListener("click", () => found.close());
  found.querySelector(".buttons")?.append(close);
  if (!found.open) found.showModal();
}

/** All rungs, and which one is next: a win leads up. */
function ladderText(ladder: LadderDoc): HTMLElement {
  const rows = ladder.rungs.map((rung, k) => make("li", k === ladder.rung ? { "aria-current": "true" } : {}, `${rung.name}: won ${rung.won} of ${rung.games}`, k === ladder.rung ? make("b", {}, "  the next one") : ""));
  const range = ladder.elo_range ? `, between ${ladder.elo_range.map(Math.round).join(" and ")}` : "";
  const elo = ladder.elo === null ? "" : `: your Elo is ${Math.round(ladder.elo)}${range}`;
  return make("div", { class: "ladder" }, make("h3", {}, `The ladder${elo}`), make("ol", {}, ...rows));
}
