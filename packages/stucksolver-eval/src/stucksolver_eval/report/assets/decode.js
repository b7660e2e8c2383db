// Reads the compact form that pack.py writes. Meters, seconds, radians; x east, y north.

function sums(packed, count, unit) {
  const values = new Float64Array(count);
  if (typeof packed === "number") return values.fill(packed * unit);
  let total = 0;
  for (let i = 0; i < count; i += 1) {
    total += packed[i];
    values[i] = total * unit;
  }
  return values;
}

function decodeLine([count, x, y]) {
  return { count, x: sums(x, count, 0.01), y: sums(y, count, 0.01) };
}

function decodeTrack(spells) {
  return spells.map(([first, count, x, y, yaw]) => ({
    first,
    last: first + count - 1,
    x: sums(x, count, 0.01),
    y: sums(y, count, 0.01),
    yaw: sums(yaw, count, Math.PI / 1800),
  }));
}

function decodeMap(packed) {
  return {
    name: packed.name,
    lanes: packed.lanes.map((lane) => ({
      kind: lane.kind, left: decodeLine(lane.left), right: decodeLine(lane.right),
    })),
    markings: packed.markings.map((mark) => ({ ...mark, points: decodeLine(mark.points) })),
  };
}

function decodeRun(packed, map) {
  const time = sums(packed.time, packed.frames, 0.001);
  return {
    ...packed,
    map,
    time,
    start: time[0] || 0,
    end: time[time.length - 1] || 0,
    speed: sums(packed.speed, packed.frames, 0.01),
    route: decodeLine(packed.route),
    tracks: packed.tracks.map(decodeTrack),
    lights: packed.lights.map(([x, y, changes]) => ({ x: x * 0.01, y: y * 0.01, changes })),
    paths: packed.paths.map(([frame, line]) => [frame, line && decodeLine(line)]),
  };
}

// Returns the position of a time between frames: 12.25 is a quarter of the way from frame 12 to frame 13.
function frameAt(run, time) {
  const times = run.time;
  if (!times.length || time <= times[0]) return 0;
  let low = 0;
  let high = times.length - 1;
  if (time >= times[high]) return high;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return low + (time - times[low]) / (times[high] - times[low]);
}

function poseAt(track, frame) {
  const whole = Math.floor(frame);
  const spell = track.find((part) => part.first <= whole && whole <= part.last);
  if (!spell) return null;
  const at = whole - spell.first;
  const next = Math.min(at + 1, spell.x.length - 1);
  const mix = frame - whole;
  const between = (values) => values[at] + (values[next] - values[at]) * mix;
  return { x: between(spell.x), y: between(spell.y), yaw: between(spell.yaw) };
}

// Returns the value at a frame in a list of [frame, value] changes.
function stateAt(changes, frame) {
  let value = null;
  for (const [from, state] of changes) {
    if (from > frame) break;
    value = state;
  }
  return value;
}

const during = (spans, time) => spans.some(([from, to]) => from <= time && time <= to);
