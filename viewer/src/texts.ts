// What the page says in words: score, clock, panel, captions, and what a screen reader is told.

import { byId, press, say } from "./dom";
import { type Entry, signed } from "./log";
import { logPanel } from "./logpanel";
import type { Page } from "./page";
import { piecesPanel } from "./piecespanel";
import { policyPanel } from "./policypanel";
import type { Scene } from "./scene";
import { CAMPS } from "./story";
import type { Tape } from "./tape";

const PANEL_MS = 120; // between two pictures of the panel while it plays: a pace that can be read

export function drawTexts(page: Page, scene: Scene, now: number): void {
  const { tick } = scene.state;
  drawScore(page, scene);
  const minutes = `${Math.floor(tick / 60)}:${String(tick % 60).padStart(2, "0")}`;
  say(byId("tick"), String(tick));
  say(byId("of"), ` of ${page.game.story.game_ticks}  (${minutes})`);
  say(byId("speed"), `${page.speed}×`);
  drawLast(lastOf(scene.entries, tick));
  const slider = byId("timeline");
  slider.setAttribute("aria-valuemax", String(page.last));
  slider.setAttribute("aria-valuenow", String(tick));
  slider.setAttribute("aria-valuetext", `tick ${tick}, ${marginText(page, scene)}`);
  if (page.playing && now - page.panelled < PANEL_MS) return;
  page.panelled = now;
  drawPanel(page, scene);
}

/** The last thing that happened: a shot, a loss, a capture, a first sight. */
export function lastOf(entries: Entry[], tick: number): Entry | null {
  let [low, high] = [0, entries.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (entries[middle].tick <= tick) low = middle + 1;
    else high = middle;
  }
  for (let k = low - 1; k >= 0; k--) if (entries[k].group === "fire" || entries[k].group === "sight") return entries[k];
  return null;
}

function drawLast(entry: Entry | null): void {
  const place = byId("last");
  say(place, entry ? `${entry.tick}: ${entry.brief ?? entry.text}` : "");
  const name = entry ? `t-${entry.camp}` : "";
  if (place.className !== name) place.className = name;
}

function drawPanel(page: Page, scene: Scene): void {
  const panel = byId("panel");
  if (page.tab === "pieces") piecesPanel(panel, scene);
  else if (page.tab === "log") logPanel(panel, scene, true);
  else policyPanel(panel, scene);
  for (const button of byId("tabs").children) button.setAttribute("aria-selected", String(button.id === `tab-${page.tab}`));
  for (const button of byId("views").children) press(button as HTMLElement, button.id === `view-${page.game.view}`);
  for (const name of ["los", "ranges", "beliefs", "fog"] as const) press(byId(`on-${name}`), page.on[name]);
  press(byId("on-follow"), page.follow);
  byId("on-fog").hidden = page.game.view === "referee";
  byId("on-beliefs").hidden = page.game.view !== "referee";
}

function drawScore(page: Page, scene: Scene): void {
  if (page.tapes.length > 1) return drawCaptions(page);
  const { margin } = scene.state;
  for (const camp of CAMPS) say(byId(`margin-${camp}`), margin[camp] === undefined ? "" : signed(margin[camp] ?? 0));
  const ahead = leadOf(margin);
  for (const camp of CAMPS) {
    byId(`lead-${camp}`).hidden = ahead?.camp !== camp;
    if (ahead?.camp === camp) say(byId(`by-${camp}`), ` by ${ahead.points}`);
  }
  say(byId("what"), aboutText(page.tape, scene.state.tick));
}

/** Who is ahead, and by how much, where both margins are known. */
export function leadOf({ red, blue }: Scene["state"]["margin"]): { camp: "red" | "blue"; points: number } | null {
  if (red === undefined || blue === undefined || red === blue) return null;
  return { camp: red > blue ? "red" : "blue", points: Math.abs(red - blue) };
}

function drawCaptions(page: Page): void {
  for (const [k, tape] of page.tapes.entries()) {
    const { margin } = page.scene(k).state;
    for (const camp of CAMPS) say(byId(`margin-${camp}-${k}`), margin[camp] === undefined ? "" : signed(margin[camp] ?? 0));
    byId(`about-${k}`).classList.toggle("active", k === page.active);
    press(byId(`pick-${k}`), k === page.active);
    say(byId(`result-${k}`), resultText(tape, Math.floor(page.time)));
  }
}

function resultText(tape: Tape, tick: number): string {
  const { story, last } = tape.game;
  const winner = story.end?.winner;
  return !winner || tick < last ? "" : winner === "draw" ? "a draw" : `${winner} wins`;
}

function aboutText(tape: Tape, tick: number): string {
  const { view, story } = tape.game;
  const name = tape.name ? `${tape.name}, ` : "";
  if (view !== "referee") return `${name}${story.scenario}, margin as ${view} knows it`;
  return [`${name}${story.scenario}, seed …\u2060${story.seed?.slice(-6)}`, resultText(tape, tick)].filter(Boolean).join(", ");
}

function marginText(page: Page, scene: Scene): string {
  const known = page.game.view === "referee" ? "margin" : "margin as known";
  const margins = CAMPS.filter((camp) => scene.state.margin[camp] !== undefined);
  return `${known} ${margins.map((camp) => `${camp} ${signed(scene.state.margin[camp] ?? 0)}`).join(", ")}`;
}

/** Tell who does not see the map where the game stands. */
export function announce(page: Page, before = ""): void {
  const scene = page.scene();
  const { tick, pieces } = scene.state;
  const happened = page.list().filter((one) => one.tick === tick && one.group !== "orders").map((one) => one.text);
  say(byId("live"), [before, `Tick ${tick}`, marginText(page, scene), ...happened.slice(0, 3)].filter(Boolean).join(". "));
  const alive = CAMPS.map((camp) => `${pieces.filter((one) => one.piece.camp === camp && one.blood > 0).length} ${camp}`);
  byId("terrain").setAttribute("aria-label", `Map ${page.map.name}, tick ${tick}: pieces ${alive.join(", ")}; ${marginText(page, scene)}`);
}
