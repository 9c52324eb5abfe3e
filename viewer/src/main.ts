// The page: one store, one clock, one draw.

import { badge, byId, make, press, say } from "./dom";
import { KEYS, type Moment, SPEEDS, readCommand, readMoment, writeMoment } from "./commands";
import { type HexMap, cellName, centre, parseCell, readMap } from "./hex";
import { type Entry, entriesOf, luckOf, signed, spoken } from "./log";
import { paletteOf } from "./palette";
import { type Scene, type Tab, ground, logPanel, mindsOf, piecesPanel, policyPanel } from "./panels";
import { Stage } from "./stage";
import { Game, type Piece } from "./state";
import { CAMPS, type Camp, type View, loadMap, loadStory, viewsOf } from "./story";
import "./style.css";
import { Timeline, markName } from "./timeline";

const GAME = 1;
const DECISION = 75;
const MOST_RATIO = 2; // device pixels a CSS pixel
const FIRE_TICKS = 14;

class Page {
  private games = new Map<View, Game>();
  private game!: Game;
  private map!: HexMap;
  private stage!: Stage;
  private timeline!: Timeline;
  private entries = new Map<View, Entry[]>();
  private time = 0;
  private speed = 16;
  private playing = false;
  private picked: Piece | null = null;
  private cell = -1;
  private hover = -1;
  private tab: Tab = "pieces";
  private hot: Entry | null = null;
  private follow = false;
  private muted = false;
  private on = { los: false, ranges: false, beliefs: true, policy: true, fog: true };
  private dark = matchMedia("(prefers-color-scheme: dark)").matches;
  private readonly still = matchMedia("(prefers-reduced-motion: reduce)");
  private asked = 0; // number of the frame that was asked for
  private before = 0; // time of the last frame
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
    this.buildHeader(views);
    this.buildLayers();
    this.buildTabs();
    this.buildKeys();
    this.listen();
    this.stage.resize(this.ratio);
    this.go(moment);
    this.stage.frame(this.scene());
    this.draw(performance.now());
    performance.mark("first frame");
    new ResizeObserver(() => this.resized()).observe(byId("stage"));
  }

  // --- the store ----------------------------------------------------------------------------------

  private get ratio(): number {
    return Math.min(MOST_RATIO, window.devicePixelRatio || 1);
  }

  private list(): Entry[] {
    return this.entries.get(this.game.view) ?? [];
  }

  private curves() {
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

  private get luck() {
    const game = this.games.get("referee");
    this.lucky ??= game ? { red: luckOf(game, "red"), blue: luckOf(game, "blue") } : {};
    return this.lucky;
  }

  private lucky: Scene["luck"] | undefined;

  private go(moment: Moment): void {
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

  private tick(now: number): void {
    this.asked = 0;
    if (this.playing) this.advance(Math.min(250, now - this.before));
    this.before = now;
    this.draw(now);
    if (this.playing) this.ask();
  }

  private advance(ms: number): void {
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

  private step(direction: 1 | -1): void {
    const now = Math.floor(this.time);
    const ticks = this.list().filter((one) => one.group === "fire" || one.shape === "sight").map((one) => one.tick);
    const next = direction > 0 ? ticks.find((tick) => tick > now) : ticks.filter((tick) => tick < now).pop();
    this.seek(next ?? (direction > 0 ? this.game.last : 0));
  }

  private decide(): void {
    const now = Math.floor(this.time);
    const ticks = CAMPS.flatMap((camp) => this.game.story.policy[camp]?.decisions.map(([tick]) => tick) ?? []);
    const next = ticks.filter((tick) => tick > now).sort((a, b) => a - b)[0];
    this.seek(next ?? (Math.floor(now / DECISION) + 1) * DECISION);
  }

  private setSpeed(speed: number): void {
    this.speed = speed;
    this.noteMoment();
    this.ask();
  }

  private faster(by: 1 | -1): void {
    const k = SPEEDS.indexOf(this.speed) + by;
    this.setSpeed(SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, k))]);
  }

  private noteMoment(): void {
    try {
      history.replaceState(null, "", writeMoment(this.moment()));
    } catch {
      // a page within a page has no address of its own
    }
  }

  // --- drawing ------------------------------------------------------------------------------------

  private draw(now: number): void {
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

  private minds(): number[] {
    const key = `${this.game.view} ${this.picked?.index}`;
    if (this.mindKey !== key) [this.mindKey, this.mindTicks] = [key, mindsOf(this.game, this.picked)];
    return this.mindTicks;
  }

  private mindKey = "";
  private mindTicks: number[] = [];

  private drawTexts(scene: Scene, now: number): void {
    const { state } = scene;
    this.drawScore(scene);
    const clock = byId("clock");
    const minutes = `${Math.floor(state.tick / 60)}:${String(state.tick % 60).padStart(2, "0")}`;
    if (clock.dataset.tick !== String(state.tick)) {
      clock.dataset.tick = String(state.tick);
      clock.replaceChildren("tick ", make("b", {}, String(state.tick)), make("span", { class: "of" }, ` of ${this.game.story.game_ticks}  (${minutes})`));
    }
    say(byId("speed"), `${this.speed}×`);
    const slider = byId("timeline");
    slider.setAttribute("aria-valuemax", String(this.game.last));
    slider.setAttribute("aria-valuenow", String(state.tick));
    slider.setAttribute("aria-valuetext", `tick ${state.tick}, ${this.marginText(scene)}`);
    if (this.playing && now - this.panelled < 120) return; // the panel follows at a pace that can be read
    this.panelled = now;
    this.drawPanel(scene);
  }

  private panelled = 0;

  private drawPanel(scene: Scene): void {
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

  private drawScore(scene: Scene): void {
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

  private chase(scene: Scene): void {
    const shown = this.picked ? scene.state.pieces[this.picked.index] : null;
    if (!shown || shown.cell < 0) return;
    const { camera } = this.stage;
    const at = camera.toScreen(shown.at);
    camera.pan((camera.width / 2 - at.x) * 0.15, (camera.height / 2 - at.y) * 0.15);
    if (Math.hypot(camera.width / 2 - at.x, camera.height / 2 - at.y) > 2 && !this.playing) this.ask();
  }

  private resized(): void {
    this.stage.resize(this.ratio);
    this.stage.renew(this.scene());
    this.ask();
  }

  // --- words --------------------------------------------------------------------------------------

  private marginText(scene: Scene): string {
    const known = this.game.view === "referee" ? "margin" : "margin as known";
    const margins = CAMPS.filter((camp) => scene.state.margin[camp] !== undefined);
    return `${known} ${margins.map((camp) => `${camp} ${signed(scene.state.margin[camp] ?? 0)}`).join(", ")}`;
  }

  private announce(before = ""): void {
    const scene = this.scene();
    const happened = this.list().filter((one) => one.tick === scene.state.tick && one.group !== "orders").map((one) => one.text);
    const said = [before, `Tick ${scene.state.tick}`, this.marginText(scene), ...happened.slice(0, 3)].filter(Boolean).join(". ");
    say(byId("live"), said);
    const alive = CAMPS.map((camp) => `${scene.state.pieces.filter((one) => one.piece.camp === camp && one.blood > 0).length} ${camp}`);
    byId("terrain").setAttribute("aria-label", `Map ${this.map.name}, tick ${scene.state.tick}: pieces ${alive.join(", ")}; ${this.marginText(scene)}`);
  }

  // --- building -----------------------------------------------------------------------------------

  private buildHeader(views: View[]): void {
    const { story } = this.game;
    const side = (camp: Camp) => {
      const { name, kind } = story.players[camp];
      const who = make("span", { class: "who" }, make("bdi", { class: "name", title: name }, name), make("span", { class: "kind" }, `${camp}${kind ? `, ${kind}` : ""}`));
      const margin = make("span", { class: "margin", id: `margin-${camp}` });
      return make("div", { class: `side ${camp}` }, badge(camp, camp[0].toUpperCase()), who, margin);
    };
    const what = make("span", { class: "what", id: "what", title: story.seed ? `seed ${story.seed}` : "" });
    byId("score").replaceChildren(side("red"), make("span", { class: "versus" }, "against"), side("blue"), what);
    for (const [k, view] of views.entries()) {
      const button = make("button", { type: "button", id: `view-${view}`, title: `${k + 1}` }, view[0].toUpperCase() + view.slice(1));
      button.addEventListener("click", () => void this.show(view));
      byId("views").append(button);
    }
  }

  private buildLayers(): void {
    const names: [string, string, string][] = [
      ["beliefs", "Beliefs", "b"], ["fog", "Fog", "g"], ["los", "Sight", "l"], ["ranges", "Ranges", "r"], ["follow", "Follow", "f"],
    ];
    for (const [name, text, key] of names) {
      const button = make("button", { type: "button", id: `on-${name}`, title: `${text} (${key})` }, text);
      button.addEventListener("click", () => this.toggle(name));
      byId("layers").append(button);
    }
  }

  private toggle(name: string): void {
    if (name === "follow") this.follow = !this.follow;
    else if (name in this.on) this.on[name as keyof typeof this.on] = !this.on[name as keyof typeof this.on];
    this.ask();
  }

  private buildTabs(): void {
    for (const [tab, text] of [["pieces", "Pieces"], ["log", "Log"], ["policy", "Policy"]] as [Tab, string][]) {
      const button = make("button", { type: "button", role: "tab", id: `tab-${tab}`, "aria-controls": "panel" }, text);
      button.addEventListener("click", () => this.open_(tab));
      byId("tabs").append(button);
    }
  }

  private open_(tab: Tab): void {
    this.tab = tab;
    byId("panel").dataset.key = "";
    this.ask();
  }

  private buildKeys(): void {
    const rows = KEYS.map(([key, says]) => make("div", { class: "key" }, make("kbd", {}, key), make("span", {}, says)));
    const shapes = ["hit", "dead", "point", "sight", "round", "refused"].map(markName).join(", ");
    const close = make("button", { type: "button" }, "Close");
    const dialog = byId<HTMLDialogElement>("keys");
    close.addEventListener("click", () => dialog.close());
    dialog.replaceChildren(
      make("h2", {}, "Keys"),
      make("div", { class: "columns" }, ...rows),
      make("p", { class: "small soft" }, `Squares are red, discs are blue; T tank, C chariot, S soldier, A aerocraft. A dashed rim hides, a triangle is suppressed, a pale token is where a side believes an enemy to be, with the ticks since it saw it. Marks of the timeline: ${shapes}. Fog lies where a vehicle that does not hide would not be seen.`),
      close,
    );
  }

  // --- listening ----------------------------------------------------------------------------------

  private listen(): void {
    const clicks: Record<string, () => void> = {
      play: () => this.play(!this.playing), previous: () => this.step(-1), next: () => this.step(1), decision: () => this.decide(),
      speed: () => this.setSpeed(SPEEDS[(SPEEDS.indexOf(this.speed) + 1) % SPEEDS.length]), share: () => void this.share(),
      theme: () => this.setDark(!this.dark), help: () => byId<HTMLDialogElement>("keys").showModal(),
      closer: () => this.zoom(1.5), farther: () => this.zoom(1 / 1.5), whole: () => this.whole(),
    };
    for (const [id, act] of Object.entries(clicks)) byId(id).addEventListener("click", act);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => this.setDark(event.matches));
    document.addEventListener("visibilitychange", () => document.hidden && this.playing && this.play(false));
    window.addEventListener("hashchange", () => {
      const moment = readMoment(location.hash);
      this.go(moment);
      if (moment.view && viewsOf(GAME).includes(moment.view)) void this.show(moment.view);
      this.ask();
    });
    window.addEventListener("keydown", (event) => this.key(event));
    byId("command").addEventListener("blur", () => (byId("line").hidden = true));
    this.listenMap();
    this.listenTimeline();
  }

  private setDark(dark: boolean): void {
    this.dark = dark;
    document.documentElement.classList.toggle("dark", dark);
    this.stage.renew(this.scene());
    byId("panel").dataset.key = "";
    this.ask();
  }

  private zoom(factor: number): void {
    const { camera } = this.stage;
    camera.zoom(factor, { x: camera.width / 2, y: camera.height / 2 });
    this.ask();
  }

  private whole(): void {
    this.stage.camera.fit();
    this.ask();
  }

  private async share(): Promise<void> {
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

  private flash(text: string): void {
    say(byId("readout"), text);
  }

  private pick(piece: Piece | null, cell = -1): void {
    this.picked = piece;
    this.cell = cell;
    if (this.tab === "log") this.tab = "pieces";
    byId("panel").dataset.key = "";
    this.noteMoment();
    this.ask();
  }

  private pointAt(entry: Entry | null): void {
    this.hot = entry;
    this.ask();
  }

  private listenMap(): void {
    const canvas = byId<HTMLCanvasElement>("terrain");
    const fingers = new Map<number, { x: number; y: number }>();
    let moved = 0;
    const place = (event: PointerEvent | WheelEvent) => {
      const box = canvas.getBoundingClientRect();
      return { x: event.clientX - box.left, y: event.clientY - box.top };
    };
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.stage.camera.zoom(Math.exp(-event.deltaY * 0.0016), place(event));
      this.ask();
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, place(event));
      moved = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const here = place(event);
      const last = fingers.get(event.pointerId);
      if (!last) return this.hovered(here);
      const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      moved += Math.hypot(here.x - last.x, here.y - last.y);
      if (others.length === 1) {
        const [a] = others;
        this.stage.camera.zoom(Math.hypot(here.x - a.x, here.y - a.y) / Math.max(1, Math.hypot(last.x - a.x, last.y - a.y)), a);
      } else if (moved > 4) {
        this.follow = false;
        this.stage.camera.pan(here.x - last.x, here.y - last.y);
      }
      fingers.set(event.pointerId, here);
      this.ask();
    });
    const lift = (event: PointerEvent) => {
      const here = place(event);
      if (fingers.delete(event.pointerId) && moved <= 4 && event.type === "pointerup") {
        const token = this.stage.tokenAt(here);
        const cell = this.stage.cellAt(here, this.game);
        this.pick(token?.shown.piece ?? null, token ? -1 : cell);
      }
    };
    canvas.addEventListener("pointerup", lift);
    canvas.addEventListener("pointercancel", lift);
    canvas.addEventListener("pointerleave", () => {
      this.hover = -1;
      say(byId("readout"), "");
      this.ask();
    });
  }

  private hovered(here: { x: number; y: number }): void {
    const cell = this.stage.cellAt(here, this.game);
    if (cell === this.hover) return;
    this.hover = cell;
    const { map } = this;
    const text = cell < 0 ? "" : `${cellName(map, cell)}  ${map.level[cell] * map.gradeM} m  ${ground(map.bits[cell])}`;
    const token = this.stage.tokenAt(here);
    say(byId("readout"), token ? `${spoken(token.shown.piece.name)}  ${text}` : text);
    if (this.picked || this.cell >= 0) this.ask();
  }

  private listenTimeline(): void {
    const canvas = this.timeline.canvas;
    const tip = byId("tip");
    let start = -1;
    const at = (event: PointerEvent) => this.timeline.tickAt(event.clientX - canvas.getBoundingClientRect().left);
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      start = at(event);
      if (!event.shiftKey) this.seek(this.timeline.near(start) && event.pointerType === "mouse" ? this.snapped(start, event) : start);
    });
    canvas.addEventListener("pointermove", (event) => {
      const tick = at(event);
      this.timeline.hover = tick;
      if (start >= 0 && event.shiftKey) this.timeline.loop = [Math.min(start, tick), Math.max(start, tick) + 1];
      else if (start >= 0) this.seek(tick);
      const near = this.timeline.near(tick);
      tip.hidden = false;
      say(tip, near ? `${near.tick}: ${near.text}` : `tick ${tick}`);
      const box = canvas.getBoundingClientRect();
      tip.style.left = `${Math.max(6, Math.min(window.innerWidth - tip.offsetWidth - 8, event.clientX + 10))}px`;
      tip.style.top = `${box.top - tip.offsetHeight - 6}px`;
      this.ask();
    });
    canvas.addEventListener("pointerup", () => (start = -1));
    canvas.addEventListener("pointerleave", () => {
      this.timeline.hover = -1;
      tip.hidden = true;
      this.ask();
    });
  }

  /** A click on a mark goes to its tick. */
  private snapped(tick: number, event: PointerEvent): number {
    const low = event.offsetY > this.timeline.canvas.clientHeight - 46;
    return low ? (this.timeline.near(tick)?.tick ?? tick) : tick;
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.target instanceof HTMLInputElement) {
      if (event.key === "Enter") this.command();
      else if (event.key === "Escape") byId("line").hidden = true;
      return;
    }
    if (byId<HTMLDialogElement>("keys").open) return;
    const acts: Record<string, () => void> = {
      " ": () => this.play(!this.playing), n: () => this.step(1), p: () => this.step(-1), d: () => this.decide(),
      ArrowRight: () => this.seek(this.time + (event.shiftKey ? DECISION : 1)), ArrowLeft: () => this.seek(this.time - (event.shiftKey ? DECISION : 1)),
      Home: () => this.seek(0), End: () => this.seek(this.game.last), "[": () => this.faster(-1), "]": () => this.faster(1),
      l: () => this.toggle("los"), r: () => this.toggle("ranges"), b: () => this.toggle("beliefs"), g: () => this.toggle("fog"),
      f: () => this.toggle("follow"), q: () => this.open_("policy"), m: () => (this.muted = !this.muted), c: () => void this.share(),
      x: () => (this.timeline.loop = null), "+": () => this.zoom(1.5), "=": () => this.zoom(1.5), "-": () => this.zoom(1 / 1.5), "0": () => this.whole(),
      "/": () => this.type(), "?": () => byId<HTMLDialogElement>("keys").showModal(), Escape: () => this.pick(null),
    };
    viewsOf(GAME).forEach((view, k) => (acts[String(k + 1)] = () => void this.show(view)));
    const act = acts[event.key];
    if (!act || (event.key === " " && event.target instanceof HTMLButtonElement)) return;
    event.preventDefault();
    act();
    this.ask();
  }

  private type(): void {
    byId("line").hidden = false;
    const input = byId<HTMLInputElement>("command");
    input.value = "";
    input.focus();
  }

  private command(): void {
    const text = byId<HTMLInputElement>("command").value;
    const camp = this.game.view === "blue" ? "blue" : "red";
    const command = readCommand(text, this.game, this.map, camp);
    byId("line").hidden = true;
    byId("terrain").focus();
    if (command.kind === "seek") this.seek(command.tick);
    else if (command.kind === "pick") this.pick(command.piece);
    else if (command.kind === "cell") {
      this.pick(null, command.cell);
      this.stage.camera.show([centre(this.map, command.cell)], 12);
    } else if (command.kind === "view") void this.show(command.view);
    else if (command.kind === "speed") this.setSpeed(command.speed);
    else if (command.kind === "help") byId<HTMLDialogElement>("keys").showModal();
    else this.flash(`not understood: ${command.text.slice(0, 40)}`);
  }

  // --- for tests ----------------------------------------------------------------------------------

  /** What is drawn at a tick, in the names of the replay. */
  at(tick: number) {
    const { game } = this;
    const state = game.at(tick);
    const name = (cell: number) => (cell < 0 ? null : cellName(this.map, cell));
    return {
      tick: state.tick, margin: state.margin, owners: state.owners,
      pieces: state.pieces.map((one) => [one.piece.name, name(one.cell), one.blood, Number(one.hidden), Number(one.suppressed), one.carrier < 0 ? null : game.pieces[one.carrier].short]),
      sees: state.pieces.map((one) => game.seenBy(one.piece, state.tick).map((seer) => seer.name)),
      beliefs: Object.fromEntries(CAMPS.filter((camp) => game.story.beliefs[camp]).map((camp) => [camp, game.pieces.filter((piece) => piece.camp !== camp).map((piece) => {
        const known = game.believed(piece, tick);
        return [piece.name, known.how, name(known.cell), known.blood, known.age];
      })])),
    };
  }
}

const page = new Page();
const ready = page.open();
Object.assign(window, { hexwar: { ready, at: (tick: number) => page.at(tick), show: (view: View) => page.show(view), seek: (tick: number) => page.seek(tick), play: (on: boolean) => page.play(on), costs: page.costs } });
