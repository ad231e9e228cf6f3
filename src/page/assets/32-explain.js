// Short explanations beside the words that need them: a button that shows and hides a paragraph.

const s_explanations = {
  relmse: ["relMSE", "Relative mean squared error: the squared difference to the reference, divided by its squared brightness, "
    + "summed over red, green and blue and averaged over the pixels. 0.03 is about 10 % noise in each channel of a pixel. "
    + "A quarter of it is half the noise, and takes four times the samples. Without a reference the renderer estimates it."],
  phi: ["\u03c6", "Flicker relative to the error: how much the error changes from the frame before, over how large it is. "
    + "1: new noise in every frame. 0: the noise stands still. 2: it alternates. At equal relMSE a lower \u03c6 looks calmer."],
  f1: ["F1", "How much the error changes from the frame before, as root mean square in scene values: the flicker that is seen. "
    + "Less is better. F1 falls with the noise, \u03c6 does not."],
  seconds: ["Seconds", "Wall-clock time since the frame before was finished. Frames of a group are finished together or one after "
    + "another, so single frames vary; their sum is the time of the render."],
  noise: ["Noise of a channel", "The square root of a third of relMSE: the typical deviation of red, green or blue of a pixel from its true value."],
};

let s_explained = 0;

// A button, and the paragraph that it shows; the caller puts them where they belong.
function makeExplanation(key) {
  const [name, text] = s_explanations[key], id = `explain-${key}-${++s_explained}`;
  const words = make("p", { id, className: "explanation", textContent: text, hidden: true });
  const button = make("button", { type: "button", className: "explain", textContent: "?" });
  button.setAttribute("aria-label", `What is ${name}?`);
  button.setAttribute("aria-expanded", "false");
  button.setAttribute("aria-controls", id);
  button.addEventListener("click", () => {
    words.hidden = !words.hidden;
    button.setAttribute("aria-expanded", String(!words.hidden));
  });
  button.addEventListener("keydown", event => {
    if (event.key === "Escape" && !words.hidden)
      button.click();
  });
  return { button, words };
}

// The explanation that a row of the tables has.
function explanationOfFact(label) {
  if (/relMSE|worst 0.1 %/.test(label))
    return "relmse";
  return /phi$/.test(label) ? "phi" : /F1$/.test(label) ? "f1" : label === "Noise of a channel" ? "noise" : null;
}
