// Draws a frame of a film with the model's outlines over it; scrubs, plays, and says the gap.
window.ghostFilm = (root, film) => {
  const [scene, slider] = ["svg", "input[type=range]"].map((name) => root.querySelector(name));
  const [ghost, large] = root.querySelectorAll("input[type=checkbox]");
  const play = root.querySelector("button");
  const circle = (x, y, r, look) => `<circle cx="${x}" cy="${y}" r="${r}" ${look}/>`;
  const draw = () => {
    const at = Number(slider.value);
    const frame = film.frames[at];
    const k = large.checked ? film.times : 1;
    const parts = film.still.slice();
    if (frame.picture) parts.push(`<image href="${frame.picture}" width="${film.width}" height="${film.height}"/>`);
    for (const [x, y, r, sphere, dx, dy] of frame.rings) {
      const look = film.looks[sphere];
      parts.push(circle(x, y, r, `${frame.picture ? 'fill="none"' : 'class="ball"'} stroke="${look}" stroke-width="${film.stroke}"`));
      if (ghost.checked && dx !== null)
        parts.push(circle(x + k * dx, y + k * dy, r, `class="ghost" fill="none" stroke-width="${film.stroke}" stroke-dasharray="${4 * film.stroke} ${3 * film.stroke}"`));
    }
    scene.innerHTML = parts.join("");
    const side = frame.time < 0 ? "before" : "after";
    const said = `${Math.abs(frame.time).toFixed(1)} ms ${side} contact`;
    const gap = frame.gap === null ? "not measured here" : `the model is ${frame.gap.toPrecision(2)} mm off`;
    root.querySelector(".ghost-text").textContent = `${said}: ${gap}.`;
    root.querySelector(".ghost-scale").textContent =
      ghost.checked && large.checked ? `Gap drawn ${film.times} times as large as it is.` : "";
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
