// Moves the model's curve and the error of a preview with its slider, without asking the server.
window.slidePreview = (slider, sums) => {
  cancelAnimationFrame(slider.frame);
  slider.frame = requestAnimationFrame(() => {
    const amplitude = Number(slider.value);
    const share = amplitude / sums.best;
    const error = Math.sqrt(
      sums.with_it ** 2 + (sums.without ** 2 - sums.with_it ** 2) * (1 - share) ** 2,
    );
    const panel = slider.closest(".lead-card");
    const plot = panel.querySelector(".js-plotly-plot.over");
    if (plot) window.Plotly.restyle(plot, { y: [sums.curve.map((y) => y * share)] }, [0]);
    const most = Math.max(sums.without, sums.with_it) - sums.floor;
    const level = Math.min(1, Math.max(0, (error - sums.floor) / (most || 1)));
    const errorSaid = `${error >= 1000 ? error.toFixed(0) : error.toPrecision(3)} ${sums.error_unit}`;
    const size = Number((amplitude * sums.factor).toPrecision(3));
    const said = `${sums.symbol} = ${size}${sums.unit}`.replace("-", "−");
    const outside = amplitude < sums.believed[0] || amplitude > sums.believed[1];
    panel.querySelector(".gauge > i").style.height = `${100 * level}%`;
    const number = panel.querySelector(".gauge-number");
    number.textContent = errorSaid;
    number.classList.toggle("good", level < 0.02);
    const amount = panel.querySelector(".amplitude");
    amount.textContent = outside && share !== 0 ? `▲ ${said}, beyond what is believed` : said;
    amount.classList.toggle("fails", outside && share !== 0);
    const signed = (y) => {
      const change = Number((y * share).toPrecision(2));
      return change === 0 ? "0" : `${change < 0 ? "−" : "+"}${Math.abs(change)}`;
    };
    const last = sums.curve.length - 1;
    const moves = sums.always
      ? `The ${sums.row} changes by ${signed(sums.curve[0])} ${sums.row_unit} in all shots.`
      : `The ${sums.row} changes by ${signed(sums.curve[0])} ${sums.row_unit} at ${sums.ends[0]}` +
      ` and by ${signed(sums.curve[last])} ${sums.row_unit} at ${sums.ends[1]}.`;
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
