/* Colours, from the page's custom properties; shapes of solvers; canvases as sharp as the screen. */
"use strict";
(function (parts) {
  const FALLBACK = { ink: "#1b1f24", paper: "#ffffff", faint: "#6b7280", line: "#d7dbe0", accent: "#0b62c4", warn: "#8a5a00" };
  const SHAPES = ["square", "triangle", "diamond", "kite", "plus", "cross", "pentagon", "hexagon"];

  /** The colours of now; `people` [K] are those of a palette { light, dark } that the slots [K] name. */
  function readTheme(slots, palette) {
    const style = getComputedStyle(document.documentElement);
    const read = (name, other) => style.getPropertyValue(name).trim() || other;
    const theme = {};
    for (const name of Object.keys(FALLBACK)) theme[name] = read(`--${name}`, FALLBACK[name]);
    theme.dark = luminance(theme.paper) < 0.4;
    theme.solver = (k) => read(`--solver-${k}`, `hsl(${(k * 97) % 360} 70% ${theme.dark ? 65 : 40}%)`);
    theme.people = slots.map((slot) => palette[theme.dark ? "dark" : "light"][slot]);
    return theme;
  }

  function luminance(colour) {
    const context = document.createElement("canvas").getContext("2d");
    context.fillStyle = colour;
    context.fillRect(0, 0, 1, 1);
    const [red, green, blue] = context.getImageData(0, 0, 1, 1).data;
    return (0.3 * red + 0.6 * green + 0.1 * blue) / 255;
  }

  /** Call back whenever the page turns dark or light; returns how to stop. */
  function onTheme(changed) {
    const observer = new MutationObserver(changed);
    observer.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme", "class"] });
    const media = matchMedia("(prefers-color-scheme: dark)");
    media.addEventListener("change", changed);
    return () => { observer.disconnect(); media.removeEventListener("change", changed); };
  }

  const polygon = (path, x, y, r, corners, turn) => {
    for (let i = 0; i <= corners; i++) {
      const angle = turn + (2 * Math.PI * i) / corners;
      path[i ? "lineTo" : "moveTo"](x + r * Math.cos(angle), y + r * Math.sin(angle));
    }
  };

  /** Add a solver's mark to a path, or to a canvas' current one. */
  function addShape(path, shape, x, y, r) {
    switch (shape) {
      case "square": path.rect(x - 0.85 * r, y - 0.85 * r, 1.7 * r, 1.7 * r); break;
      case "triangle": polygon(path, x, y, 1.2 * r, 3, -Math.PI / 2); break;
      case "diamond": polygon(path, x, y, 1.2 * r, 4, 0); break;
      case "kite": polygon(path, x, y, 1.2 * r, 3, Math.PI / 2); break;
      case "pentagon": polygon(path, x, y, 1.1 * r, 5, -Math.PI / 2); break;
      case "hexagon": polygon(path, x, y, 1.1 * r, 6, 0); break;
      default: {
        const d = shape === "plus" ? [r, 0, 0, r] : [0.8 * r, 0.8 * r, -0.8 * r, 0.8 * r];
        path.moveTo(x - d[0], y - d[1]); path.lineTo(x + d[0], y + d[1]);
        path.moveTo(x - d[2], y - d[3]); path.lineTo(x + d[2], y + d[3]);
      }
    }
  }

  /** Make a canvas fill its box at the screen's own resolution; true if that changed anything. */
  function fit(canvas) {
    const ratio = Math.min(window.devicePixelRatio || 1, 3);
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    const changed = canvas.width !== width || canvas.height !== height;
    if (changed) Object.assign(canvas, { width, height });
    canvas.ratio = ratio;
    return changed;
  }

  const FONT = "system-ui, sans-serif";

  /** Text with a halo of paper, readable on anything. */
  function label(context, text, x, y, colour, halo) {
    context.lineWidth = 3;
    context.lineJoin = "round";
    context.strokeStyle = halo;
    context.strokeText(text, x, y);
    context.fillStyle = colour;
    context.fillText(text, x, y);
  }

  Object.assign(parts, { readTheme, onTheme, addShape, SHAPES, fit, label, FONT });
})(vbbench.player.parts);
