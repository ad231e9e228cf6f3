// Verdict, warnings and tables.

function showVerdict(data, seek) {
  const { text, basis, worst_frame } = data.verdict, line = document.getElementById("verdict-text");
  line.append(text);
  if (worst_frame !== null) {
    const button = make("button", { type: "button", textContent: `worst frame ${worst_frame}`, title: "Show this frame" });
    button.addEventListener("click", () => seek(worst_frame));
    line.append("; ", button);
  }
  const { button, words } = makeExplanation("relmse");
  document.getElementById("verdict-basis").append(basis, " ", button);
  document.getElementById("verdict").append(words);
}

function showWarnings(data) {
  const box = document.getElementById("warnings"), count = data.warnings.length;
  const lost = data.warnings.filter(warning => warning.loss).length, rest = count - lost;
  const titles = [lost > 0 ? `Lost by the export: ${lost}` : "", rest > 0 ? `${rest} warning${rest === 1 ? "" : "s"}` : ""];
  box.hidden = count === 0;
  box.open = count <= 4 || lost > 0;
  document.getElementById("warnings-title").textContent = titles.filter(title => title !== "").join("; ");
  for (const { sequence, text, loss } of data.warnings) {
    const name = data.sequences.length > 1 ? [make("strong", { textContent: `${data.sequences[sequence].name}: ` })] : [];
    document.getElementById("warnings-list").append(make("li", { className: loss ? "loss" : "" }, ...name, text));
  }
}

function withRole(element, role) {
  element.setAttribute("role", role);
  return element;
}

// On narrow screens the cells of a row stand below each other, so each carries the name of its sequence, and roles that keep it a table.
function makeFactRow(label, values, data) {
  const head = withRole(make("th", { scope: "row" }, label), "rowheader"), key = explanationOfFact(label);
  if (key !== null) {
    const { button, words } = makeExplanation(key);
    head.append(" ", button, words);
  }
  const cells = values.map((value, i) => {
    const cell = withRole(make("td", { textContent: value }), "cell");
    if (values.length > 1 && value !== "")
      cell.dataset.sequence = data.sequences[i].name;
    return cell;
  });
  const row = withRole(make("tr", {}, head, ...cells), "row");
  row.classList.toggle("alike", values.length > 1 && values.every(value => value === values[0])); // shown once on narrow screens
  return row;
}

function addFacts(data) {
  const box = document.getElementById("facts"), groups = new Map();
  box.style.setProperty("--fact-width", `${240 + 110 * data.sequences.length}px`);
  data.sequences.forEach((sequence, index) => {
    for (const [group, label, value] of sequence.facts) {
      if (!groups.has(group))
        groups.set(group, new Map());
      if (!groups.get(group).has(label))
        groups.get(group).set(label, data.sequences.map(() => ""));
      groups.get(group).get(label)[index] = value;
    }
  });
  for (const [group, rows] of groups) {
    const table = withRole(make("table", {}), "table");
    table.setAttribute("aria-label", group);
    if (data.sequences.length > 1)
      table.append(withRole(make("thead", {}, withRole(make("tr", {}, make("td", {}), ...data.sequences.map(sequence => withRole(make("th", { scope: "col", textContent: sequence.name }), "columnheader"))), "row")), "rowgroup"));
    const body = withRole(make("tbody", {}), "rowgroup");
    for (const [label, values] of rows)
      body.append(makeFactRow(label, values, data));
    table.append(body);
    box.append(make("div", { className: "card" }, make("h2", { textContent: group }), table));
  }
}
