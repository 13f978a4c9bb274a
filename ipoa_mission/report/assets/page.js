// One cursor in all views: a pointer in one view shows the same moment of the flight in the others, and a chosen item
// is marked everywhere. Without this script only the 3D view is missing.

(() => {
  const { course, stops, world, flown, tube, home } = JSON.parse(document.getElementById("data").textContent);
  const all = (selector) => [...document.querySelectorAll(selector)];
  const map = document.getElementById("map"), canvas = document.querySelector(".space canvas"), readout = document.querySelector(".readout");
  const plan = makeMap(map);
  const unclear = all(".way:not(.clear)").map((way) => way.dataset);
  let chosen = -1;

  const path = course.points.filter((_, i) => i % 2 === 0);
  const lines = [
    { points: path.map(([e, n], i) => [e, n, course.ground[2 * i] + 0.15]), color: "--quiet", width: 0.5, dashed: false },
    { points: path, color: "--planned", width: 1.8, dashed: false },
    ...tube.map((hoop) => ({ points: hoop, color: "--planned", width: 0.4, dashed: false })),
    ...(flown ? [{ points: flown, color: "--flown", width: 1.3, dashed: true }] : []),
  ];
  const placed = stops.map((stop, n) => ({ ...stop, n })).filter((stop) => stop.spot);
  const scene = makeScene(canvas, world, lines, placed.map((stop) => stop.spot));

  function nearest(values, value) {
    let best = 0;
    values.forEach((v, i) => { if (Math.abs(v - value) < Math.abs(values[best] - value)) best = i; });
    return best;
  }
  function point(i) {
    document.body.classList.add("pointing");
    for (const chart of all(".chart[data-along]")) {
      const series = course[chart.dataset.along];
      if (!series) continue;
      const { low, high } = chart.dataset;
      chart.querySelector(".cursor").style.left = `${(100 * (series[i] - low)) / (high - low)}%`;
    }
    const [east, north, up] = course.points[i];
    const way = home.findLast((one) => one.from <= course.times[i]) ?? null;
    plan.mark(east, north);
    plan.home(way);
    scene.mark(course.points[i], placed.findIndex((stop) => stop.n === chosen), way);
    const apart = course.apart[i];
    const words = [
      [chosen >= 0 && stops[chosen].index === i ? `item ${stops[chosen].seq}, ${stops[chosen].name}` : "here", ""],
      [`${course.times[i].toFixed(1)} s`, `${course.along[i].toFixed(0)} m flown over ground`],
      [`${course.speeds[i].toFixed(1)} m/s`, ""],
      [`${up.toFixed(1)} m`, `above home, ${(up - course.ground[i]).toFixed(1)} m above ground`],
      ...(apart === null ? [] : [[`${apart.toFixed(1)} m`, "to the nearest obstacle"]]),
      ...(chosen >= 0 && stops[chosen].index === i && stops[chosen].reason ? [["slow:", stops[chosen].reason]] : []),
    ];
    const now = course.times[i];
    for (const { ending, from, to, keeps } of unclear)
      if (Number(from) <= now && now <= Number(to)) words.push([ending, keeps]);
    readout.replaceChildren(...words.map(([strong, rest]) => {
      const part = document.createElement("span"), bold = document.createElement("b");
      bold.textContent = strong;
      part.append(bold, rest && ` ${rest}`);
      return part;
    }));
  }
  function choose(n) {
    all(".chosen").forEach((element) => element.classList.remove("chosen"));
    chosen = n;
    if (n < 0) return;
    all(`[data-stop="${n}"]`).forEach((element) => element.classList.add("chosen"));
    const row = document.querySelector(`tr[data-stop="${n}"]`), box = row.closest(".scroll");
    if (row.offsetTop < box.scrollTop + 50 || row.offsetTop + row.offsetHeight > box.scrollTop + box.clientHeight)
      box.scrollTop = row.offsetTop - box.clientHeight / 2;
    if (stops[n].spot) plan.reveal(...stops[n].spot);
    point(stops[n].index);
  }

  for (const chart of all(".chart[data-along]")) {
    const series = course[chart.dataset.along], plot = chart.querySelector(".plot");
    if (!series) continue;
    const aim = (event) => {
      const box = plot.getBoundingClientRect(), low = Number(chart.dataset.low), high = Number(chart.dataset.high);
      point(nearest(series, low + ((event.clientX - box.left) / box.width) * (high - low)));
    };
    plot.addEventListener("pointermove", aim);
    plot.addEventListener("pointerdown", aim);
  }
  const aimOnMap = (event) => {
    if (event.buttons && map.classList.contains("near")) return;  // the map is panned
    const [east, north] = plan.place(event);
    const apart = course.points.map((p) => Math.hypot(p[0] - east, p[1] - north));
    point(apart.indexOf(Math.min(...apart)));
  };
  map.addEventListener("pointermove", aimOnMap);
  map.addEventListener("pointerdown", aimOnMap);
  document.addEventListener("click", (event) => {
    const marked = event.target.closest("[data-stop]");
    if (marked) choose(Number(marked.dataset.stop));
  });
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") { choose(-1); document.body.classList.remove("pointing"); plan.home(null); scene.mark(null, -1, null); }
    if (event.key === "Enter" && event.target.matches("tr[data-stop]")) choose(Number(event.target.dataset.stop));
  });
  canvas.addEventListener("click", (event) => {
    const n = scene.nearestSpot(event.offsetX, event.offsetY);
    if (n >= 0) choose(placed[n].n);
  });
  all(".space .tools button").forEach((button) => button.addEventListener("click", () => scene.key(button.dataset.key)));
})();
