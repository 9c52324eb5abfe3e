// Mouse, fingers and keys of a game that is played.

import { SPEEDS } from "../commands";
import { byId, say } from "../dom";
import { type Point, centre } from "../hex";
import { spoken } from "../log";
import { cellText } from "../piecespanel";
import { listenPointer } from "../pointer";
import { listenTimeline } from "../scrub";
import { sayCell } from "./aim";
import { readTyped } from "./command";
import { isStep, stepped } from "./cursor";
import { showStops } from "./desk";
import { stepOf } from "./orders";
import type { Play, Tab } from "./play";

const SETTLES_MS = 300; // until a cursor that has come to rest is told about

export function listen(play: Play): void {
  const clicks: Record<string, () => void> = {
    play: () => play.toggleClock(), one: () => play.step("tick"), event: () => play.step("event"), decision: () => play.step("decision"),
    speed: () => play.setSpeed(SPEEDS[(SPEEDS.indexOf(play.speed) + 1) % SPEEDS.length]), theme: () => play.setDark(!play.dark), help: () => byId<HTMLDialogElement>("keys").showModal(),
    stops: () => showStops(play), closer: () => play.zoom(1.5), farther: () => play.zoom(1 / 1.5), whole: () => play.whole(),
    back: () => play.look(play.session.tick), "show-stop": () => play.showStop(),
  };
  for (const [id, act] of Object.entries(clicks)) byId(id).addEventListener("click", act);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => play.setDark(event.matches));
  document.addEventListener("visibilitychange", () => document.hidden && play.session?.state.clock.running && play.session.commands && play.pause());
  window.addEventListener("keydown", (event) => key(play, event));
  byId("command").addEventListener("blur", () => (byId("line").hidden = true));
  listenMap(play);
  listenTimeline(play);
}

function listenMap(play: Play): void {
  listenPointer(byId<HTMLCanvasElement>("terrain"), {
    stage: () => play.stage,
    ask: () => play.ask(),
    panned: () => (play.follow = false),
    hovered: (here) => hovered(play, here),
    left: () => {
      play.hover = -1;
      say(byId("readout"), "");
      play.ask();
    },
    clicked: (here, event) => clicked(play, here, event),
  });
  byId("terrain").addEventListener("pointermove", (event) => {
    if (play.shift === event.shiftKey) return;
    play.shift = event.shiftKey;
    play.ask();
  });
}

/** The cell that is meant: that of a token, or the one under the pointer. */
function cellUnder(play: Play, here: Point): number {
  const token = play.stage.tokenAt(here);
  return token && token.shown.piece.camp !== play.session.camp && !token.ghost ? token.shown.cell : play.stage.cellAt(here, play.session.game);
}

function hovered(play: Play, here: Point): void {
  const cell = cellUnder(play, here);
  if (cell === play.hover) return;
  play.hover = cell;
  const token = play.stage.tokenAt(here);
  const text = cell < 0 ? "" : cellText(play.session.map, cell);
  say(byId("readout"), token ? `${spoken(token.shown.piece.name)}  ${text}` : text);
  play.ask();
}

function clicked(play: Play, here: Point, event: PointerEvent): void {
  const token = play.stage.tokenAt(here);
  const cell = cellUnder(play, here);
  const then = event.shiftKey || play.place === "then";
  if (play.mortar && cell >= 0 && play.canOrder && play.mortarGroup(cell)) return meant(play, cell, then, event);
  if (token && token.shown.piece.camp === play.session.camp && !(event.shiftKey && play.canOrder)) return play.pick(token.shown.piece);
  if (token && !play.canOrder) return play.pick(token.shown.piece);
  if (cell >= 0 && play.canOrder) meant(play, cell, then, event);
}

/** A mouse has seen what would come of it; a finger sees it first, and means it when it taps again. */
function meant(play: Play, cell: number, then: boolean, event: PointerEvent): void {
  if (event.pointerType === "mouse" || play.cursor === cell) void play.planAt(cell, then);
  else play.setCursor(cell);
}

// --- keys -----------------------------------------------------------------------------------------

function key(play: Play, event: KeyboardEvent): void {
  if (event.ctrlKey || event.altKey || event.metaKey || !play.session) return;
  if (event.target instanceof HTMLInputElement) return typing(play, event);
  if (document.querySelector("dialog[open]") || (event.repeat && !isStep(event.key))) return;
  const { target } = event;
  const inPanel = target instanceof Node && byId("panel").contains(target);
  const pressed = target instanceof HTMLButtonElement || target instanceof HTMLAnchorElement || (target instanceof HTMLElement && target.tagName === "SUMMARY");
  if (pressed && (event.key === " " || event.key === "Enter")) return;
  const act = inPanel && isStep(event.key) ? () => walkPanel(event.key) : target === byId("timeline") && isStep(event.key) ? () => play.look(Math.round(play.time) + (event.key === "ArrowRight" || event.key === "ArrowUp" ? 1 : -1)) : actOf(play, event);
  if (!act) return;
  event.preventDefault();
  act();
  play.ask();
}

export function actOf(play: Play, event: KeyboardEvent): (() => void) | undefined {
  if (isStep(event.key)) return () => moveCursor(play, event);
  if (/^[1-9]$/.test(event.key)) return () => pickOwn(play, Number(event.key) - 1);
  const order = (verb: string) => () => play.picked?.own && void play.plan([`${play.picked.short} ${verb}`], play.place === "then");
  const tab = (name: Tab) => () => play.openTab(name);
  const acts: Record<string, () => void> = {
    Enter: () => enter(play, event.shiftKey), Backspace: () => play.undo(), " ": () => play.toggleClock(), ".": () => play.step("tick"), n: () => play.step("event"), d: () => play.step("decision"),
    "[": () => play.faster(-1), "]": () => play.faster(1), h: order("hide"), o: order("occupy"), s: order("stop"), m: () => play.toggle("mortar"),
    l: () => play.toggle("los"), r: () => play.toggle("ranges"), g: () => play.toggle("fog"), f: () => play.toggle("follow"),
    e: tab("orders"), i: tab("pieces"), t: tab("log"), q: tab("hints"), a: () => openActs(play), p: () => showStops(play), c: () => play.showStop(),
    Home: () => play.look(0), End: () => play.look(play.session.tick), "+": () => play.zoom(1.5), "=": () => play.zoom(1.5), "-": () => play.zoom(1 / 1.5), "0": () => play.whole(),
    "/": () => openLine(), "?": () => byId<HTMLDialogElement>("keys").showModal(), Escape: () => letGo(play),
  };
  return acts[event.key];
}

/** At the cursor it plans; without one it gives the orders and runs. */
function enter(play: Play, then: boolean): void {
  if (play.cursor >= 0 && play.canOrder) void play.planAt(play.cursor, then || play.place === "then");
  else if (!play.session.state.clock.running) play.run();
}

function letGo(play: Play): void {
  if (byId("panel").contains(document.activeElement)) byId("terrain").focus({ preventScroll: true });
  else if (play.cursor >= 0) play.cursor = -1;
  else play.pick(null);
}

function pickOwn(play: Play, k: number): void {
  const piece = play.own()[k];
  if (!piece) return;
  play.cursor = -1;
  play.pick(piece);
  const shown = play.session.game.shown(piece, play.session.tick);
  const { camera } = play.stage;
  const at = camera.toScreen(shown.at);
  if (at.x < 0 || at.y < 0 || at.x > camera.width || at.y > camera.height) camera.show([shown.at], 12);
  say(byId("live"), `${piece.short}, ${play.session.game.doing(piece, play.session.tick)}, ${sayCell(play, shown.cell)}`);
}

let telling = 0;

function moveCursor(play: Play, event: KeyboardEvent): void {
  const shown = play.picked ? play.session.game.shown(play.picked, play.session.tick) : null;
  const start = play.cursor >= 0 ? play.cursor : shown && shown.cell >= 0 ? shown.cell : play.stage.cellAt({ x: play.stage.camera.width / 2, y: play.stage.camera.height / 2 }, play.session.game);
  if (start < 0) return;
  byId("terrain").focus({ preventScroll: true }); // from here on Enter means the cell
  play.setCursor(stepped(play.session.map, start, event.key, event.shiftKey));
  window.clearTimeout(telling);
  telling = window.setTimeout(() => say(byId("live"), [sayCell(play, play.cursor), ...(play.aimAt(play.cursor, play.then)?.lines ?? [])].join(". ")), SETTLES_MS);
}

/** The list of what the piece can do, for the keys. */
function openActs(play: Play): void {
  play.openTab("orders");
  requestAnimationFrame(() => requestAnimationFrame(() => (byId("panel").querySelector<HTMLElement>(".acts button") ?? byId("panel").querySelector<HTMLElement>("button"))?.focus()));
}

/** Up and down in the panel: from button to button. */
function walkPanel(key: string): void {
  const buttons = [...byId("panel").querySelectorAll<HTMLElement>("button:not(:disabled), summary")];
  const here = buttons.indexOf(document.activeElement as HTMLElement);
  const by = key === "ArrowDown" || key === "ArrowRight" ? 1 : -1;
  buttons[Math.max(0, Math.min(buttons.length - 1, here + by))]?.focus();
}

// --- the line -------------------------------------------------------------------------------------

function openLine(): void {
  byId("line").hidden = false;
  const input = byId<HTMLInputElement>("command");
  input.value = "";
  input.focus();
}

function typing(play: Play, event: KeyboardEvent): void {
  if (event.target !== byId("command")) return;
  if (event.key === "Escape") byId("line").hidden = true;
  if (event.key !== "Enter") return;
  const text = byId<HTMLInputElement>("command").value;
  byId("line").hidden = true;
  byId("terrain").focus();
  typed(play, text);
  play.ask();
}

function typed(play: Play, text: string): void {
  const found = readTyped(text, play.session.game, play.session.map, play.session.camp);
  if (found.kind === "order") void play.plan([stepOf(found.text)], found.then);
  else if (found.kind === "pick") play.pick(found.piece);
  else if (found.kind === "cell") {
    play.setCursor(found.cell);
    play.stage.camera.show([centre(play.session.map, found.cell)], 12);
    say(byId("live"), sayCell(play, found.cell));
  } else if (found.kind === "go") play.run();
  else if (found.kind === "pause") play.pause();
  else if (found.kind === "step") play.step("tick");
  else if (found.kind === "next") play.step("event");
  else if (found.kind === "decision") play.step("decision");
  else if (found.kind === "undo") play.undo();
  else if (found.kind === "hint") void play.hint();
  else if (found.kind === "speed") play.setSpeed(found.speed);
  else if (found.kind === "help") byId<HTMLDialogElement>("keys").showModal();
  else play.tell(`not understood: ${found.text.slice(0, 40)}`);
}
