// Zoom and pan the map: the drawing shows a window of the extent, and the elements on top follow.

function makeMap(map) {
  const svg = map.querySelector("svg"), scale = map.querySelector(".scale");
  const [west, south, width, height] = ["west", "south", "width", "height"].map((key) => Number(map.dataset[key]));
  const nearest = 40;
  let view = { x: 0, y: 0, zoom: 1 };  // upper left corner of the window [m from the extent's], and zoom
  const onTop = [...map.querySelectorAll("button.stop")].map((element) => ({
    element, x: (parseFloat(element.style.left) / 100) * width, y: (parseFloat(element.style.top) / 100) * height,
  }));
  const here = { element: map.querySelector(".here"), x: 0, y: 0 };

  function put({ element, x, y }) {
    element.style.left = `${(100 * (x - view.x) * view.zoom) / width}%`;
    element.style.top = `${(100 * (y - view.y) * view.zoom) / height}%`;
  }
  function show() {
    svg.setAttribute("viewBox", [view.x, view.y, width / view.zoom, height / view.zoom].map((v) => v.toFixed(3)).join(" "));
    [...onTop, here].forEach(put);
    const room = width / view.zoom / 5, power = 10 ** Math.floor(Math.log10(room));
    const length = [1, 2, 5, 10].map((k) => k * power).find((value) => value >= room * (1 - 1e-9));
    scale.style.width = `${(100 * length * view.zoom) / width}%`;
    scale.textContent = `${Number(length.toPrecision(1))} m`;
    map.style.touchAction = view.zoom > 1 ? "none" : "pan-y";
    map.classList.toggle("near", view.zoom > 1);
    map.dataset.zoom = view.zoom.toFixed(2);
  }
  function look(x, y, zoom) {
    const near = Math.min(Math.max(zoom, 1), nearest), clamp = (v, most) => Math.min(Math.max(v, 0), most);
    view = { zoom: near, x: clamp(x, width * (1 - 1 / near)), y: clamp(y, height * (1 - 1 / near)) };
    show();
  }
  function nearer(factor, [across, down] = [0.5, 0.5]) {  // zooms round a point given as shares of the map
    const zoom = Math.min(Math.max(view.zoom * factor, 1), nearest), gain = 1 / view.zoom - 1 / zoom;
    look(view.x + across * width * gain, view.y + down * height * gain, zoom);
  }
  const pan = (across, down) => look(view.x - (across * width) / view.zoom, view.y - (down * height) / view.zoom, view.zoom);
  function shares(event) {
    const box = map.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  const keys = {
    "+": () => nearer(1.5), "=": () => nearer(1.5), "-": () => nearer(1 / 1.5), 0: () => look(0, 0, 1), Home: () => look(0, 0, 1),
    ArrowLeft: () => pan(0.1, 0), ArrowRight: () => pan(-0.1, 0), ArrowUp: () => pan(0, 0.1), ArrowDown: () => pan(0, -0.1),
  };
  map.addEventListener("keydown", (event) => {
    const moves = event.key.startsWith("Arrow") && view.zoom === 1;  // then the page scrolls
    if (!keys[event.key] || moves || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    keys[event.key]();
  });
  map.querySelectorAll(".tools button").forEach((button) => button.addEventListener("click", () => keys[button.dataset.key]()));
  map.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !map.contains(document.activeElement)) return;  // the page scrolls until the map has the focus
    event.preventDefault();
    nearer(Math.exp(-event.deltaY * 0.0016), shares(event));
  }, { passive: false });

  const fingers = new Map();
  map.addEventListener("pointerdown", (event) => {
    if (!event.target.closest("button")) fingers.set(event.pointerId, shares(event));
  });
  map.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = shares(event), other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const apart = (p) => Math.hypot((p[0] - other[0]) * width, (p[1] - other[1]) * height) || 1;
      nearer(apart(now) / apart(before), [(now[0] + other[0]) / 2, (now[1] + other[1]) / 2]);
    } else if (view.zoom > 1) {
      map.setPointerCapture(event.pointerId);
      pan(now[0] - before[0], now[1] - before[1]);
    }
    fingers.set(event.pointerId, now);
  });
  for (const kind of ["pointerup", "pointercancel", "pointerleave"])
    map.addEventListener(kind, (event) => fingers.delete(event.pointerId));
  show();

  return {
    home(way) {  // draws the return path, or none
      const line = svg.querySelector(".way-home");
      line.setAttribute("d", way ? `M${way.points.map(([e, n]) => `${e} ${n}`).join("L")}` : "");
      line.classList.toggle("not-clear", Boolean(way) && !way.clear);
    },
    mark(east, north) { here.x = east - west; here.y = south + height - north; put(here); },
    reveal(east, north) {  // pans to a place outside of the window
      const x = east - west, y = south + height - north, across = width / view.zoom, down = height / view.zoom;
      if (x < view.x || x > view.x + across || y < view.y || y > view.y + down) look(x - across / 2, y - down / 2, view.zoom);
    },
    place(event) {  // returns east and north of the pointer
      const [across, down] = shares(event);
      return [west + view.x + (across * width) / view.zoom, south + height - view.y - (down * height) / view.zoom];
    },
  };
}
