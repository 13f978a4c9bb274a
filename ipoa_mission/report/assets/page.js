// One cursor in all views: a pointer in one view shows the same moment of the flight in the others, and a chosen item
// is marked everywhere.

(() => {
  const { course, stops, home } = JSON.parse(document.getElementById("data").textContent);
  const all = (selector) => [...document.querySelectorAll(selector)];
  const map = document.getElementById("map"), readout = document.querySelector(".readout");
  const plan = makeMap(map);
  const unclear = all(".way:not(.clear)").map((way) => way.dataset);
  let chosen = -1;

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
    plan.mark(east, north);
    plan.home(home.findLast((one) => one.from <= course.times[i]) ?? null);
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
    for (const { contingency, from, to, keeps } of unclear)
      if (Number(from) <= now && now <= Number(to)) words.push([contingency, keeps]);
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
    if (stops[n].place) plan.reveal(...stops[n].place);
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
    if (event.key === "Escape") { choose(-1); document.body.classList.remove("pointing"); plan.home(null); }
    if (event.key === "Enter" && event.target.matches("tr[data-stop]")) choose(Number(event.target.dataset.stop));
  });
})();
