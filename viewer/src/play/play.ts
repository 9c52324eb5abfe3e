// The page of a game that is played: one store. What is drawn of it is in painter.ts, what stands around it in desk.ts, who touches it in hands.ts.

import { SPEEDS } from "../commands";
import { byId, say } from "../dom";
import { centre } from "../hex";
import { type Entry, signed } from "../log";
import { paletteOf } from "../palette";
import type { Scene } from "../scene";
import { Stage } from "../stage";
import type { Piece, Shown } from "../state";
import { Timeline } from "../timeline";
import { type Aim, aimOf, startOf } from "./aim";
import { showEnding, showNotice, showScore } from "./desk";
import { Known } from "./known";
import { Link } from "./link";
import { sayOrder } from "./orders";
import { Painter } from "./painter";
import { type Answers, type Ask, type Fields, type LookDoc, type MortarDoc, type NowDoc, type PathDoc, type Said, VERSION } from "./protocol";
import { Session } from "./session";
import { Refused, Wire } from "./wire";

const MOST_RATIO = 2; // device pixels a CSS pixel
const CATCH_UP = 8; // share of the ticks behind, a second
const LAST_STEPS = 24; // ticks a second, to where the clock stands
const ROOM_CELLS = 5; // around what is shown first
const FIRST_SCALE = 26; // pixels a cell, at most

export type Tab = "orders" | "pieces" | "log" | "hints";
export type Place = "now" | "then"; // where the picked piece is thought of

export class Play {
  session!: Session;
  wire: Wire | null = null;
  stage!: Stage;
  readonly link = new Link({
    opened: (send) => this.opened(send),
    heard: (text) => this.wire?.take(text),
    lost: (why, again) => this.lost(why, again),
  });
  readonly timeline = new Timeline(byId<HTMLCanvasElement>("timeline"));
  readonly known = new Known(() => this.wire, () => this.session, () => this.ask());
  time = 0; // that is shown
  speed = 8; // at which the clock is to run, ticks a second
  looking = false; // back, at what was
  picked: Piece | null = null;
  hover = -1;
  cursor = -1;
  shift = false; // held while the pointer moves
  place: Place = "now";
  tab: Tab = "orders";
  mortar = false;
  follow = false;
  hot: Entry | null = null;
  told = ""; // the last answer to what the person did
  on = { los: false, ranges: false, fog: true };
  dark = matchMedia("(prefers-color-scheme: dark)").matches;
  readonly still = matchMedia("(prefers-reduced-motion: reduce)");
  readonly costs: number[] = [];
  private asked = 0;
  private before = 0;
  private readonly painter = new Painter(this);

  // --- what the server says -----------------------------------------------------------------------

  private opened(send: (text: string) => void): void {
    this.wire = new Wire({ send }, (said) => this.heard(said));
  }

  private lost(why: string, again: number | null): void {
    this.wire?.close();
    this.wire = null;
    if (this.session) this.session.state.clock.running = false;
    showNotice(why, again === null ? null : () => this.link.open());
    if (this.session) this.ask();
  }

  private heard(said: Said): void {
    if (said.say === "hello" && said.version !== VERSION) showNotice(`This page speaks version ${VERSION} of the protocol, the server version ${said.version}. Load the page again.`, null);
    else if (said.say === "hello") this.begin(new Session(said));
    else if (said.say === "now") this.follows(said);
    else {
      this.session.over = said;
      showEnding(this, said);
      this.ask();
    }
  }

  private begin(session: Session): void {
    const first = this.session === undefined;
    this.session = session;
    this.time = session.tick;
    this.speed = session.state.clock.speed;
    this.looking = false;
    this.pickAnew();
    this.known.forget();
    byId("app").hidden = false;
    byId("app").classList.toggle("reads", session.role !== "commands");
    showScore(this);
    showNotice(session.role === "commands" ? "" : "This tab reads along: another one commands. When that one is closed, this one takes over.", null);
    if (first) this.build();
    byId("panel").dataset.key = "";
    this.showTimeline();
    this.announce(session.role !== "commands" ? "This tab reads along" : `You command ${session.camp} against ${session.hello.opponent}`);
    if (session.over) showEnding(this, session.over);
    this.ask();
  }

  private build(): void {
    this.stage = new Stage(this.session.game, () => this.ask());
    this.stage.resize(this.ratio);
    this.frameOwn();
    byId("fallback").hidden = true;
    new ResizeObserver(() => this.resized()).observe(byId("stage"));
    performance.mark("first frame");
    this.onBegin();
  }

  /** Own pieces, enemies in sight and the points: where orders are given first. */
  private frameOwn(): void {
    const { game, story, map, tick, camp } = this.session;
    const known = game.at(tick).pieces.filter((one) => (one.piece.camp === camp || one.how === "seen") && one.blood > 0 && one.cell >= 0);
    const places = [...known.map((one) => one.at), ...story.points.map(([, cell]) => centre(map, cell))];
    const { camera } = this.stage;
    if (places.length === 0) return camera.fit();
    camera.show(places, ROOM_CELLS);
    camera.zoom(Math.min(1, FIRST_SCALE / camera.scale), { x: camera.width / 2, y: camera.height / 2 });
  }

  onBegin: () => void = () => {};

  private follows(now: NowDoc): void {
    const ran = this.session.state.clock.running;
    const before = this.session.tick;
    this.session.take(now);
    this.pickAnew();
    if ("events" in now.story || before !== this.session.tick) this.showTimeline();
    for (const [, order, why] of now.refused) this.tell(`${sayOrder(order)}: ${why}`);
    if (before !== this.session.tick) {
      this.hot = null;
      this.look(this.session.tick, false);
    }
    if (!now.clock.running && (ran || before !== now.clock.tick)) this.halted();
    byId("panel").dataset.stale = "1";
    this.ask();
  }

  /** The clock stands: what has happened is said. */
  private halted(): void {
    this.painter.hurry();
    this.announce(this.session.stopped ?? "");
  }

  // --- what the page asks -------------------------------------------------------------------------

  /** Do something; a refusal is told to the person. */
  async send<A extends Ask>(ask: A, fields: Fields = {}): Promise<Answers[A] | null> {
    if (!this.wire) return null;
    try {
      const answer = await this.wire.ask(ask, fields);
      return answer;
    } catch (why) {
      if (!(why instanceof Refused)) throw why;
      this.tell(why.message);
      return null;
    }
  }

  tell(text: string): void {
    this.told = text;
    say(byId("live"), text);
    this.ask();
  }

  get canOrder(): boolean {
    const { picked } = this;
    if (!picked?.own || !this.session.commands || this.looking) return false;
    return this.session.game.shown(picked, this.session.tick).blood > 0;
  }

  hasPlan(short: string): boolean {
    const { tray, plans } = this.session.state;
    return tray[short] !== undefined || (plans[short]?.length ?? 0) > 0;
  }

  get then(): boolean {
    return this.shift || this.place === "then";
  }

  async plan(steps: string[], then: boolean): Promise<void> {
    const piece = steps[0].split(" ")[0];
    this.told = "";
    const done = await this.send("plan", { piece, steps, then: then && this.hasPlan(piece) });
    if (done) say(byId("live"), `${piece}: ${steps.map(sayOrder).join(", then ")}. Waits until the clock runs.`);
  }

  /** What a click on a cell means for the picked piece. */
  async planAt(cell: number, then: boolean): Promise<void> {
    this.look(this.session.tick, false);
    if (this.enemyIn(cell) && !this.mortar) await this.lookAhead(then);
    const aim = this.aimAt(cell, then);
    if (!aim) return;
    if (!aim.steps) return this.tell(aim.lines[aim.lines.length - 1]);
    this.cursor = -1;
    await this.plan(aim.steps, aim.then);
  }

  /** Wait for what a shot, or a way, needs to be known. */
  private async lookAhead(then: boolean): Promise<void> {
    const { picked } = this;
    if (picked) await this.known.need(picked.short, then && this.hasPlan(picked.short) ? startOf(this, true) : null);
  }

  run(): void {
    this.told = "";
    void this.send("run", { speed: this.speed });
  }

  pause(): void {
    void this.send("pause");
  }

  toggleClock(): void {
    if (this.session.state.clock.running) this.pause();
    else this.run();
  }

  step(to: "tick" | "event" | "decision"): void {
    this.told = "";
    void this.send("step", { to });
  }

  setSpeed(speed: number): void {
    this.speed = speed;
    if (this.session.state.clock.running) void this.send("run", { speed });
    this.ask();
  }

  faster(by: 1 | -1): void {
    const k = SPEEDS.indexOf(this.speed) + by;
    this.setSpeed(SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, k))]);
  }

  undo(): void {
    if (this.session.state.undo > 0) void this.send("undo").then((done) => done && this.tell("Taken back"));
    else this.tell("Nothing to take back: the orders are given.");
  }

  async hint(): Promise<void> {
    if (!this.picked) return;
    const hint = await this.send("hint", { piece: this.picked.short });
    if (!hint) return;
    this.session.takeHint(hint);
    this.pickAnew();
    byId("panel").dataset.key = "";
    this.ask();
  }

  // --- what is known of a place -------------------------------------------------------------------

  aimAt(cell: number, then: boolean): Aim | null {
    return aimOf(this, cell, then);
  }

  /** The cell that is meant: under the pointer, or under the cursor. */
  get aimed(): number {
    return this.hover >= 0 ? this.hover : this.cursor;
  }

  pathTo(cell: number, then: boolean): PathDoc | Refused | undefined {
    return this.known.path(this.picked?.short ?? "", then ? startOf(this, true) : null, cell);
  }

  /** What the picked piece can do now. */
  lookNow(): LookDoc | undefined {
    return this.known.look(this.picked?.short ?? "");
  }

  /** What it could do in another cell. */
  thoughtOf(cell: number): LookDoc | undefined {
    return cell < 0 ? undefined : this.known.thought(this.picked?.short ?? "", cell);
  }

  /** What is listed: of now, or of the cell in which the plan ends. */
  lookHere(): LookDoc | undefined {
    const after = this.place === "then" && this.picked && this.hasPlan(this.picked.short);
    return after ? this.thoughtOf(startOf(this, true)) : this.lookNow();
  }

  mortarGroup(cell: number): MortarDoc | undefined {
    return this.lookHere()?.mortar.find((group) => group.cells.includes(cell));
  }

  enemyIn(cell: number): Shown | null {
    const { game, camp, tick } = this.session;
    return game.at(tick).pieces.find((one) => one.piece.camp !== camp && one.how === "seen" && one.cell === cell && one.blood > 0) ?? null;
  }

  // --- drawing ------------------------------------------------------------------------------------

  get ratio(): number {
    return Math.min(MOST_RATIO, window.devicePixelRatio || 1);
  }

  scene(): Scene {
    const { game, entries } = this.session;
    const shown = this.still.matches ? Math.floor(this.time) : this.time;
    return {
      game, state: game.at(shown, this.still.matches), time: shown, picked: this.picked && game.pieces[this.picked.index], cell: -1, hover: this.aimed, entries,
      luck: {}, palette: paletteOf(this.dark), ratio: this.ratio, sight: this.stage?.sight,
      pick: (piece) => this.pick(piece), seek: (tick) => this.look(tick), point: (entry) => this.pointAt(entry),
    };
  }

  ask(): void {
    if (!this.asked) this.asked = requestAnimationFrame((now) => this.frame(now));
  }

  private frame(now: number): void {
    this.asked = 0;
    this.goOn(Math.min(250, now - this.before));
    this.before = now;
    this.painter.draw(now);
    if (this.session.state.clock.running || this.isBehind) this.ask();
  }

  private get isBehind(): boolean {
    return !this.looking && this.time < this.session.tick;
  }

  /** The picture follows the clock of the server, smoothly. */
  private goOn(ms: number): void {
    if (!this.isBehind) return;
    const { tick, state } = this.session;
    const gap = tick - this.time;
    const pace = Math.max(state.clock.running ? state.clock.speed : LAST_STEPS, gap * CATCH_UP);
    this.time = this.still.matches ? tick : Math.min(tick, this.time + (ms / 1000) * pace);
  }

  resized(): void {
    this.stage.resize(this.ratio);
    this.stage.renew(this.scene());
    this.ask();
  }

  private showTimeline(): void {
    const { story, entries, tick } = this.session;
    this.timeline.show(story.known_margin, entries, tick, this.session.state.clock.end, {}, -1);
  }

  announce(before = ""): void {
    const scene = this.scene();
    const { camp, tick, entries } = this.session;
    const margin = `margin as known ${signed(scene.state.margin[camp] ?? 0)}`;
    const happened = entries.filter((one) => one.tick === tick && one.group !== "orders").map((one) => one.text);
    say(byId("live"), [before, `Tick ${tick}`, margin, ...happened.slice(0, 3)].filter(Boolean).join(". "));
    const seen = scene.state.pieces.filter((one) => one.piece.camp !== camp && one.how === "seen" && one.blood > 0).length;
    const own = scene.state.pieces.filter((one) => one.piece.camp === camp && one.blood > 0).length;
    byId("terrain").setAttribute("aria-label", `Map ${this.session.map.name}, tick ${tick}: ${own} own pieces, ${seen} enemies in sight; ${margin}. Keys 1 to 9 pick a piece, arrows move the cell cursor.`);
  }

  // --- acts ---------------------------------------------------------------------------------------

  pick(piece: Piece | null): void {
    this.picked = piece;
    this.place = "now";
    this.mortar = false;
    this.told = "";
    if (piece && this.tab === "log") this.openTab("orders");
    this.ask();
  }

  /** The picked piece as it is now: each message makes a new game of the story. */
  private pickAnew(): void {
    this.picked = this.picked && this.session.game.pieces[this.picked.index];
  }

  /** Own pieces by their keys. */
  own(): Piece[] {
    return this.session.game.pieces.filter((piece) => piece.camp === this.session.camp);
  }

  setCursor(cell: number): void {
    this.hover = -1;
    this.cursor = cell;
    const { camera } = this.stage;
    const at = camera.toScreen(centre(this.session.map, cell));
    const edge = 60;
    camera.pan(Math.max(0, edge - at.x) - Math.max(0, at.x - camera.width + edge), Math.max(0, edge - at.y) - Math.max(0, at.y - camera.height + edge));
    this.ask();
  }

  /** Look at a tick that was; the present one is now. */
  look(tick: number, told = true): void {
    const { session } = this;
    const back = tick < session.tick;
    if (back || this.looking) this.time = Math.max(0, Math.min(session.tick, Math.floor(tick)));
    if (back !== this.looking && told) this.tell(back ? `You look back at tick ${Math.floor(tick)}. End leads to now.` : "Now");
    this.looking = back && told;
    byId("panel").dataset.stale = "1";
    this.ask();
  }

  /** Where that happened for which the clock stopped. */
  showStop(): void {
    const cell = this.session.stoppedAt;
    if (cell < 0) return;
    const { camera } = this.stage;
    const at = camera.toScreen(centre(this.session.map, cell));
    camera.pan(camera.width / 2 - at.x, camera.height / 2 - at.y);
    this.hot = { tick: this.session.tick, camp: this.session.camp, shape: "note", group: "rest", text: "", luck: null, from: -1, to: cell, dead: false, result: -1 };
    this.ask();
  }

  /** For the timeline's hand. */
  seek(tick: number): void {
    this.look(tick);
  }

  toggle(name: string): void {
    if (name === "follow") this.follow = !this.follow;
    else if (name === "mortar") this.mortar = !this.mortar;
    else if (name in this.on) this.on[name as keyof typeof this.on] = !this.on[name as keyof typeof this.on];
    byId("panel").dataset.stale = "1";
    this.ask();
  }

  openTab(tab: Tab): void {
    this.tab = tab;
    byId("panel").dataset.key = "";
    this.painter.hurry();
    this.ask();
  }

  setDark(dark: boolean): void {
    this.dark = dark;
    document.documentElement.classList.toggle("dark", dark);
    if (!this.stage) return;
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

  private pointAt(entry: Entry | null): void {
    this.hot = entry;
    this.ask();
  }
}
