/* The moments that tell most: where a solver is lost, or where two solvers differ most. */
"use strict";
(function (parts) {
  const MOST = 5, APART = 1.5; // so many moments, seconds apart
  const LEVELS = 20, FEW = 2; // of what is told: within one, the first counts; the lowest tell nothing

  /** [T] how much a frame tells: the error, its mean over solvers, or of two the difference; beyond the cap it counts less and less. */
  function signal(curves, cap) {
    const tame = (value) => value / (1 + value / cap), T = curves.length ? curves[0].length : 0, out = new Float64Array(T);
    for (let t = 0; t < T; t++) {
      const values = curves.map((curve) => tame(curve[t])).filter((value) => value === value);
      if (curves.length === 2) out[t] = values.length === 2 ? Math.abs(values[0] - values[1]) : 0;
      else for (const value of values) out[t] += value / curves.length;
    }
    return out;
  }

  /** Frames that tell most, of nearly equal ones the first, none close to another that tells more. */
  function moments(curves, cap, dt) {
    const told = signal(curves, cap), most = told.reduce((one, other) => Math.max(one, other), 0), found = [];
    const level = (t) => Math.round((LEVELS * told[t]) / most);
    for (const t of most > 0 ? Array.from(told.keys()).sort((a, b) => level(b) - level(a) || a - b) : []) {
      if (found.length === MOST || level(t) <= FEW) break;
      if (found.every((other) => Math.abs(other - t) * dt >= APART)) found.push(t);
    }
    return found;
  }

  /** Which of two solvers is nearer the truth, in words. */
  function tellPair(drawn, curves) {
    if (curves.length !== 2) return "";
    const apart = curves[0].map((first, t) => curves[1][t] - first).filter((one) => one === one);
    const first = apart.filter((one) => one > 0).length, second = apart.filter((one) => one < 0).length, ahead = first >= second ? 0 : 1;
    return apart.length ? `${drawn[ahead].name} is nearer the truth in ${Math.max(first, second)} of ${apart.length} frames` : "";
  }

  Object.assign(parts, { moments, tellPair });
})(vbbench.player.parts);
