// Moves the model's curve and the error of a preview with its slider, without asking the server.
window.slidePreview = (slider, sums) => {
  cancelAnimationFrame(slider.frame);
  slider.frame = requestAnimationFrame(() => {
    const amplitude = Number(slider.value);
    const share = amplitude / sums.best;
    const square = sums.with_it ** 2 + (sums.without ** 2 - sums.with_it ** 2) * (1 - share) ** 2;
    const error = Math.sqrt(Math.max(0, square));
    const panel = slider.closest(".lead-card");
    const plot = panel.querySelector(".js-plotly-plot.over");
    if (plot) window.Plotly.restyle(plot, { y: [sums.curve.map((y) => y * share)] }, [0]);
    const close = sums.floor && error < sums.near_one;
    const number = close ? error.toFixed(3) : error >= 1000 ? error.toFixed(0) : error.toPrecision(3);
    const errorSaid = `${number} ${sums.error_unit}`;
    const size = Number((amplitude * sums.factor).toPrecision(3));
    const said = `${sums.symbol} = ${size}${sums.unit}`.replace("-", "−");
    const outside = amplitude < sums.believed[0] || amplitude > sums.believed[1];
    const bar = panel.querySelector(".gauge > i");
    bar.style.height = `${(100 * error) / sums.most}%`;
    const shown = panel.querySelector(".gauge-number");
    shown.textContent = errorSaid;
    for (const part of [bar, shown]) part.classList.toggle("good", error <= sums.good);
    const amount = panel.querySelector(".amplitude");
    amount.textContent = outside && share !== 0 ? `▲ ${said}, beyond what is believed` : said;
    amount.classList.toggle("fails", outside && share !== 0);
    const signed = (y) => {
      const change = Number((y * share).toPrecision(2));
      return change === 0 ? "0" : `${change < 0 ? "−" : "+"}${Math.abs(change)}`;
    };
    const told = sums.told.map(([k, at]) => `by ${signed(sums.curve[k])} ${sums.row_unit} at ${at}`);
    const moves = sums.always
      ? `The ${sums.row} changes by ${signed(sums.curve[0])} ${sums.row_unit} in all shots.`
      : `The ${sums.row} changes ${told.slice(0, -1).join(", ")} and ${told.at(-1)}.`;
    const does = sums.does[Math.round((amplitude - sums.low) / sums.step)] || "";
    panel.querySelector(".effect-text").textContent = does || moves;
    panel.querySelector(".does").textContent = does ? moves : "";
    slider.setAttribute("aria-valuetext", `${said}, error ${errorSaid.replace("×", "times the noise")}`);
  });
};

const moved = (slider) => slider.dispatchEvent(new Event("input", { bubbles: true }));

// With Shift an arrow key moves ten steps.
window.stepSlider = (event) => {
  const slider = event.target;
  const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
  if (!way || !event.shiftKey) return;
  event.preventDefault();
  const across = slider.dir === "rtl" && event.key.match(/Left|Right/) ? -way : way;
  slider.value = Number(slider.value) + 10 * across * Number(slider.step);
  moved(slider);
};

window.toBest = (target) => {
  const slider = target.closest(".lead-card").querySelector(".amount");
  slider.value = slider.dataset.best;
  moved(slider);
};
