// What stands on the page before anything is drawn: names, buttons, tabs, the list of keys.

import { KEYS } from "./commands";
import { badge, byId, make } from "./dom";
import type { Page } from "./page";
import type { Tab } from "./scene";
import type { Camp, View } from "./story";
import { markName } from "./timeline";

export function build(page: Page, views: View[]): void {
  buildHeader(page, views);
  buildLayers(page);
  buildTabs(page);
  buildKeys();
}

function buildHeader(page: Page, views: View[]): void {
  const { story } = page.game;
  const side = (camp: Camp) => {
    const { name, kind } = story.players[camp];
    const who = make("span", { class: "who" }, make("bdi", { class: "name", title: name }, name), make("span", { class: "kind" }, `${camp}${kind ? `, ${kind}` : ""}`));
    const margin = make("span", { class: "margin", id: `margin-${camp}` });
    return make("div", { class: `side ${camp}` }, badge(camp, camp[0].toUpperCase()), who, margin);
  };
  const what = make("span", { class: "what", id: "what", title: story.seed ? `seed ${story.seed}` : "" });
  byId("score").replaceChildren(side("red"), make("span", { class: "versus" }, "against"), side("blue"), what);
  for (const [k, view] of views.entries()) {
    const button = make("button", { type: "button", id: `view-${view}`, title: `${k + 1}` }, view[0].toUpperCase() + view.slice(1));
    button.addEventListener("click", () => void page.show(view));
    byId("views").append(button);
  }
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
