// A slider beside a number: it writes into the number, and follows what is typed there.
window.slideField = (slider) => {
  const number = slider.parentElement.querySelector("input:not([type=range])");
  number.value = slider.value;
  number.dispatchEvent(new Event("input", { bubbles: true }));
};
document.addEventListener("input", (event) => {
  const slider = event.target.closest?.(".slid")?.querySelector("input[type=range]");
  if (slider && slider !== event.target && event.target.value !== "") slider.value = event.target.value;
});
