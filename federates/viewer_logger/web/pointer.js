// Fingers and mouse on the map: what moves it, turns it, drags a label, picks a target.

import { nameOf } from "./wishes.js";

/** Has `map` follow what happens on its canvas. */
export function listen(map) {
  const { canvas } = map, pointers = new Map();
  let moved = 0, pinch = 0, label = null;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, at(event));
    moved = 0;
    map.held = true;
    label = pointers.size === 1 ? map.labelAt(...at(event)) : null;
  });
  canvas.addEventListener("pointermove", (event) => {
    const here = at(event);
    map.onPointer?.(map.toMetres(...here));
    const last = pointers.get(event.pointerId);
    if (!last) {
      canvas.style.cursor = map.pick(...here) ? "pointer" : "grab";
      return;
    }
    pointers.set(event.pointerId, here);
    if (pointers.size === 2) {
      const [a, b] = [...pointers.values()], apart = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (pinch) map.zoom(apart / pinch, (a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
      pinch = apart;
      moved = 99;
      return;
    }
    const dx = here[0] - last[0], dy = here[1] - last[1];
    moved += Math.hypot(dx, dy);
    if (moved <= 4) return;
    canvas.style.cursor = "grabbing";
    if (label) map.dragLabel(label, dx, dy);
    else map.pan(dx, dy);
  });
  const up = (event) => {
    pinch = 0;
    label = null;
    map.held = pointers.size > 1;
    if (moved > 4) map.rest();
    if (pointers.delete(event.pointerId) && event.type === "pointerup" && moved <= 4) {
      const here = at(event);
      map.onPick?.(map.pick(...here)?.id ?? null, map.toMetres(...here));
    }
    canvas.style.cursor = "grab";
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => map.onPointer?.(null));
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const step = event.deltaY * (event.deltaMode ? 33 : 1);
    if (map.turning) map.rotate(step * 0.05);
    else map.zoom(Math.exp(-step * 0.0015), ...at(event));
  }, { passive: false });
  canvas.addEventListener("dblclick", (event) => {
    const free = map.labelAt(...at(event));
    if (free && map.dragged.delete(nameOf(free.item.target))) {
      map.onDragged?.(map.dragged);
      map.need("place");
    } else map.zoom(2, ...at(event));
  });
}
