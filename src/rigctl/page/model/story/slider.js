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
    const errorSaid = `${error.toFixed(sums.digits)} ${sums.error_unit}`;
    const said = `${sums.symbol} = ${Number(amplitude.toPrecision(3))}${sums.unit}`.replace("-", "−");
    panel.querySelector(".gauge > i").style.height = `${100 * level}%`;
    panel.querySelector(".gauge-number").textContent = errorSaid;
    panel.querySelector(".amplitude").textContent = said;
    const signed = (y) => {
      const change = Number((y * share).toPrecision(2));
      return change === 0 ? "0" : `${change < 0 ? "−" : "+"}${Math.abs(change)}`;
    };
    const last = sums.curve.length - 1;
    panel.querySelector(".effect-text").textContent = sums.always
      ? `It changes the ${sums.row} by ${signed(sums.curve[0])} ${sums.row_unit} in all shots.`
      : `It changes the ${sums.row} by ${signed(sums.curve[0])} ${sums.row_unit} at ${sums.ends[0]}` +
      ` and by ${signed(sums.curve[last])} ${sums.row_unit} at ${sums.ends[1]}.`;
    slider.setAttribute("aria-valuetext", `${said}, error ${errorSaid.replace("×", "times the noise")}`);
  });
};
