// What stands on the page before anything is drawn: names, buttons, tabs, the list of keys.

import { KEYS } from "./commands";
import type { Parting } from "./compare";
import { badge, byId, make } from "./dom";
import type { Page } from "./page";
import type { Tab } from "./scene";
import { CAMPS, type Camp } from "./story";
import { markName } from "./timeline";

export function build(page: Page): void {
  buildLayers(page);
  buildTabs(page);
  buildKeys();
}

/** What changes with the game that is open. */
export function buildGame(page: Page): void {
  const many = page.contents !== null;
  for (const id of ["all", "earlier", "later"]) byId(id).hidden = !many;
  byId<HTMLButtonElement>("earlier").disabled = page.entryOf(page.tape.number - 1) === null;
  byId<HTMLButtonElement>("later").disabled = page.entryOf(page.tape.number + 1) === null;
  if (page.tapes.length > 1) buildPair(page);
  else buildScore(page);
  const views = page.views.map((view, k) => {
    const button = make("button", { type: "button", id: `view-${view}`, title: `${k + 1}` }, view[0].toUpperCase() + view.slice(1));
    button.addEventListener("click", () => void page.show(view));
    return button;
  });
  byId("views").replaceChildren(...views);
}

function buildScore(page: Page): void {
  const { story } = page.game;
  const side = (camp: Camp) => {
    const { name, kind } = story.players[camp];
    const who = make("span", { class: "who" }, make("bdi", { class: "name", title: name }, name), make("span", { class: "kind" }, `${camp}${kind ? `, ${kind}` : ""}`));
    const margin = make("span", { class: "margin", id: `margin-${camp}` });
    const lead = make("span", { class: "lead", id: `lead-${camp}` }, "leads", make("span", { class: "by", id: `by-${camp}` }));
    return make("div", { class: `side ${camp}` }, badge(camp, camp[0].toUpperCase()), who, margin, lead);
  };
  const what = make("span", { class: "what", id: "what", title: story.seed ? `seed ${story.seed}` : "" });
  byId("score").replaceChildren(side("red"), make("span", { class: "versus" }, "against"), side("blue"), what);
}

/** Two games: where they part in the header, who plays above each map. */
function buildPair(page: Page): void {
  const { parting } = page;
  const [a, b] = page.tapes.map((tape) => tape.game.story.seed);
  const why = a === undefined ? "the seed is not known here" : a === b ? "the same game, to the end" : "the seeds differ";
  const found = parting ? make("button", { type: "button", id: "parting", title: orderText(parting) }, `They part at tick ${parting.tick}`) : make("span", { class: "soft", id: "parting" }, why);
  if (parting) found.addEventListener("click", () => page.seek(parting.tick));
  byId("score").replaceChildren(make("b", { class: "pair-title" }, "Two games on one clock"), found, make("span", { class: "what" }, parting ? orderText(parting) : ""));
  for (const [k, tape] of page.tapes.entries()) {
    const { players } = tape.game.story;
    const side = (camp: Camp) => make("span", { class: `side ${camp}`, title: players[camp].name }, badge(camp, camp[0].toUpperCase()), make("span", { class: "margin", id: `margin-${camp}-${k}` }));
    const pick = make("button", { type: "button", class: "about", id: `pick-${k}`, title: "Show its pieces, log and policy (w)" }, make("bdi", {}, tape.name), make("small", {}, make("bdi", {}, players.red.name), " against ", make("bdi", {}, players.blue.name)));
    pick.addEventListener("click", () => page.focus(k));
    byId(`about-${k}`).replaceChildren(pick, side("red"), side("blue"), make("span", { class: "soft small", id: `result-${k}` }));
  }
}

function orderText(parting: Parting): string {
  const parts = CAMPS.filter((camp) => parting.orders[camp] !== undefined).map((camp) => `${camp} from ${parting.orders[camp]}`);
  return parts.length ? `other orders: ${parts.join(", ")}` : "";
}

function buildLayers(page: Page): void {
  const names: [string, string, string][] = [
    ["beliefs", "Beliefs", "b"], ["fog", "Fog", "g"], ["los", "Sight", "l"], ["ranges", "Ranges", "r"], ["follow", "Follow", "f"],
  ];
  for (const [name, text, key] of names) {
    const button = make("button", { type: "button", id: `on-${name}`, title: `${text} (${key})` }, text);
    button.addEventListener("click", () => page.toggle(name));
    byId("layers").append(button);
  }
}

function buildTabs(page: Page): void {
  for (const [tab, text] of [["pieces", "Pieces"], ["log", "Log"], ["policy", "Policy"]] as [Tab, string][]) {
    const button = make("button", { type: "button", role: "tab", id: `tab-${tab}`, "aria-controls": "panel" }, text);
    button.addEventListener("click", () => page.openTab(tab));
    byId("tabs").append(button);
  }
}

function buildKeys(): void {
  const rows = KEYS.map(([key, says]) => make("div", { class: "key" }, make("kbd", {}, key), make("span", {}, says)));
  const shapes = ["hit", "dead", "point", "sight", "round", "refused"].map(markName).join(", ");
  const close = make("button", { type: "button" }, "Close");
  const dialog = byId<HTMLDialogElement>("keys");
  close.addEventListener("click", () => dialog.close());
  dialog.replaceChildren(
    make("h2", {}, "Keys"),
    make("div", { class: "columns" }, ...rows),
    make("p", { class: "small soft" }, `Squares are red, discs are blue; T tank, C chariot, S soldier, A aerocraft. A dashed rim hides, a triangle is suppressed, a pale token is where a side believes an enemy to be, with the ticks since it saw it. Marks of the timeline: ${shapes}. Fog lies where a vehicle that does not hide would not be seen.`),
    close,
  );
}
