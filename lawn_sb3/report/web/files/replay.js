// The replay: draws what the element "data" holds, one slot at a time. All numbers are those of the raw rows.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const { game, looks } = data;
  const at = (id) => document.getElementById(id);
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const state = { episode: 0, methods: [0], slot: 0, timer: null };
  const uavs = data.methods[0].tracks[0].voxels[0].map((_, i) => i);
  const quiet = { displayModeBar: false, responsive: true };
  const mostDrawnLinks = 64;
  const mostNamedCells = 12;

  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const colour = (i) => (dark.matches ? looks.dark : looks.light)[i % looks.light.length];
  const dash = (i) => looks.dashes[Math.floor(i / looks.light.length) % looks.dashes.length];
  const range = (count) => Array.from({ length: count }, (_, k) => k);
  const shown = () => state.methods.map((m) => ({ method: data.methods[m], track: data.methods[m].tracks[state.episode] }));
  const lastSlot = () => Math.max(...shown().map(({ track }) => track.slots));
  const number = (value, digits) => (value === null ? "–" : value.toFixed(digits));

  // A UAV's place in metres: the centre of its voxel, moved aside by its own little offset.
  const place = (voxel, i) => [
    (voxel[0] + 0.5) * game.voxel + looks.offsets[i][0],
    (voxel[1] + 0.5) * game.voxel + looks.offsets[i][1],
    game.low + (voxel[2] + 0.5) * game.voxel,
  ];
  const flies = (track, i, slot) => slot <= track.rows.slots[i];
  const isUp = (track, i, slot) => slot < track.rows.slots[i];

  // Points as Plotly takes them; null breaks a line.
  const points = (list) => ({
    x: list.map((p) => p && p[0]),
    y: list.map((p) => p && p[1]),
    z: list.map((p) => p && p[2]),
  });

  // The floor: two triangles for each voxel of the lowest layer.
  const floor = (() => {
    const [width, length] = game.grid;
    const mesh = { x: [], y: [], z: [], i: [], j: [], k: [], cell: [] };
    for (let x = 0; x <= width; x += 1) {
      for (let y = 0; y <= length; y += 1) {
        mesh.x.push(x * game.voxel);
        mesh.y.push(y * game.voxel);
        mesh.z.push(game.low);
      }
    }
    for (let x = 0; x < width; x += 1) {
      for (let y = 0; y < length; y += 1) {
        const corner = x * (length + 1) + y;
        const beyond = corner + length + 1;
        mesh.i.push(corner, beyond + 1);
        mesh.j.push(beyond, corner + 1);
        mesh.k.push(corner + 1, beyond);
        mesh.cell.push(game.cells[x][y], game.cells[x][y]);
      }
    }
    return mesh;
  })();
  const borders = points(game.borders.flatMap(([from, to]) => [[...from, game.low], [...to, game.low], null]));
  const sites = game.gbs.map(([x, y, z]) => [x, y, Math.max(z, game.low + 0.05 * game.voxel)]); // above the floor
  const mostLoad = Math.max(1, ...data.methods.flatMap((m) => m.tracks.flatMap((t) => t.loads.flat())));
  const loadScale = () => [[0, css("--empty")], [1, css("--full")]];

  function sceneTraces(track, slot) {
    const loads = track.loads[slot];
    const here = uavs.map((i) => place(track.voxels[slot][i], i));
    const { cell, i, j, k, ...corners } = floor;
    const base = { type: "scatter3d", showlegend: false, hoverinfo: "skip" };
    const traces = [
      {
        type: "mesh3d", ...corners, i, j, k, intensity: cell.map((b) => loads[b]), intensitymode: "cell",
        cmin: 0, cmax: mostLoad, colorscale: loadScale(), hoverinfo: "skip", flatshading: true, showscale: false,
        lighting: { ambient: 1, diffuse: 0, specular: 0, fresnel: 0 },
      },
      { ...base, mode: "lines", ...borders, line: { color: css("--faint"), width: 2, dash: "dash" } },
      {
        ...base, mode: game.gbs.length <= mostNamedCells ? "markers+text" : "markers", ...points(sites),
        marker: { symbol: "square", size: 5, color: css("--faint"), line: { color: css("--ground"), width: 1 } },
        text: game.gbs.map((_, b) => `GBS ${b}`), textposition: "top center",
        textfont: { size: 12, color: css("--text") }, hoverinfo: "text",
        hovertext: game.gbs.map((_, b) => `GBS ${b}, ${game.rbs[b]} RBs<br>serves ${loads[b]} UAVs`),
      },
    ];
    const linked = uavs.filter((i_) => flies(track, i_, slot)).slice(0, mostDrawnLinks);
    traces.push({
      ...base, mode: "lines", ...points(linked.flatMap((u) => [here[u], sites[track.cell[slot][u]], null])),
      line: { color: css("--faint"), width: 2, dash: "dot" },
    });
    // Paths of UAVs that look the same are one trace.
    const alike = new Map();
    for (const u of uavs) {
      const look = `${colour(u)} ${dash(u)}`;
      const path = range(slot + 1).map((t) => place(track.voxels[t][u], u));
      alike.set(look, [...(alike.get(look) || []), ...path, null]);
    }
    for (const [look, path] of alike) {
      const [color, line] = look.split(" ");
      traces.push({ ...base, mode: "lines", ...points(path), line: { color, width: 5, dash: line } });
    }
    const many = uavs.length > 24;
    traces.push({
      ...base, mode: "markers", ...points(uavs.map((u) => place(track.voxels[0][u], u))),
      marker: { symbol: "circle-open", size: many ? 4 : 7, color: uavs.map(colour), line: { width: 2 } },
    });
    const destinations = data.episodes[state.episode].destinations;
    traces.push({
      ...base, mode: "markers", ...points(uavs.map((u) => place(destinations[u], u))),
      marker: { symbol: "cross", size: many ? 4 : 8, color: uavs.map(colour) },
    });
    traces.push({
      ...base, name: "UAVs", mode: many ? "markers" : "markers+text", ...points(here),
      marker: {
        symbol: "circle", size: many ? 5 : 10, color: uavs.map(colour), line: { color: css("--ground"), width: 1 },
        opacity: 1,
      },
      text: uavs.map(String), textposition: "top center", textfont: { size: 13, color: css("--text") },
      hoverinfo: "text",
      hovertext: uavs.map((u) =>
        `UAV ${u}: ${standing(track, u, slot)}<br>voxel (${track.voxels[slot][u].join(", ")}), cell of GBS ` +
        `${track.cell[slot][u]}<br>rate ${number(track.rate[slot][u], 2)} Mbps, EMA ${number(track.ema[slot][u], 2)} Mbps`),
    });
    return traces;
  }

  function sceneLayout(box) {
    const away = Math.max(1, (1.35 * box.clientHeight) / box.clientWidth); // all of it, also in a narrow box
    const [width, length, height] = game.grid.map((count) => count * game.voxel);
    const longer = Math.max(width, length);
    const axis = (title, low, high) => ({
      title: { text: title, font: { size: 11 } }, range: [low, high], autorange: false, color: css("--faint"),
      gridcolor: css("--line"), zeroline: false, showbackground: false, tickfont: { size: 10 }, nticks: 5,
      showspikes: false,
    });
    return {
      margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: css("--raised"), font: { color: css("--text") },
      uirevision: "as turned", showlegend: false,
      hoverlabel: { bgcolor: css("--ground"), font: { color: css("--text") }, bordercolor: css("--line") },
      scene: {
        xaxis: axis("x (m)", 0, width), yaxis: axis("y (m)", 0, length),
        zaxis: axis("z (m)", game.low, game.low + height), aspectmode: "manual",
        aspectratio: { x: width / longer, y: length / longer, z: Math.max(height / longer, game.flattest) },
        camera: { eye: { x: -0.68 * away, y: -1.3 * away, z: 0.88 * away }, center: { x: 0, y: 0, z: -0.15 } },
        uirevision: "as turned",
      },
    };
  }

  const standing = (track, u, slot) => {
    if (isUp(track, u, slot)) return "flies";
    return track.rows.arrived[u] ? `arrived in slot ${track.rows.slots[u]}` : "out of time";
  };

  function chartLayout(slots, slot, top) {
    const axis = {
      color: css("--faint"), gridcolor: css("--line"), zeroline: false, tickfont: { size: 11 }, fixedrange: true,
    };
    return {
      margin: { l: 44, r: 8, t: 6, b: 34 }, paper_bgcolor: css("--ground"), plot_bgcolor: css("--ground"),
      font: { color: css("--text") }, showlegend: false, hovermode: "closest",
      hoverlabel: { bgcolor: css("--ground"), font: { color: css("--text") }, bordercolor: css("--line") },
      xaxis: { ...axis, range: [-0.5, slots + 0.5], title: { text: "slot", font: { size: 11 }, standoff: 4 }, dtick: slots <= 12 ? 1 : undefined },
      yaxis: { ...axis, range: top === null ? undefined : [0, top * 1.08], nticks: 5 },
      shapes: [nowLine(slot)],
    };
  }
  const nowLine = (slot) => ({
    type: "line", xref: "x", yref: "paper", x0: slot, x1: slot, y0: 0, y1: 1,
    line: { color: css("--accent"), width: 2 },
  });

  const quantities = [
    ["rate", "Rate in the slot (Mbps)"], ["ema", "EMA rate (Mbps)"], ["utility", "Utility once done (Mbps)"],
  ];
  const lines = (track, name) => uavs.map((u) => ({
    type: "scatter", mode: "lines+markers", name: `UAV ${u}`, x: range(track.slots + 1),
    y: track[name].map((values) => values[u]), marker: { size: uavs.length > 15 ? 2 : 5, color: colour(u) },
    line: { color: colour(u), width: uavs.length > 15 ? 1 : 2, dash: dash(u), shape: "linear" },
    hovertemplate: `UAV ${u}, slot %{x}: %{y:.2f} Mbps<extra></extra>`,
  }));
  const heat = (track) => ({
    type: "heatmap", x: range(track.slots + 1), y: game.gbs.map((_, b) => b),
    z: game.gbs.map((_, b) => track.loads.map((loads) => loads[b])), zmin: 0, zmax: mostLoad, colorscale: loadScale(),
    showscale: false, xgap: track.slots > 50 ? 0 : 1, ygap: 1, hovertemplate: "GBS %{y}, slot %{x}: %{z} UAVs<extra></extra>",
    texttemplate: game.gbs.length <= mostNamedCells && track.slots <= 20 ? "%{z}" : "",
  });

  const figures = (track) => data.game && {
    mean: track.rows.utility_mbps.reduce((sum, value) => sum + value, 0) / uavs.length,
    arrived: track.rows.arrived.filter(Boolean).length,
  };

  // One column for each method that is shown; made anew when methods or episode change.
  function build() {
    const main = at("methods");
    main.querySelectorAll(".js-plotly-plot").forEach((one) => Plotly.purge(one));
    main.replaceChildren();
    const top = (name) => Math.max(1, ...shown().flatMap(({ track }) => track[name].flat()));
    const pictures = []; // drawn once all columns are there, so that each knows its width
    for (const { method, track } of shown()) {
      const column = document.createElement("section");
      column.className = "method";
      column.style.setProperty("--mark", method.colour);
      column.setAttribute("aria-label", method.title);
      const { mean, arrived } = figures(track);
      column.innerHTML = '<h2></h2><p class="means faint"></p><div class="scene" role="img"></div>' +
        '<p class="loads faint">UAVs in a cell: 0 <span></span> <b></b></p><div class="charts"></div>' +
        '<div class="scrolls" tabindex="0" role="region" aria-label="The UAVs in this slot"><table><thead></thead><tbody></tbody></table></div>';
      column.querySelector("h2").textContent = method.title;
      column.querySelector(".loads b").textContent = mostLoad;
      column.querySelector(".means").textContent =
        `Here ${track.slots} slots, ${arrived} of ${uavs.length} UAVs arrive, U ${mean.toFixed(2)} Mbps. ` +
        `Over all ${data.total} episodes ${method.means.success_percent.toFixed(1)} % arrive, U ` +
        `${method.means.utility_mbps.toFixed(2)} Mbps, J ${method.means.reward.toFixed(2)}.`;
      const heads = ["UAV", "voxel", "cell", "load", "rate", "EMA", "U", ""];
      const row = document.createElement("tr");
      heads.forEach((text, k) => {
        const head = document.createElement("th");
        head.textContent = text;
        head.scope = "col";
        if (k > 1 && k < 7) head.className = "number";
        row.append(head);
      });
      column.querySelector("thead").append(row);
      main.append(column);
      const slot = Math.min(state.slot, track.slots);
      const scene = column.querySelector(".scene");
      pictures.push(() => Plotly.newPlot(scene, sceneTraces(track, slot), sceneLayout(scene), quiet));
      const chart = (title, traces, highest) => {
        const box = document.createElement("div");
        box.className = "chart";
        box.innerHTML = "<h3></h3><div></div>";
        box.querySelector("h3").textContent = title;
        column.querySelector(".charts").append(box);
        const layout = chartLayout(track.slots, slot, highest);
        if (highest === null) {
          layout.yaxis.title = { text: "GBS", font: { size: 11 }, standoff: 4 };
          layout.yaxis.dtick = game.gbs.length <= mostNamedCells ? 1 : undefined;
        }
        pictures.push(() => Plotly.newPlot(box.querySelector("div"), traces, layout, quiet));
      };
      chart("Cell loads (UAVs)", [heat(track)], null);
      for (const [name, title] of quantities) chart(title, lines(track, name), top(name));
    }
    pictures.forEach((picture) => picture());
    draw();
  }

  // What changes from slot to slot.
  function draw() {
    const columns = [...at("methods").children];
    const told = [];
    shown().forEach(({ method, track }, k) => {
      const slot = Math.min(state.slot, track.slots);
      const scene = columns[k].querySelector(".scene");
      Plotly.react(scene, sceneTraces(track, slot), sceneLayout(scene), quiet);
      columns[k].querySelectorAll(".chart > div").forEach((one) => Plotly.relayout(one, { shapes: [nowLine(slot)] }));
      const up = uavs.filter((u) => isUp(track, u, slot)).length;
      const text = `${method.title}: ${up} of ${uavs.length} UAVs fly on, ` +
        (game.gbs.length <= mostNamedCells
          ? `UAVs in the cells ${track.loads[slot].join(", ")}`
          : `at most ${Math.max(...track.loads[slot])} UAVs in a cell`);
      scene.setAttribute("aria-label", `The airspace in slot ${slot}. ${text}.`);
      told.push(text);
      columns[k].querySelector("tbody").replaceChildren(...uavs.map((u) => row(track, u, slot)));
    });
    at("slot").max = lastSlot();
    at("slot").value = state.slot;
    at("slot").setAttribute("aria-valuetext", `slot ${state.slot} of ${lastSlot()}`);
    at("now").textContent = `slot ${state.slot} of ${lastSlot()}`;
    at("said").setAttribute("aria-live", state.timer === null ? "polite" : "off"); // nobody can listen that fast
    at("said").textContent = `${told.join(". ")}.`;
  }

  function row(track, u, slot) {
    const line = document.createElement("tr");
    const up = flies(track, u, slot);
    const cells = [
      `UAV ${u}`, track.voxels[slot][u].join(", "), `${track.cell[slot][u]}`,
      up ? `${track.loads[slot][track.cell[slot][u]]}` : "–", number(track.rate[slot][u], 2),
      number(track.ema[slot][u], 2), number(track.utility[slot][u], 2), standing(track, u, slot),
    ];
    cells.forEach((text, k) => {
      const cell = document.createElement(k ? "td" : "th");
      if (!k) {
        cell.scope = "row";
        const dot = document.createElement("span");
        dot.className = "dot";
        dot.style.background = colour(u);
        cell.append(dot);
      }
      cell.append(text);
      if (k > 1 && k < 7) cell.className = "number";
      line.append(cell);
    });
    return line;
  }

  function go(slot) {
    state.slot = Math.max(0, Math.min(slot, lastSlot()));
    draw();
  }
  function pause() {
    clearInterval(state.timer);
    state.timer = null;
    at("play").textContent = "Play";
    draw();
  }
  function play() {
    if (state.timer !== null) return pause();
    if (state.slot >= lastSlot()) go(0);
    at("play").textContent = "Pause";
    tick();
    return undefined;
  }
  function tick() {
    clearInterval(state.timer);
    state.timer = setInterval(() => {
      go(state.slot + 1);
      if (state.slot >= lastSlot()) pause();
    }, 1000 / Number(at("speed").value));
  }

  function choose(id, texts, chosen) {
    at(id).replaceChildren(...texts.map(([value, text]) => {
      const option = document.createElement("option");
      option.value = value;
      option.textContent = text;
      option.selected = value === chosen;
      return option;
    }));
    at(id).parentElement.hidden = texts.length < 2;
  }

  choose("episode", data.episodes.map(({ number: k }, index) => [index, `${k}`]), 0);
  choose("method", data.methods.map(({ title }, index) => [index, title]), 0);
  choose("beside", [[-1, "nothing"], ...data.methods.map(({ title }, index) => [index, title])],
    data.methods.length > 1 && window.innerWidth > 900 ? 1 : -1);
  at("beside").parentElement.hidden = data.methods.length < 2;
  at("about").textContent =
    `Game ${game.title}: ${uavs.length} UAVs, ${game.gbs.length} GBSs; missions of seed ${data.seed}, as in evaluate.`;

  function chosen() {
    const beside = Number(at("beside").value);
    state.episode = Number(at("episode").value);
    state.methods = [Number(at("method").value), ...(beside < 0 ? [] : [beside])];
    state.slot = Math.min(state.slot, lastSlot());
    build();
  }
  for (const id of ["episode", "method", "beside"]) at(id).addEventListener("change", chosen);
  at("slot").addEventListener("input", (event) => go(Number(event.target.value)));
  at("play").addEventListener("click", play);
  at("speed").addEventListener("change", () => state.timer !== null && tick());
  const steps = { first: () => 0, back: () => state.slot - 1, on: () => state.slot + 1, last: lastSlot };
  for (const [id, to] of Object.entries(steps)) {
    at(id).addEventListener("click", () => {
      if (state.timer !== null) pause();
      go(to());
    });
  }
  const keys = { ArrowLeft: "back", ArrowRight: "on", Home: "first", End: "last", " ": "play" };
  document.addEventListener("keydown", (event) => {
    const busy = event.target.closest("button, select, input, .scrolls"); // these have keys of their own
    if (busy || event.ctrlKey || event.altKey || event.metaKey || !(event.key in keys)) return;
    event.preventDefault();
    at(keys[event.key]).click();
  });
  dark.addEventListener("change", build);
  chosen();
})();
