// Opens the page; what tests need of it is `window.hexwar`.

import { byId } from "./dom";
import { cellName } from "./hex";
import { Page } from "./page";
import { CAMPS, type View } from "./story";
import "./style.css";

/** What is drawn at a tick, in the names of the replay. */
function at(page: Page, tick: number) {
  const { game } = page;
  const state = game.at(tick);
  const name = (cell: number) => (cell < 0 ? null : cellName(page.map, cell));
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

const page = new Page();
page.open().catch((problem: unknown) => {
  byId("fallback").className = "now"; // no DecompressionStream, or no canvas
  throw problem;
});
Object.assign(window, {
  hexwar: {
    at: (tick: number) => at(page, tick), show: (view: View) => page.show(view), seek: (tick: number) => page.seek(tick),
    play: (on: boolean) => page.play(on), costs: page.costs,
    open: (...numbers: number[]) => page.choose(numbers), parting: () => page.parting,
    frame: (time: number, now: number) => page.drawAt(time, now),
    tokens: () => page.stages.filter((stage) => stage.isShown).map((stage) => stage.places),
  },
});
