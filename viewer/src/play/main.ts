// Opens the page of a game that is played; what tests need of it is `window.hexwar`.

import { byId } from "../dom";
import { type Point, centre, parseCell } from "../hex";
import { buildDesk, showFirst } from "./desk";
import { listen } from "./hands";
import { Play } from "./play";

import "../style.css";
import "./play.css";

const play = new Play();
document.documentElement.classList.toggle("dark", play.dark);
play.onBegin = () => {
  if (play.session.tick === 0 && play.session.commands) showFirst();
};
buildDesk(play);
listen(play);
void play.link.start();
Object.assign(window, {
  hexwar: {
    session: () => play.session, state: () => play.scene().state, costs: play.costs,
    aimed: () => (play.aimed < 0 ? null : play.aimAt(play.aimed, play.then)),
    mortarCells: () => play.lookHere()?.mortar.flatMap((group) => group.cells).length ?? 0,
    placeOf: (name: string) => onScreen(play.stage.camera.toScreen(centre(play.session.map, parseCell(play.session.map, name)))),
    token: (name: string) => {
      const piece = play.session.game.byName(name);
      return onScreen(piece ? play.stage.placeOf(piece.index) : null);
    },
    show: (names: string[], room: number) => {
      play.stage.camera.show(names.map((name) => centre(play.session.map, parseCell(play.session.map, name))), room);
      play.ask();
    },
  },
});

/** A place of the map's canvas, in the coordinates of the window. */
function onScreen(at: Point | null): Point | null {
  const box = byId("terrain").getBoundingClientRect();
  return at && { x: at.x + box.x, y: at.y + box.y };
}
