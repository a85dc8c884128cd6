/* What lies near an address that leads nowhere. */
(function () {
  "use strict";
  const MOST = 5;
  const TOO_FAR = 1.3;
  const UNSAID = 0.3;

  /** @param {string} one @param {string} other @returns {number} share of letters to change, 0 = the same */
  function unlikeness(one, other) {
    const [a, b] = [one.toLowerCase(), other.toLowerCase()];
    let row = Array.from({ length: b.length + 1 }, (_, n) => n);
    for (let i = 1; i <= a.length; i++) {
      const next = [i];
      for (let j = 1; j <= b.length; j++) {
        next.push(Math.min(next[j - 1] + 1, row[j] + 1, row[j - 1] + (a[i - 1] === b[j - 1] ? 0 : 1)));
      }
      row = next;
    }
    return row[b.length] / Math.max(a.length, b.length, 1);
  }

  /**
   * The known paths nearest to a path, the nearest first; of those that are equally near, the first.
   * @param {string[]} parts
   * @param {string[]} known such as "hotel/one-step-noisy", those that matter most first
   * @returns {string[]}
   */
  function near(parts, known) {
    const far = (path) => {
      const own = path.split("/");
      const rest = parts.length > 1 ? unlikeness(parts[1], own[1]) : UNSAID;
      return 2 * unlikeness(parts[0] || "", own[0]) + rest;
    };
    const found = known.map((path, n) => ({ path, n, far: far(path) })).filter((one) => one.far < TOO_FAR);
    return found.sort((one, two) => one.far - two.far || one.n - two.n).slice(0, MOST).map((one) => one.path);
  }

  window.vbbench.near = near;
})();
