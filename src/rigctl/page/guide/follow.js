// Moves the drawing of the rig with the fields of the next shot, without asking the server.
window.followRig = (diameter) => {
  const field = (name) => {
    const at = document.querySelector(`[data-testid=${name}]`);
    return at ? Number((at.querySelector("input") ?? at).value) || 0 : 0;
  };
  const draw = () => {
    const offset = field("offset_mm");
    const share = Math.min(1, Math.max(-1, offset / diameter));
    const degrees = (Math.asin(share) * 180) / Math.PI;
    const met = Math.abs(share) >= 1 ? "they miss" : `${degrees.toFixed(0)}° off head-on`;
    for (const [name, radius, x, y] of [["wide", 30, 326, 220], ["narrow", 17, 146, 132]]) {
      const part = document.querySelector(`svg.${name}-drawing`);
      if (!part) continue;
      const down = 2 * radius * share;
      const beside = Math.sqrt(Math.max(0, 4 * radius * radius - down * down));
      part.querySelector(".sphere-b").setAttribute("transform", `translate(${x + beside} ${y + down})`);
      part.querySelector(".lower").setAttribute("transform", `translate(0 ${down})`);
      part.querySelector(".gap")?.setAttribute("d", `M548 ${y}V${y + Math.max(down, 0.1)}`);
      part.querySelector(".angle").textContent = offset ? `${offset} mm: ${met}` : "0 mm: head on";
      for (const side of ["a", "b"]) {
        const turn = 2.2 * field(`pressure_${side}_kpa`);
        const centre = side === "a" ? "62 144" : "640 144";
        part.querySelector(`.needle-${side}`)?.setAttribute("transform", `rotate(${turn} ${centre})`);
      }
    }
  };
  document.addEventListener("input", (event) => {
    if (event.target.closest("[data-testid$=_kpa], [data-testid=offset_mm], .field")) draw();
  });
  draw();
};
