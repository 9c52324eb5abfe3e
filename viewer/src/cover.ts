// The cover of a page of many games: a learning curve, heat maps, a lineage, and a strip of how the games ended.

import { type CellDoc, type ContentsDoc, type EntryDoc, type TableDoc, resultOf, whyApart } from "./contents";
import { byId, make, press, say } from "./dom";
import { signed } from "./log";
import type { Page } from "./page";
import { paletteOf } from "./palette";
import { other } from "./state";
import { CAMPS, type Camp, loadSetup } from "./story";
import { MARGIN, WIN_RATE, curveChart, lineageChart } from "./svg";
import { Thumbs } from "./thumb";

const CHART_HEIGHT = { wide: 230, narrow: 172 };
const [HEAT_NAMES, HEAT_COLUMN] = [120, 77]; // pixels; where they do not fit cells are small
const WIDE = 860; // pixels with room for two charts side by side
const TINTS = { light: [[236, 164, 152], [246, 245, 242], [158, 191, 236]], dark: [[132, 47, 35], [44, 50, 58], [35, 75, 139]] };

export class Cover {
  private picked: number[] = []; // games to compare
  private table = 0;
  private picking = false; // a cell of a heat map is picked to compare, not opened
  private readonly rates: { number: number; button: HTMLButtonElement }[] = []; // cells with a game
  private width = 0;
  private room = 0; // pixels beside the padding
  private readonly thumbs = new Thumbs();
  private readonly cards: { number: number; box: HTMLInputElement; why: HTMLElement; card: HTMLElement; canvas: HTMLCanvasElement }[] = [];

  constructor(
    private readonly page: Page,
    private readonly contents: ContentsDoc,
  ) {}

  /** All of it: when it is shown, when the colours change, when there is more or less room. */
  draw(): void {
    if (!this.page.covered) return;
    const { contents } = this;
    const main = byId("cover-main");
    this.width = main.clientWidth;
    this.room = this.width - 2 * Number.parseFloat(getComputedStyle(main).paddingLeft);
    say(byId("cover-title"), contents.title);
    const parts = [this.about(), contents.curve?.rows.length ? this.curves() : null, contents.tables?.length ? this.heat() : null, contents.lineage ? this.lineage() : null];
    const strip = contents.kind === "league" ? null : this.strip();
    main.replaceChildren(...[...parts, strip].filter((one) => one !== null));
    this.showPicked();
    void this.drawThumbs();
  }

  resized(): void {
    if (this.page.covered && byId("cover-main").clientWidth !== this.width) this.draw();
  }

  // --- words --------------------------------------------------------------------------------------

  private about(): HTMLElement {
    const { games, kind } = this.contents;
    const why = kind === "compare" && games.length > 1 ? whyApart(games[0], games[1]) : null;
    const seeds = new Set(games.map((one) => one.seed));
    const same = games.length > 1 && seeds.size === 1 && !seeds.has(undefined) ? " with the same dice" : "";
    const count = games.length === 1 ? "One recorded game" : `${games.length} recorded games${same}`;
    const lead: Record<ContentsDoc["kind"], string> = {
      album: `${count}: the commander as it was at each step${learnerText(games)}. A point of the curve or a picture opens a game.`,
      league: games.length ? `A cell opens the median game of its match, by margin. ${count}.` : "No game of these matches was recorded.",
      games: `${count}. A picture opens one.`,
      compare: why ? `These two cannot be shown side by side: they have ${why}.` : `${count}.`,
    };
    return make("p", { class: "soft", id: "about" }, lead[kind]);
  }

  // --- the learning curve -------------------------------------------------------------------------

  private curves(): HTMLElement {
    const { curve } = this.contents;
    if (!curve) return make("section");
    const wide = this.room >= WIDE;
    const size: [number, number] = [wide ? (this.room - 24) / 2 : this.room, wide ? CHART_HEIGHT.wide : CHART_HEIGHT.narrow];
    const charts = [WIN_RATE, MARGIN].map((measure) => {
      const box = make("div", { class: "chart" }, make("h2", {}, `${measure.name[0].toUpperCase()}${measure.name.slice(1)}`));
      box.append(curveChart(curve, measure, [size[0] - 26, size[1]], (game) => void this.page.choose([game])));
      return box;
    });
    const note = make("p", { class: "soft small" }, `Band: 95 % interval of ${curve.games.toLocaleString("en")} games an evaluation. Large points have a game.`);
    return make("section", { "aria-label": "Learning curve" }, make("div", { class: "charts" }, ...charts), note);
  }

  // --- heat maps ----------------------------------------------------------------------------------

  private heat(): HTMLElement {
    const tables = this.contents.tables ?? [];
    const table = tables[this.table] ?? tables[0];
    const tabs = tables.map((one, k) => {
      const button = make("button", { type: "button" }, one.name);
      press(button, k === this.table);
      button.addEventListener("click", () => {
        this.table = k;
        this.draw();
      });
      return button;
    });
    this.rates.length = 0;
    const told = make("p", { id: "cell-text", "aria-live": "polite" }, "Red's win rate in percent, then its 95 % interval and the number of games.");
    const head = make("tr", {}, make("th", { scope: "col" }, "red ↓  blue →"), ...table.blue.map((name) => make("th", { scope: "col" }, make("bdi", {}, name))));
    const rows = table.red.map((red, i) => make("tr", {}, make("th", { scope: "row" }, make("bdi", {}, red)), ...table.blue.map((_, j) => this.cell(table, i, j, told))));
    const grid = make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Heat map" }, make("table", { class: HEAT_NAMES + table.blue.length * HEAT_COLUMN > this.room ? "heat crowded" : "heat" }, make("thead", {}, head), make("tbody", {}, ...rows)));
    return make("section", { "aria-label": "Who beats whom" }, make("h2", {}, tables.length > 1 ? "Round robins" : `Round robin on ${table.name}`), tables.length > 1 ? make("div", { class: "tabs" }, ...tabs) : null, this.pickButton(), grid, told, this.legend());
  }

  /** Cells open their games, or are picked: two of them are put side by side. */
  private pickButton(): HTMLElement | null {
    if (this.contents.games.length < 2) return null;
    const button = make("button", { type: "button", id: "pick-two" }, "Compare two games");
    press(button, this.picking);
    button.addEventListener("click", () => {
      this.picking = !this.picking;
      press(button, this.picking);
      this.picked = [];
      this.showPicked();
    });
    return make("div", { class: "tabs" }, button);
  }

  private cell(table: TableDoc, i: number, j: number, told: HTMLElement): HTMLElement {
    const one = table.cells[i][j];
    if (!one) return make("td", { class: "none" }, "–");
    const [rate, low, high] = one.rate.map((value) => Math.round(100 * value));
    const text = `${table.red[i]} (red) against ${table.blue[j]} (blue): ${rate} % [${low}, ${high}] of ${one.games} games. ${gameText(one)}`;
    const inside = [make("b", {}, String(rate)), make("small", {}, `${low}–${high}`), make("small", { class: "count" }, `n ${one.games}`)];
    const box = one.game ? make("button", { type: "button", class: "rate", title: text, "data-game": String(one.game) }, ...inside) : make("div", { class: "rate", title: text }, ...inside);
    box.style.backgroundColor = tint(one.rate[0], this.page.dark);
    const { game } = one;
    if (game && box instanceof HTMLButtonElement) {
      this.rates.push({ number: game, button: box });
      box.addEventListener("click", () => (this.picking ? this.pick(game, !this.picked.includes(game)) : void this.page.choose([game])));
    }
    for (const event of ["pointerenter", "focus"]) box.addEventListener(event, () => say(told, text));
    return make("td", {}, box);
  }

  private legend(): HTMLElement {
    const steps = [0, 0.25, 0.5, 0.75, 1].map((rate) => {
      const box = make("span", { class: "step" }, `${100 * rate}`);
      box.style.backgroundColor = tint(rate, this.page.dark);
      return box;
    });
    return make("p", { class: "legend small" }, "blue wins ", ...steps, " red wins");
  }

  // --- who comes from whom ------------------------------------------------------------------------

  private lineage(): HTMLElement {
    const charts = Object.entries(this.contents.lineage ?? {}).map(([camp, generations]) => {
      const box = make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": `Lineage, ${camp}` });
      box.append(lineageChart(generations, camp));
      return make("div", {}, camp === "both" ? null : make("h3", {}, `${camp} models`), box);
    });
    return make("section", { "aria-label": "Lineage" }, make("h2", {}, "Who was kept, and whom each was trained from"), ...charts, make("p", { class: "soft small" }, "The best on top. A dashed line: the same model, kept again."));
  }

  // --- the strip ----------------------------------------------------------------------------------

  private strip(): HTMLElement {
    this.cards.length = 0;
    const { games, kind } = this.contents;
    const cards = games.map((entry, k) => this.card(entry, k + 1));
    const name = kind === "album" ? "How each of them ended" : "How they ended";
    return make("section", { "aria-label": name }, make("h2", {}, name), make("div", { id: "strip" }, ...cards));
  }

  private card(entry: EntryDoc, number: number): HTMLElement {
    const canvas = make("canvas", { "aria-hidden": "true" });
    const margins = CAMPS.filter((camp) => entry.margin[camp] !== undefined).flatMap((camp) => [make("span", { class: `t-${camp}` }, `${camp} ${signed(entry.margin[camp] ?? 0)}`), " "]);
    const who = make("span", { class: "soft small who" }, make("bdi", {}, entry.players.red.name), " against ", make("bdi", {}, entry.players.blue.name), `, ${entry.scenario}`);
    const open = make("button", { type: "button", class: "open", "data-game": String(number) }, canvas, make("bdi", { class: "title" }, entry.name), make("span", { class: "margins" }, ...margins), make("span", { class: "soft small" }, resultOf(entry)), this.contents.kind === "album" ? null : who);
    open.addEventListener("click", () => void this.page.choose([number]));
    const box = make("input", { type: "checkbox", id: `compare-${number}` });
    const why = make("span", { class: "small why" });
    box.addEventListener("change", () => this.pick(number, box.checked));
    const card = make("article", { class: "card" }, open, this.contents.games.length > 1 ? make("label", { class: "small" }, box, "compare ", why) : null);
    this.cards.push({ number, box, why, card, canvas });
    return card;
  }

  private pick(number: number, picked: boolean): void {
    this.picked = picked ? [...this.picked, number] : this.picked.filter((one) => one !== number);
    this.showPicked();
  }

  /** Why a game cannot be picked now; null where it can. */
  private whyNot(number: number): string | null {
    const [first, second] = this.picked;
    if (first === undefined || this.picked.includes(number)) return null;
    return this.page.whyApart(first, number) ?? (second === undefined ? null : "two are picked");
  }

  /** Two can be picked; what cannot be shown beside the first is greyed, and says why. */
  private showPicked(): void {
    const [first, second] = this.picked;
    for (const { number, button } of this.rates) {
      const reason = this.whyNot(number);
      button.disabled = reason !== null;
      if (this.picking) press(button, this.picked.includes(number));
      else button.removeAttribute("aria-pressed");
    }
    for (const { number, box, why, card } of this.cards) {
      const mine = this.picked.includes(number);
      const reason = this.whyNot(number);
      box.checked = mine;
      box.disabled = reason !== null;
      card.classList.toggle("shut", reason !== null && second === undefined);
      say(why, reason && second === undefined ? `not with it: ${reason}` : "");
    }
    const bar = byId("cover-pair");
    bar.hidden = first === undefined && !this.picking;
    const go = make("button", { type: "button", id: "compare" }, "Compare");
    go.disabled = second === undefined;
    go.addEventListener("click", () => void this.page.choose(this.picked));
    const clear = make("button", { type: "button" }, "Clear");
    clear.addEventListener("click", () => {
      this.picked = [];
      this.showPicked();
    });
    const names = this.picked.map((number) => make("b", {}, make("bdi", {}, this.page.entryOf(number)?.name ?? "")));
    const next = first === undefined ? "Pick a cell, then another one" : second === undefined ? ": pick another one" : " side by side";
    bar.replaceChildren(make("span", {}, ...names.flatMap((name, k) => (k ? [" and ", name] : [name])), next), go, clear);
  }

  private async drawThumbs(): Promise<void> {
    for (const { number, canvas } of this.cards) {
      const entry = this.contents.games[number - 1];
      const [map, setup] = await Promise.all([this.page.mapOf(entry.map), loadSetup(entry.setup)]);
      if (!canvas.isConnected) return;
      this.thumbs.draw(canvas, entry, setup, map, paletteOf(this.page.dark), this.page.ratio);
    }
  }
}

/** Whom the commander of an album plays, and as what: the camp whose player has another name in each game. */
function learnerText(games: EntryDoc[]): string {
  const names = (camp: Camp) => new Set(games.map((one) => one.players[camp].name));
  const camp = CAMPS.find((one) => names(one).size > 1 && names(other(one)).size === 1);
  return camp ? `, as ${camp} against ${[...names(other(camp))][0]}` : "";
}

function gameText(cell: CellDoc): string {
  return cell.game ? `Opens game ${cell.episode} of seed ${cell.seed}, the median by margin.` : "No game was recorded.";
}

/** Blue where blue wins, red where red does. */
export function tint(rate: number, dark: boolean): string {
  const [red, middle, blue] = dark ? TINTS.dark : TINTS.light;
  const end = rate > 0.5 ? red : blue;
  const share = Math.abs(rate - 0.5) * 2;
  return `rgb(${middle.map((part, k) => Math.round(part + (end[k] - part) * share)).join(",")})`;
}
