// Mouse, fingers and keys.

import { SPEEDS, readCommand, readMoment } from "./commands";
import { byId, say } from "./dom";
import { cellName, centre } from "./hex";
import { spoken } from "./log";
import { DECISION, type Page } from "./page";
import { ground } from "./piecespanel";
import { openSaving } from "./save";

export function listen(page: Page): void {
  const clicks: Record<string, () => void> = {
    play: () => page.play(!page.playing), previous: () => page.step(-1), next: () => page.step(1), decision: () => page.decide(),
    speed: () => page.setSpeed(SPEEDS[(SPEEDS.indexOf(page.speed) + 1) % SPEEDS.length]), share: () => void page.share(), save: () => openSaving(page),
    theme: () => page.setDark(!page.dark), "cover-theme": () => page.setDark(!page.dark), all: () => page.leave(), earlier: () => page.turn(-1), later: () => page.turn(1), help: () => byId<HTMLDialogElement>("keys").showModal(),
    closer: () => page.zoom(1.5), farther: () => page.zoom(1 / 1.5), whole: () => page.whole(),
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
  const canvas = byId<HTMLCanvasElement>(k > 0 ? `terrain-${k + 1}` : "terrain");
  const stage = () => page.stages[k];
  const game = () => page.tapes[k].game;
  const fingers = new Map<number, { x: number; y: number }>();
  let moved = 0;
  const place = (event: PointerEvent | WheelEvent) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    stage().camera.zoom(Math.exp(-event.deltaY * 0.0016), place(event));
    page.ask();
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, place(event));
    moved = 0;
    page.focus(k);
  });
  canvas.addEventListener("pointermove", (event) => {
    const here = place(event);
    const last = fingers.get(event.pointerId);
    if (!last) return hovered(page, here, k);
    const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    moved += Math.hypot(here.x - last.x, here.y - last.y);
    if (others.length === 1) {
      const [a] = others;
      stage().camera.zoom(Math.hypot(here.x - a.x, here.y - a.y) / Math.max(1, Math.hypot(last.x - a.x, last.y - a.y)), a);
    } else if (moved > 4) {
      page.follow = false;
      stage().camera.pan(here.x - last.x, here.y - last.y);
    }
    fingers.set(event.pointerId, here);
    page.ask();
  });
  const lift = (event: PointerEvent) => {
    const here = place(event);
    if (fingers.delete(event.pointerId) && moved <= 4 && event.type === "pointerup") {
      const token = stage().tokenAt(here);
      const cell = stage().cellAt(here, game());
      page.pick(token?.shown.piece ?? null, token ? -1 : cell);
    }
  };
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("pointerleave", () => {
    page.hover = -1;
    say(byId("readout"), "");
    page.ask();
  });
}

function hovered(page: Page, here: { x: number; y: number }, k: number): void {
  const cell = page.stages[k].cellAt(here, page.tapes[k].game);
  if (cell === page.hover) return;
  page.hover = cell;
  const { map } = page;
  const text = cell < 0 ? "" : `${cellName(map, cell)}  ${map.level[cell] * map.gradeM} m  ${ground(map.bits[cell])}`;
  const token = page.stages[k].tokenAt(here);
  say(byId("readout"), token ? `${spoken(token.shown.piece.name)}  ${text}` : text);
  if (page.picked || page.cell >= 0) page.ask();
}

function listenTimeline(page: Page): void {
  const canvas = page.timeline.canvas;
  const tip = byId("tip");
  let start = -1;
  const at = (event: PointerEvent) => page.timeline.tickAt(event.clientX - canvas.getBoundingClientRect().left);
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    start = at(event);
    if (!event.shiftKey) page.seek(page.timeline.near(start) && event.pointerType === "mouse" ? snapped(page, start, event) : start);
  });
  canvas.addEventListener("pointermove", (event) => {
    const tick = at(event);
    page.timeline.hover = tick;
    if (start >= 0 && event.shiftKey) page.timeline.loop = [Math.min(start, tick), Math.max(start, tick) + 1];
    else if (start >= 0) page.seek(tick);
    const near = page.timeline.near(tick);
    tip.hidden = false;
    say(tip, near ? `${near.tick}: ${near.text}` : `tick ${tick}`);
    const box = canvas.getBoundingClientRect();
    tip.style.left = `${Math.max(6, Math.min(window.innerWidth - tip.offsetWidth - 8, event.clientX + 10))}px`;
    tip.style.top = `${box.top - tip.offsetHeight - 6}px`;
    page.ask();
  });
  canvas.addEventListener("pointerup", () => (start = -1));
  canvas.addEventListener("pointerleave", () => {
    page.timeline.hover = -1;
    tip.hidden = true;
    page.ask();
  });
}

/** A click on a mark goes to its tick. */
function snapped(page: Page, tick: number, event: PointerEvent): number {
  const low = event.offsetY > page.timeline.canvas.clientHeight - 46;
  return low ? (page.timeline.near(tick)?.tick ?? tick) : tick;
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
    x: () => (page.timeline.loop = null), "+": () => page.zoom(1.5), "=": () => page.zoom(1.5), "-": () => page.zoom(1 / 1.5), "0": () => page.whole(),
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
