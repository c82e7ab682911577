// Controls of the interactive view: mouse, fingers, keys, and the panel beside it.

// Show a sentence instead of the view.
function explain(root, sentence) {
  root.classList.remove("ready");
  root.querySelector(".view3d-missing").textContent = sentence;
}

function connect(root) {
  const head = JSON.parse(root.querySelector(".view3d-head").textContent);
  const bodies = decode(head, root.querySelector(".view3d-data").textContent);
  const canvas = root.querySelector("canvas");
  const painter = new Painter(canvas, bodies, head.box), { state } = painter;
  root.classList.add("ready");
  state.exaggeration = head.exaggeration;
  state.explode = head.explode;
  const find = (name) => root.querySelector(`[data-do=${name}]`);

  function draw() {
    const size = [canvas.clientWidth, canvas.clientHeight];
    const [width, height] = size.map((n) => Math.max(1, Math.round(n * devicePixelRatio)));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const style = getComputedStyle(root);
    const colour = (name) => rgb(style.getPropertyValue(name).trim());
    painter.draw(colour("--paper"), colour("--faint"));
    compass();
  }
  let waiting = false;
  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; draw(); });
  }

  function compass() {
    const { right, up } = painter.camera();
    for (const [name, axis] of [["e", 0], ["n", 1], ["up", 2]]) {
      const [x, y] = [22 * right[axis], -22 * up[axis]];
      const line = root.querySelector(`.compass .${name}`), mark = line.nextElementSibling;
      line.setAttribute("x2", x);
      line.setAttribute("y2", y);
      mark.setAttribute("x", 1.45 * x);
      mark.setAttribute("y", 1.45 * y);
      line.style.opacity = mark.style.opacity = Math.hypot(x, y) < 5 ? 0 : 1;
    }
  }

  // What a slider says, in words.
  function words() {
    find("exaggeration-words").textContent = `${state.exaggeration}\u00d7`;
    find("explode-words").textContent = `${Math.round(100 * state.explode)} %`;
    const k = AXES[state.axis], low = head.box[2 * k], high = head.box[2 * k + 1];
    find("level-words").textContent = state.axis
      ? `${grouped(head.lower[k] + low + state.level * (high - low))} m` : "";
    find("level").disabled = find("flip").disabled = !state.axis;
  }

  function choose(row) {
    state.picked = row;
    const list = find("facts"), body = bodies[row];
    list.replaceChildren();
    find("name").textContent = body ? body.name : "Click a body, or its name, for its numbers.";
    for (const [key, value] of body ? body.facts : []) {
      const term = document.createElement("dt"), detail = document.createElement("dd");
      term.textContent = key;
      detail.textContent = value;
      list.append(term, detail);
    }
    root.querySelectorAll(".view3d-list button").forEach((button) =>
      button.setAttribute("aria-pressed", String(Number(button.value) === row)));
    redraw();
  }

  function show(rows, on) {
    rows.forEach((i) => { bodies[i].shown = on; });
    root.querySelectorAll("[data-row]").forEach((box) => {
      box.checked = bodies[Number(box.dataset.row)].shown;
    });
    root.querySelectorAll("[data-group]").forEach((box) => {
      const of = bodies.filter((body) => body.group === box.dataset.group);
      const n = of.filter((body) => body.shown).length;
      box.checked = n > 0;
      box.indeterminate = n > 0 && n < of.length;
    });
    redraw();
  }

  function list() {
    const target = root.querySelector(".view3d-list");
    for (const group of new Set(bodies.map((body) => body.group))) {
      const rows = bodies.map((_, i) => i).filter((i) => bodies[i].group === group);
      const fold = document.createElement("details"), summary = document.createElement("summary");
      fold.open = rows.length <= 12;
      const all = document.createElement("input");
      Object.assign(all, { type: "checkbox", checked: true, ariaLabel: `Show ${group}` });
      all.dataset.group = group;
      all.addEventListener("change", () => show(rows, all.checked));
      summary.append(all, `${group} (${rows.length})`);
      fold.append(summary);
      for (const i of rows) fold.append(item(i));
      target.append(fold);
    }
  }

  function item(i) {
    const row = document.createElement("div"), box = document.createElement("input");
    const button = document.createElement("button"), patch = document.createElement("i");
    Object.assign(box, { type: "checkbox", checked: true, ariaLabel: `Show ${bodies[i].name}` });
    box.dataset.row = i;
    box.addEventListener("change", () => show([i], box.checked));
    patch.style.background = bodies[i].colour;
    Object.assign(button, { type: "button", value: i });
    button.append(patch, bodies[i].name);
    button.addEventListener("click", () => choose(state.picked === i ? -1 : i));
    row.append(box, button);
    return row;
  }

  const everything = bodies.map((_, i) => i);
  const number = (name) => (event) => { state[name] = Number(event.target.value); };
  const actions = {
    all: ["click", () => show(everything, true)],
    none: ["click", () => show(everything, false)],
    explode: ["input", number("explode")],
    exaggeration: ["input", number("exaggeration")],
    level: ["input", number("level")],
    axis: ["change", (event) => { open(event.target.value); }],
    flip: ["change", (event) => { state.flip = event.target.checked; }],
    view: ["change", (event) => turn(event.target.value)],
    save: ["click", save],
    wide: ["click", () => document.fullscreenElement
      ? document.exitFullscreen() : root.requestFullscreen().catch(() => {})],
  };
  for (const [name, [event, act]] of Object.entries(actions)) {
    find(name).addEventListener(event, (happened) => { act(happened); words(); redraw(); });
  }
  function open(axis) { // the side towards the viewer is taken away
    state.axis = axis;
    state.flip = axis !== "" && painter.camera().towards[AXES[axis]] < 0;
    find("flip").checked = state.flip;
  }
  function turn(view) {
    [state.azimuth, state.elevation] = VIEWS[view];
    Object.assign(state, { zoom: 1, pan: [0, 0] });
  }
  function save() {
    draw();
    const link = document.createElement("a");
    Object.assign(link, { download: "view.png", href: canvas.toDataURL("image/png") });
    link.click();
  }

  // Drag turns, drag with Shift or the right button moves, the wheel zooms; two fingers do both.
  const down = new Map();
  let still = true, gap = 0;
  const apart = () => {
    const [a, b] = [...down.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  function move(dx, dy) {
    state.pan[0] += 2 * dx / canvas.clientWidth;
    state.pan[1] -= 2 * dy / canvas.clientHeight;
  }
  function orbit(dx, dy) {
    state.azimuth = (state.azimuth + 0.4 * dx + 360) % 360;
    state.elevation = Math.max(-90, Math.min(90, state.elevation + 0.4 * dy));
  }
  function zoom(by, x, y) {
    const before = state.zoom;
    state.zoom = Math.max(0.3, Math.min(60, before * by));
    const here = [2 * x / canvas.clientWidth - 1, 1 - 2 * y / canvas.clientHeight];
    state.pan = state.pan.map((p, k) => here[k] + (p - here[k]) * state.zoom / before);
  }
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    still = down.size === 1;
    if (down.size === 2) gap = apart();
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = down.get(event.pointerId);
    if (!last) return;
    const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
    if (still && Math.hypot(dx, dy) < 3) return; // a click, so far
    still = false;
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const place = canvas.getBoundingClientRect();
    if (down.size === 2) {
      move(dx / 2, dy / 2); // as far as the middle between the fingers
      const [a, b] = [...down.values()];
      zoom(apart() / gap, (a.x + b.x) / 2 - place.left, (a.y + b.y) / 2 - place.top);
      gap = apart();
    } else if (event.shiftKey || event.buttons === 2) {
      move(dx, dy);
    } else {
      orbit(dx, dy);
    }
    redraw();
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, (event) => {
      const mine = down.delete(event.pointerId);
      if (!mine || !still || name === "pointercancel" || event.button) return;
      const place = canvas.getBoundingClientRect(), by = canvas.width / place.width;
      choose(painter.pick(Math.round((event.clientX - place.left) * by),
        Math.round((event.clientY - place.top) * by)));
    });
  }
  canvas.addEventListener("wheel", (event) => {
    // a page that is scrolled past the view goes on scrolling: click into it first
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    zoom(Math.exp(-0.0015 * event.deltaY), event.offsetX, event.offsetY);
    redraw();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const middle = [canvas.clientWidth / 2, canvas.clientHeight / 2];
    const arrows = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, 12],
      ArrowDown: [0, -12] };
    const [x, y] = arrows[event.key] || [0, 0], along = event.shiftKey ? move : orbit;
    const arrow = () => along(x, event.shiftKey ? -y : y);
    const keys = { "+": () => zoom(1.2, ...middle), "=": () => zoom(1.2, ...middle),
      "-": () => zoom(1 / 1.2, ...middle), "0": () => turn(find("view").value),
      Escape: () => choose(-1), ...Object.fromEntries(Object.keys(arrows).map((k) => [k, arrow])) };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
    redraw();
  });
  canvas.addEventListener("webglcontextlost", () => { // too many views in one browser, say
    explain(root, "The browser has closed this interactive view. Load the page again.");
  });
  const printed = document.createElement("img");
  Object.assign(printed, { className: "view3d-print", alt: "The model as the view shows it" });
  addEventListener("beforeprint", () => {
    draw();
    printed.src = canvas.toDataURL("image/png");
    root.append(printed);
  });

  find("explode").value = state.explode;
  find("exaggeration").value = state.exaggeration;
  list();
  show(everything.filter((i) => !bodies[i].on), false);
  choose(-1);
  words();
  new ResizeObserver(redraw).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  root.view = { draw, painter, choose };
  draw();
}

document.querySelectorAll(".view3d").forEach((root) => {
  try {
    connect(root);
  } catch (error) {
    explain(root, "The interactive view needs WebGL 2, which this browser does not offer.");
    console.info(error.message);
  }
});
