// Opens the page of a game that is played; what tests need of it is `window.hexwar`.

import { buildDesk, showFirst } from "./desk";
import { listen } from "./hands";
import { Play } from "./play";
import { centre } from "../hex";
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
    /** Where a cell is on the screen. */
    place: (cell: number) => {
      const box = document.getElementById("terrain")?.getBoundingClientRect();
      const at = play.stage.camera.toScreen(centre(play.session.map, cell));
      return { x: at.x + (box?.x ?? 0), y: at.y + (box?.y ?? 0) };
    },
    token: (name: string) => {
      const box = document.getElementById("terrain")?.getBoundingClientRect();
      const piece = play.session.game.byName(name);
      const at = piece && play.stage.placeOf(piece.index);
      return at ? { x: at.x + (box?.x ?? 0), y: at.y + (box?.y ?? 0) } : null;
    },
    session: () => play.session, costs: play.costs, state: () => play.scene().state,
    zoomTo: (cells: number[], room: number) => {
      play.stage.camera.show(cells.map((cell) => centre(play.session.map, cell)), room);
      play.ask();
    },
  },
});
