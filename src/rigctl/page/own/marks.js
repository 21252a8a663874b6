// Marks on a picture of a film, dragged by their border or moved by arrow keys: the part that is
// looked at, a ring on the ball, a line over a known length. All lengths are pixels of the film.
window.filmMarks = (root, { width, height, part, ring, line }) => {
  const scene = root.querySelector("svg");
  const marks = { part: part || [0, 0, width, height], ring, line };
  const within = (value, low, high) => Math.min(Math.max(value, low), high);
  const LEAST = 8;
  const edge = (axis, far) => ({
    at: () => {
      const middle = marks.part.map((start, k) => (k < 2 ? start + marks.part[k + 2] / 2 : 0));
      middle[axis] = marks.part[axis] + (far ? marks.part[axis + 2] : 0);
      return middle;
    },
    move: (by) => {
      const [start, length] = [marks.part[axis], marks.part[axis + 2]];
      if (far) marks.part[axis + 2] = within(length + by[axis], LEAST, [width, height][axis] - start);
      else {
        marks.part[axis] = within(start + by[axis], 0, start + length - LEAST);
        marks.part[axis + 2] = start + length - marks.part[axis];
      }
    },
    value: () => marks.part[axis] + (far ? marks.part[axis + 2] : 0),
    most: [width, height][axis],
    said: (value) => `${axis ? "row" : "column"} ${Math.round(value)}`,
  });
  const corner = (right, low) => ({
    at: () => [marks.part[0] + (right ? marks.part[2] : 0), marks.part[1] + (low ? marks.part[3] : 0)],
    move: (by) => {
      edge(0, right).move(by);
      edge(1, low).move(by);
    },
    mouse: true,
  });
  const point = (of, first) => ({
    at: () => marks[of].slice(first, first + 2),
    move: (by) => {
      marks[of][first] = within(marks[of][first] + by[0], 0, width);
      marks[of][first + 1] = within(marks[of][first + 1] + by[1], 0, height);
    },
    value: () => marks[of][first],
    most: width,
    said: () => `column ${Math.round(marks[of][first])}, row ${Math.round(marks[of][first + 1])}`,
  });
  const handles = {
    part: {
      "left border of the part": edge(0, false),
      "right border of the part": edge(0, true),
      "upper border of the part": edge(1, false),
      "lower border of the part": edge(1, true),
      nw: corner(false, false),
      ne: corner(true, false),
      sw: corner(false, true),
      se: corner(true, true),
    },
    ring: {
      "place of the ring": point("ring", 0),
      "size of the ring": {
        at: () => [marks.ring[0] + marks.ring[2], marks.ring[1]],
        move: (by) => (marks.ring[2] = within(marks.ring[2] + (by[0] || -by[1]), 2, width)),
        value: () => 2 * marks.ring[2],
        most: 2 * width,
        said: (value) => `${value.toFixed(1)} pixels across`,
      },
    },
    line: { "one end of the line": point("line", 0), "other end of the line": point("line", 2) },
  };
  const made = (name, look, into = scene) => {
    const one = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(look)) one.setAttribute(key, value);
    return into.appendChild(one);
  };
  const set = (one, look) => Object.entries(look).forEach(([key, value]) => one.setAttribute(key, value));
  scene.querySelectorAll("g").forEach((old) => old.remove());
  const shown = Object.keys(handles).filter((of) => marks[of]);
  const shapes = {};
  for (const of of shown) {
    const group = made("g", { class: `mark-${of}` });
    if (of === "part") shapes.shade = made("path", { class: "shade", "fill-rule": "evenodd" }, group);
    const shape = { part: "rect", ring: "circle", line: "line" }[of];
    shapes[of] = [made(shape, { class: "halo" }, group), made(shape, { class: "shape" }, group)];
    if (of !== "part") shapes[`${of}Text`] = made("text", { "text-anchor": "middle" }, group);
  }
  const grips = shown.flatMap((of) =>
    Object.entries(handles[of]).map(([name, handle]) => {
      const group = made("g", { class: `grip mark-${of}` });
      made("circle", { class: "reach" }, group);
      made("circle", { class: "dot" }, group);
      if (!handle.mouse) {
        set(group, { tabindex: 0, role: "slider", "aria-label": name, "aria-valuemin": 0 });
        group.dataset.testid = `grip-${name.replaceAll(" ", "-")}`;
      }
      return { group, handle };
    }),
  );
  const draw = () => {
    // A handle is as large on the screen whatever the film's size.
    const unit = width / (scene.clientWidth || width);
    const [x, y, w, h] = marks.part;
    set(shapes.shade, { d: `M0 0H${width}V${height}H0ZM${x} ${y}h${w}v${h}h${-w}Z` });
    shapes.part.forEach((one) => set(one, { x, y, width: w, height: h }));
    const text = { "font-size": 14 * unit, "stroke-width": 4 * unit };
    if (marks.ring) {
      const [cx, cy, r] = marks.ring;
      shapes.ring.forEach((one) => set(one, { cx, cy, r }));
      const below = cy + r + 18 * unit < height ? cy + r + 18 * unit : cy - r - 8 * unit;
      set(shapes.ringText, { x: within(cx, 40 * unit, width - 40 * unit), y: below, ...text });
      shapes.ringText.textContent = `${(2 * r).toFixed(1)} px`;
    }
    if (marks.line) {
      const [x1, y1, x2, y2] = marks.line;
      shapes.line.forEach((one) => set(one, { x1, y1, x2, y2 }));
      const middle = within((x1 + x2) / 2, 40 * unit, width - 40 * unit);
      set(shapes.lineText, { x: middle, y: within((y1 + y2) / 2 - 10 * unit, 14 * unit, height), ...text });
      shapes.lineText.textContent = `${Math.hypot(x2 - x1, y2 - y1).toFixed(1)} px`;
    }
    scene.style.setProperty("--unit", unit);
    for (const { group, handle } of grips) {
      const [cx, cy] = handle.at();
      const [reach, dot] = group.children;
      // At the picture's border a handle stays whole.
      const inside = [within(cx, 7 * unit, width - 7 * unit), within(cy, 7 * unit, height - 7 * unit)];
      set(reach, { cx: inside[0], cy: inside[1], r: 13 * unit });
      set(dot, { cx: inside[0], cy: inside[1], r: 6 * unit });
      if (handle.mouse) continue;
      const value = handle.value();
      set(group, { "aria-valuenow": value.toFixed(1), "aria-valuemax": handle.most, "aria-valuetext": handle.said(value) });
    }
  };
  const tell = () => root.dispatchEvent(new CustomEvent("marked", { detail: JSON.parse(JSON.stringify(marks)) }));
  const dragged = (target, move) => {
    target.onpointerdown = (event) => {
      event.preventDefault();
      event.stopPropagation();
      target.setPointerCapture(event.pointerId);
      const matrix = scene.getScreenCTM().inverse();
      const place = ({ clientX, clientY }) => new DOMPoint(clientX, clientY).matrixTransform(matrix);
      let last = place(event);
      target.onpointermove = (moved) => {
        const now = place(moved);
        move([now.x - last.x, now.y - last.y]);
        last = now;
        draw();
      };
      target.onpointerup = target.onpointercancel = () => {
        target.onpointermove = target.onpointerup = target.onpointercancel = null;
        tell();
      };
    };
  };
  let rest = null;
  const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  for (const { group, handle } of grips) {
    dragged(group, handle.move);
    group.onkeydown = (event) => {
      const step = STEPS[event.key];
      if (!step) return;
      event.preventDefault();
      event.stopPropagation();
      handle.move(step.map((by) => by * (event.shiftKey ? 10 : 1)));
      draw();
      clearTimeout(rest);
      rest = setTimeout(tell, 250);
    };
  }
  // A ring is dragged by its face too.
  if (marks.ring) shapes.ring.forEach((one) => dragged(one, handles.ring["place of the ring"].move));
  new ResizeObserver(draw).observe(scene);
  draw();
};
