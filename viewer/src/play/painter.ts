// One frame of a game that is played: the map with the plans on it, the texts around it, the open panel.

import { byId, press, say } from "../dom";
import { centre } from "../hex";
import { signed } from "../log";
import { logPanel } from "../logpanel";
import { piecesPanel } from "../piecespanel";
import type { Scene } from "../scene";
import type { Overlay } from "../stage";
import { CAMPS } from "../story";
import { sayStanding } from "./desk";
import { hintsPanel } from "./hintspanel";
import { ordersPanel } from "./orderspanel";
import { type MortarPaths, mortarPaths, overlayOf } from "./plandraw";
import type { Play } from "./play";
import { showTray } from "./tray";
import { shotsOf, waysOf } from "./ways";

const FIRE_TICKS = 14;
const NARROW = 600; // pixels of a map that has no room for sentences
const PANEL_MS = 250; // while the clock runs the panels follow at a pace that can be read

export class Painter {
  private panelled = 0; // time of the last panel
  private mortarDrawn: MortarPaths | null = null;

  constructor(private readonly play: Play) {}

  /** The panel is drawn with the next frame. */
  hurry(): void {
    this.panelled = 0;
  }

  draw(now: number): void {
    const start = performance.now();
    const scene = this.play.scene();
    if (this.play.follow) this.chase(scene);
    const policy = this.play.tab === "hints";
    const { speed } = this.play.session.state.clock;
    const hot = this.play.hot && this.play.hot.to >= 0 ? { shape: "arrow" as const, from: this.play.hot.from, to: this.play.hot.to } : null;
    this.play.stage.draw(scene, { ...this.play.on, beliefs: true, policy: policy && this.play.picked !== null, fireTicks: Math.max(FIRE_TICKS, speed * 0.9) }, hot, this.overlay(scene));
    this.play.timeline.loop = null;
    this.play.timeline.draw(scene.time, scene.palette, this.play.ratio, false);
    this.drawTexts(scene, now);
    this.play.costs.push(performance.now() - start);
    if (this.play.costs.length > 2000) this.play.costs.splice(0, 1000);
  }

  private overlay(scene: Scene): Overlay {
    const { camp, map } = this.play.session;
    const aim = this.play.aimed >= 0 ? this.play.aimAt(this.play.aimed, this.play.then) : null;
    const bare = aim && { from: centre(map, aim.cell), cells: [], lines: aim.lines, eyes: [], end: aim.cell };
    const preview = aim?.preview ?? bare;
    const inTray = this.play.hover < 0 && this.play.stage.camera.width < NARROW; // the tray says it, and there is no room for it twice
    return overlayOf({
      map, palette: scene.palette, colour: scene.palette.camp[camp],
      ways: this.play.looking ? [] : waysOf(this.play), shots: this.play.looking ? [] : shotsOf(this.play),
      preview: preview && inTray ? { ...preview, lines: [] } : preview, cursor: this.play.cursor, mortar: this.mortarLayer(),
    });
  }

  private mortarLayer(): MortarPaths | null {
    if (!this.play.mortar || !this.play.canOrder) return null;
    const groups = this.play.lookHere()?.mortar ?? [];
    const cells = groups.flatMap((group) => group.cells.map((cell): [number, number] => [cell, group.class]));
    const key = `${this.play.picked?.index} ${this.play.place} ${cells.length} ${cells.map(([cell, one]) => cell * 3 + one).reduce((a, b) => (a * 31 + b) % 1_000_000_007, 7)}`;
    if (this.mortarDrawn?.key !== key) this.mortarDrawn = mortarPaths(this.play.session.map, key, cells);
    return this.mortarDrawn;
  }

  private drawTexts(scene: Scene, now: number): void {
    const { clock } = this.play.session.state;
    const tick = Math.floor(this.play.time);
    for (const camp of CAMPS) {
      const margin = scene.state.margin[camp];
      if (margin !== undefined) say(byId(`margin-${camp}`), signed(margin));
    }
    say(byId("tick"), String(tick));
    say(byId("of"), ` of ${clock.end}  (${Math.floor(tick / 60)}:${String(tick % 60).padStart(2, "0")})`);
    say(byId("speed"), `${this.play.speed}×`);
    byId("back").hidden = !this.play.looking;
    byId("play").classList.toggle("on", clock.running);
    byId("play").setAttribute("aria-label", clock.running ? "Pause" : "Run");
    for (const id of ["play", "one", "event", "decision", "speed"]) byId<HTMLButtonElement>(id).disabled = !this.play.session.commands;
    sayStanding(this.play);
    const slider = byId("timeline");
    slider.setAttribute("aria-valuemax", String(this.play.session.tick));
    slider.setAttribute("aria-valuenow", String(tick));
    slider.setAttribute("aria-valuetext", `tick ${tick}`);
    showTray(this.play);
    if (clock.running && now - this.panelled < PANEL_MS) return;
    this.panelled = now;
    this.drawPanel(scene);
  }

  private drawPanel(scene: Scene): void {
    const panel = byId("panel");
    if (this.play.tab === "orders") ordersPanel(panel, this.play);
    else if (this.play.tab === "pieces") piecesPanel(panel, scene);
    else if (this.play.tab === "log") logPanel(panel, scene, true);
    else hintsPanel(panel, this.play, scene);
    for (const button of byId("tabs").children) button.setAttribute("aria-selected", String(button.id === `tab-${this.play.tab}`));
    for (const name of ["los", "ranges", "fog"] as const) press(byId(`on-${name}`), this.play.on[name]);
    press(byId("on-follow"), this.play.follow);
    press(byId("on-mortar"), this.play.mortar);
  }

  private chase(scene: Scene): void {
    const shown = this.play.picked ? scene.state.pieces[this.play.picked.index] : null;
    if (!shown || shown.cell < 0) return;
    const { camera } = this.play.stage;
    const at = camera.toScreen(shown.at);
    camera.pan((camera.width / 2 - at.x) * 0.15, (camera.height / 2 - at.y) * 0.15);
    if (Math.hypot(camera.width / 2 - at.x, camera.height / 2 - at.y) > 2) this.play.ask();
  }
}
