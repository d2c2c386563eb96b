// @ts-check
// The timeline of a panel: a window of time that can be zoomed, curves of every signal, and values at a moment.
const makeTimeline = (() => {
  const POINTS = 700; // largest number of points of a curve
  const NARROWEST = 0.25; // shortest window [s]

  return (root, data) => {
    const plot = root.querySelector(".plot");
    const [start, end] = [Number(plot.dataset.start), Number(plot.dataset.end)];
    const lanes = [...plot.querySelectorAll(".lane[data-low]")].map((lane) => {
      const { columns } = data.lanes.find(({ key }) => key === lane.dataset.lane);
      const [low, high] = [Number(lane.dataset.low), Number(lane.dataset.high)];
      const digits = Math.max(0, Math.min(4, 2 - Math.floor(Math.log10(high - low))));
      // The first curve was drawn last.
      const lines = [...lane.querySelectorAll("polyline")].reverse();
      return { lane, columns, low, high, digits, lines, values: [...lane.querySelectorAll(".key:not(.limit) .value")] };
    });
    const carried = plot.querySelector("[data-carried]");
    let signals = { times: new Float32Array(0), columns: [] };
    let [first, last, now] = [start, end, start];

    // Smallest and largest sample of each bin inside the window, so that no peak is lost.
    function points(column, low, high) {
      const { times } = signals;
      const values = signals.columns[column];
      const from = Math.max(0, lastFrame(times, first) - 1);
      const to = Math.min(times.length, lastFrame(times, last) + 2);
      const size = Math.max(1, Math.ceil((2 * (to - from)) / POINTS));
      const found = [];
      const put = (k) => {
        const x = (1000 * (times[k] - first)) / (last - first);
        const y = 100 * (1 - (values[k] - low) / (high - low));
        found.push(`${Math.max(-2000, Math.min(3000, x)).toFixed(1)},${Math.max(0, Math.min(100, y)).toFixed(1)}`);
      };
      for (let k = from; k < to; k += size) {
        let [least, most] = [k, k];
        for (let j = k; j < Math.min(to, k + size); j++) {
          if (values[j] < values[least]) least = j;
          if (values[j] > values[most]) most = j;
        }
        put(Math.min(least, most));
        if (least !== most) put(Math.max(least, most));
      }
      return found.join(" ");
    }

    function drawLane({ lane, columns, low, high, lines }) {
      if (lane.hidden || !signals.times.length) return;
      lines.forEach((line, index) => line.setAttribute("points", points(columns[index], low, high)));
    }

    function drawTicks() {
      const place = plot.querySelector(".ticks");
      const [found, digits] = niceTicks(first, last, 10);
      for (const old of place.querySelectorAll(".tx")) old.remove();
      found.forEach((time, index) => {
        const label = document.createElement("span");
        label.className = index % 2 ? "tx odd" : "tx";
        label.style.left = `${(100 * (time - first)) / (last - first)}%`;
        label.textContent = time.toFixed(digits);
        place.prepend(label);
      });
    }

    function setWindow(from, to) {
      const width = Math.max(NARROWEST, Math.min(end - start, to - from));
      first = Math.max(start, Math.min(end - width, from));
      last = first + width;
      const zoom = (end - start) / width;
      for (const part of plot.querySelectorAll(".stretch")) {
        part.style.width = `${100 * zoom}%`;
        part.style.left = `${(-100 * zoom * (first - start)) / (end - start)}%`;
      }
      lanes.forEach(drawLane);
      drawTicks();
      place(now);
    }

    function zoom(factor, around = now) {
      const share = (around - first) / (last - first);
      const width = (last - first) * factor;
      setWindow(around - share * width, around + (1 - share) * width);
    }

    function readOut(moment) {
      const { times } = signals;
      if (times.length) {
        const k = lastFrame(times, moment);
        for (const { lane, columns, digits, values } of lanes) {
          if (!lane.hidden) values.forEach((value, index) => (value.textContent = written(signals.columns[columns[index]][k], digits)));
        }
      }
      if (carried) {
        const names = data.carried.filter((one) => one.start <= moment && moment <= one.end).map(({ name }) => name);
        carried.textContent = names.length ? names.join(", ") : "nothing";
      }
    }

    function place(moment) {
      now = moment;
      const share = (moment - first) / (last - first);
      const cursor = plot.querySelector(".cursor");
      cursor.style.left = `${100 * share}%`;
      cursor.style.visibility = share < -1e-6 || share > 1 + 1e-6 ? "hidden" : "";
    }

    // The window follows the moment when it leaves it.
    function show(moment) {
      if (moment < first - 1e-9 || moment > last + 1e-9) setWindow(moment - 0.2 * (last - first), moment + 0.8 * (last - first));
      place(moment);
      readOut(moment);
    }

    // The moment under a pointer; the lanes begin right of their names.
    function momentAt(clientX) {
      const box = plot.querySelector(".over").getBoundingClientRect();
      return first + ((last - first) * Math.max(0, Math.min(1, (clientX - box.left) / box.width)));
    }

    function hover(clientX) {
      const line = plot.querySelector(".hover");
      line.hidden = clientX === null;
      if (clientX === null) return readOut(now);
      const moment = momentAt(clientX);
      line.style.left = `${(100 * (moment - first)) / (last - first)}%`;
      line.dataset.time = `${moment.toFixed(2)} s`;
      return readOut(moment);
    }

    function choose(key, on) {
      const lane = [...plot.querySelectorAll(".lane")].find(({ dataset }) => dataset.lane === key);
      if (!lane) return;
      lane.hidden = !on;
      lanes.filter((one) => one.lane === lane).forEach(drawLane);
      readOut(now);
    }

    return {
      plot,
      show,
      zoom,
      hover,
      choose,
      momentAt,
      window: () => [first, last],
      signals: () => signals,
      load: (found) => {
        signals = found;
        readOut(now);
      },
    };
  };
})();
