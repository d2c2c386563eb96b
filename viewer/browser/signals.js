// @ts-check
// All recorded signals, from the block that page/signal_block.py describes.
const readSignals = (() => {
  return (bytes) => {
    if (bytes.length < 9) return { times: new Float32Array(0), columns: [] };
    const numbers = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const [samples, count] = [numbers.getUint32(0, true), numbers.getUint32(4, true)];
    const times = Float32Array.from({ length: samples }, (_, k) => numbers.getFloat32(8 + 4 * k, true));
    const ranges = 8 + 4 * samples;
    const content = ranges + 8 * count;
    const columns = Array.from({ length: count }, (_, column) => {
      const [low, step] = [0, 4].map((offset) => numbers.getFloat32(ranges + 8 * column + offset, true));
      const [small, large] = [content + 2 * samples * column, content + 2 * samples * column + samples];
      const values = new Float32Array(samples);
      let at = 0;
      for (let k = 0; k < samples; k++) {
        at = (at + bytes[small + k] + 256 * bytes[large + k]) & 0xffff;
        values[k] = low + step * at;
      }
      return values;
    });
    return { times, columns };
  };
})();
