/* The address is the state: #/SPLIT/PROTOCOL-TIER?by=dx&show=… for a table, …/play?sequence=12 for the player,
   …/compare?a=…&b=… for two solvers, and #/solver/NAME for one. */
(function () {
  "use strict";
  const vbbench = window.vbbench;
  const VIEWS = ["play", "compare"];

  /**
   * @typedef {object} State
   * @property {"front" | "board" | "solver" | "unknown"} kind
   * @property {string} board split/protocol-tier, or "" where it is no board
   * @property {string} view of a board: "" for its table, "play" or "compare"
   * @property {string} solver its name, or "" where it is no solver's page
   * @property {string[]} parts of the path
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
    const parts = path.split("/").filter(Boolean).map(decoded);
    const options = Object.fromEntries(new URLSearchParams(query || ""));
    const state = { kind: "unknown", board: "", view: "", solver: "", parts, options };
    if (parts.length === 0) return { ...state, kind: "front" };
    if (parts.length === 2 && parts[0] === "solver") return { ...state, kind: "solver", solver: parts[1] };
    if (parts.length === 2) return { ...state, kind: "board", board: parts.join("/") };
    if (parts.length === 3 && VIEWS.includes(parts[2])) {
      return { ...state, kind: "board", board: parts.slice(0, 2).join("/"), view: parts[2] };
    }
    return state;
  }

  /** @param {{board: string, view: string, options: Record<string, string>}} state @returns {string} */
  function format(state) {
    const path = state.board.split("/").map(encodeURIComponent).join("/");
    const kept = Object.entries(state.options).filter(([, value]) => value !== "" && value != null);
    const query = new URLSearchParams(kept).toString().replaceAll("%2C", ",");
    return "#/" + path + (state.view ? "/" + state.view : "") + (query ? "?" + query : "");
  }

  /** @param {{board: string, view: string, options: Record<string, string>}} state */
  function replace(state) {
    history.replaceState(null, "", format(state));
  }

  vbbench.state = { parse, format, replace, decoded };
})();
