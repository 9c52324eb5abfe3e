// The page: one store, one clock, one draw. What builds it is in build.ts and cover.ts, who touches it in input.ts.

import { build, buildGame } from "./build";
import { type Moment, SPEEDS, readMoment, writeMoment } from "./commands";
import { type Parting, partingOf } from "./compare";
import { type ContentsDoc, type EntryDoc, whyApart } from "./contents";
import { Cover } from "./cover";
import { byId, press, say } from "./dom";
import { type HexMap, cellName, parseCell, readMap } from "./hex";
import { listen } from "./input";
import { type Entry, signed } from "./log";
import { paletteOf } from "./palette";
import { logPanel } from "./logpanel";
import { piecesPanel } from "./piecespanel";
import { mindsOf, policyPanel } from "./policypanel";
import type { Scene, Tab } from "./scene";
import { Stage } from "./stage";
import type { Game, Piece } from "./state";
import { CAMPS, type View, loadContents, loadMap, viewsOf } from "./story";
import { Tape } from "./tape";
import { Timeline } from "./timeline";

export const DECISION = 75;
const MOST_RATIO = 2; // device pixels a CSS pixel
const FIRE_TICKS = 14;
const FIRST = 1; // number of the first game

export class Page {
  contents: ContentsDoc | null = null; // of a page of many games
  cover: Cover | null = null;
  covered = false;
  tapes: Tape[] = []; // that are shown: one game, or two side by side
  stages: Stage[] = [];
  active = 0; // of two games, whose panel is shown
  parting: Parting | null = null;
  readonly timeline = new Timeline(byId<HTMLCanvasElement>("timeline"));
  private readonly maps = new Map<string, Promise<HexMap>>();
  time = 0;
  speed = 16;
  playing = false;
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
  asked = 0; // number of the frame that was asked for
  before = 0; // time of the last frame
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
    if (this.covered || numbers.join() !== this.tapes.map((tape) => tape.number).join()) await this.openGames(numbers, moment);
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
    try {
      history.pushState(null, "", writeMoment(numbers.length > 1 ? { game: numbers[0], with: numbers[1] } : { game: numbers[0] }));
    } catch {
      // a page within a page has no address of its own
    }
    await this.moveTo({ game: numbers[0], ...(numbers.length > 1 ? { with: numbers[1] } : {}) });
    byId("play").focus();
  }

  leave(): void {
    if (!this.contents) return;
    try {
      history.pushState(null, "", "#");
    } catch {
      // as above
    }
    this.showCover();
    byId("cover").focus();
  }

  /** The game before, or after. */
  turn(by: 1 | -1): void {
    const number = this.tape.number + by;
    if (this.entryOf(number)) void this.choose([number]);
  }

  private async openGames(numbers: number[], moment: Moment): Promise<void> {
    const tapes = numbers.map((number) => new Tape(number, this.entryOf(number), this.entryOf(number)?.views ?? viewsOf(number), (key) => this.mapOf(key)));
    const views = tapes[0].views;
    const first = moment.view && views.includes(moment.view) ? moment.view : views[0];
    await Promise.all(tapes.map((tape) => tape.show(first)));
    this.halt();
    Object.assign(this, { tapes, active: 0, covered: false, time: 0, picked: null, cell: -1, hover: -1, hot: null, mindKey: "" });
    this.parting = tapes.length > 1 ? partingOf(tapes[0].game.story, tapes[1].game.story) : null;
    byId("cover").hidden = true;
    byId("app").hidden = false;
    byId("app").classList.toggle("pair", tapes.length > 1);
    for (const stage of this.stages) stage.drop();
    this.stages = [];
    for (const [k, tape] of tapes.entries()) this.stages.push(new Stage(tape.game, () => this.ask(), k, this.stages[0]?.camera));
    buildGame(this);
    this.showTimeline();
    byId("panel").dataset.key = "";
    for (const stage of this.stages) stage.resize(this.ratio);
    this.go(moment);
    this.stage.frame(this.scene());
    this.draw(performance.now());
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
    this.hot = null;
    this.showTimeline();
    byId("panel").dataset.key = "";
    this.announce(this.tape.name);
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
    this.announce(view === "referee" ? "The referee's view" : `What ${view} knows`);
    this.noteMoment();
    this.ask();
  }

  // --- the clock ----------------------------------------------------------------------------------

  ask(): void {
    if (!this.asked) this.asked = requestAnimationFrame((now) => this.tick(now));
  }

  tick(now: number): void {
    this.asked = 0;
    if (this.playing) this.advance(Math.min(250, now - this.before));
    this.before = now;
    this.draw(now);
    if (this.playing) this.ask();
  }

  advance(ms: number): void {
    const end = this.timeline.loop?.[1] ?? this.last;
    this.time += (ms / 1000) * this.speed;
    if (this.time < end) return;
    if (this.timeline.loop) this.time = this.timeline.loop[0];
    else {
      this.time = end;
      this.play(false);
    }
  }

  private halt(): void {
    this.playing = false;
    byId("play").classList.remove("on");
    byId("play").setAttribute("aria-label", "Play");
  }

  play(playing: boolean): void {
    if (this.covered || this.tapes.length === 0) return;
    if (playing && this.time >= this.last) this.time = 0;
    this.playing = playing;
    this.before = performance.now();
    byId("play").classList.toggle("on", playing);
    byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
    if (!playing) {
      this.time = Math.floor(this.time);
      this.announce();
      this.noteMoment();
    }
    this.ask();
  }

  seek(tick: number): void {
    this.time = Math.max(0, Math.min(this.last, Math.floor(tick)));
    this.announce();
    this.noteMoment();
    this.ask();
  }

  step(direction: 1 | -1): void {
    const now = Math.floor(this.time);
    const ticks = this.list().filter((one) => one.group === "fire" || one.shape === "sight").map((one) => one.tick);
    const next = direction > 0 ? ticks.find((tick) => tick > now) : ticks.filter((tick) => tick < now).pop();
    this.seek(next ?? (direction > 0 ? this.last : 0));
  }

  decide(): void {
    const now = Math.floor(this.time);
    const ticks = CAMPS.flatMap((camp) => this.game.story.policy[camp]?.decisions.map(([tick]) => tick) ?? []);
    const next = ticks.filter((tick) => tick > now).sort((a, b) => a - b)[0];
    this.seek(next ?? (Math.floor(now / DECISION) + 1) * DECISION);
  }

  setSpeed(speed: number): void {
    this.speed = speed;
    this.noteMoment();
    this.ask();
  }

  faster(by: 1 | -1): void {
    const k = SPEEDS.indexOf(this.speed) + by;
    this.setSpeed(SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, k))]);
  }

  noteMoment(): void {
    if (this.covered) return;
    try {
      history.replaceState(null, "", writeMoment(this.moment()));
    } catch {
      // a page within a page has no address of its own
    }
  }

  // --- drawing ------------------------------------------------------------------------------------

  draw(now: number): void {
    if (this.covered || this.tapes.length === 0) return;
    const start = performance.now();
    const scene = this.scene();
    if (this.follow && this.picked) this.chase(scene);
    const hot = this.hot && this.hot.to >= 0 ? { shape: "arrow" as const, from: this.hot.from, to: this.hot.to } : null;
    const policy = this.on.policy && this.tab === "policy";
    for (const [k, stage] of this.stages.entries()) {
      const own = k === this.active;
      stage.draw(own ? scene : this.scene(k), { ...this.on, policy, fireTicks: Math.max(FIRE_TICKS, this.speed * 0.9) }, own ? hot : null);
    }
    this.timeline.minds = this.picked ? { camp: this.picked.camp, ticks: this.minds() } : null;
    this.timeline.draw(scene.time, scene.palette, this.ratio, this.muted);
    this.drawTexts(scene, now);
    this.costs.push(performance.now() - start);
    if (this.costs.length > 5000) this.costs.splice(0, 1000);
  }

  minds(): number[] {
    const key = `${this.game.view} ${this.picked?.index}`;
    if (this.mindKey !== key) [this.mindKey, this.mindTicks] = [key, mindsOf(this.game, this.picked)];
    return this.mindTicks;
  }

  mindKey = "";
  mindTicks: number[] = [];

  drawTexts(scene: Scene, now: number): void {
    const { state } = scene;
    this.drawScore(scene);
    const minutes = `${Math.floor(state.tick / 60)}:${String(state.tick % 60).padStart(2, "0")}`;
    say(byId("tick"), String(state.tick));
    say(byId("of"), ` of ${this.game.story.game_ticks}  (${minutes})`);
    say(byId("speed"), `${this.speed}×`);
    const slider = byId("timeline");
    slider.setAttribute("aria-valuemax", String(this.last));
    slider.setAttribute("aria-valuenow", String(state.tick));
    slider.setAttribute("aria-valuetext", `tick ${state.tick}, ${this.marginText(scene)}`);
    if (this.playing && now - this.panelled < 120) return; // the panel follows at a pace that can be read
    this.panelled = now;
    this.drawPanel(scene);
  }

  panelled = 0;

  drawPanel(scene: Scene): void {
    const panel = byId("panel");
    if (this.tab === "pieces") piecesPanel(panel, scene);
    else if (this.tab === "log") logPanel(panel, scene, true);
    else policyPanel(panel, scene);
    for (const button of byId("tabs").children) button.setAttribute("aria-selected", String(button.id === `tab-${this.tab}`));
    for (const button of byId("views").children) press(button as HTMLElement, button.id === `view-${this.game.view}`);
    for (const name of ["los", "ranges", "beliefs", "fog"] as const) press(byId(`on-${name}`), this.on[name]);
    press(byId("on-follow"), this.follow);
    byId("on-fog").hidden = this.game.view === "referee";
    byId("on-beliefs").hidden = this.game.view !== "referee";
  }

  drawScore(scene: Scene): void {
    if (this.tapes.length > 1) return this.drawCaptions();
    for (const camp of CAMPS) {
      const margin = scene.state.margin[camp];
      say(byId(`margin-${camp}`), margin === undefined ? "" : signed(margin));
    }
    say(byId("what"), this.aboutText(this.tape, scene.state.tick));
  }

  private drawCaptions(): void {
    for (const [k, tape] of this.tapes.entries()) {
      const { margin } = this.scene(k).state;
      for (const camp of CAMPS) say(byId(`margin-${camp}-${k}`), margin[camp] === undefined ? "" : signed(margin[camp] ?? 0));
      byId(`about-${k}`).classList.toggle("active", k === this.active);
      press(byId(`pick-${k}`), k === this.active);
      say(byId(`result-${k}`), this.resultText(tape, Math.floor(this.time)));
    }
  }

  private resultText(tape: Tape, tick: number): string {
    const { story, last } = tape.game;
    const winner = story.end?.winner;
    return !winner || tick < last ? "" : winner === "draw" ? "a draw" : `${winner} wins`;
  }

  private aboutText(tape: Tape, tick: number): string {
    const { view, story } = tape.game;
    const name = tape.name ? `${tape.name}, ` : "";
    if (view !== "referee") return `${name}${story.scenario}, margin as ${view} knows it`;
    return [`${name}${story.scenario}, seed …${story.seed?.slice(-6)}`, this.resultText(tape, tick)].filter(Boolean).join(", ");
  }

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
    if (this.covered || this.tapes.length === 0) return;
    for (const [k, stage] of this.stages.entries()) {
      stage.resize(this.ratio);
      stage.renew(this.scene(k));
    }
    this.ask();
  }

  // --- words --------------------------------------------------------------------------------------

  marginText(scene: Scene): string {
    const known = this.game.view === "referee" ? "margin" : "margin as known";
    const margins = CAMPS.filter((camp) => scene.state.margin[camp] !== undefined);
    return `${known} ${margins.map((camp) => `${camp} ${signed(scene.state.margin[camp] ?? 0)}`).join(", ")}`;
  }

  announce(before = ""): void {
    const scene = this.scene();
    const happened = this.list().filter((one) => one.tick === scene.state.tick && one.group !== "orders").map((one) => one.text);
    const said = [before, `Tick ${scene.state.tick}`, this.marginText(scene), ...happened.slice(0, 3)].filter(Boolean).join(". ");
    say(byId("live"), said);
    const alive = CAMPS.map((camp) => `${scene.state.pieces.filter((one) => one.piece.camp === camp && one.blood > 0).length} ${camp}`);
    byId("terrain").setAttribute("aria-label", `Map ${this.map.name}, tick ${scene.state.tick}: pieces ${alive.join(", ")}; ${this.marginText(scene)}`);
  }

  // --- acts ---------------------------------------------------------------------------------------

  toggle(name: string): void {
    if (name === "follow") this.follow = !this.follow;
    else if (name in this.on) this.on[name as keyof typeof this.on] = !this.on[name as keyof typeof this.on];
    this.ask();
  }

  openTab(tab: Tab): void {
    this.tab = tab;
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

  async share(): Promise<void> {
    const address = location.href.split("#")[0] + writeMoment(this.moment());
    const command = `hexwar watch ${this.contents ? "GAMES" : "GAME.hwr"} -o game.html  ${writeMoment(this.moment())}`;
    try {
      await navigator.clipboard.writeText(location.protocol.startsWith("about") ? command : address);
      this.announce("The link is copied");
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
