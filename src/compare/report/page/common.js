"use strict";
const data = JSON.parse(document.getElementById("data").textContent);

/** An element with attributes and children; text is never read as HTML. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === true) element.setAttribute(name, "");
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child != null));
  return element;
}

/** A number as short as it can be read; nothing for what was not measured. */
function shown(value) {
  if (value == null) return "\u2013";
  const size = Math.abs(value);
  if (size >= 1e6) return (value / 1e6).toFixed(1) + " M";
  if (size >= 1e4) return (value / 1e3).toFixed(0) + " k";
  if (size >= 100) return value.toFixed(0);
  if (size >= 10) return value.toFixed(1);
  if (size >= 1 || size === 0) return value.toFixed(2);
  return size < 0.001 ? value.toExponential(1) : value.toFixed(3);
}

/** A drop-down with a label. */
function choice(label, options, picked, change) {
  const id = `choice-${document.querySelectorAll("select").length}-${label}`;
  const select = make("select", { id });
  for (const [value, text] of options) select.append(make("option", { value, selected: value === picked }, text));
  select.addEventListener("change", () => change(select.value));
  return make("span", { class: "choice" }, make("label", { for: id }, label), select);
}

const GOOD = { lower: "lower is better", higher: "higher is better", neither: "neither is better" };
const good = (name) => GOOD[name] ?? name.replace("near", "best near");
