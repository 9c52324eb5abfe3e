// Mouse, fingers and keys.

import { DECISION } from "./clock";
import { SPEEDS, readCommand, readMoment } from "./commands";
import { byId, say } from "./dom";
import { type Point, centre } from "./hex";
import { spoken } from "./log";
import type { Page } from "./page";
import { cellText } from "./piecespanel";
import { listenPointer } from "./pointer";
import { openSaving } from "./save";
import { listenTimeline } from "./scrub";

export function listen(page: Page): void {
  const clicks: Record<string, () => void> = {
    play: () => page.play(!page.playing), previous: () => page.step(-1), next: () => page.step(1), decision: () => page.decide(),
    speed: () => page.setSpeed(SPEEDS[(SPEEDS.indexOf(page.speed) + 1) % SPEEDS.length]), share: () => void page.share(), save: () => openSaving(page),
    theme: () => page.setDark(!page.dark), "cover-theme": () => page.setDark(!page.dark), all: () => page.leave(), earlier: () => page.turn(-1), later: () => page.turn(1), help: () => byId<HTMLDialogElement>("keys").showModal(),
    closer: () => page.zoom(1.5), farther: () => page.zoom(1 / 1.5), whole: () => page.whole(),
    fold: () => page.unfold(false),
  };
  for (const [id, act] of Object.entries(clicks)) byId(id).addEventListener("click", act);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => page.setDark(event.matches));
  document.addEventListener("visibilitychange", () => document.hidden && page.playing && page.play(false));
  window.addEventListener("hashchange", () => void page.moveTo(readMoment(location.hash)));
  window.addEventListener("keydown", (event) => key(page, event));
  byId("command").addEventListener("blur", () => (byId("line").hidden = true));
  listenMap(page, 0);
  listenMap(page, 1);
  listenTimeline(page);
}

function listenMap(page: Page, k: number): void {
  const stage = () => page.stages[k];
  listenPointer(byId<HTMLCanvasElement>(k > 0 ? `terrain-${k + 1}` : "terrain"), {
    stage,
    ask: () => page.ask(),
    grabbed: () => page.focus(k),
    panned: () => (page.follow = false),
    hovered: (here) => hovered(page, here, k),
    left: () => {
      page.hover = -1;
      say(byId("readout"), "");
      page.ask();
    },
    clicked: (here) => {
      const token = stage().tokenAt(here);
      page.pick(token?.shown.piece ?? null, token ? -1 : stage().cellAt(here, page.tapes[k].game));
    },
  });
}

function hovered(page: Page, here: Point, k: number): void {
  const cell = page.stages[k].cellAt(here, page.tapes[k].game);
  if (cell === page.hover) return;
  page.hover = cell;
  const text = cell < 0 ? "" : cellText(page.map, cell);
  const token = page.stages[k].tokenAt(here);
  say(byId("readout"), token ? `${spoken(token.shown.piece.name)}  ${text}` : text);
  if (page.picked || page.cell >= 0) page.ask();
}

function key(page: Page, event: KeyboardEvent): void {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.target instanceof HTMLInputElement) {
    if (event.key === "Enter") command(page);
    else if (event.key === "Escape") byId("line").hidden = true;
    return;
  }
  if (page.covered || document.querySelector("dialog[open]")) return;
  const acts: Record<string, () => void> = {
    " ": () => page.play(!page.playing), n: () => page.step(1), p: () => page.step(-1), d: () => page.decide(),
    ArrowRight: () => page.seek(page.time + (event.shiftKey ? DECISION : 1)), ArrowLeft: () => page.seek(page.time - (event.shiftKey ? DECISION : 1)),
    Home: () => page.seek(0), End: () => page.seek(page.last), "[": () => page.faster(-1), "]": () => page.faster(1),
    l: () => page.toggle("los"), r: () => page.toggle("ranges"), b: () => page.toggle("beliefs"), g: () => page.toggle("fog"),
    f: () => page.toggle("follow"), q: () => page.openTab("policy"), m: () => (page.muted = !page.muted), c: () => void page.share(), s: () => openSaving(page),
    x: () => (page.timeline.loop = null), "+": () => page.zoom(1.5), "=": () => page.zoom(1.5), "-": () => page.zoom(1 / 1.5), "0": () => page.whole(), z: () => page.toPieces(),
    a: () => page.leave(), "<": () => page.turn(-1), ">": () => page.turn(1), w: () => page.focus(1 - page.active),
    "/": () => type(), "?": () => byId<HTMLDialogElement>("keys").showModal(), Escape: () => page.pick(null),
  };
  page.views.forEach((view, k) => (acts[String(k + 1)] = () => void page.show(view)));
  const act = acts[event.key];
  if (!act || (event.key === " " && event.target instanceof HTMLButtonElement)) return;
  event.preventDefault();
  act();
  page.ask();
}

function type(): void {
  byId("line").hidden = false;
  const input = byId<HTMLInputElement>("command");
  input.value = "";
  input.focus();
}

function command(page: Page): void {
  const text = byId<HTMLInputElement>("command").value;
  const camp = page.game.view === "blue" ? "blue" : "red";
  const command = readCommand(text, page.game, page.map, camp);
  byId("line").hidden = true;
  byId("terrain").focus();
  if (command.kind === "seek") page.seek(command.tick);
  else if (command.kind === "pick") page.pick(command.piece);
  else if (command.kind === "cell") {
    page.pick(null, command.cell);
    page.stage.camera.show([centre(page.map, command.cell)], 12);
  } else if (command.kind === "view") void page.show(command.view);
  else if (command.kind === "speed") page.setSpeed(command.speed);
  else if (command.kind === "help") byId<HTMLDialogElement>("keys").showModal();
  else page.flash(`not understood: ${command.text.slice(0, 40)}`);
}
