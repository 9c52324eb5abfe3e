// The panel of orders: own pieces, the state of the one that is picked, and what it can do, with chances or with the reason why not.

import { badge, facts, make } from "../dom";
import { cellName } from "../hex";
import { spoken } from "../log";
import { pieceCard } from "../piecespanel";
import type { Piece } from "../state";
import { MORTAR_CLASSES, startOf } from "./aim";
import { CLASS_NAMES, classes, endOf, percent, readOrder, sayChances, sayOrder, sayPoints } from "./orders";
import { MORTAR_COLOURS } from "./plandraw";
import type { Place, Play } from "./play";
import type { LookDoc, ShotDoc } from "./protocol";
import { rebuilt } from "./rebuilt";

const LETTERS: Record<string, string> = { hide: "h", occupy: "o", stop: "s" };

export function ordersPanel(panel: HTMLElement, play: Play): void {
  const { session, picked } = play;
  const look = picked && play.canOrder ? play.lookHere() : undefined;
  const idle = play.own().map((piece) => session.isIdle(piece.short));
  const key = JSON.stringify(["orders", picked?.index, session.tick, play.place, play.mortar, idle, look, picked && [session.state.tray[picked.short], session.state.plans[picked.short]], play.looking, session.role, session.over !== null]);
  rebuilt(panel, key, () => [pickRow(play), ...body(play, look)]);
}

/** A button for each own piece: its key, its letter, and a mark where nobody has told it what to do. */
function pickRow(play: Play): HTMLElement {
  const row = make("div", { class: "pick-row", role: "group", "aria-label": "Own pieces" });
  for (const [k, piece] of play.own().entries()) {
    const shown = play.session.game.shown(piece, play.session.tick);
    const idle = play.session.isIdle(piece.short);
    const says = shown.blood === 0 ? "destroyed" : idle ? "idle" : play.session.game.doing(piece, play.session.tick);
    const traits = { type: "button", id: `pick-${piece.short}`, title: `${piece.short} (${k + 1}), ${says}`, "aria-pressed": String(piece.index === play.picked?.index) };
    const button = make("button", traits, badge(piece.camp, piece.letter), make("span", { class: "short" }, piece.short), make("span", { class: "unseen" }, `, ${says}`), idle ? make("span", { class: "idle", "aria-hidden": "true" }) : null);
    if (shown.blood === 0) button.className = "gone";
    button.addEventListener("click", () => play.pick(piece));
    row.append(button);
  }
  return row;
}

function body(play: Play, look: LookDoc | undefined): HTMLElement[] {
  const { picked, session } = play;
  if (!picked) return [make("p", { class: "soft" }, "Pick a piece of yours: click it, or press its number. Then click a cell to send it there, or an enemy to fire at it.")];
  if (picked.camp !== session.camp) return [pieceCard(play.scene(), play.scene().game.pieces[picked.index])];
  const state = stateOf(play);
  if (!play.canOrder) return [state, make("p", { class: "soft" }, play.looking ? "This is what was. Orders are given now." : session.over ? "The game is over." : session.role === "commands" ? "It takes no orders any more." : "Another tab commands.")];
  return [state, ...where(play), ...(look ? acts(play, look) : [make("p", { class: "soft" }, "…")])];
}

function stateOf(play: Play): HTMLElement {
  const { picked, session } = play;
  const piece = picked ? session.game.pieces[picked.index] : null;
  if (!piece) return make("p");
  const shown = session.game.shown(piece, session.tick);
  const kind = session.story.rules.kinds[piece.kind];
  const sees = session.game.seenFrom(piece, session.game.at(session.tick)).map((one) => spoken(one.piece.name)).join(", ");
  const aboard = shown.carrier >= 0 ? `aboard ${session.game.pieces[shown.carrier].short}, ` : "";
  const goal = goalText(play, piece);
  const rows: [string, string][] = [
    ["where", `${aboard}${cellName(session.map, shown.cell)}${goal ? `, will be in ${goal}` : ""}`],
    ["does", [session.game.doing(piece, session.tick), shown.hidden ? "hidden" : "", shown.suppressed ? "suppressed" : ""].filter(Boolean).join(", ")],
    ["blood", `${shown.blood} of ${kind.blood}`],
    ["sees", sees || "no enemy"],
  ];
  const all = make("button", { type: "button", id: "all-of-it", class: "quiet" }, "all of it");
  all.addEventListener("click", () => play.openTab("pieces"));
  return make("section", { class: "state" }, make("h2", {}, badge(piece.camp, piece.letter), spoken(piece.name), all), facts(rows));
}

/** The cell in which it will stand; nothing where it stays. */
function goalText(play: Play, piece: Piece): string {
  const { map, game, tick, state } = play.session;
  const here = game.shown(piece, tick).cell;
  const end = endOf(map, here, state.tray[piece.short], state.plans[piece.short] ?? []);
  return end === here ? "" : cellName(map, end);
}

/** Now, or in the cell in which the plan ends. */
function where(play: Play): HTMLElement[] {
  const { picked, session } = play;
  if (!picked || !play.hasPlan(picked.short)) return [];
  const choice = (place: Place, text: string) => {
    const button = make("button", { type: "button", id: `place-${place}`, "aria-pressed": String(play.place === place) }, text);
    button.addEventListener("click", () => {
      play.place = place;
      play.ask();
    });
    return button;
  };
  return [make("div", { class: "places", role: "group", "aria-label": "When" }, choice("now", "Now, instead of it"), choice("then", `Then, in ${cellName(session.map, startOf(play, true))}`))];
}

function acts(play: Play, look: LookDoc): HTMLElement[] {
  const found = make("ul", { class: "acts", "aria-label": "What it can do" });
  const then = look.planned;
  for (const shot of [...look.shots].sort((a, b) => b.points - a.points)) found.append(shotRow(play, shot, then));
  if (look.mortar.length) found.append(mortarRow(play));
  for (const text of look.orders) {
    const { verb } = readOrder(text);
    if (verb !== "move" && verb !== "null") found.append(orderRow(play, text, then));
  }
  found.append(...meetings(play, then));
  const legend = play.mortar && look.mortar.length ? [mortarLegend()] : [];
  return [found, ...legend, make("p", { class: "small soft" }, matchMedia("(pointer: coarse)").matches ? "Tap a cell to send it there." : "A click on the map sends it there; with shift after what is planned."), ...impossible(look)];
}

function button(play: Play, text: string, then: boolean, ...children: (Node | string)[]): HTMLElement {
  const found = make("button", { type: "button", id: `act-${text.replace(/[^a-z0-9]+/gi, "-")}` }, ...children);
  found.addEventListener("click", () => void play.plan([text], then));
  return make("li", {}, found);
}

const RIDES: Record<string, string> = { soldier: "chariot", chariot: "soldier" };

/** Ways to those it could carry, or ride in: a click on a piece of one's own picks it. */
function meetings(play: Play, then: boolean): HTMLElement[] {
  const { picked, session } = play;
  const pieces = session.game.at(session.tick).pieces;
  const here = startOf(play, then);
  if (!picked || pieces[picked.index].carrier >= 0) return [];
  const others = pieces.filter((one) => one.piece.camp === picked.camp && one.piece.kind === RIDES[picked.kind] && one.blood > 0 && one.carrier < 0 && one.cell !== here);
  return others.map((one) => {
    const cell = cellName(session.map, one.cell);
    return button(play, `${picked.short} go ${cell}`, then, `Go to ${one.piece.short}, in ${cell}`);
  });
}

function orderRow(play: Play, text: string, then: boolean): HTMLElement {
  const key = then ? undefined : LETTERS[readOrder(text).verb];
  return button(play, text, then, sayOrder(text), ...(key ? [make("kbd", {}, key)] : []));
}

function shotRow(play: Play, shot: ShotDoc, then: boolean): HTMLElement {
  const ago = shot.ago ? `, last seen ${shot.ago} ticks ago` : "";
  const points = make("b", { class: "points" }, sayPoints(shot.points));
  return button(play, shot.order, then, make("span", { class: "row" }, make("span", {}, sayOrder(shot.order)), points), odds(shot.chances), make("small", {}, `level ${shot.level}${ago}: ${sayChances(shot.chances)}`));
}

/** Chances as a bar; the text below it says the same. */
function odds(chances: number[]): HTMLElement {
  const bar = make("span", { class: "odds", "aria-hidden": "true" });
  for (const [k, chance] of classes(chances).entries()) {
    if (chance < 0.005) continue;
    const part = make("i", { class: `k${k}`, title: `${CLASS_NAMES[k]} ${percent(chance)}` }, chance >= 0.12 ? `${Math.round(chance * 100)}` : "");
    part.style.flexGrow = String(chance);
    part.style.flexBasis = "0";
    bar.append(part);
  }
  return bar;
}

function mortarRow(play: Play): HTMLElement {
  const found = make("button", { type: "button", id: "act-mortar", "aria-pressed": String(play.mortar) }, "Mortar", make("kbd", {}, "m"), make("small", {}, play.mortar ? "now click the cell in which the round is to land" : "shows the cells that it reaches"));
  found.addEventListener("click", () => play.toggle("mortar"));
  return make("li", {}, found);
}

function mortarLegend(): HTMLElement {
  const rows = MORTAR_CLASSES.map((text, k) => {
    const swatch = make("i", { class: "sw" });
    swatch.style.background = MORTAR_COLOURS[k];
    return make("li", {}, swatch, text);
  });
  return make("ul", { class: "key-list small" }, ...rows.reverse());
}

/** What its kind can do, but it cannot now: the engine's own sentences. */
function impossible(look: LookDoc): HTMLElement[] {
  if (look.impossible.length === 0) return [];
  const rows = look.impossible.map(([order, why]) => make("p", { class: "why" }, make("b", {}, sayOrder(order)), ` ${why}`));
  return [make("h3", {}, look.planned ? "Not there" : "Not now"), ...rows];
}
