/* Pointer, wheel and touch on the views. */
"use strict";
(function (parts) {
  const CLICK = 5; // CSS px that a click may wander

  /** Drag to pan, wheel or pinch to zoom, hover and click to find a person. Handlers: pan, zoom, hover, click. */
  function onMap(canvas, handlers) {
    const held = new Map();
    let travelled = 0;
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      handlers.zoom(Math.exp(-0.0016 * lines * event.deltaY), ...at(event));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, at(event));
      if (held.size === 1) travelled = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const now = at(event), before = held.get(event.pointerId);
      if (!before) return handlers.hover(...now);
      const others = [...held].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      held.set(event.pointerId, now);
      travelled += Math.hypot(now[0] - before[0], now[1] - before[1]);
      if (others.length) pinch(before, now, others[0]);
      else if (travelled > CLICK) handlers.pan(now[0] - before[0], now[1] - before[1]);
    });
    const pinch = (before, now, other) => {
      const apart = ([x, y]) => Math.hypot(x - other[0], y - other[1]) || 1;
      handlers.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
      handlers.zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    };
    const release = (event) => {
      const was = held.delete(event.pointerId);
      if (was && event.type === "pointerup" && travelled <= CLICK) handlers.click(...at(event));
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", () => handlers.hover(-1, -1));
  }

  /** Hover and click on a view that does not move. */
  function onView(canvas, handlers) {
    canvas.addEventListener("pointermove", (event) => handlers.hover(event.offsetX, event.offsetY));
    canvas.addEventListener("pointerleave", () => handlers.hover(-1, -1));
    canvas.addEventListener("click", (event) => handlers.click(event.offsetX, event.offsetY));
  }

  /** Click or drag along the strip. */
  function onStrip(canvas, jump) {
    const go = (event) => { if (event.buttons) jump(event.offsetX); };
    canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); go(event); });
    canvas.addEventListener("pointermove", go);
  }

  Object.assign(parts, { onMap, onView, onStrip });
})(vbbench.player.parts);
