// Who has no label for lack of room: their number in the corner of the map, their names behind it.

import { element } from "./text.js";

/** Names listed, at most. */
const MOST = 200;

/** Keeps the `details` element `box` at what `map` leaves out; `pick(id)` selects. */
export function hiddenLabels(box, map, pick) {
  const [summary, list] = box.children;
  let shown = "";
  const fill = () => {
    if (!box.open) return;
    const ids = map.hidden.slice(0, MOST), text = ids.join();
    if (text === shown) return;
    shown = text;
    list.replaceChildren(...ids.map((id) => {
      const target = map.find(id), name = target?.callsign || (target?.number === undefined ? "no name" : `#${target.number}`);
      const button = element("button", name, { type: "button" });
      button.addEventListener("click", () => pick(id));
      return button;
    }));
    if (map.hidden.length > MOST) list.append(element("span", `${map.hidden.length - MOST} more`));
  };
  box.addEventListener("toggle", () => {
    shown = "";
    fill();
  });
  map.onHidden = () => {
    const text = `labels hidden: ${map.hidden.length}`;
    if (summary.textContent !== text) summary.textContent = text;
    if (box.hidden === map.hidden.length > 0) box.hidden = !map.hidden.length;
    fill();
  };
}
