// Draws a frame of a film with the model's outlines over it; scrubs, plays, and says the error.
window.ghostFilm = (root, film) => {
  const [scene, slider] = ["svg", "input[type=range]"].map((name) => root.querySelector(name));
  const [ghost, large] = root.querySelectorAll("input[type=checkbox]");
  const play = root.querySelector("button");
  const circle = (x, y, r, look) => `<circle cx="${x}" cy="${y}" r="${r}" ${look}/>`;
  const clip = `loupe-${root.id}`;
  // Of the view where it is largest, the true gap magnified, in the corner farthest from rings.
  const loupe = (frame) => {
    const gap = (ring) => Math.hypot(ring[4], ring[5]);
    const seen = frame.rings.filter((ring) => ring[4] !== null && gap(ring) > 0);
    if (!seen.length) return "";
    const [x, y, r, sphere, dx, dy] = seen.reduce((most, ring) => (gap(ring) > gap(most) ? ring : most));
    const apart = Math.hypot(dx, dy);
    const size = 0.11 * film.width;
    const half = Math.max(1.8 * apart, size / 99);
    const [px, py] = [x + (dx / apart) * (r + apart / 2), y + (dy / apart) * (r + apart / 2)];
    const free = ([cx, cy]) => Math.min(...frame.rings.map((ring) => Math.hypot(ring[0] - cx, ring[1] - cy) - ring[2]));
    const edge = 1.12 * size;
    const corners = [1.5 * edge, film.width - 1.5 * edge].flatMap((cx) => [1.4 * edge, film.height - 1.4 * edge, film.height / 2].map((cy) => [cx, cy]));
    const [cx, cy] = corners.reduce((best, one) => (free(one) > free(best) ? one : best));
    const thin = (half / size) * film.stroke;
    const near = (mx, my, look) => circle(mx, my, r, `${look} fill="none" stroke-width="${1.6 * thin}"`);
    const [ux, uy] = [(dx / apart) * (apart / 2), (dy / apart) * (apart / 2)];
    const text = 0.032 * film.width;
    // Words stand on the side that the line to the gap leaves free.
    const words = py > cy ? cy - size - 0.5 * text : cy + size + 1.1 * text;
    const far = Math.hypot(px - cx, py - cy) || 1;
    const [rx, ry] = [cx + ((px - cx) / far) * size, cy + ((py - cy) / far) * size];
    return `<g class="loupe"><line x1="${rx}" y1="${ry}" x2="${px}" y2="${py}" stroke-width="${film.stroke / 2}"/>
      <clipPath id="${clip}">${circle(px, py, half, "")}</clipPath>
      <svg x="${cx - size}" y="${cy - size}" width="${2 * size}" height="${2 * size}" viewBox="${px - half} ${py - half} ${2 * half} ${2 * half}">
      <g clip-path="url(#${clip})">${circle(px, py, half, 'class="pane"')}
      ${near(x, y, `stroke="${film.looks[sphere]}"`)}${near(x + dx, y + dy, `class="ghost" stroke-dasharray="${5 * thin} ${3 * thin}"`)}
      <line class="between" x1="${px - ux}" y1="${py - uy}" x2="${px + ux}" y2="${py + uy}" stroke-width="${2 * thin}"/></g></svg>
      ${circle(cx, cy, size, `class="rim" fill="none" stroke-width="${film.stroke}"`)}
      <text x="${cx}" y="${words}" text-anchor="middle" font-size="${text}">${(size / half).toPrecision(2)} × larger</text></g>`;
  };
  const draw = () => {
    const at = Number(slider.value);
    const frame = film.frames[at];
    const k = large.checked ? film.times : 1;
    const parts = [];
    if (frame.picture) parts.push(`<image href="${frame.picture}" width="${film.width}" height="${film.height}"/>`);
    for (const [x, y, r, sphere, dx, dy] of frame.rings) {
      const look = film.looks[sphere];
      parts.push(circle(x, y, r, `${frame.picture ? 'fill="none"' : 'class="ball"'} stroke="${look}" stroke-width="${film.stroke}"`));
      if (ghost.checked && dx !== null)
        parts.push(circle(x + k * dx, y + k * dy, r, `class="ghost" fill="none" stroke-width="${film.stroke}" stroke-dasharray="${4 * film.stroke} ${3 * film.stroke}"`));
    }
    parts.push(...film.still);
    if (ghost.checked) parts.push(loupe(frame));
    scene.innerHTML = parts.join("");
    const side = frame.time < 0 ? "before" : "after";
    const said = `${Math.abs(frame.time).toFixed(1)} ms ${side} contact`;
    const gap = frame.gap === null ? "not measured here" : `the model is ${frame.gap.toPrecision(2)} mm off`;
    root.querySelector(".ghost-text").textContent = `${said}: ${gap}.`;
    root.querySelector(".ghost-scale").textContent =
      ghost.checked && large.checked ? `Error drawn ${film.times} times as large as it is.` : "";
    slider.setAttribute("aria-valuetext", `${said}, ${gap}`);
  };
  let timer = null;
  const stop = () => {
    clearInterval(timer);
    timer = null;
    play.textContent = "Play";
  };
  play.onclick = () => {
    if (timer) return stop();
    play.textContent = "Pause";
    timer = setInterval(() => {
      if (!root.isConnected) return stop();
      slider.value = (Number(slider.value) + 1) % film.frames.length;
      draw();
    }, 100);
  };
  slider.oninput = () => {
    stop();
    draw();
  };
  ghost.onchange = large.onchange = draw;
  draw();
};
