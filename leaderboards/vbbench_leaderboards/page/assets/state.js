/* The address is the state: #/SPLIT/PROTOCOL-TIER?by=dx&show=… for a table, …/play?sequence=12 for the player. */
(function () {
  "use strict";
  const vbbench = window.vbbench;

  /**
   * @typedef {object} State
   * @property {string} board split/protocol-tier, or "" for the first
   * @property {boolean} play
   * @property {Record<string, string>} options
   */

  /** @param {string} text @returns {string} */
  function decoded(text) {
    try {
      return decodeURIComponent(text);
    } catch (error) {
      return "";
    }
  }

  /**
   * @param {string} hash
   * @returns {State | null} null for a place on the page, such as #meanings
   */
  function parse(hash) {
    if (hash && hash !== "#" && !hash.startsWith("#/")) return null;
    const [path, query] = hash.replace(/^#\/?/, "").split("?");
    const parts = path.split("/").map(decoded).filter(Boolean);
    const options = Object.fromEntries(new URLSearchParams(query || ""));
    return { board: parts.slice(0, 2).join("/"), play: parts[2] === "play", options };
  }

  /** @param {State} state @returns {string} */
  function format(state) {
    const path = state.board.split("/").map(encodeURIComponent).join("/");
    const kept = Object.entries(state.options).filter(([, value]) => value !== "" && value != null);
    const query = new URLSearchParams(kept).toString().replaceAll("%2C", ",");
    return "#/" + path + (state.play ? "/play" : "") + (query ? "?" + query : "");
  }

  /** @param {State} state */
  function replace(state) {
    history.replaceState(null, "", format(state));
  }

  vbbench.state = { parse, format, replace, decoded };
})();
