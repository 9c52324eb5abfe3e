// The page: one store, one clock, one draw. What builds it is in build.ts and cover.ts, who touches it in input.ts.

import { build } from "./build";
import { Clock } from "./clock";
import { type Moment, readMoment, writeMoment } from "./commands";
import type { Parting } from "./compare";
import { type ContentsDoc, type EntryDoc, whyApart } from "./contents";
import { Cover } from "./cover";
import { byId, say } from "./dom";
import { type HexMap, cellName, parseCell, readMap } from "./hex";
import { listen } from "./input";
import type { Entry } from "./log";
import { paletteOf } from "./palette";
import { noteAddress, openGames } from "./opening";
import { mindsOf } from "./policypanel";
import type { Scene, Tab } from "./scene";
import type { Stage } from "./stage";
import type { Game, Piece } from "./state";
import { CAMPS, type View, loadContents, loadMap } from "./story";
import type { Tape } from "./tape";
import { announce, drawTexts } from "./texts";
import { Timeline } from "./timeline";

const MOST_RATIO = 2; // device pixels a CSS pixel
const FIRE_TICKS = 14;
const FIRST = 1; // number of the first game

export class Page extends Clock {
  contents: ContentsDoc | null = null; // of a page of many games
  cover: Cover | null = null;
  covered = false;
  tapes: Tape[] = []; // that are shown: one game, or two side by side
  stages: Stage[] = [];
  active = 0; // of two games, whose panel is shown
  parting: Parting | null = null;
  readonly timeline = new Timeline(byId<HTMLCanvasElement>("timeline"));
  private readonly maps = new Map<string, Promise<HexMap>>();
  picked: Piece | null = null;
  cell = -1;
  hover = -1;
  tab: Tab = "pieces";
  hot: Entry | null = null;
  follow = false;
  muted = false;
  on = { los: false, ranges: false, beliefs: true, policy: true, fog: true };
  dark = matchMedia("(prefers-color-scheme: dark)").matches;
  readonly still = matchMedia("(prefers-reduced-motion: reduce)");
  readonly costs: number[] = []; // script time of the last frames, ms

  async open(): Promise<void> {
    document.documentElement.classList.toggle("dark", this.dark);
    this.contents = await loadContents();
    if (this.contents) this.cover = new Cover(this, this.contents);
    build(this);
    listen(this);
    await this.moveTo(this.firstMoment());
    byId("fallback").hidden = true;
    performance.mark("first frame");
    const observer = new ResizeObserver(() => this.resized());
    for (const id of ["stage", "stage-2"]) observer.observe(byId(id));
  }

  /** Where the page begins: as the address says, or with two games side by side where it was made for that. */
  private firstMoment(): Moment {
    const moment = readMoment(location.hash);
    const pair = this.contents?.kind === "compare" && moment.game === undefined && this.whyApart(1, 2) === null;
    return pair ? { ...moment, game: 1, with: 2 } : moment;
  }

  // --- which game ---------------------------------------------------------------------------------

  entryOf(number: number): EntryDoc | null {
    return this.contents?.games[number - 1] ?? null;
  }

  whyApart(one: number, other: number): string | null {
    const [a, b] = [this.entryOf(one), this.entryOf(other)];
    return a && b ? whyApart(a, b) : "no such game";
  }

  /** Go where an address leads: to the cover, to a game, to another moment of the one that is open. */
  async moveTo(moment: Moment): Promise<void> {
    const number = this.contents ? moment.game : FIRST;
    if (number === undefined || (this.contents && !this.entryOf(number))) return this.showCover();
    const beside = moment.with !== undefined && this.whyApart(number, moment.with) === null ? [moment.with] : [];
    const numbers = [number, ...beside];
    if (this.covered || numbers.join() !== this.tapes.map((tape) => tape.number).join()) await openGames(this, numbers, moment);
    else if (moment.view && this.views.includes(moment.view)) await this.show(moment.view);
    this.go(moment);
    this.ask();
  }

  showCover(): void {
    this.halt();
    this.covered = true;
    byId("app").hidden = true;
    byId("cover").hidden = false;
    this.cover?.draw();
    document.title = this.contents?.title ?? document.title;
  }

  /** From the cover: a step that the browser can take back. */
  async choose(numbers: number[]): Promise<void> {
    const moment = { game: numbers[0], ...(numbers.length > 1 ? { with: numbers[1] } : {}) };
    noteAddress(moment, "push");
    await this.moveTo(moment);
    byId("play").focus();
  }

  leave(): void {
    if (!this.contents) return;
    noteAddress({}, "push");
    this.showCover();
    byId("cover").focus();
  }

  /** The game before, or after. */
  turn(by: 1 | -1): void {
    const number = this.tape.number + by;
    if (this.entryOf(number)) void this.choose([number]);
  }

  mapOf(key: string): Promise<HexMap> {
    const found = this.maps.get(key) ?? loadMap(key).then(readMap);
    this.maps.set(key, found);
    return found;
  }

  /** Of two games, whose panel and log are shown. */
  focus(k: number): void {
    if (k === this.active || !this.tapes[k]) return;
    this.active = k;
    byId("app").classList.toggle("second", k === 1);
    this.hot = null;
    this.showTimeline();
    byId("panel").dataset.key = "";
    announce(this, this.tape.name);
    this.ask();
  }

  get tape(): Tape {
    return this.tapes[this.active];
  }

  get game(): Game {
    return this.tape.game;
  }

  get map(): HexMap {
    return this.game.map;
  }

  get stage(): Stage {
    return this.stages[this.active];
  }

  get views(): View[] {
    return this.tape.views;
  }

  /** The last tick of the clock: of two games, the later one. */
  get last(): number {
    return Math.max(...this.tapes.map((tape) => tape.game.last));
  }

  // --- the store ----------------------------------------------------------------------------------

  get ratio(): number {
    return Math.min(MOST_RATIO, window.devicePixelRatio || 1);
  }

  list(): Entry[] {
    return this.tape.list();
  }

  showTimeline(): void {
    const other = this.tapes[1 - this.active];
    this.timeline.show(this.tape.curves(), this.list(), this.last, this.game.story.game_ticks, other?.curves() ?? {}, this.parting?.tick ?? -1);
  }

  scene(k = this.active): Scene {
    const { time } = this;
    const { game } = this.tapes[k];
    const shown = this.still.matches ? Math.floor(time) : time;
    return {
      game, state: game.at(shown, this.still.matches), time: shown, picked: this.picked && game.pieces[this.picked.index], cell: this.cell, hover: this.hover, entries: this.tapes[k].list(),
      luck: this.tapes[k].luck, palette: paletteOf(this.dark), ratio: this.ratio, sight: this.stages[k].sight,
      pick: (piece) => this.pick(piece), seek: (tick) => this.seek(tick), point: (entry) => this.pointAt(entry),
    };
  }

  scenes(): Scene[] {
    return this.tapes.map((_, k) => this.scene(k));
  }

  go(moment: Moment): void {
    if (this.covered) return;
    if (moment.t !== undefined) this.time = Math.min(moment.t, this.last);
    if (moment.speed) this.speed = moment.speed;
    const piece = moment.pick ? this.game.byName(moment.pick) : undefined;
    if (piece) this.picked = piece;
    if (moment.cell) this.cell = parseCell(this.map, moment.cell);
  }

  moment(): Moment {
    const moment: Moment = {};
    if (this.contents) moment.game = this.tapes[0].number;
    if (this.tapes.length > 1) moment.with = this.tapes[1].number;
    Object.assign(moment, { t: Math.floor(this.time), view: this.game.view });
    if (this.picked) moment.pick = this.picked.name;
    else if (this.cell >= 0) moment.cell = cellName(this.map, this.cell);
    moment.speed = this.speed;
    return moment;
  }

  async show(view: View): Promise<void> {
    if (view === this.game.view) return;
    await Promise.all(this.tapes.map((tape) => tape.show(view)));
    this.showTimeline();
    announce(this, view === "referee" ? "The referee's view" : `What ${view} knows`);
    this.noteMoment();
    this.ask();
  }

  // --- the clock ----------------------------------------------------------------------------------

  get loop(): [number, number] | null {
    return this.timeline.loop;
  }

  get isOpen(): boolean {
    return !this.covered && this.tapes.length > 0;
  }

  get eventTicks(): number[] {
    return this.list().filter((one) => one.group === "fire" || one.shape === "sight").map((one) => one.tick);
  }

  get decisionTicks(): number[] {
    return CAMPS.flatMap((camp) => this.game.story.policy[camp]?.decisions.map(([tick]) => tick) ?? []);
  }

  stopped(): void {
    announce(this);
    this.noteMoment();
  }

  noteMoment(): void {
    if (!this.covered) noteAddress(this.moment(), "replace");
  }

  // --- drawing ------------------------------------------------------------------------------------

  draw(now: number): void {
    if (!this.isOpen) return;
    const start = performance.now();
    const scene = this.scene();
    if (this.follow && this.picked) this.chase(scene);
    const hot = this.hot && this.hot.to >= 0 ? { shape: "arrow" as const, from: this.hot.from, to: this.hot.to } : null;
    const policy = this.on.policy && this.tab === "policy";
    for (const [k, stage] of this.stages.entries()) {
      if (!stage.isShown) continue;
      const own = k === this.active;
      stage.draw(own ? scene : this.scene(k), { ...this.on, policy, fireTicks: Math.max(FIRE_TICKS, this.speed * 0.9) }, own ? hot : null);
    }
    this.timeline.minds = this.picked ? { camp: this.picked.camp, ticks: this.minds() } : null;
    this.timeline.draw(scene.time, scene.palette, this.ratio, this.muted);
    drawTexts(this, scene, now);
    this.costs.push(performance.now() - start);
    if (this.costs.length > 5000) this.costs.splice(0, 1000);
  }

  /** A frame of a game that plays: the same one on any machine. */
  drawAt(time: number, now: number): void {
    Object.assign(this, { time, playing: true });
    this.draw(now);
    this.playing = false;
  }

  minds(): number[] {
    const key = `${this.game.view} ${this.picked?.index}`;
    if (this.mindKey !== key) [this.mindKey, this.mindTicks] = [key, mindsOf(this.game, this.picked)];
    return this.mindTicks;
  }

  mindKey = "";
  mindTicks: number[] = [];
  panelled = 0; // time at which the panel was drawn

  chase(scene: Scene): void {
    const shown = this.picked ? scene.state.pieces[this.picked.index] : null;
    if (!shown || shown.cell < 0) return;
    const { camera } = this.stage;
    const at = camera.toScreen(shown.at);
    camera.pan((camera.width / 2 - at.x) * 0.15, (camera.height / 2 - at.y) * 0.15);
    if (Math.hypot(camera.width / 2 - at.x, camera.height / 2 - at.y) > 2 && !this.playing) this.ask();
  }

  resized(): void {
    this.cover?.resized();
    if (!this.isOpen) return;
    for (const [k, stage] of this.stages.entries()) {
      stage.resize(this.ratio);
      if (stage.isShown) stage.renew(this.scene(k));
    }
    this.ask();
  }

  // --- acts ---------------------------------------------------------------------------------------

  toggle(name: string): void {
    if (name === "follow") this.follow = !this.follow;
    else if (name in this.on) this.on[name as keyof typeof this.on] = !this.on[name as keyof typeof this.on];
    this.ask();
  }

  openTab(tab: Tab): void {
    this.tab = tab;
    this.unfold(true);
    byId("panel").dataset.key = "";
    this.ask();
  }

  setDark(dark: boolean): void {
    this.dark = dark;
    document.documentElement.classList.toggle("dark", dark);
    this.cover?.draw();
    for (const [k, stage] of this.stages.entries()) stage.renew(this.scene(k));
    byId("panel").dataset.key = "";
    this.ask();
  }

  zoom(factor: number): void {
    const { camera } = this.stage;
    camera.zoom(factor, { x: camera.width / 2, y: camera.height / 2 });
    this.ask();
  }

  whole(): void {
    this.stage.camera.fit();
    this.ask();
  }

  /** To where the pieces are. */
  toPieces(): void {
    this.stage.frame(this.scenes(), true);
    this.ask();
  }

  /** Where there is little room and two games: the panel, or the map of the other one. */
  unfold(open: boolean): void {
    const room = () => (this.stages.length > 0 ? byId("stage").clientHeight + byId("stage-2").clientHeight : 0); // asking costs a layout
    const before = room();
    byId("app").classList.toggle("open", open);
    byId("fold").setAttribute("aria-expanded", String(open));
    if (room() !== before) {
      this.resized();
      this.toPieces();
    }
    this.ask();
  }

  async share(): Promise<void> {
    const address = location.href.split("#")[0] + writeMoment(this.moment());
    const command = `hexwar watch ${this.contents ? "GAMES" : "GAME.hwr"} -o game.html  ${writeMoment(this.moment())}`;
    try {
      await navigator.clipboard.writeText(location.protocol.startsWith("about") ? command : address);
      announce(this, "The link is copied");
      this.flash("copied");
    } catch {
      this.flash(writeMoment(this.moment()));
    }
  }

  flash(text: string): void {
    say(byId("readout"), text);
  }

  pick(piece: Piece | null, cell = -1): void {
    this.picked = piece;
    this.cell = cell;
    if (this.tab === "log") this.openTab("pieces");
    this.noteMoment();
    this.ask();
  }

  pointAt(entry: Entry | null): void {
    this.hot = entry;
    this.ask();
  }
}
