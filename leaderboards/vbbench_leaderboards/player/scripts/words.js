/* What the player says in words: lists to choose from, a person's errors, the frame's, and what the views show. */
"use strict";
(function (parts) {
  const short = (value) => parts.short(value);

  /** The list of sequences, each with its people, frames and error. */
  function listSequences(s) {
    const { index } = s, text = (sequence) => {
      const place = index.sequences.indexOf(sequence);
      return `${sequence} · Δx ${short(s.errorOf(sequence))} m · ${index.people[place]} people · ${index.frames[place]} frames`;
    };
    parts.options(s.ui.sequence, s.sorted().map((sequence) => [sequence, text(sequence)]), s.sequence);
    const known = { relative: "; all as seen from the camera, Δx is Δx̃", poses: "; where people really are is not known" };
    s.ui.facts.textContent = `${index.sequences.length === 1 ? "1 sequence" : `${index.sequences.length} sequences`} of ${index.split}${index.sequences.length > 2 ? ", the best and the worst among them" : ""}${known[index.truth] || ""}`;
  }

  /** The boards on which this sequence can be played. */
  function listBoards(s) {
    const pairs = Object.keys(s.index.boards).map((name) => [name, name.replace(/-(?=[^-]*$)/, ", ")]);
    parts.options(s.ui.board, pairs, s.name);
  }

  function listPeople(s) {
    const people = Array.from(s.clip.tracks, (track, k) => [k, track]);
    parts.options(s.ui.person, [[-1, "nobody"], ...people], -1);
  }

  /** A person's distance and errors in this frame. */
  function tellPerson(s, k) {
    const { moment, clip, drawn, estimates } = s, i = moment.frame * clip.K + k, t = moment.frame;
    const reason = moment.others ? moment.others.reason(k) : 0, [px, py] = moment.placeOf(k), why = parts.REASONS[reason][1];
    const away = Math.hypot(px - moment.truth.x, py - moment.truth.y);
    if (k >= clip.K) return reason ? `Somebody, ${away.toFixed(1)} m away; ${why}.` : "Somebody who is not there in this frame.";
    if (s.isAlarm(t, k)) return `Box ${clip.tracks[k]} shows nobody: a false alarm, which is not scored.`;
    if (Number.isNaN(clip.px[i])) return `Person ${clip.tracks[k]} is not there in this frame.`;
    if (!clip.observed[i] && !reason) return `Person ${clip.tracks[k]} has another box in this frame: the track was lost.`;
    const errors = estimates.map((estimate, n) =>
      `${drawn[n].name} ${short(Math.hypot(estimate.px[i] - clip.px[i], estimate.py[i] - clip.py[i]))} m`);
    const state = s.isGiven(t, k) ? "; its position is given" : why && `; ${why}`;
    return `Person ${clip.tracks[k]}, ${away.toFixed(1)} m away${state}. Off by: ${errors.join(", ") || "no solver chosen"}.`;
  }

  /** Say the frame's errors, and describe both views, for those who hear the page. */
  function tellFrame(s) {
    const { ui, clip, moment, drawn, estimates } = s, t = moment.frame;
    let seen = 0;
    for (let k = 0; k < clip.K; k++) seen += clip.observed[t * clip.K + k];
    const errors = t < parts.START ? (s.board.given === "origin" ? "nothing is scored" : "everything is given") : !seen ? "nothing is scored" : estimates
      .map((estimate, n) => `${drawn[n].name}: people off by ${short(estimate.dx[t])} m, camera by ${short(estimate.dt[t])} m`).join("; ");
    const said = `Frame ${t} of ${clip.T - 1}, ${seen} people seen${errors && ": "}${errors}.`;
    if (ui.said.textContent !== said) ui.said.textContent = said;
    const camera = clip.picture.round ? "the panorama around the observer" : "the observer's picture";
    ui.ego.setAttribute("aria-label", `Boxes of ${seen} people in ${camera}.`);
    const outside = drawn.map(({ name }, n) => (s.views.map.outside?.[n]?.length ? ` Outside the map: ${name} ${s.views.map.outside[n].join(", ")}.` : ""));
    ui.map.setAttribute("aria-label", `Map from above: the observer, the people around, and the estimates of ${
      drawn.map(({ name }) => name).join(", ") || "no solver"}.${outside.join("")}`);
  }

  /** How many boxes there are, and why some people have none, each beside the mark that it has. */
  function showBoxes(s) {
    const said = parts.tellBoxes(s);
    for (const [name, text] of Object.entries(said)) {
      const place = s.ui.boxes.querySelector(`[data-${name}]`);
      if (place.lastChild.textContent !== text) place.lastChild.textContent = text;
      place.hidden = !text;
    }
  }

  /** Say what an address asks for that cannot be played here. */
  function tellGone(s, sequence, solvers) {
    const gone = [], asked = sequence !== undefined && String(sequence) !== String(s.sequence);
    if (asked) gone.push(`Sequence ${sequence} cannot be played here; this is sequence ${s.sequence}.`);
    if (solvers.length) gone.push(`There is no solver ${solvers.join(", ")} on this board.`);
    s.ui.gone.textContent = gone.join(" ");
    s.ui.gone.hidden = !gone.length;
  }

  Object.assign(parts, { listBoards, listSequences, listPeople, tellPerson, tellFrame, showBoxes, tellGone });
})(vbbench.player.parts);
