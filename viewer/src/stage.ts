// The four layers of the map, the camera, and the pointer on them.

import { Camera } from "./camera";
import { Fog } from "./fog";
import { type Point, cellAt, centre, extent } from "./hex";
import { byId } from "./dom";
import { Labels } from "./labels";
import { Sight } from "./los";
import {
  type SightPaths, arrow, drawCell, drawError, drawEye, drawEyes, drawFire, drawPath, drawPoints, drawRanges, drawReach, drawRounds, drawSight, sightPaths,
} from "./marks";
import { decisionOf, taskCell } from "./policypanel";
import type { Scene } from "./scene";
import { fade } from "./palette";
import type { Game, Shown } from "./state";
import { CAMPS, type Camp } from "./story";
import { Terrain } from "./terrain";
import { type Token, drawTokens, drawWrecks, knowBlood, tokenSize, tokensOf } from "./tokens";

const LAYERS = ["terrain", "fog", "marks", "pieces"] as const;
const SETTLES_MS = 150; // after a zoom or a pan the terrain is drawn anew
const BUTTON = 48; // pixels of a row of buttons
const BELIEF_CELLS = 0.5; // a ghost on its piece is not worth a mark

export interface Choices {
  los: boolean;
  ranges: boolean;
  beliefs: boolean;
  policy: boolean;
  fog: boolean;
  fireTicks: number; // how long fire is shown
}

/** What a page draws itself: on the ground, between fog and pieces, and above them. It has the paths of the pieces, too. */
export interface Overlay {
  ground(ctx: CanvasRenderingContext2D, stage: Stage): void;
  below(ctx: CanvasRenderingContext2D, stage: Stage): void;
  above(ctx: CanvasRenderingContext2D, stage: Stage): void;
}

export class Stage {
  readonly camera: Camera;
  readonly sight: Sight;
  private readonly terrain: Terrain;
  private fog: Fog | null = null;
  private readonly contexts: Record<(typeof LAYERS)[number], CanvasRenderingContext2D>;
  private timer = 0;
  private tokens: Token[] = [];
  private placed = ""; // camera of the last frame
  private drawn = false; // the terrain, at all
  isShown = true; // of two games one may have no room; asked at a new size, as the answer takes its time

  /** k: 0 of the one game, or of the first; 1 of the game beside it, which is looked at through the same camera. */
  constructor(
    game: Game,
    private readonly redraw: () => void,
    private readonly k = 0,
    camera?: Camera,
  ) {
    this.camera = camera ?? new Camera(extent(game.map));
    this.sight = new Sight(game.map, game.story.rules.air_height_m);
    this.terrain = new Terrain(game.map);
    this.contexts = Object.fromEntries(LAYERS.map((id) => [id, context(byId<HTMLCanvasElement>(id + this.suffix))])) as typeof this.contexts;
    knowBlood(game);
  }

  private get suffix(): string {
    return this.k > 0 ? `-${this.k + 1}` : "";
  }

  /** The layers, the lowest first. */
  get canvases(): HTMLCanvasElement[] {
    return LAYERS.map((id) => this.contexts[id].canvas);
  }

  /** It draws no more: another game is shown. */
  drop(): void {
    window.clearTimeout(this.timer);
  }

  forget(): void {
    this.terrain.forget();
    this.placed = "";
  }

  resize(ratio: number): void {
    const { clientWidth, clientHeight } = byId(`stage${this.suffix}`);
    this.isShown = clientWidth > 0;
    if (!this.isShown) return;
    for (const id of LAYERS) {
      const canvas = this.contexts[id].canvas;
      canvas.width = Math.round(clientWidth * ratio);
      canvas.height = Math.round(clientHeight * ratio);
    }
    this.camera.resize(clientWidth, clientHeight);
    this.labels.free = this.covered();
    this.forget();
  }

  /** The pieces and points of what is shown, with room; unless one looks closely all of the map where there is room for it. */
  frame(scenes: Scene[], closely = false): void {
    this.camera.fit();
    this.labels.free = this.covered();
    if (this.camera.scale >= 9.5 && !closely) return;
    const { map, story } = scenes[0].game;
    const pieces = scenes.flatMap(({ state }) => state.pieces.filter((one) => one.cell >= 0 && one.blood > 0).map((one) => one.at));
    this.camera.show([...pieces, ...story.points.map(([, cell]) => centre(map, cell))], 3, this.labels.free);
  }

  /** How much of it lies under buttons and texts, above and below. */
  private covered(): [number, number] {
    const height = this.camera.height;
    const boxes = ["layers", "zoom", "last"].map((id) => document.getElementById(id)).flatMap((one) => (one?.offsetHeight ? [one] : []));
    const above = boxes.filter((one) => one.offsetTop < height / 4).map((one) => one.offsetTop + Math.min(one.offsetHeight, BUTTON));
    const below = boxes.filter((one) => one.offsetTop > height / 2).map((one) => height - one.offsetTop);
    return [Math.max(0, ...above), Math.max(0, ...below)];
  }

  draw(scene: Scene, choices: Choices, hot: { shape: "arrow"; from: number; to: number } | null, overlay?: Overlay): void {
    const { game, state, palette, ratio, time } = scene;
    const { camera } = this;
    const placed = `${camera.x} ${camera.y} ${camera.scale} ${camera.width} ${camera.height} ${ratio} ${palette.dark}`;
    const moved = placed !== this.placed;
    this.placed = placed;
    if (moved) this.drawTerrain(scene);
    const foggy = game.view !== "referee" && choices.fog;
    if (foggy) this.fog ??= new Fog(game.map, this.sight, game.story.rules); // takes its time: not before the first frame
    const changed = foggy && this.fog?.look(state.pieces.filter((one) => one.how === "own"), palette);
    if (moved || changed || foggy !== this.wasFoggy) this.fog?.blit(this.contexts.fog, camera, ratio, foggy);
    this.wasFoggy = foggy;

    const ghosts = game.view === "referee" && choices.beliefs ? CAMPS.flatMap((camp) => game.ghosts(camp, time)) : [];
    const away = new Set(ghosts.filter((ghost) => this.isAway(ghost, scene)));
    this.tokens = tokensOf(game, state, camera, ghosts, away);
    const marks = this.clear("marks", ratio);
    this.labels.clear();
    overlay?.ground(marks, this);
    this.drawAsked(marks, scene, choices, overlay === undefined);
    drawPoints(marks, game, state, camera, palette, this.tokens, this.labels);
    this.drawBeliefs(marks, scene, away);
    drawRounds(marks, game, state, time, camera, palette);
    overlay?.below(marks, this);
    if (hot) this.drawHot(marks, scene, hot);
    const pieces = this.clear("pieces", ratio);
    drawWrecks(pieces, state, camera, palette);
    drawFire(pieces, game.map, scene.entries, time, choices.fireTicks, camera, palette);
    this.labels.draw(pieces, palette);
    drawTokens(pieces, this.tokens, scene.picked?.index ?? -1, palette);
    overlay?.above(pieces, this);
  }

  private wasFoggy: boolean | null = null;
  private readonly labels = new Labels(); // above the fire

  private drawTerrain(scene: Scene): void {
    const { camera, terrain } = this;
    if (!terrain.fits(camera)) {
      window.clearTimeout(this.timer);
      if (this.drawn) {
        this.timer = window.setTimeout(() => {
          terrain.draw(camera, scene.ratio, scene.palette);
          this.placed = "";
          this.redraw();
        }, SETTLES_MS);
      } else {
        terrain.draw(camera, scene.ratio, scene.palette);
        this.drawn = true;
      }
    }
    terrain.blit(this.contexts.terrain, camera, scene.ratio);
  }

  /** Draw the terrain at once, for a new size or new colours. */
  renew(scene: Scene): void {
    this.terrain.draw(this.camera, scene.ratio, scene.palette);
    this.placed = "";
  }

  private clear(layer: "marks" | "pieces", ratio: number): CanvasRenderingContext2D {
    const ctx = this.contexts[layer];
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.clearRect(0, 0, ctx.canvas.width, ctx.canvas.height);
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    return ctx;
  }

  private isAway(ghost: Shown, scene: Scene): boolean {
    const truth = scene.state.pieces[ghost.piece.index];
    return truth.blood === 0 || truth.carrier >= 0 || Math.hypot(truth.at.x - ghost.at.x, truth.at.y - ghost.at.y) > BELIEF_CELLS;
  }

  private drawAsked(ctx: CanvasRenderingContext2D, scene: Scene, choices: Choices, withPath: boolean): void {
    const { game, state, palette, picked } = scene;
    const shown = picked ? state.pieces[picked.index] : null;
    const from = shown && shown.blood > 0 ? shown.cell : scene.cell;
    if (choices.los && from >= 0) {
      const kind = shown?.piece.kind ?? "tank"; // from a cell as a tank would look
      drawSight(ctx, this.sightFrom(game, from, kind), this.camera, palette);
    } else if (choices.los) drawEyes(ctx, this.eyes(scene), palette);
    if (choices.policy && !picked) for (const one of state.pieces) this.drawChoice(ctx, scene, one, false);
    if (scene.cell >= 0) drawCell(ctx, game.map, scene.cell, this.camera, palette);
    if (!shown || shown.blood === 0 || shown.cell < 0) return;
    for (const enemy of game.seenFrom(shown.piece, state)) drawEye(ctx, this.camera.toScreen(shown.at), this.camera.toScreen(enemy.at), palette);
    if (choices.ranges) drawRanges(ctx, game, shown, this.camera, palette);
    if (withPath) drawPath(ctx, game.map, shown.at, game.path(shown.piece, state.tick), this.camera, palette.camp[shown.piece.camp]);
    if (choices.policy) this.drawChoice(ctx, scene, shown, true);
  }

  /** Who sees whom, between the tokens. */
  private eyes({ game, state }: Scene): [Camp, Point, Point][] {
    const places = new Map(this.tokens.filter((one) => !one.ghost).map((one) => [one.shown.piece.index, one.at]));
    const found: [Camp, Point, Point][] = [];
    for (const { piece, blood, carrier } of state.pieces) {
      const from = places.get(piece.index);
      if (!from || blood === 0 || carrier >= 0) continue;
      for (const enemy of game.seenFrom(piece, state)) {
        const to = places.get(enemy.piece.index);
        if (to) found.push([piece.camp, from, to]);
      }
    }
    return found;
  }

  private sightFrom(game: Game, cell: number, kind: string): SightPaths {
    const key = `${cell} ${kind}`;
    if (this.lookedFrom.key !== key) {
      const field = this.sight.field(cell, game.story.rules.kinds[kind].sight.tank, kind === "aerocraft");
      this.lookedFrom = { key, paths: sightPaths(game.map, field) };
    }
    return this.lookedFrom.paths;
  }

  private lookedFrom: { key: string; paths: SightPaths } = { key: "", paths: { open: [], shut: [], hatch: [] } };

  /** From a piece to where its chosen task leads. */
  private drawChoice(ctx: CanvasRenderingContext2D, scene: Scene, shown: Shown, alone: boolean): void {
    if (shown.blood === 0 || shown.carrier >= 0 || shown.cell < 0) return;
    const decision = decisionOf(scene.game, shown.piece, scene.state.tick);
    if (!decision) return;
    const text = decision.tasks[decision.choice[2][decision.choice[1]]] ?? "";
    const goal = taskCell(scene.game, text);
    const target = goal < -1 ? scene.state.pieces[-2 - goal] : null;
    const place = target ? target.at : goal >= 0 ? centre(scene.game.map, goal) : null;
    if (!place || (target && target.cell < 0)) return;
    const [a, b] = [this.camera.toScreen(shown.at), this.camera.toScreen(place)];
    arrow(ctx, a, b, fade("#ffffff", 0.85), alone ? 6 : 3);
    arrow(ctx, a, b, scene.palette.camp[shown.piece.camp], alone ? 3.2 : 1.4);
    if (alone) this.labels.add(ctx, text, b, tokenSize(this.camera), this.tokens, this.camera);
  }

  private drawBeliefs(ctx: CanvasRenderingContext2D, scene: Scene, away: Set<Shown>): void {
    const { game, state, palette, picked } = scene;
    const lost = game.view === "referee" ? [...away] : state.pieces.filter((one) => one.how === "lost" && one.blood > 0);
    for (const ghost of lost) {
      const chosen = picked === ghost.piece;
      if (game.view !== "referee" || chosen) drawReach(ctx, game, ghost, this.camera, palette, chosen);
      const truth = state.pieces[ghost.piece.index];
      if (game.view !== "referee" || truth.cell < 0) continue;
      const token = this.tokens.find((one) => one.shown === ghost);
      drawError(ctx, token?.at ?? this.camera.toScreen(ghost.at), this.camera.toScreen(truth.at), palette.camp[ghost.piece.camp]);
    }
  }

  private drawHot(ctx: CanvasRenderingContext2D, scene: Scene, hot: { from: number; to: number }): void {
    const { map } = scene.game;
    const to = this.camera.toScreen(centre(map, hot.to));
    if (hot.from >= 0 && hot.from !== hot.to) {
      const from = this.camera.toScreen(centre(map, hot.from));
      arrow(ctx, from, to, fade("#ffffff", 0.9), 7);
      arrow(ctx, from, to, scene.palette.ink, 3.5);
    }
    drawCell(ctx, map, hot.to, this.camera, scene.palette);
  }

  /** The token under a place of the screen. */
  tokenAt(place: Point): Token | null {
    const hits = this.tokens.filter((one) => Math.hypot(one.at.x - place.x, one.at.y - place.y) <= Math.max(one.size + 2, 14));
    return hits.sort((a, b) => Number(a.ghost) - Number(b.ghost))[0] ?? null;
  }

  /** How many tokens lie under a part of the screen. */
  tokensUnder(left: number, top: number, width: number, height: number): number {
    const under = (one: Token) => one.at.x + one.size > left && one.at.x - one.size < left + width && one.at.y + one.size > top && one.at.y - one.size < top + height;
    return this.tokens.filter(under).length;
  }

  /** Where all tokens are drawn on the screen, and how large. */
  get places(): { name: string; x: number; y: number; size: number }[] {
    return this.tokens.map(({ shown, at, size }) => ({ name: shown.piece.name, ...at, size }));
  }

  /** Where a piece is drawn on the screen; null where it is not. */
  placeOf(index: number): Point | null {
    return this.tokens.find((one) => one.shown.piece.index === index)?.at ?? null;
  }

  cellAt(place: Point, game: Game): number {
    return cellAt(game.map, this.camera.toMap(place));
  }
}

function context(canvas: HTMLCanvasElement): CanvasRenderingContext2D {
  const found = canvas.getContext("2d");
  if (!found) throw new Error("no canvas");
  return found;
}
