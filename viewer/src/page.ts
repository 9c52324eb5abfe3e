// The page: one store, one clock, one draw. What builds it is in build.ts, who touches it in input.ts.

import { build } from "./build";
import { type Moment, SPEEDS, readMoment, writeMoment } from "./commands";
import { byId, press, say } from "./dom";
import { type HexMap, cellName, parseCell, readMap } from "./hex";
import { listen } from "./input";
import { type Entry, entriesOf, luckOf, signed } from "./log";
import { paletteOf } from "./palette";
import { logPanel } from "./logpanel";
import { piecesPanel } from "./piecespanel";
import { mindsOf, policyPanel } from "./policypanel";
import type { Scene, Tab } from "./scene";
import { Stage } from "./stage";
import { Game, type Piece } from "./state";
import { CAMPS, type View, loadMap, loadStory, viewsOf } from "./story";
import { Timeline } from "./timeline";

export const GAME = 1; // of the games on a page
export const DECISION = 75;
const MOST_RATIO = 2; // device pixels a CSS pixel
const FIRE_TICKS = 14;

export class Page {
  games = new Map<View, Game>();
  game!: Game;
  map!: HexMap;
  stage!: Stage;
  timeline!: Timeline;
  entries = new Map<View, Entry[]>();
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
    const views = viewsOf(GAME);
    const moment = readMoment(location.hash);
    const first = moment.view && views.includes(moment.view) ? moment.view : views[0];
    const story = await loadStory(GAME, first);
    this.map = readMap(await loadMap(story.map));
    this.game = new Game(story, this.map);
    this.games.set(first, this.game);
    this.entries.set(first, entriesOf(this.game));
    byId("fallback").hidden = true;
    byId("app").hidden = false;
    document.documentElement.classList.toggle("dark", this.dark);
    this.stage = new Stage(this.game, () => this.ask());
    this.timeline = new Timeline(byId<HTMLCanvasElement>("timeline"), this.curves(), this.list(), this.game.last, this.game.story.game_ticks);
    build(this, views);
    listen(this);
    this.stage.resize(this.ratio);
    this.go(moment);
    this.stage.frame(this.scene());
    this.draw(performance.now());
    performance.mark("first frame");
    new ResizeObserver(() => this.resized()).observe(byId("stage"));
  }

  // --- the store ----------------------------------------------------------------------------------

  get ratio(): number {
    return Math.min(MOST_RATIO, window.devicePixelRatio || 1);
  }

  list(): Entry[] {
    return this.entries.get(this.game.view) ?? [];
  }

  curves() {
    const { story } = this.game;
    return story.margin ?? story.known_margin;
  }

  scene(time = this.time): Scene {
    const { game } = this;
    const shown = this.still.matches ? Math.floor(time) : time;
    return {
      game, state: game.at(shown, this.still.matches), time: shown, picked: this.picked, cell: this.cell, hover: this.hover, entries: this.list(),
      luck: game.view === "referee" ? this.luck : {}, palette: paletteOf(this.dark), ratio: this.ratio, sight: this.stage.sight,
      pick: (piece) => this.pick(piece), seek: (tick) => this.seek(tick), point: (entry) => this.pointAt(entry),
    };
  }

  get luck() {
    const game = this.games.get("referee");
    this.lucky ??= game ? { red: luckOf(game, "red"), blue: luckOf(game, "blue") } : {};
    return this.lucky;
  }

  lucky: Scene["luck"] | undefined;

  go(moment: Moment): void {
    if (moment.t !== undefined) this.time = Math.min(moment.t, this.game.last);
    if (moment.speed) this.speed = moment.speed;
    const piece = moment.pick ? this.game.byName(moment.pick) : undefined;
    if (piece) this.picked = piece;
    if (moment.cell) this.cell = parseCell(this.map, moment.cell);
  }

  moment(): Moment {
    const moment: Moment = { t: Math.floor(this.time), view: this.game.view };
    if (this.picked) moment.pick = this.picked.name;
    else if (this.cell >= 0) moment.cell = cellName(this.map, this.cell);
    moment.speed = this.speed;
    return moment;
  }

  async show(view: View): Promise<void> {
    if (view === this.game.view) return;
    let game = this.games.get(view);
    if (!game) {
      game = new Game(await loadStory(GAME, view), this.map);
      this.games.set(view, game);
      this.entries.set(view, entriesOf(game));
    }
    this.game = game;
    this.picked = this.picked ? (game.byName(this.picked.name) ?? null) : null;
    this.timeline.show(this.curves(), this.list(), game.last);
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
    const end = this.timeline.loop?.[1] ?? this.game.last;
    this.time += (ms / 1000) * this.speed;
    if (this.time < end) return;
    if (this.timeline.loop) this.time = this.timeline.loop[0];
    else {
      this.time = end;
      this.play(false);
    }
  }

  play(playing: boolean): void {
    if (playing && this.time >= this.game.last) this.time = 0;
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
    this.time = Math.max(0, Math.min(this.game.last, Math.floor(tick)));
    this.announce();
    this.noteMoment();
    this.ask();
  }

  step(direction: 1 | -1): void {
    const now = Math.floor(this.time);
    const ticks = this.list().filter((one) => one.group === "fire" || one.shape === "sight").map((one) => one.tick);
    const next = direction > 0 ? ticks.find((tick) => tick > now) : ticks.filter((tick) => tick < now).pop();
    this.seek(next ?? (direction > 0 ? this.game.last : 0));
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
    try {
      history.replaceState(null, "", writeMoment(this.moment()));
    } catch {
      // a page within a page has no address of its own
    }
  }

  // --- drawing ------------------------------------------------------------------------------------

  draw(now: number): void {
    const start = performance.now();
    const scene = this.scene();
    if (this.follow && this.picked) this.chase(scene);
    const hot = this.hot && this.hot.to >= 0 ? { shape: "arrow" as const, from: this.hot.from, to: this.hot.to } : null;
    const policy = this.on.policy && this.tab === "policy";
    this.stage.draw(scene, { ...this.on, policy, fireTicks: Math.max(FIRE_TICKS, this.speed * 0.9) }, hot);
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
    slider.setAttribute("aria-valuemax", String(this.game.last));
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
    for (const camp of CAMPS) {
      const margin = scene.state.margin[camp];
      say(byId(`margin-${camp}`), margin === undefined ? "" : signed(margin));
    }
    const { view, story, last } = this.game;
    const winner = story.end?.winner;
    const result = !winner || scene.state.tick < last ? "" : winner === "draw" ? ", a draw" : `, ${winner} wins`;
    const what = view === "referee" ? `${story.scenario}, seed …${story.seed?.slice(-6)}${result}` : `${story.scenario}, margin as ${view} knows it`;
    say(byId("what"), what);
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
    this.stage.resize(this.ratio);
    this.stage.renew(this.scene());
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
    this.stage.renew(this.scene());
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
    const command = `hexwar watch GAME.hwr -o game.html  ${writeMoment(this.moment())}`;
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
