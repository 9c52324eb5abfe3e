// A game is opened, or two side by side: their stories are unpacked, and the page is made ready for them.

import { buildGame } from "./build";
import { type Moment, writeMoment } from "./commands";
import { partingOf } from "./compare";
import { byId } from "./dom";
import type { Page } from "./page";
import { Stage } from "./stage";
import { viewsOf } from "./story";
import { Tape } from "./tape";

export async function openGames(page: Page, numbers: number[], moment: Moment): Promise<void> {
  const tapes = numbers.map((number) => new Tape(number, page.entryOf(number), page.entryOf(number)?.views ?? viewsOf(number), (key) => page.mapOf(key)));
  const views = tapes[0].views;
  const first = moment.view && views.includes(moment.view) ? moment.view : views[0];
  await Promise.all(tapes.map((tape) => tape.show(first)));
  page.halt();
  Object.assign(page, { tapes, active: 0, covered: false, time: 0, picked: null, cell: -1, hover: -1, hot: null, mindKey: "" });
  page.parting = tapes.length > 1 ? partingOf(tapes[0].game.story, tapes[1].game.story) : null;
  byId("cover").hidden = true;
  byId("app").hidden = false;
  byId("app").classList.toggle("pair", tapes.length > 1);
  byId("app").classList.remove("second");
  for (const stage of page.stages) stage.drop();
  page.stages = [];
  page.unfold(false);
  for (const [k, tape] of tapes.entries()) page.stages.push(new Stage(tape.game, () => page.ask(), k, page.stages[0]?.camera));
  buildGame(page);
  page.showTimeline();
  byId("panel").dataset.key = "";
  for (const stage of page.stages) stage.resize(page.ratio);
  page.go(moment);
  page.stage.frame(page.scenes());
  page.draw(performance.now());
}

/** Another address: one more step that the browser can take back, or the same step. */
export function noteAddress(moment: Moment, how: "push" | "replace"): void {
  try {
    if (how === "push") history.pushState(null, "", writeMoment(moment));
    else history.replaceState(null, "", writeMoment(moment));
  } catch {
    // a page within a page has no address of its own
  }
}
